//! Which sleeping rigid bodies must wake: Rapier lets them sleep by their own motion, and knows nothing of what lies on them,
//! carries them, or comes at them.

use crate::coupling::observe::velocity;
use crate::math::{DVec3, wide};
use crate::world::group::{Touched, handle_of};
use crate::world::reach::{self, Search};
use crate::world::substep::Group;
use crate::world::{AttachmentState, DeformableWorld, RapierParts};
use rapier3d::dynamics::{RigidBodyHandle, RigidBodySet};

/// How deep a held node is at least for which a body is kept awake, in length units: for less it would hardly move.
const DEEP: f64 = 5e-4;

impl Group {
    /// Per touched body, whether it holds a node that is deep in what never moves, and has to get it out: asleep it would not be
    /// lifted.
    pub(in crate::world) fn holders(&self, unit: f64, bodies: &RigidBodySet) -> Vec<bool> {
        let body = |shadow: u32| Some(&self.touched[(shadow as usize).checked_sub(1)?]);
        let never_moves = |t: &Touched| bodies.get(t.body).is_some_and(|b| !b.is_dynamic());
        let mut holds = vec![false; self.touched.len()];
        for [holder, in_what] in self.rows.held_deep(DEEP * unit) {
            if holder > 0 && body(in_what).is_none_or(never_moves) {
                holds[holder as usize - 1] = true;
            }
        }
        holds
    }

    /// Whether a kinematic body that it touches moves in a rigid step of `dt` s, or nodes are led: Rapier lets nothing sleep that
    /// touches a kinematic body on its way, and what does so through a deformable is no less on its way.
    pub(in crate::world) fn is_led(&self, near: &[bool], bodies: &RigidBodySet, dt: f64) -> bool {
        let moves = |(t, near): (&Touched, &bool)| {
            let kinematic = bodies.get(t.body).filter(|b| *near && b.is_kinematic());
            kinematic.is_some_and(|b| {
                let (v, w) = velocity(b, dt);
                v.length_squared() + w.length_squared() > 0.0
            })
        };
        self.touched.iter().zip(near).any(moves)
            || self.members.iter().any(|(_, body)| body.has_moving_pins())
    }
}

impl DeformableWorld {
    /// Whether one of the bodies that a group touches is on its way: awake, and not where it stayed. Like an island of Rapier's, what
    /// hangs together by deformables sleeps as a whole.
    pub(in crate::world) fn has_movers(
        &mut self,
        group: &Group,
        near: &[bool],
        parts: &RapierParts,
    ) -> bool {
        let unit = parts.length_unit();
        let mut any = false;
        for (touched, _) in group.touched.iter().zip(near).filter(|(_, near)| **near) {
            let key = touched.body.into_raw_parts();
            let (Some(body), Some(memory)) =
                (parts.bodies.get(touched.body), self.memory.get_mut(&key))
            else {
                continue;
            };
            if body.is_dynamic() && !body.is_sleeping() {
                let extent = f64::from(body.mass_properties().max_extent());
                // What has no colliders has no extent.
                let arm = if extent > 0.0 { extent } else { unit };
                any |= memory.moves_on(touched.at, arm, unit);
            }
        }
        any
    }

    /// Wakes bodies that a deformable is about to hit, at twice the speed below which Rapier lets bodies sleep, and those that
    /// its pinned nodes take along.
    pub(in crate::world) fn wake_sleepers_in_the_way(&mut self, parts: &mut RapierParts, dt: f64) {
        let threshold = 0.1 * parts.length_unit();
        if !self.iter().any(|(_, b)| b.is_active()) {
            return;
        }
        let search = Search::ahead(&mut self.known, &self.attachments, parts, dt);
        let mut wake = self.loads_of_moving_pins(&search);
        let mut forms = std::mem::take(&mut self.forms);
        let mut gate = self.open_gate();
        for own in self.iter().filter(|(_, b)| b.is_active()) {
            wake.extend(reach::sleepers_in_the_way(
                own, &search, &mut gate, &mut forms, threshold,
            ));
        }
        self.keep_answers(gate);
        self.forms = forms;
        for handle in wake {
            parts.islands.wake_up(parts.bodies, handle, true);
        }
    }

    /// Bodies asleep that are attached to pinned nodes which are on their way, or were put elsewhere since the last step.
    /// Neither of the two gives way, so their attachment would bear nothing, and the body stay behind.
    fn loads_of_moving_pins(&self, search: &Search) -> Vec<RigidBodyHandle> {
        let parts = search.parts;
        let takes_along = |bond: &AttachmentState| {
            let Some(soft) = self.get(bond.deformable).filter(|b| b.is_active()) else {
                return false;
            };
            let mut pins = bond.pinned_nodes(&soft.state).peekable();
            if bond.is_broken() || pins.peek().is_none() {
                return false;
            }
            let velocities = soft.coming_velocities(search.lead);
            pins.any(|node| velocities[node as usize] != DVec3::ZERO)
                || self.is_moved_asleep(bond, parts)
        };
        let loads = self.attachments.iter().filter_map(|(_, bond)| {
            let body = parts.bodies.get(bond.body()?)?;
            let wakes = body.is_enabled() && body.is_dynamic() && body.is_sleeping();
            (wakes && takes_along(bond)).then_some(bond.body())?
        });
        loads.collect()
    }

    pub(in crate::world) fn watch_sleepers(&mut self, parts: &mut RapierParts, dt: f64) {
        let gravity = wide(parts.gravity).length();
        let mut wake = Vec::new();
        let steps = self.steps;
        self.feel_sleeping_islands();
        self.memory.retain(|&key, memory| {
            let handle = handle_of(key);
            let Some(body) = parts.bodies.get(handle) else {
                return false;
            };
            let near = memory.near && memory.seen == steps;
            if memory.seen != steps {
                memory.feel(Default::default(), dt);
            }
            let weight = f64::from(body.mass()) * gravity;
            if memory.watch_sleep(body.is_sleeping(), near, weight, dt) {
                wake.push(handle);
            }
            memory.seen == steps || body.is_sleeping()
        });
        for handle in wake {
            parts.islands.wake_up(parts.bodies, handle, true);
        }
    }

    /// Rapier lets sleepers sleep when gravity changes; those that lie on deformables are woken, and the deformables.
    pub(in crate::world) fn wake_on_new_gravity(&mut self, parts: &mut RapierParts) {
        let old = self.gravity.replace(parts.gravity);
        if old.is_some_and(|g| g != parts.gravity) {
            for handle in self.memory.keys().copied().map(handle_of) {
                if parts.bodies.get(handle).is_some_and(|b| b.is_sleeping()) {
                    parts.islands.wake_up(parts.bodies, handle, true);
                }
            }
            self.iter_mut().for_each(|(_, body)| body.wake_up());
        }
    }
}
