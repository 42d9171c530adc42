//! How two surfaces treat each other.

use super::outline::Outline;
use crate::contact::target::SurfaceProperties;
use rapier3d::dynamics::CoefficientCombineRule;

/// What two bodies agree upon.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Manners {
    /// Combined μ.
    pub friction: f64,
    /// What each keeps to itself of the distance between them: half of its thickness \[m\].
    pub halves: [f64; 2],
    /// Stiffness of their contacts \[N/m\] per point, if they give.
    pub stiffness: Option<f64>,
    /// What each takes of an impulse: 1, or 0 if it dominates the other.
    pub shares: [f64; 2],
}

/// Whether two surfaces meet at all.
pub fn admit(a: &SurfaceProperties, b: &SurfaceProperties) -> bool {
    a.collision_groups.test(b.collision_groups) && a.solver_groups.test(b.solver_groups)
}

impl Manners {
    /// Of the surfaces of two bodies.
    pub fn new(surfaces: [&SurfaceProperties; 2], outlines: [&Outline; 2]) -> Self {
        let [a, b] = surfaces;
        let friction = CoefficientCombineRule::combine(
            a.friction,
            b.friction,
            a.friction_combine_rule,
            b.friction_combine_rule,
        );
        let half = |outline: &Outline, surface: &SurfaceProperties| {
            0.5 * outline.thickness(surface.thickness)
        };
        Self {
            friction: f64::from(friction).max(0.0),
            halves: [half(outlines[0], a), half(outlines[1], b)],
            // Springs in series.
            stiffness: match (a.stiffness, b.stiffness) {
                (Some(a), Some(b)) => Some(1.0 / (1.0 / f64::from(a) + 1.0 / f64::from(b))),
                (a, b) => a.or(b).map(f64::from),
            },
            shares: [
                f64::from(a.dominance_group <= b.dominance_group),
                f64::from(b.dominance_group <= a.dominance_group),
            ],
        }
    }

    /// The distance that they keep \[m\].
    pub fn distance(&self) -> f64 {
        self.halves[0] + self.halves[1]
    }

    /// What part of a gap each fills, half of it where neither has a thickness.
    pub fn parts(&self) -> [f64; 2] {
        let sum = self.distance();
        self.halves.map(|h| if sum > 0.0 { h / sum } else { 0.5 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::geometry::{Group, InteractionGroups, InteractionTestMode};

    #[test]
    fn surfaces_agree() {
        let a = SurfaceProperties {
            friction: 0.2,
            thickness: 0.01,
            stiffness: Some(100.0),
            dominance_group: 1,
            ..SurfaceProperties::default()
        };
        let b = SurfaceProperties {
            friction: 0.6,
            stiffness: Some(300.0),
            ..SurfaceProperties::default()
        };
        let outline = Outline::default();
        let m = Manners::new([&a, &b], [&outline, &outline]);
        assert!((m.friction - 0.4).abs() < 1e-6);
        assert!((m.stiffness.unwrap() - 75.0).abs() < 1e-9);
        assert!((m.distance() - 0.005).abs() < 1e-9);
        assert_eq!(m.parts(), [1.0, 0.0]);
        assert_eq!(m.shares, [0.0, 1.0]);
        assert!(admit(&a, &b));
        let apart = SurfaceProperties {
            collision_groups: InteractionGroups::new(
                Group::GROUP_1,
                Group::GROUP_2,
                InteractionTestMode::And,
            ),
            ..SurfaceProperties::default()
        };
        assert!(!admit(&apart, &apart));
    }
}
