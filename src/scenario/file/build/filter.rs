//! Pairs that do not touch.

use super::super::super::Cast;
use super::super::model::Scenario;
use crate::world::{Deformable, DeformableHandle, DeformableHooks, DeformableWorld, PairContext};
use rapier3d::dynamics::RigidBodyHandle;
use rapier3d::geometry::SolverFlags;
use rapier3d::pipeline::{ActiveHooks, PairFilterContext, PhysicsHooks, PhysicsWorld};
use std::sync::Arc;

/// Something that may touch.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Rigid(RigidBodyHandle),
    Soft(DeformableHandle),
}

/// The pairs that may not.
#[derive(Clone)]
struct Apart(Vec<[Side; 2]>);

impl Apart {
    fn holds(&self, a: Side, b: Side) -> bool {
        self.0.iter().any(|pair| *pair == [a, b] || *pair == [b, a])
    }
}

impl PhysicsHooks for Apart {
    fn filter_contact_pair(&self, context: &PairFilterContext) -> Option<SolverFlags> {
        let bodies = context.rigid_body1.zip(context.rigid_body2);
        let apart = bodies.is_some_and(|(a, b)| self.holds(Side::Rigid(a), Side::Rigid(b)));
        (!apart).then(SolverFlags::default)
    }

    fn filter_intersection_pair(&self, context: &PairFilterContext) -> bool {
        self.filter_contact_pair(context).is_some()
    }
}

impl DeformableHooks for Apart {
    fn filter(&self, pair: &PairContext) -> bool {
        let body = pair.body.map(|(handle, _)| Side::Rigid(handle));
        !body.is_some_and(|body| self.holds(Side::Soft(pair.deformable.0), body))
    }

    fn filter_pair(
        &self,
        first: (DeformableHandle, &Deformable),
        second: (DeformableHandle, &Deformable),
    ) -> bool {
        !self.holds(Side::Soft(first.0), Side::Soft(second.0))
    }
}

/// Keeps the pairs of a scene apart; what Rapier must be told in every step, if there are any.
pub(super) fn install(
    scene: &Scenario,
    world: &mut PhysicsWorld,
    deformables: &mut DeformableWorld,
    cast: &Cast,
) -> Option<Arc<dyn PhysicsHooks>> {
    if scene.no_contact.is_empty() {
        return None;
    }
    let side = |name: &String| match cast.body(name) {
        Some(body) => Some(Side::Rigid(body)),
        None => cast.deformable(name).map(Side::Soft),
    };
    let pairs = scene.no_contact.iter();
    let pairs: Vec<[Side; 2]> = pairs
        .filter_map(|[a, b]| Some([side(a)?, side(b)?]))
        .collect();
    for (_, collider) in world.colliders.iter_mut() {
        let body = collider.parent().map(Side::Rigid);
        if pairs.iter().flatten().any(|s| Some(*s) == body) {
            let hooks = ActiveHooks::FILTER_CONTACT_PAIRS | ActiveHooks::FILTER_INTERSECTION_PAIR;
            collider.set_active_hooks(hooks);
        }
    }
    let apart = Arc::new(Apart(pairs));
    deformables.set_hooks(apart.clone());
    Some(apart)
}
