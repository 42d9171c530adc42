//! Bodies that hold nodes go where their shadows are, where nodes would have to jump to follow them.
//!
//! Nodes that follow far get what energy that takes from nothing: those of a light body that strikes the ground with a long lever, or
//! of a chain that comes to the limit of a joint. Rapier answers both for the bodies alone, shadows with what they hold.

use super::attach::{AttachmentState, frame};
use super::group::{BodyKey, Waiting};
use super::{DeformableWorld, RapierParts};
use crate::coupling::handover;
use crate::coupling::observe::Answer;
use rapier3d::dynamics::{RigidBody, RigidBodyHandle};
use std::collections::BTreeSet;

/// How far nodes can follow at once whatever it takes, in length units.
const JUMP: f64 = 5e-4;

impl DeformableWorld {
    /// Puts bodies that hold nodes where their shadows are, as fast as these, with all that they press on or are jointed to, if to bring
    /// the nodes to where Rapier's step of `dt` s has left them would take more than to put all these.
    pub(super) fn lead_back(&mut self, parts: &mut RapierParts, waiting: &mut [Waiting], dt: f64) {
        let jumping = self.jumping(parts);
        for i in 0..waiting.len() {
            let w = &waiting[i];
            let handle = w.touched.body;
            if w.put || !jumping.contains(&handle.into_raw_parts()) {
                continue;
            }
            let Some(set) = hanging_together(parts, waiting, handle) else {
                continue;
            };
            let (mut follow, mut put) = (0.0, 0.0);
            for w in set.iter().map(|i| &waiting[*i]) {
                let body = &parts.bodies[w.touched.body];
                follow += self.cost_to_follow((w.touched.body, body), dt);
                put += handover::cost_to_put(body, &w.end, dt);
            }
            // Rapier would close at once what shadows have left open.
            let goes_on = set.iter().any(|i| waiting[*i].touched.was_put);
            if goes_on || put < follow {
                for i in set {
                    let w = &mut waiting[i];
                    let body = &mut parts.bodies[w.touched.body];
                    let ends = [&w.touched.start, &w.end];
                    handover::become_shadow(body, &w.touched.mobility, ends, dt);
                    let memory = self.memory.entry(w.touched.body.into_raw_parts());
                    memory.or_default().was_put = true;
                    w.put = true;
                }
            }
        }
    }

    /// The bodies that a node which they hold would have to jump to, see [`JUMP`].
    fn jumping(&self, parts: &RapierParts) -> BTreeSet<BodyKey> {
        let far = JUMP * parts.length_unit();
        let jumps = |(_, bond): (_, &AttachmentState)| {
            let handle = bond.body().filter(|h| leads(bond, *h))?;
            let soft = self.bodies.get(bond.deformable.0);
            let soft = soft.filter(|s| s.is_active())?;
            let (origin, rot) = frame(parts.bodies.get(handle)?);
            let mut errors = bond.errors(origin, rot, &soft.state, None);
            errors
                .any(|e| e.length() > far)
                .then(|| handle.into_raw_parts())
        };
        self.attachments.iter().filter_map(jumps).collect()
    }

    /// What it takes to bring the nodes of a body to where it is \[J\], see [`Deformable::cost_of_shift`].
    fn cost_to_follow(&mut self, (handle, rigid): (RigidBodyHandle, &RigidBody), dt: f64) -> f64 {
        let (origin, rot) = frame(rigid);
        let mut cost = 0.0;
        for (_, bond) in self.attachments.iter().filter(|(_, b)| leads(b, handle)) {
            let soft = self.bodies.get_mut(bond.deformable.0);
            if let Some(soft) = soft.filter(|s| s.is_active()) {
                let errors: Vec<_> = bond.errors(origin, rot, &soft.state, None).collect();
                cost += soft.cost_of_shift(&bond.points, &errors, dt);
            }
        }
        cost
    }
}

/// Whether a body takes nodes with it by an attachment.
fn leads(bond: &AttachmentState, body: RigidBodyHandle) -> bool {
    bond.body() == Some(body) && !bond.loose && !bond.is_broken() && !bond.is_link()
}

/// Which of those that wait are a body and all that hang together with it by joints or contacts, if each of them waits, and ends where
/// its shadow does but for what Rapier's contacts and joints answer otherwise.
fn hanging_together(
    parts: &RapierParts,
    waiting: &[Waiting],
    body: RigidBodyHandle,
) -> Option<BTreeSet<usize>> {
    let place = |handle: RigidBodyHandle| {
        let i = waiting.iter().position(|w| w.touched.body == handle)?;
        let is_awake = !parts.bodies.get(handle)?.is_sleeping();
        (waiting[i].touched.answer == Answer::Constrained && is_awake).then_some(i)
    };
    let mut found = BTreeSet::from([place(body)?]);
    let mut next = vec![body];
    while let Some(handle) = next.pop() {
        for other in parts.bound_to(handle) {
            if parts.moving(other).is_some() && found.insert(place(other)?) {
                next.push(other);
            }
        }
    }
    Some(found)
}
