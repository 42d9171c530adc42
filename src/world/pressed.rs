//! Rigid bodies that press on each other: their shadows belong to the same group and keep these contacts.

use super::group::{BodyKey, shadow_of};
use super::substep::Group;
use crate::coupling::memory::BodyMemory;
use crate::coupling::observe::{self, Answer, Surroundings};
use crate::coupling::pressed::{self, RigidContact};
use crate::math::DVec3;
use crate::solve::rows::RigidRow;
use rapier3d::dynamics::RigidBodyHandle;
use std::collections::{BTreeMap, BTreeSet};

impl Group {
    /// Adds the contacts of all touched bodies with other rigid ones, and of those with others again. What hangs on joints
    /// ends a chain: its response is measured, contacts included.
    pub fn find_rigid_contacts(
        &mut self,
        memory: &mut BTreeMap<BodyKey, BodyMemory>,
        around: &Surroundings,
        dt: f64,
    ) {
        let mut seen = BTreeSet::new();
        let mut next = 0;
        while let Some(touched) = self.touched.get(next) {
            next += 1;
            if touched.answer != Answer::Pressed {
                continue;
            }
            for pair in pressed::pairs(touched.body, around) {
                let key = [pair.collider1, pair.collider2].map(|c| c.into_raw_parts());
                if !seen.insert(key) {
                    continue;
                }
                for contact in pressed::points(pair, around.bodies) {
                    let shadows = contact
                        .bodies
                        .map(|b| shadow_of(self, b, memory, around, dt));
                    self.add_rigid_contact(shadows, &contact, dt);
                }
            }
        }
    }

    fn add_rigid_contact(&mut self, shadows: [u32; 2], contact: &RigidContact, dt: f64) {
        let anchor = |k: usize| {
            let shadow = &self.shadows[shadows[k] as usize];
            shadow.rot.inverse() * (contact.points[k] - shadow.com)
        };
        let row = RigidRow {
            shadows,
            anchors: [anchor(0), anchor(1)],
            normal: contact.normal,
            shares: contact.shares,
            friction: contact.friction,
            belt: contact.belt,
            // A force for now, until the length of a substep is known.
            normal_impulse: contact.impulse / dt,
            friction_impulse: DVec3::ZERO,
            ..RigidRow::default()
        };
        self.rows.rigid.push(row);
    }

    /// Makes the forces that rigid contacts start from impulses of substeps of h s.
    pub fn start_rigid_contacts(&mut self, h: f64) {
        for row in &mut self.rows.rigid {
            row.normal_impulse *= h;
        }
    }
}

/// The bodies that a body presses on, those that they press on, and so forth; those that don't answer, and those that hang
/// on joints, end a chain.
pub(super) fn heap(body: RigidBodyHandle, around: &Surroundings) -> Vec<RigidBodyHandle> {
    let mut heap = vec![body];
    let mut known = BTreeSet::from([body.into_raw_parts()]);
    let mut next = 0;
    while let Some(&handle) = heap.get(next) {
        next += 1;
        let pressed = |b| observe::answer(handle, b, around) == Answer::Pressed;
        if !around.bodies.get(handle).is_some_and(pressed) {
            continue;
        }
        for pair in pressed::pairs(handle, around) {
            let colliders = [pair.collider1, pair.collider2];
            let parents = colliders.map(|c| around.colliders.get(c)?.parent());
            for other in parents.into_iter().flatten() {
                let moves = around.bodies.get(other).is_some_and(|b| b.is_dynamic());
                if moves && known.insert(other.into_raw_parts()) {
                    heap.push(other);
                }
            }
        }
    }
    heap
}
