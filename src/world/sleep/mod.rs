//! Sleep: deformables at rest cost nothing.
//!
//! A group of deformables sleeps as a whole, once all its nodes have been slow for a while and everything rigid that it can
//! touch rests as well ([`Island`]). It wakes when anything awake comes near, when anything near changes, and when one of
//! its bodies is changed (`wake.rs`). Rigid bodies sleep by Rapier's own rule, which knows nothing of deformables: `rigid.rs`
//! wakes those that must not.

mod island;
mod moored;
mod rigid;
mod struck;
mod wake;

pub(super) use island::{Drowsy, Island};
pub(super) use moored::Moorings;
#[cfg(feature = "serde-serialize")]
pub(super) use wake::{HeldShape, Neighbour};

use super::reach::Search;
use super::{Deformable, DeformableHandle, DeformableWorld, RapierParts};
use crate::math::DVec3;

/// A deformable's part in sleeping.
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sleep {
    /// Whether it may sleep.
    pub allowed: bool,
    pub asleep: bool,
    /// For how long its nodes have been slow \[s\].
    slow_for: f64,
    /// The momentum that it had when it fell asleep, summed up over all times it did \[N·s\].
    pub lost: DVec3,
    /// Whether a rigid body that is not fixed was in reach in the last step.
    pub beside_rigid: bool,
}

impl Sleep {
    pub fn new(allowed: bool) -> Self {
        Self {
            allowed,
            ..Self::default()
        }
    }

    /// What the next steps depend on.
    pub fn bits(&self) -> u64 {
        self.slow_for.to_bits() ^ u64::from(self.asleep) ^ u64::from(self.allowed) << 1
    }
}

impl Deformable {
    /// Whether it sleeps: it costs next to nothing, and stands still until something wakes it.
    pub fn is_sleeping(&self) -> bool {
        self.sleep.asleep
    }

    /// Wakes it, and in the next step the group it sleeps with. Every change of a body does that by itself.
    pub fn wake_up(&mut self) {
        self.sleep.asleep = false;
        self.sleep.slow_for = 0.0;
    }

    /// What of its momentum falling asleep has taken so far \[N·s\].
    pub(crate) fn momentum_lost_in_sleep(&self) -> DVec3 {
        self.sleep.lost
    }

    /// Whether it may sleep.
    pub fn can_sleep(&self) -> bool {
        self.sleep.allowed
    }

    /// Lets it sleep from now on, or not.
    pub fn set_can_sleep(&mut self, can_sleep: bool) {
        self.wake_up();
        self.sleep.allowed = can_sleep;
    }

    /// Whether rest is what it comes to: nothing drives it, and something damps it.
    fn comes_to_rest(&self) -> bool {
        let solid = self.blueprint.solid.as_ref().map(|s| s.solid);
        let damped = self.solver.external.drag > 0.0
            || self.blueprint.springs.iter().any(|s| s.damping > 0.0)
            || solid.is_some_and(|s| s.mass_damping > 0.0 || s.stiffness_damping > 0.0);
        let moved = !self.led.is_empty() || self.has_moving_pins();
        self.sleep.allowed && damped && self.field.is_none() && !moved
    }

    /// Whether a pinned node is on its way: led, or with a velocity of its own.
    fn has_moving_pins(&self) -> bool {
        let mut pinned = self.state.particles.iter().filter(|p| p.inv_mass == 0.0);
        pinned.any(|p| p.v != [0.0; 3])
    }

    /// Stops it where it is. Its last motion is taken from it as external work.
    fn fall_asleep(&mut self) {
        self.sleep.lost += self.momentum();
        self.edit(|body| {
            body.state.particles.iter_mut().for_each(|p| p.v = [0.0; 3]);
        });
        self.solver.speed_squared = 0.0;
        self.sleep.asleep = true;
    }
}

impl DeformableWorld {
    /// Whether there is such a body and it sleeps.
    pub(super) fn is_asleep(&self, handle: DeformableHandle) -> bool {
        self.get(handle).is_some_and(Deformable::is_sleeping)
    }

    /// Lets drowsy groups fall asleep at the end of a step of `dt` s.
    pub(super) fn fall_asleep(&mut self, parts: &RapierParts, dt: f64) {
        let limit = self.params.sleep_speed * parts.length_unit();
        for (_, body) in self.bodies.iter_mut().filter(|(_, b)| b.is_active()) {
            let slow = body.last_motion_squared() < limit * limit;
            body.sleep.slow_for = if slow { body.sleep.slow_for + dt } else { 0.0 };
        }
        let drowsy = std::mem::take(&mut self.drowsy);
        if drowsy.is_empty() {
            return;
        }
        let search = Search::new(&mut self.known, &self.attachments, parts, dt);
        for group in drowsy {
            let Some(island) = self.island(group, &search) else {
                continue;
            };
            for handle in island.members() {
                if let Some(body) = self.get_mut(handle) {
                    body.fall_asleep();
                }
            }
            self.islands.push(island);
        }
    }

    /// The island that a drowsy group makes; `None` if one of its members is lively again, or something near is awake.
    fn island(&mut self, group: Drowsy, search: &Search) -> Option<Island> {
        let slow = |h: &DeformableHandle| {
            let body = self.get(*h);
            body.is_some_and(|b| b.sleep.slow_for >= self.params.sleep_after)
        };
        if !group.members.iter().all(slow) {
            return None;
        }
        let rigid = group.resting(search.parts)?;
        let mut gate = self.open_gate();
        let members = group.members.iter();
        let sleepers = members.map(|&h| self.sleeper(h, search, &mut gate));
        let sleepers: Option<_> = sleepers.collect();
        self.forget_answers(gate);
        Some(Island {
            sleepers: sleepers?,
            rigid,
            pairs: group.pairs,
            tied: group.tied,
        })
    }
}
