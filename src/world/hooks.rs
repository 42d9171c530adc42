//! The user's say in what may touch what, beside Rapier's own hooks: those tell pairs by two colliders, and a deformable has
//! none.

use super::{Deformable, DeformableHandle, DeformableWorld};
use crate::contact::form::Form;
use crate::contact::target::{admits, pushes};
use rapier3d::dynamics::{RigidBody, RigidBodyHandle};
use rapier3d::geometry::{Collider, ColliderHandle};
use rapier3d::pipeline::PhysicsWorld;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A deformable and a collider that may come to touch.
#[derive(Clone, Copy)]
pub struct PairContext<'a> {
    /// The deformable.
    pub deformable: (DeformableHandle, &'a Deformable),
    /// The collider; a sensor as well.
    pub collider: (ColliderHandle, &'a Collider),
    /// Its rigid body, if it has one.
    pub body: Option<(RigidBodyHandle, &'a RigidBody)>,
}

/// Decides which pairs touch, see [`DeformableWorld::set_hooks`]. A closure of a [`PairContext`] is one.
///
/// Asked once for every pair within reach and every Rapier step, after whether both are enabled and their collision groups
/// agree, and before the solver groups; once more when a group falls asleep, and by [`DeformableWorld::may_touch`] and
/// [`DeformableWorld::may_meet`] whenever these are called. Odd answers are taken as they are:
/// - A pair that is refused while it touches parts at once, what lay there wakes, and nothing is remembered of the contact.
///   Accepted again while one is inside of the other, they are moved apart at
///   [`push_out_speed`](super::DeformableParameters::push_out_speed), as two that were created that way; of what a node has
///   gone through in between, it does not know from which side it came.
/// - A panic is not caught. It leaves [`DeformableWorld::step`] before anything of the coming Rapier step was touched: both
///   worlds are whole and stand between two Rapier steps, though the rest of the frame is missing.
pub trait DeformableHooks: Send + Sync {
    /// Whether a deformable and a collider may touch. A refused sensor does not notice the deformable.
    fn filter(&self, pair: &PairContext) -> bool {
        let _ = pair;
        true
    }

    /// Whether two deformables may touch; the one of the smaller slot comes first.
    fn filter_pair(
        &self,
        first: (DeformableHandle, &Deformable),
        second: (DeformableHandle, &Deformable),
    ) -> bool {
        let _ = (first, second);
        true
    }
}

impl<F: Fn(&PairContext) -> bool + Send + Sync> DeformableHooks for F {
    fn filter(&self, pair: &PairContext) -> bool {
        self(pair)
    }
}

/// The deformable and the collider of a question.
type Asked = ((u32, u32), (u32, u32));

/// The hooks, and their answers in the Rapier step under way.
#[derive(Clone, Default)]
pub(super) struct Gate {
    hooks: Option<Arc<dyn DeformableHooks>>,
    answers: BTreeMap<Asked, bool>,
}

impl std::fmt::Debug for Gate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Gate")
            .field("hooked", &self.hooks.is_some())
            .finish_non_exhaustive()
    }
}

impl Gate {
    /// Whether the hooks let a pair touch.
    pub fn passes(&mut self, pair: &PairContext) -> bool {
        let Some(hooks) = &self.hooks else {
            return true;
        };
        let key = (pair.deformable.0.key(), pair.collider.0.into_raw_parts());
        *self
            .answers
            .entry(key)
            .or_insert_with(|| hooks.filter(pair))
    }
}

impl DeformableWorld {
    /// Lets `hooks` decide which pairs may touch. They stay with the world and its clones.
    ///
    /// ```
    /// use crumple::prelude::*;
    /// use crumple::rapier3d::prelude::*;
    /// use std::sync::Arc;
    /// let mut deformables = DeformableWorld::default();
    /// // Ghosts go through everything.
    /// deformables.set_hooks(Arc::new(|pair: &PairContext| pair.deformable.1.user_data != 13));
    /// # let mut world = PhysicsWorld::default();
    /// # world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::cuboid(5.0, 0.1, 5.0));
    /// # let ghost = deformables.insert(
    /// #     DeformableBuilder::new(lattice(Vector::splat(0.4), 0.2))
    /// #         .material(Material::rubber())
    /// #         .translation(Vector::Y * 0.4)
    /// #         .user_data(13),
    /// # )?;
    /// # for _ in 0..60 {
    /// #     deformables.step(&mut world);
    /// # }
    /// # assert!(deformables[ghost].center_of_mass().y < -1.0);
    /// # Ok::<(), crumple::body::BuildError>(())
    /// ```
    pub fn set_hooks(&mut self, hooks: Arc<dyn DeformableHooks>) {
        self.gate.hooks = Some(hooks);
    }

    /// Lets everything touch again that groups let touch.
    pub fn clear_hooks(&mut self) {
        self.gate.hooks = None;
    }

    /// Whether two different deformables may touch, by being enabled, by their collision groups, and by the hooks.
    pub fn may_meet(&self, a: DeformableHandle, b: DeformableHandle) -> bool {
        let (first, second) = if a.key() <= b.key() { (a, b) } else { (b, a) };
        let (Some(one), Some(other)) = (self.get(first), self.get(second)) else {
            return false;
        };
        let groups = [one, other].map(|body| body.surface.collision_groups);
        let hooks = &self.gate.hooks;
        a != b
            && one.is_enabled()
            && other.is_enabled()
            && groups[0].test(groups[1])
            && (hooks.as_ref()).is_none_or(|h| h.filter_pair((first, one), (second, other)))
    }

    /// Whether a deformable and a collider may touch, by being enabled, by the collider's shape, by their groups, and by the
    /// hooks. A sensor never does.
    pub fn may_touch(
        &self,
        deformable: DeformableHandle,
        collider: ColliderHandle,
        world: &PhysicsWorld,
    ) -> bool {
        let found = self.get(deformable).zip(world.colliders.get(collider));
        let Some((soft, rigid)) = found else {
            return false;
        };
        let parent = rigid.parent().and_then(|h| Some((h, world.bodies.get(h)?)));
        let pair = PairContext {
            deformable: (deformable, soft),
            collider: (collider, rigid),
            body: parent,
        };
        soft.is_enabled()
            && admits(rigid, parent.map(|(_, body)| body), &soft.surface)
            && pushes(rigid, &soft.surface)
            && Form::takes(rigid.shape())
            && (self.gate.hooks.as_ref()).is_none_or(|h| h.filter(&pair))
    }

    /// The gate, to be asked while the world is looked at. A panic of a hook takes the answers along, never the hooks.
    pub(super) fn open_gate(&mut self) -> Gate {
        Gate {
            hooks: self.gate.hooks.clone(),
            answers: std::mem::take(&mut self.gate.answers),
        }
    }

    /// Keeps the answers for the rest of this Rapier step.
    pub(super) fn keep_answers(&mut self, gate: Gate) {
        self.gate.answers = gate.answers;
    }

    /// Forgets the answers: the next Rapier step asks anew.
    pub(super) fn forget_answers(&mut self, mut gate: Gate) {
        gate.answers.clear();
        self.gate.answers = gate.answers;
    }
}
