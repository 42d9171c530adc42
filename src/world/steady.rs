//! How steady a body's substeps are, and how long they may be because of that.
//!
//! Of a mode with the frequency ω leapfrog keeps x² + (v/ω)²/(1 − a²) with a = ½hω: another energy at another h. A change of h
//! multiplies the second part by (1 − a₁²)/(1 − a₂²), up or down, as the mode happens to swing. Many such changes are a pump,
//! which makes ρ²/4 more of the energy in each on the mean, with ρ = δ·2a²/(1 − a²) for a change by δ = Δh/h: close to the limit,
//! a = 1, very much. So where frames differ, or the stable substep does, what is not damped must keep farther from it.

use crate::solve::Integrator;

/// By what share the energy of the fastest mode may grow between two reviews of the stable substep \[1\]: a fifth in a minute of
/// 60 frames per second.
const GROWTH: f64 = 5e-5;
/// What changes count that come from the shape of a body, and not from the length of a frame or from others in its group \[1\]: they
/// are over when it is at rest.
/// A compromise: counted whole, a sheet that falls into its corners would take twice as long for modes that hold no energy.
pub(super) const SHAPE: f64 = 0.03;
/// The same of tets, which get stiff without limit as they are crushed: undamped plates that ring by their own still went
/// non-finite with 0.03.
pub(super) const SHAPE_OF_TETS: f64 = 0.2;
/// Over how many reviews changes are looked back at.
const MEMORY: f64 = 16.0;

/// The last substep of a body, and how much they have changed of late.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(super) struct Steadiness {
    /// \[s\], 0 for none; as if it had been made no shorter to be calm.
    last: f64,
    /// What the body itself asked for \[s\], and by how much that was shorter to be calm \[1\].
    asked: (f64, f64),
    /// Whether the last one was what it asked for.
    own: bool,
    /// Mean square of the logarithm of the ratio of a substep to that of the review before \[1\].
    change: f64,
    /// The largest share of the stable substep that is calm \[1\].
    calm: f64,
    /// Length of the world's last step \[s\].
    frame: f64,
}

impl Default for Steadiness {
    fn default() -> Self {
        Self {
            last: 0.0,
            asked: (0.0, 1.0),
            own: false,
            change: 0.0,
            calm: 1.0,
            frame: 0.0,
        }
    }
}

impl Steadiness {
    /// The largest share of the stable substep that gives the fastest mode no energy; `most` if that is less.
    pub fn share(&self, most: f64) -> f64 {
        self.calm.min(most)
    }

    /// Takes note of what a body asks for, h s, `shorter` times as short as it would be without a need to be calm.
    pub fn ask(&mut self, h: f64, shorter: f64) {
        self.asked = (h, shorter);
    }

    /// Takes note of the substep h that was made since the last review, before one in a `frame` of the world \[s\], and finds what
    /// will be. `shape` is what changes count that the body itself asked for within a frame. `decay` is by what share at least
    /// damping takes from the energy of the fastest mode between reviews; it is asked for where substeps have changed. Other
    /// schemes lose energy where a change might give them any.
    pub fn note(
        &mut self,
        (h, frame): (f64, f64),
        shape: f64,
        integrator: Integrator,
        decay: impl FnOnce() -> f64,
    ) {
        // Others may have asked for shorter ones.
        let (asked, shorter) = self.asked;
        let own = h == asked;
        let h = if own { h * shorter } else { h };
        if self.last > 0.0 && h > 0.0 {
            let change = (h / self.last).ln().powi(2);
            let of_shape = own && self.own && frame == self.frame;
            let weight = if of_shape { shape } else { 1.0 };
            self.change += (change * weight - self.change) / MEMORY;
        }
        (self.last, self.own, self.frame) = (h, own, frame);
        let keeps_energy = matches!(
            integrator,
            Integrator::SymplecticEuler | Integrator::VelocityVerlet
        );
        // A thousandth does nothing at 0.97 of the limit.
        self.calm = if keeps_energy && self.change > 1e-6 {
            let rho = ((decay() + GROWTH) / self.change).sqrt();
            let calm = (1.0 + 1.0 / rho).sqrt().recip();
            if calm.is_finite() { calm } else { 1.0 }
        } else {
            1.0
        };
    }
}

/// Whether damping that takes so large a share of the energy of the fastest mode between reviews leaves it to itself: by more no
/// change of the substep can matter.
pub(super) fn is_lively(decay: f64) -> bool {
    decay < 0.1
}

/// How many substeps to make where `least` would do and the last ones were so long that `last` would be: as many as that, as
/// long as it is a 16th more, or one.
pub(super) fn steady_count(least: usize, last: f64) -> usize {
    let last = last.round();
    let most = least + (least / 16).max(1);
    if last >= least as f64 && last <= most as f64 {
        last as usize
    } else {
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(substeps: impl Fn(usize) -> f64, integrator: Integrator, decay: f64) -> f64 {
        let mut steady = Steadiness::default();
        for i in 0..200 {
            // As a body does that takes the share that it is told.
            let share = steady.share(0.9);
            let h = substeps(i) * share;
            steady.ask(h, 0.9 / share);
            steady.note((h, i as f64), SHAPE, integrator, || decay);
        }
        steady.share(1.0)
    }

    #[test]
    fn even_substeps_may_be_long() {
        assert_eq!(after(|_| 1e-3, Integrator::SymplecticEuler, 0.0), 1.0);
        // One change is nothing.
        let once = |i| if i < 20 { 1e-3 } else { 2e-3 };
        assert_eq!(after(once, Integrator::SymplecticEuler, 0.0), 1.0);
    }

    #[test]
    fn uneven_ones_may_not_unless_something_damps() {
        let uneven = |i| if i % 2 == 0 { 1.0e-3 } else { 1.05e-3 };
        let undamped = after(uneven, Integrator::VelocityVerlet, 0.0);
        assert!((0.3..0.45).contains(&undamped), "{undamped}");
        assert!(after(uneven, Integrator::SymplecticEuler, 1.0) > 0.97);
        assert_eq!(after(uneven, Integrator::Rk4, 0.0), 1.0);
    }

    #[test]
    fn a_change_of_the_shape_is_soon_over_and_one_by_others_is_not() {
        let share = |own: bool| {
            let mut steady = Steadiness::default();
            for i in 0..200 {
                let h = if i % 2 == 0 { 1.0e-3 } else { 1.05e-3 };
                if own {
                    steady.ask(h, 1.0);
                }
                let scheme = Integrator::SymplecticEuler;
                steady.note((h, 0.02), SHAPE, scheme, || 0.0);
            }
            steady.share(1.0)
        };
        let (own, of_others) = (share(true), share(false));
        assert!((0.6..0.75).contains(&own), "{own}");
        assert!((0.3..0.45).contains(&of_others), "{of_others}");
    }

    #[test]
    fn substeps_stay_as_they_were_while_that_costs_little() {
        assert_eq!(steady_count(40, 41.0), 41);
        assert_eq!(steady_count(40, 42.2), 42);
        assert_eq!(steady_count(40, 43.0), 40);
        assert_eq!(steady_count(40, 39.0), 40);
        assert_eq!(steady_count(1, 2.0), 2);
        assert_eq!(steady_count(3, f64::NAN), 3);
    }
}
