//! The row law: unilateral contact without depth-driven velocity, and Coulomb friction, as accumulated impulses.
//!
//! A contact asks for v·n ≥ u, with u = d/h while the surfaces are still apart (d < 0: they may close the gap within the
//! substep, no more) and u = 0 once they touch. A velocity computed from depth would throw overlapping bodies apart and
//! make squeezed ones jitter; depth is mended at position level instead, see [`push_out`].

use crate::math::DVec3;

/// Smallest relative normal velocity \[m/s\] a contact of signed depth `depth` \[m\] (positive inside) allows in a substep
/// of h \[s\].
#[inline(always)]
pub fn allowed_velocity(depth: f64, h: f64) -> f64 {
    if depth < 0.0 { depth / h } else { 0.0 }
}

/// Softness γ \[1/kg\] of a contact that gives with a stiffness of k N/m: with the velocity asked for by [`yielding`] its
/// impulse j ≥ 0 is written as v + γ·j = u. A rigid row has none.
#[inline(always)]
pub fn softness(stiffness: f64, h: f64) -> f64 {
    4.0 / (h * h * stiffness)
}

/// The velocity that a contact which gives asks for \[m/s\], if its normal velocity was `before` in the last substep.
///
/// The impulse is that of a spring, j = ½h·k·(d⁻ + d⁺) with the depths d⁻ = d + ½h·v⁻ and d⁺ = d − ½h·v⁺ half a substep before
/// and after: as in [`link`], the average acceleration between the half steps of leapfrog, without damping of its own. What had not
/// touched by then has no d⁻. While it enters and while it leaves, the impulse takes no less, and gives no more, energy than the
/// spring holds, so a bounce loses some (h·ω)²/3 of it and, in substeps of one length, never gains.
#[inline(always)]
pub fn yielding(depth: f64, before: f64, h: f64) -> f64 {
    let last = (depth + 0.5 * h * before).max(0.0);
    2.0 * (depth + last) / h
}

/// A link of k N/m and c N·s/m as a soft row: its softness γ \[1/kg\], and what of the elongation \[1/s\] and of the
/// velocity before the substep goes into the velocity asked for, v + γ·j = carry·v⁻ − pull·e.
///
/// The impulse is j = −h·(k·((1−β)·e⁻ + β·e⁺) + ½c(v⁺ + v⁻)) with the elongations e⁻ = e − ½h·v⁻ and e⁺ = e + ½h·v⁺ half a
/// substep before and after. With β = ½ that is Newmark's average acceleration between the half steps of leapfrog, stable at
/// every h and without damping of its own, where implicit Euler takes ½h·ω of critical. See [`lean`] for β.
#[inline(always)]
pub fn link(stiffness: f64, damping: f64, h: f64, lean: f64) -> (f64, f64, f64) {
    let spring = 0.5 * h * h * stiffness;
    let damper = 0.5 * h * damping;
    let sum = lean * spring + damper;
    let carry = (1.0 - lean) * spring - damper;
    (1.0 / sum, h * stiffness / sum, carry / sum)
}

/// How much of the elongation at its end a link takes in a substep of `h` s, by the length of the last one, 0 for none: half
/// of it, and more the more they differ. A mass on a link that is stiff for both has its place and so moves h_last/h times as
/// fast, and many such changes would be a pump: what is taken from it is more.
pub fn lean(last: f64, h: f64) -> f64 {
    let change = if last > 0.0 {
        (h - last).abs() / h.max(last)
    } else {
        0.0
    };
    0.5 * (1.0 + change)
}

/// The accumulated normal impulse \[N·s\] after one pass: j' = max(0, j + (u − v_n)·m_eff).
#[inline(always)]
pub fn normal_impulse(accumulated: f64, allowed: f64, velocity: f64, mass: f64) -> f64 {
    (accumulated + (allowed - velocity) * mass).max(0.0)
}

/// The accumulated friction impulse \[N·s\] after one pass: the one that stops the slip `slip` \[m/s\], within the Coulomb
/// disc of radius `limit` = μ·j_n.
#[inline(always)]
pub fn friction_impulse(accumulated: DVec3, slip: DVec3, mass: f64, limit: f64) -> DVec3 {
    let wanted = accumulated - slip * mass;
    let square = wanted.length_squared();
    if square > limit * limit {
        wanted * (limit / square.sqrt())
    } else {
        wanted
    }
}

/// How far a node at `depth` \[m\] inside is moved out in a substep of h \[s\]: half of it, at `rate` \[m/s\] at most.
#[inline(always)]
pub fn push_out(depth: f64, h: f64, rate: f64) -> f64 {
    (0.5 * depth).min(rate * h).max(0.0)
}

/// How a row moves a rigid body out of what nodes are in, or out of nodes that can't give way, because they are tied to that body,
/// pinned, or held on their other side: what is moved at position level would be brought back. Slowly, and with no more impulse than
/// that takes, for the body may be held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lift {
    /// \[m/s\].
    pub speed: f64,
    /// What is left of the impulse in this substep \[N·s\].
    pub left: f64,
}

impl Lift {
    /// By how much the normal velocity exceeds what it is to be, given by how much it exceeds what it must be at least, for an
    /// effective mass of `mass` kg. Any velocity between the two will do once the impulse is spent.
    #[inline(always)]
    pub fn excess(&mut self, excess: f64, mass: f64) -> f64 {
        if self.speed == 0.0 {
            return excess;
        }
        let missing = self.speed - excess.max(0.0);
        if missing <= 0.0 {
            return -missing;
        }
        let given = (missing * mass).min(self.left);
        self.left -= given;
        excess.min(0.0) - if mass > 0.0 { given / mass } else { 0.0 }
    }
}

/// How a surface that turns at ω \[rad/s\] comes towards a point on it, `arm` m from its centre of mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turn {
    /// ω, as far as it deflects what slides along the surface \[rad/s\].
    pub swing: DVec3,
    /// ½n·ω×(ω×r): half the acceleration of the surface's point along its normal \[m/s²\].
    pub bend: f64,
}

impl Turn {
    /// How much faster the surface comes than the velocity of a point tells that moves at `relative` m/s along it, in the mean
    /// over a substep of h \[s\]: Coriolis' and the centripetal acceleration, h·n·(ω×v + ½ω×(ω×r)). Without it a point that
    /// slides along a fan's blade sinks in by ωvh².
    ///
    /// It is no more than the speed at which the point comes: one that goes on sliding comes just as fast, for the surface has
    /// turned since, and what left faster than it came would have got energy from nowhere.
    #[inline(always)]
    pub fn faster(&self, relative: DVec3, normal: DVec3, h: f64) -> f64 {
        let faster = h * (normal.dot(self.swing.cross(relative)) + self.bend);
        faster.min((-relative.dot(normal)).max(0.0))
    }
}

/// What the mean velocity over a substep of h \[s\] of a point that turns at `w` \[rad/s\] with an arm of `arm` m differs from
/// that at its start \[m/s\]: ½h·ω×(ω×r), as far as the chord leads from the tangent. What sticks must take it, or it is left
/// behind by as much, and creeps outward on a turntable.
#[inline(always)]
pub fn chord(w: DVec3, arm: DVec3, h: f64) -> DVec3 {
    w.cross(w.cross(arm)) * (0.5 * h)
}

/// The share of its drift that a sticking point is moved back by in a substep of h \[s\]: e-fold in 30 ms. Impulses hold it
/// already; what is left is the creep of a millimetre per second that comes from contacts lost for single substeps.
#[inline(always)]
pub fn pull_back(h: f64) -> f64 {
    (h / 0.03).min(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_sticks_inside_and_slides_on_the_disc() {
        let slip = DVec3::new(0.3, -0.4, 0.0);
        let stick = friction_impulse(DVec3::ZERO, slip, 2.0, 1.5);
        assert!((stick + slip * 2.0).length() < 1e-15);
        let slide = friction_impulse(DVec3::ZERO, slip, 2.0, 0.5);
        assert!((slide.length() - 0.5).abs() < 1e-15);
        assert!(slide.dot(slip) < 0.0);
    }

    #[test]
    fn a_link_keeps_its_energy_at_any_substep_and_loses_what_its_damper_takes() {
        let (m, k) = (2.0, 50.0_f64);
        for (h, c) in [(0.01, 0.0), (0.3, 0.0), (3.0, 0.0), (0.01, 1.5), (0.3, 1.5)] {
            let (mut e, mut v) = (0.1, 0.0);
            let energy =
                |e: f64, v: f64, h: f64| 0.5 * m * v * v + 0.5 * k * (e - 0.5 * h * v).powi(2);
            let first = energy(e, v, h);
            let mut lost = 0.0;
            for _ in 0..1000 {
                let (softness, pull, carry) = link(k, c, h, 0.5);
                // v + γ·m·(v − v⁻) = carry·v⁻ − pull·e
                let new = (carry * v - pull * e + softness * m * v) / (1.0 + softness * m);
                lost += h * c * (0.5 * (v + new)).powi(2);
                v = new;
                e += h * v;
            }
            let last = energy(e, v, h) + lost;
            assert!(
                (last / first - 1.0).abs() < 1e-9,
                "h = {h}, c = {c}: {}",
                last / first
            );
        }
    }

    fn turn(w: DVec3, n: DVec3, arm: DVec3) -> Turn {
        Turn {
            swing: w,
            bend: 0.5 * n.dot(w.cross(w.cross(arm))),
        }
    }

    /// A point that is given the velocity the law asks for ends a substep on the turning surface, to the third order in h.
    #[test]
    fn a_point_stays_on_a_turning_surface() {
        let (w, n) = (DVec3::new(0.7, -0.4, 6.7), DVec3::new(0.0, 0.6, 0.8));
        let arm = DVec3::new(0.3, -0.2, 0.5);
        let along = DVec3::new(40.0, 8.0, -6.0);
        assert!(along.dot(n).abs() < 1e-12);
        let height = |h: f64| {
            let faster = turn(w, n, arm).faster(along - n, n, h);
            let v = w.cross(arm) + along + n * faster;
            let turned = crate::math::DQuat::from_scaled_axis(w * h);
            (arm + v * h - turned * arm).dot(turned * n)
        };
        let (one, half) = (height(1e-3), height(0.5e-3));
        assert!(one.abs() < 2e-6, "{one}");
        assert!((one / half - 8.0).abs() < 0.3, "{one} {half}");
    }

    /// And one that goes along with it ends where its own point of it does.
    #[test]
    fn a_point_that_sticks_stays_on_its_point() {
        let (w, arm) = (DVec3::new(0.7, -0.4, 6.7), DVec3::new(0.3, -0.2, 0.5));
        let off = |h: f64| {
            let turned = crate::math::DQuat::from_scaled_axis(w * h) * arm;
            (arm + (w.cross(arm) + chord(w, arm, h)) * h - turned).length()
        };
        let (one, half) = (off(1e-3), off(0.5e-3));
        assert!(one < 1e-7, "{one}");
        assert!((one / half - 8.0).abs() < 0.1, "{one} {half}");
    }

    #[test]
    fn what_meets_a_turning_surface_leaves_it_no_faster_than_it_came() {
        let (w, n, arm) = (
            DVec3::new(0.0, 0.0, 500.0),
            DVec3::Y,
            DVec3::new(0.01, 0.0, 0.0),
        );
        let along = DVec3::new(20.0, 0.0, 0.0);
        for came in [-3.0, 0.0, 0.2, 5.0, 1e3] {
            let faster = turn(w, n, arm).faster(along - n * came, n, 1e-3);
            assert_eq!(faster, came.clamp(0.0, 10.0), "{came}");
        }
    }

    /// Substeps of lengths that differ at random, by a little and by much, for links that they see well and hardly.
    #[test]
    fn substeps_that_change_give_a_link_no_energy() {
        let (m, mut seed) = (1.0, 1_u32);
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24)
        };
        for k in [1.0, 100.0, 1e4, 1e6] {
            for spread in [1.01, 1.5, 8.0_f64] {
                let (mut e, mut v, mut moved, mut last) = (0.0, 1.0, 0.0, 0.0);
                let (mut first, mut energy) = (None, 0.0);
                for i in 0..2000 {
                    let h = if i % 7 == 0 {
                        0.02 * spread.powf(random())
                    } else {
                        last
                    };
                    let before = moved / h;
                    let (softness, pull, carry) = link(k, 0.0, h, lean(last, h));
                    v = (carry * before - pull * e + softness * m * v) / (1.0 + softness * m);
                    (moved, last) = (h * v, h);
                    energy = 0.5 * m * v * v + 0.5 * k * (e + 0.5 * moved).powi(2);
                    // What moves as far in a shorter substep is faster for as long.
                    let most = 1.05 * spread * spread * *first.get_or_insert(energy);
                    assert!(energy <= most, "{k} {spread} {i}: {energy} of {most} J");
                    e += moved;
                }
                assert!(
                    Some(energy) <= first,
                    "{k} {spread}: {energy} of {first:?} J"
                );
            }
        }
    }

    /// A mass falls on a contact that gives, from where within a substep it may be: it comes back about as fast, and never faster.
    #[test]
    fn a_contact_that_gives_gives_back_what_it_took() {
        let (m, k, speed) = (2.0, 800.0_f64, 3.0);
        let period = (m / k).sqrt();
        for share in [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 30.0] {
            let h = share * period;
            for start in 0..20 {
                let (mut d, mut v) = (-h * speed * (1.0 + 0.05 * f64::from(start)), -speed);
                for _ in 0..1_000_000 {
                    let (softness, asked) = (softness(k, h), yielding(d, v, h));
                    let j = normal_impulse(0.0, asked, v, 1.0 / (1.0 / m + softness));
                    v += j / m;
                    d -= h * v;
                    if v > 0.0 && d < -h * speed {
                        break;
                    }
                }
                let kept = (v / speed).powi(2);
                assert!(v > 0.0 && kept <= 1.0 + 1e-9, "{share}: {kept}");
                let least = 1.0 - 0.5 * share * share - 1e-9;
                assert!(
                    kept >= least,
                    "{share}: {kept} of the energy, {least} expected"
                );
            }
        }
    }

    /// At rest it is as deep as the spring is pressed.
    #[test]
    fn a_contact_that_gives_bears_by_its_stiffness() {
        let (m, k, g, h) = (2.0, 800.0, 9.81, 0.02);
        let depth = m * g / k;
        let (softness, asked) = (softness(k, h), yielding(depth, 0.0, h));
        let j = normal_impulse(0.0, asked, -h * g, 1.0 / (1.0 / m + softness));
        assert!((j - m * g * h).abs() < 1e-12, "{j} N·s");
    }

    #[test]
    fn a_contact_never_pulls() {
        assert_eq!(normal_impulse(0.0, 0.0, 1.0, 5.0), 0.0);
        assert_eq!(normal_impulse(3.0, 0.0, 1.0, 5.0), 0.0);
        assert_eq!(normal_impulse(0.0, 0.0, -1.0, 5.0), 5.0);
    }
}
