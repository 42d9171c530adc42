//! Rigid bodies that press on each other: their shadows belong to the same group and keep these contacts.

use super::group::{BodyKey, shadow_of};
use super::substep::Group;
use crate::coupling::memory::BodyMemory;
use crate::coupling::observe::{Answer, Surroundings};
use crate::coupling::pressed::{Presses, RigidContact};
use crate::math::DVec3;
use crate::solve::rows::RigidRow;
use std::collections::{BTreeMap, BTreeSet};

impl Group {
    /// Adds the contacts of all touched bodies with other rigid ones, and of those with others again. What hangs on joints
    /// ends a chain: its response is measured, contacts included.
    pub fn find_rigid_contacts(
        &mut self,
        memory: &mut BTreeMap<BodyKey, BodyMemory>,
        presses: &Presses,
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
            for (number, contact) in presses.of(touched.body) {
                if seen.insert(number) {
                    let shadows = contact
                        .bodies
                        .map(|b| shadow_of(self, b, memory, presses, around, dt));
                    self.add_rigid_contact(shadows, contact, dt);
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

    /// Lets go of bodies that could have pressed on others and did not: they are as free as any.
    pub fn release(&mut self) {
        let mut pressed = vec![false; self.shadows.len()];
        for row in self.rows.rigid.iter().filter(|r| r.pressed) {
            for shadow in row.shadows {
                pressed[shadow as usize] = true;
            }
        }
        for (touched, pressed) in self.touched.iter_mut().zip(&pressed[1..]) {
            if touched.answer == Answer::Pressed && !pressed {
                touched.answer = Answer::Free;
            }
        }
    }

    /// Makes the forces that rigid contacts start from impulses of substeps of h s.
    pub fn start_rigid_contacts(&mut self, h: f64) {
        for row in &mut self.rows.rigid {
            row.normal_impulse *= h;
        }
    }
}
