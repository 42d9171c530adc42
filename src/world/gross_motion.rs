//! How the nodes of a body move on the whole, and how fast that and others may come towards each other.

use super::Deformable;
use crate::math::DVec3;
use crate::solve::shadow::Shadow;

/// How the nodes of a body move.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GrossMotion {
    /// Mean of their velocities, and the largest speed against it \[m/s\].
    pub mean: DVec3,
    pub most: f64,
    /// Mean of their places, and the largest distance from it \[m\].
    pub centre: DVec3,
    pub radius: f64,
}

impl GrossMotion {
    /// How fast a rigid body and what moves as the nodes do on the average may come towards each other, or go \[m/s\].
    pub fn closing(&self, shadow: &Shadow) -> f64 {
        let there = shadow.velocity_at(self.centre - shadow.com);
        (there - self.mean).length() + shadow.w.length() * self.radius
    }
}

impl Deformable {
    /// How its nodes move and where they are.
    pub(super) fn gross_motion(&self) -> GrossMotion {
        let nodes = 0..self.node_count();
        let share = 1.0 / nodes.len().max(1) as f64;
        let mut motion = GrossMotion::default();
        for i in nodes.clone() {
            motion.mean += self.state.velocity(i) * share;
            motion.centre += self.state.position(i) * share;
        }
        let (mut most, mut radius) = (0.0_f64, 0.0_f64);
        for i in nodes {
            most = most.max((self.state.velocity(i) - motion.mean).length_squared());
            radius = radius.max((self.state.position(i) - motion.centre).length_squared());
        }
        (motion.most, motion.radius) = (most.sqrt(), radius.sqrt());
        motion
    }
}
