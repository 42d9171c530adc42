//! Spans: between which velocities those of all nodes of a body lie.
//!
//! What two bodies may do to each other in a substep is bounded by how differently they move, and far closer than by how fast
//! they are where they move together: as what falls together does, or a heap that is carried along.

use super::Deformable;
use crate::math::DVec3;
use crate::solve::kernel;

/// Up to this speed the speed itself will do, in length units/s: it is half of what forces may add within a substep, see
/// [`Reach`](crate::contact::site::Reach).
const SLOW: f64 = 0.5;

/// What numbers of `f32` may be off by, relative to the largest.
const ROUNDING: f64 = 1e-6;

/// The corners of the box around the velocities of all nodes \[m/s\].
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(super) struct Span {
    lo: DVec3,
    hi: DVec3,
}

/// How the nodes of a body moved in a substep.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(super) struct Way {
    /// When that ended, and how long it was \[s\].
    pub ended: f64,
    pub h: f64,
    /// Between which velocities.
    pub span: Span,
}

impl Span {
    /// Of velocities of `speed` m/s at most.
    pub fn within(speed: f64) -> Self {
        let hi = DVec3::splat(speed);
        Self { lo: -hi, hi }
    }

    /// With one velocity more.
    pub fn with(self, v: DVec3) -> Self {
        Self {
            lo: self.lo.min(v),
            hi: self.hi.max(v),
        }
    }

    /// Of points that are weighted means of nodes, the sizes of whose weights sum up to `gain`.
    pub fn of_points(self, gain: f64) -> Self {
        let (middle, half) = (0.5 * (self.lo + self.hi), 0.5 * (self.hi - self.lo));
        let half = half * gain + ROUNDING * self.lo.abs().max(self.hi.abs());
        Self {
            lo: middle - half,
            hi: middle + half,
        }
    }

    /// How fast anything in one may be relative to anything in the other, at most \[m/s\].
    pub fn apart(&self, other: &Self) -> f64 {
        (self.hi - other.lo).max(other.hi - self.lo).length()
    }
}

impl Deformable {
    /// Between which velocities its nodes are now; by schemes that do not move them by these, between those that its speed allows.
    pub(super) fn span_of_velocities(&self, length_unit: f64) -> Span {
        let fastest = self.fastest();
        if fastest <= SLOW * length_unit || !self.integrator().takes_late_impulses() {
            return Span::within(fastest);
        }
        let [lo, hi] = kernel::velocities_around(self.solver.kernel, &self.state);
        Span { lo, hi }
    }

    /// How fast its points may come nearer to those of another in the coming substep, at most \[m/s\].
    pub(super) fn closing(&self, other: &Self) -> f64 {
        let spans = [self, other].map(|body| body.span.of_points(body.gain()));
        let together = self.fastest() + other.fastest();
        spans[0].apart(&spans[1]).min(together)
    }

    /// How much nearer they may have come to those of another in the last substep, and since, at most \[m\].
    pub(super) fn closed(&self, other: &Self) -> f64 {
        let together = self.moved + other.moved;
        match (&self.way, &other.way) {
            (Some(own), Some(others)) if own.ended == others.ended => {
                let spans = [(own, self), (others, other)]
                    .map(|(way, body)| way.span.of_points(body.gain()));
                together.min(own.h * spans[0].apart(&spans[1]))
            }
            _ => together,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Material;
    use crate::math::Vector;
    use crate::shape;
    use crate::world::{DeformableBuilder, DeformableWorld};
    use proptest::prelude::*;
    use rapier3d::pipeline::PhysicsWorld;

    fn velocity() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-10.0..10.0f64).prop_map(DVec3::from_array)
    }

    proptest! {
        /// Of nodes and of points outside of their triangle.
        #[test]
        fn no_two_points_come_nearer_faster(
            own in prop::array::uniform3(velocity()),
            others in prop::array::uniform3(velocity()),
            (a, b) in (-1.0..2.0f64, -1.0..2.0f64),
        ) {
            let weights = [a, b, 1.0 - a - b];
            let gain = weights.iter().map(|w| w.abs()).sum();
            let span = |of: &[DVec3; 3]| Span { lo: of[0], hi: of[0] }.with(of[1]).with(of[2]);
            let point: DVec3 = weights.iter().zip(own).map(|(w, v)| v * *w).sum();
            let most = span(&own).of_points(gain).apart(&span(&others));
            for other in others {
                prop_assert!(point.distance(other) <= most);
                prop_assert!(span(&own).apart(&span(&others)) >= own[0].distance(other));
            }
        }
    }

    /// Symptom: blocks that fell beside each other looked for each other as if each fell on the other.
    #[test]
    fn what_falls_together_does_not_close() {
        let (mut world, mut deformables) = (PhysicsWorld::default(), DeformableWorld::default());
        let blocks = [0.0, 0.201].map(|x| {
            let net = shape::lattice(Vector::splat(0.2), 0.1).unwrap();
            let block = DeformableBuilder::new(net).material(Material::rubber());
            let block = block.translation(Vector::X * x);
            let block = deformables.insert(block).unwrap();
            deformables[block].set_velocities(Vector::Y * -20.0, Vector::ZERO);
            block
        });
        (0..3).for_each(|_| deformables.step(&mut world));
        let [a, b] = blocks.map(|block| &deformables[block]);
        assert!(a.fastest() > 20.0);
        assert!(a.closing(b) < 0.01, "{} m/s", a.closing(b));
        assert!(a.closed(b) < 1e-4 * a.moved, "{} m", a.closed(b));
    }
}
