//! What an attachment transmits in a substep: impulses, the energy of its links, and whether its strength holds.

use super::attach::{Bond, Break, Hold};
use crate::math::DVec3;
use crate::solve::rows::Tie;

/// Averaging time of the force that is held against the strength \[s\].
///
/// A blow that rigid parts take within one substep is an impulse J and has no force: J/h grows without bound as the
/// substep shrinks, and whether something breaks would be a matter of h. Averaged over 0.1 ms it is J/0.1 ms at every
/// substep; of a load that lasts for 1 ms the average reaches all but 5·10⁻⁵, and a load that grows within a second is read
/// 0.1 ms late. Substeps longer than that are taken as they are.
const AVERAGE_OVER: f64 = 1e-4;

/// Averages of force \[N\] and moment \[N·m\] on the target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Average {
    /// Force \[N\].
    pub force: DVec3,
    /// Moment \[N·m\].
    pub moment: DVec3,
}

impl Average {
    /// Mixes in the impulse \[N·s\] and angular impulse \[N·m·s\] of a substep of h s.
    pub fn feel(&mut self, impulse: DVec3, moment: DVec3, h: f64) {
        let mix = 1.0 - (-h / AVERAGE_OVER).exp();
        self.force += (impulse / h - self.force) * mix;
        self.moment += (moment / h - self.moment) * mix;
    }
}

/// Energies of a link's spring and damper over a substep \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkEnergy {
    /// Held by the spring before the substep and after it.
    pub held: (f64, f64),
    /// Dissipated by the damper, and where substeps change, never negative.
    pub dissipated: f64,
}

impl LinkEnergy {
    /// Of a tie that now moves at `velocity` \[m/s\] relative to its anchor. The spring's energy is that of the mean
    /// elongation between two substeps, for which the work of [`link`](crate::law::row::link) is exact.
    pub fn of(hold: Hold, tie: &Tie, velocity: DVec3, h: f64) -> Self {
        let Hold::Link { stiffness, damping } = hold else {
            return Self::default();
        };
        let held = |e: DVec3| 0.5 * stiffness * e.length_squared();
        let mean = 0.5 * (tie.before + velocity);
        let leaning = (tie.lean - 0.5) * stiffness * (h * mean).length_squared();
        Self {
            held: (
                held(tie.error - tie.before * (0.5 * h)),
                held(tie.error + velocity * (0.5 * h)),
            ),
            dissipated: damping * h * mean.length_squared() + leaning,
        }
    }
}

impl<D> Bond<D> {
    /// Feels an impulse and an angular impulse on the target over h s, and breaks when the average exceeds the strength.
    /// Returns whether it has just broken.
    pub fn bear(&mut self, impulse: DVec3, moment: DVec3, h: f64, time: f64) -> bool {
        self.average.feel(impulse, moment, h);
        let Average { force, moment } = self.average;
        let over = force.length() > self.strength || moment.length() > self.moment_strength;
        if over && self.broken.is_none() {
            self.broken = Some(Break {
                force,
                moment,
                time,
            });
            return true;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_of_a_millisecond_is_seen_in_full_and_a_blow_alike_at_every_substep() {
        for h in [1e-6_f64, 1e-5, 1e-4] {
            let mut average = Average::default();
            for _ in 0..(1e-3 / h).round() as usize {
                average.feel(DVec3::X * h, DVec3::ZERO, h);
            }
            assert!((average.force.x - 1.0).abs() < 1e-4, "{}", average.force.x);
            let mut blow = Average::default();
            blow.feel(DVec3::X, DVec3::Y, h);
            assert!(blow.force.x > 0.63 / AVERAGE_OVER && blow.force.x <= 1.0 / AVERAGE_OVER);
        }
    }
}
