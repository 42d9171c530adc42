//! Colliders that notice a deformable and do not push it: sensors, and those whose solver groups do not agree with its own.
//!
//! They are looked at after every Rapier step, where colliders and nodes stand then. A node that went right through in
//! between is found by its path, taken as straight, relative to the collider.

use super::observer::Partner;
use super::reach::true_pose;
use super::touch::Touch;
use super::{Deformable, DeformableHandle, DeformableWorld, RapierParts};
use crate::contact::target::wide_rotation;
use crate::math::{DVec3, Pose, narrow, wide};
use rapier3d::geometry::{Aabb, Collider, ColliderHandle, Ray};
use rapier3d::parry::bounding_volume::BoundingVolume;

/// A deformable and a collider that may notice it in the coming Rapier step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sensing {
    pub deformable: DeformableHandle,
    pub collider: ColliderHandle,
    pub sensor: bool,
    /// Where the collider stood before the step.
    pub start: Pose,
}

impl DeformableWorld {
    /// After Rapier's step: which colliders notice which deformables.
    pub(super) fn sense(&mut self, parts: &RapierParts) {
        let sensing = std::mem::take(&mut self.sensing);
        for s in &sensing {
            let collider = parts.colliders.get(s.collider);
            let (Some(body), Some(collider)) = (self.get(s.deformable), collider) else {
                continue;
            };
            let end = true_pose(collider, parts);
            let partner = Partner::Collider(s.collider);
            let key = Touch::key(s.deformable, partner);
            let was = self.touches.get(&key);
            let was = was.is_some_and(|t| t.inside == self.steps - 1);
            let inside = end.is_finite() && body.touching(&end, collider.shape(), 0.0).is_some();
            if inside || (!was && body.passed(collider, &s.start, &end)) {
                let touch = self.touches.entry(key);
                let touch = touch.or_insert_with(|| Touch::new(s.deformable, partner));
                touch.sensor = s.sensor;
                touch.seen = true;
                if inside {
                    touch.inside = self.steps;
                }
            }
        }
        self.sensing = sensing;
    }
}

impl Deformable {
    /// Whether any node went through a collider in the Rapier step that led it from `start` to `end`.
    fn passed(&self, collider: &Collider, start: &Pose, end: &Pose) -> bool {
        let shape = collider.shape();
        let bounds = shape.compute_local_aabb();
        if !(start.is_finite() && end.is_finite()) {
            return false;
        }
        let local = |pose: &Pose, p: DVec3| {
            narrow(wide_rotation(pose.rotation).inverse() * (p - wide(pose.translation)))
        };
        (0..self.node_count()).any(|i| {
            let from = local(start, self.backup.position(i));
            let to = local(end, self.state.position(i));
            let path = Aabb::new(from.min(to), from.max(to));
            from.is_finite()
                && to.is_finite()
                && path.intersects(&bounds)
                && shape
                    .cast_local_ray(&Ray::new(from, to - from), 1.0, true)
                    .is_some()
        })
    }
}
