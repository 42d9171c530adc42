//! What Rapier's BVH knows of colliders, and which of them it does not know as they are now.

use super::RapierParts;
use super::reach::true_pose;
use crate::contact::form::address;
use crate::contact::target::is_on;
use crate::math::Pose;
use rapier3d::dynamics::RigidBodyType;
use rapier3d::geometry::{
    Aabb, Collider, ColliderHandle, InteractionGroups, Shape, ShapeType, SharedShape,
};
use std::sync::{Arc, Weak};

/// What the BVH knew of a collider at its last update, and what else of it Rapier looks at only within its step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
struct Description {
    generation: u32,
    enabled: bool,
    /// In its own frame.
    bounds: Aabb,
    /// Of one without a body.
    pose: Option<Pose>,
    groups: [InteractionGroups; 2],
    is_sensor: bool,
    /// Its body, what that is, and what it dominates.
    body: Option<((u32, u32), RigidBodyType, i16)>,
}

/// What it knew of each collider, by slot.
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize),
    serde(transparent)
)]
pub(super) struct Known {
    colliders: Vec<Option<Description>>,
    #[cfg_attr(feature = "serde-serialize", serde(skip))]
    boxes: Boxes,
}

impl Known {
    /// The colliders that it does not know as they are now.
    pub fn strays(&mut self, parts: &RapierParts) -> Vec<ColliderHandle> {
        let mut strays = Vec::new();
        for (handle, collider) in parts.colliders.iter() {
            let now = self.boxes.describe(handle, collider, parts);
            let (index, _) = handle.into_raw_parts();
            if self.colliders.get(index as usize) != Some(&Some(now))
                || true_pose(collider, parts) != *collider.position()
            {
                strays.push(handle);
            }
        }
        strays
    }

    /// The colliders that have gone or are not as they were known, those that are new left out, and Rapier's own soft bodies,
    /// which change by themselves.
    pub fn changed(&mut self, parts: &RapierParts) -> Vec<ColliderHandle> {
        let mut changed = self.strays(parts);
        let is_soft = |c: &Collider| c.deformable_mesh_ref().is_some();
        changed.retain(|handle| {
            self.knows(*handle) && !parts.colliders.get(*handle).is_some_and(is_soft)
        });
        changed.extend(self.gone(parts));
        changed
    }

    fn knows(&self, handle: ColliderHandle) -> bool {
        let (index, generation) = handle.into_raw_parts();
        let last = self.colliders.get(index as usize).copied().flatten();
        last.is_some_and(|last| last.generation == generation)
    }

    fn gone(&self, parts: &RapierParts) -> impl Iterator<Item = ColliderHandle> {
        let known = (0..).zip(&self.colliders);
        let known = known.filter_map(|(index, last)| {
            Some(ColliderHandle::from_raw_parts(
                index,
                last.as_ref()?.generation,
            ))
        });
        known.filter(|handle| !parts.colliders.contains(*handle))
    }

    /// Strays count as known once a Rapier step is certain to follow.
    pub fn remember(&mut self, strays: &[ColliderHandle], parts: &RapierParts) {
        for &handle in strays {
            let (index, _) = handle.into_raw_parts();
            let index = index as usize;
            let count = self.colliders.len().max(index + 1);
            self.colliders.resize(count, None);
            let collider = parts.colliders.get(handle);
            self.colliders[index] = collider.map(|c| self.boxes.describe(handle, c, parts));
        }
    }
}

/// The local boxes of hulls, by slot of the collider: only they walk over all their points for it. A shape that is pointed
/// at, be it weakly, keeps its address, and Rapier copies it before it changes it, so a box is never out of date.
#[derive(Clone, Debug, Default)]
struct Boxes(Vec<Option<(Weak<dyn Shape>, Aabb)>>);

impl Boxes {
    /// What the BVH will know of a collider after the coming step.
    fn describe(
        &mut self,
        handle: ColliderHandle,
        collider: &Collider,
        parts: &RapierParts,
    ) -> Description {
        let body = collider.parent().and_then(|b| parts.bodies.get(b));
        let (index, generation) = handle.into_raw_parts();
        Description {
            generation,
            enabled: is_on(collider, body),
            bounds: self.of(index as usize, collider.shared_shape()),
            pose: collider.parent().is_none().then(|| *collider.position()),
            groups: [collider.collision_groups(), collider.solver_groups()],
            is_sensor: collider.is_sensor(),
            body: collider.parent().zip(body).map(|(handle, body)| {
                let dominance = body.effective_dominance_group();
                (handle.into_raw_parts(), body.body_type(), dominance)
            }),
        }
    }

    fn of(&mut self, slot: usize, shape: &SharedShape) -> Aabb {
        use ShapeType::{ConvexPolyhedron, RoundConvexPolyhedron};
        if !matches!(shape.shape_type(), ConvexPolyhedron | RoundConvexPolyhedron) {
            return shape.compute_local_aabb();
        }
        if let Some(Some((held, bounds))) = self.0.get(slot)
            && held.as_ptr().cast::<()>() as usize == address(shape)
        {
            return *bounds;
        }
        let bounds = shape.compute_local_aabb();
        self.0.resize(self.0.len().max(slot + 1), None);
        self.0[slot] = Some((Arc::downgrade(&shape.0), bounds));
        bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use rapier3d::geometry::ColliderBuilder;
    use rapier3d::pipeline::PhysicsWorld;

    fn hull(height: f32) -> SharedShape {
        let corners = [Vector::ZERO, Vector::X, Vector::Y * height, Vector::Z];
        SharedShape::convex_hull(&corners).unwrap()
    }

    /// What is kept is told by a box that is not the shape's.
    #[test]
    fn the_box_of_a_hull_is_found_once() {
        let mut boxes = Boxes::default();
        let (shape, other) = (hull(1.0), hull(2.0));
        assert_eq!(boxes.of(3, &shape), shape.compute_local_aabb());
        let marked = Aabb::new(Vector::ZERO, Vector::splat(7.0));
        boxes.0[3].as_mut().unwrap().1 = marked;
        assert_eq!(boxes.of(3, &shape), marked);
        assert_eq!(boxes.of(3, &shape.clone()), marked);
        assert_eq!(boxes.of(2, &shape), shape.compute_local_aabb());
        assert_eq!(boxes.of(3, &other), other.compute_local_aabb());
        assert_eq!(boxes.of(3, &shape), shape.compute_local_aabb());
    }

    #[test]
    fn hulls_that_are_replaced_or_changed_in_place_are_strays() {
        let mut world = PhysicsWorld::default();
        let hulls = [hull(1.0), hull(1.0), hull(1.0)];
        let [kept, replaced, changed] = hulls.map(|shape| {
            let collider = ColliderBuilder::new(shape).translation(Vector::X * 5.0);
            world.insert_collider(collider, None)
        });
        let mut known = Known::default();
        let parts = RapierParts::from(&mut world);
        assert_eq!(known.strays(&parts), [kept, replaced, changed]);
        known.remember(&[kept, replaced, changed], &parts);
        assert!(known.strays(&parts).is_empty());
        for height in [2.0, 3.0] {
            world.colliders[replaced].set_shape(hull(height));
            let shape = world.colliders[changed].shape_mut();
            let shape = shape.as_convex_polyhedron_mut().unwrap();
            *shape = hull(height).as_convex_polyhedron().unwrap().clone();
            let parts = RapierParts::from(&mut world);
            assert_eq!(known.strays(&parts), [replaced, changed]);
            known.remember(&[replaced, changed], &parts);
            assert!(known.strays(&parts).is_empty());
        }
    }
}
