//! Plastic flow of an axial spring with linear hardening, by return mapping (Simo & Hughes, *Computational Inelasticity*,
//! box 1.4): the trial tension is brought back to the yield surface by lengthening or shortening the rest length.
//!
//! Hardening is isotropic: both yield forces grow by H per metre of accumulated plastic elongation α = Σ|ΔL_p|.
//! No branch: an elastic spring has infinite yield forces, and `inverse` = 1/(k + H) is 0 for one that is too soft to flow.

use crate::math::Number;

/// Where a spring yields.
#[derive(Clone, Copy, Debug)]
pub struct Yield<S> {
    /// Yield force in tension before any flow \[N\].
    pub tension: S,
    /// Yield force in compression before any flow, positive \[N\].
    pub compression: S,
    /// H \[N/m\].
    pub hardening: S,
    /// 1/(k + H) \[m/N\].
    pub inverse: S,
}

/// 1/(k + H) \[m/N\], and 0 where that would be more than there are numbers for.
#[inline(always)]
pub fn inverse<S: Number>(stiffness: S, hardening: S) -> S {
    let sum = stiffness + hardening;
    S::above(sum, S::of(1e-37), S::ONE / sum, S::ZERO)
}

/// The outcome of a return mapping.
#[derive(Clone, Copy, Debug)]
pub struct Mapped<S> {
    /// Tension on or inside the yield surface, but for k times half a digit of the length \[N\].
    pub tension: S,
    /// Plastic change of the rest length \[m\], positive when it grows.
    pub flow: S,
    /// How far beyond the surface the last flow can have ended: k times half a digit of the length \[N\].
    pub beyond: S,
}

/// Half a digit of an `f32`, per number.
const HALF_DIGIT: f64 = 1.0 / (1 << 24) as f64;

/// Brings the trial tension `k·e` of a spring of this rest length \[m\] that has flowed by `accumulated` ≥ 0 \[m\] back to its yield
/// surface. It flows by as much as the rest length and the sum of flows have digits for, and ends up to half a digit off the surface: a
/// spring that is drawn slowly in short substeps would harden by flows that never came to lengthen it, or lengthen without hardening.
#[inline(always)]
pub fn return_map<S: Number>(
    stiffness: S,
    rest: S,
    elongation: S,
    accumulated: S,
    law: &Yield<S>,
) -> Mapped<S> {
    let trial = stiffness * elongation;
    let grown = law.hardening * accumulated;
    let over = (trial - (law.tension + grown)).max(S::ZERO);
    let under = (-trial - (law.compression + grown)).max(S::ZERO);
    let most = rest.max(accumulated);
    // One of the two is 0.
    let longer = (most + over * law.inverse) - most;
    let shorter = (most + under * law.inverse) - most;
    let flow = longer - shorter;
    Mapped {
        tension: trial - stiffness * flow,
        flow,
        beyond: stiffness * (most * S::of(HALF_DIGIT)),
    }
}

/// Work dissipated by a flow \[J\]: the mean of the tension before and after it, times the flow. `last` is what the
/// tension was before the flow \[N\]. It is found from a rate, so it is kept to what it can have been: no farther out than where the flow
/// ended, but for what the last one left beyond it.
#[inline(always)]
pub fn work<S: Number>(last: S, mapped: &Mapped<S>) -> S {
    let most = mapped.tension.abs();
    let last = last.min(most + mapped.beyond).max(-most - mapped.beyond);
    (S::of(0.5) * (last + mapped.tension) * mapped.flow).max(S::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(k: f64, h: f64) -> Yield<f64> {
        Yield {
            tension: 100.0,
            compression: 60.0,
            hardening: h,
            inverse: 1.0 / (k + h),
        }
    }

    #[test]
    fn the_mapped_tension_lies_on_the_hardened_surface() {
        let (k, h, alpha) = (5000.0, 400.0, 0.01);
        for (e, sign, yield_force) in [(0.5, 1.0, 100.0), (-0.5, -1.0, 60.0)] {
            let m = return_map(k, 0.0, e, alpha, &law(k, h));
            let surface = yield_force + h * (alpha + m.flow.abs());
            assert!((m.tension - sign * surface).abs() < 1e-9);
            assert!((m.tension - k * (e - m.flow)).abs() < 1e-9);
        }
    }

    #[test]
    fn inside_the_surface_nothing_flows() {
        let m = return_map(5000.0, 1.0, 0.019, 0.0, &law(5000.0, 0.0));
        assert_eq!(m.flow, 0.0);
        assert_eq!(m.tension, 95.0);
    }

    /// What a spring flows is what its rest length gains or loses, however short the steps: in `f32`, drawn or crushed by less
    /// than the last digit of its length each, also where the sum of flows has the coarser digits.
    #[test]
    fn slow_flow_hardens_by_what_it_lengthens() {
        let law = Yield {
            tension: 100.0_f32,
            compression: 100.0,
            hardening: 1e3,
            inverse: 1.0 / 1.1e4,
        };
        for (start, way) in [(1.0_f32, 0.02), (1.0, -0.02), (0.25, -0.1)] {
            // As if it had been crushed to that from a metre.
            let before = 1.0 - start;
            let (mut rest, mut flowed) = (start, before);
            let (mut last, mut dissipated) = (0.0, 0.0);
            let steps = 10_000_000;
            for i in 0..=steps {
                let length = (f64::from(start) + way * f64::from(i) / f64::from(steps)) as f32;
                let mapped = return_map(1e4, rest, length - rest, flowed, &law);
                rest += mapped.flow;
                flowed += mapped.flow.abs();
                dissipated += f64::from(work(last, &mapped));
                last = mapped.tension;
            }
            let changed = f64::from((rest - start).abs());
            assert_eq!(f64::from(flowed - before), changed, "{start} by {way}");
            // k·e = σ + H·α, and e + p is the whole way.
            let surface = 100.0 + 1e3 * f64::from(before);
            let exact = (1e4 * way.abs() - surface) / 1.1e4;
            assert!(
                exact > 0.0 && (changed - exact).abs() < 1e-4 * exact,
                "{changed} for {exact}"
            );
            let exact = changed * (surface + 0.5 * 1e3 * changed);
            let share = dissipated / exact - 1.0;
            assert!(share.abs() < 1e-6, "{share} of the work");
        }
    }

    #[test]
    fn the_tangent_is_the_elastoplastic_modulus() {
        let (k, h, d) = (5000.0, 400.0, 1e-6);
        let at = |e| return_map(k, 0.0, e, 0.0, &law(k, h)).tension;
        let slope = (at(0.05 + d) - at(0.05 - d)) / (2.0 * d);
        assert!((slope - k * h / (k + h)).abs() < 1e-4);
    }

    #[test]
    fn an_elastic_and_a_broken_spring_pass_unharmed() {
        let never = Yield {
            tension: f32::INFINITY,
            compression: f32::INFINITY,
            hardening: 0.0,
            inverse: 0.0,
        };
        assert_eq!(
            return_map(1000.0_f32, 1.0, 2.0, 0.0, &never).tension,
            2000.0
        );
        assert_eq!(return_map(0.0_f32, 1.0, 2.0, 0.3, &never).tension, 0.0);
    }
}
