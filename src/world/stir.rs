//! How the nodes of a body move on the whole, and how fast that and others may come towards each other.

use super::Deformable;
use crate::math::DVec3;
use crate::solve::shadow::Shadow;

/// How the nodes of a body move.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stir {
    /// Mean of their velocities, and the largest speed against it \[m/s\].
    pub mean: DVec3,
    pub most: f64,
    /// Mean of their places, and the largest distance from it \[m\].
    pub centre: DVec3,
    pub radius: f64,
}

impl Stir {
    /// How fast a rigid body and what moves as the nodes do on the average may come towards each other, or go \[m/s\].
    pub fn closing(&self, shadow: &Shadow) -> f64 {
        let there = shadow.velocity_at(self.centre - shadow.com);
        (there - self.mean).length() + shadow.w.length() * self.radius
    }
}

impl Deformable {
    /// How its nodes move and where they are.
    pub(super) fn stir(&self) -> Stir {
        let nodes = 0..self.node_count();
        let share = 1.0 / nodes.len().max(1) as f64;
        let mut stir = Stir::default();
        for i in nodes.clone() {
            stir.mean += self.state.velocity(i) * share;
            stir.centre += self.state.position(i) * share;
        }
        let (mut most, mut radius) = (0.0_f64, 0.0_f64);
        for i in nodes {
            most = most.max((self.state.velocity(i) - stir.mean).length_squared());
            radius = radius.max((self.state.position(i) - stir.centre).length_squared());
        }
        (stir.most, stir.radius) = (most.sqrt(), radius.sqrt());
        stir
    }
}
