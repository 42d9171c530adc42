//! Rigid bodies that press on each other or are joined: their shadows belong to the same group and keep these contacts
//! and joints.

use super::group::{BodyKey, Origins};
use super::substep::Group;
use crate::coupling::constraints::{RigidContact, RigidJoint};
use crate::math::{DQuat, DVec3};
use crate::solve::rows::{Joint, JointRow, RigidRow};
use std::collections::BTreeSet;

impl Group {
    /// Adds the contacts and joints of all touched bodies with other rigid ones, and of those with others again.
    pub fn find_rigid_constraints(&mut self, origins: &mut Origins) {
        let constraints = origins.constraints;
        let (mut pressed, mut held) = (BTreeSet::new(), BTreeSet::new());
        let mut next = 0;
        while let Some(touched) = self.touched.get(next) {
            next += 1;
            if !touched.answer.is_kept() {
                continue;
            }
            let body = touched.body;
            for (number, contact) in constraints.contacts_of(body) {
                if pressed.insert(number) {
                    let shadows = contact.bodies.map(|b| origins.shadow(self, b));
                    let slop = origins.around.parameters.allowed_linear_error();
                    self.add_rigid_contact(shadows, contact, f64::from(slop), origins.dt);
                }
            }
            for (number, joint) in constraints.joints_of(body) {
                if held.insert(number) {
                    let shadows = joint.bodies.map(|b| origins.shadow(self, Some(b)));
                    self.add_joint(shadows, joint);
                }
            }
        }
        self.take_driven_as_they_are();
        self.take_soft_joints_as_they_move();
    }

    /// What hangs on soft joints begins with the velocities by which its places change, which are not those that Rapier tells.
    fn take_soft_joints_as_they_move(&mut self) {
        self.note_ahead(true);
        for (touched, shadow) in self.touched.iter_mut().zip(&mut self.shadows[1..]) {
            let (v, w) = std::mem::take(&mut shadow.ahead);
            if (v, w) != Default::default() {
                (shadow.v, shadow.w) = (shadow.v + v, shadow.w + w);
                shadow.before = (shadow.v, shadow.w);
                let start = &mut touched.start;
                (start.v, start.w, start.before) = (shadow.v, shadow.w, shadow.before);
            }
        }
    }

    /// By how much shadows are ahead of Rapier's velocities because they hang on soft joints.
    pub fn note_ahead(&mut self, told: bool) {
        let joints = self.rows.joints.iter();
        let ahead =
            joints.filter_map(|row| Some((row.joint.shadows, row.ahead(&self.shadows, told)?)));
        for (shadows, ahead) in ahead.collect::<Vec<_>>() {
            for (shadow, (v, w)) in shadows.into_iter().zip(ahead) {
                let ahead = &mut self.shadows[shadow as usize].ahead;
                *ahead = (ahead.0 + v, ahead.1 + w);
            }
        }
    }

    /// What a motor drives, or a soft joint holds, and what is joined to that, may rest on this spring: gravity is not all that
    /// accelerates it, and half an iteration of gravity alone, see [`Shadow::synchronise`](crate::solve::shadow::Shadow::synchronise), would set
    /// it swinging by 5 mm/s in every step.
    fn take_driven_as_they_are(&mut self) {
        let mut driven = vec![false; self.shadows.len()];
        let mut more = true;
        while std::mem::take(&mut more) {
            for row in &self.rows.joints {
                let sides = row.joint.shadows.map(|i| i as usize);
                let moves = |i: &usize| self.shadows[*i].gives_way();
                if row.is_spring() || sides.iter().filter(|i| moves(i)).any(|i| driven[*i]) {
                    for i in sides.into_iter().filter(moves) {
                        more |= !std::mem::replace(&mut driven[i], true);
                    }
                }
            }
        }
        for (shadow, _) in self.shadows.iter_mut().zip(driven).filter(|(_, d)| *d) {
            shadow.lead = None;
        }
    }

    /// Whether a body was put where its shadow was.
    fn was_put(&self, shadow: u32) -> bool {
        let touched = (shadow as usize).checked_sub(1).map(|i| &self.touched[i]);
        touched.is_some_and(|t| t.was_put)
    }

    fn add_joint(&mut self, shadows: [u32; 2], joint: &RigidJoint) {
        let own = shadows.map(|i| self.body_at(i));
        let anchors = [0, 1].map(|k| own[k].1.inverse() * (joint.anchors[k] - own[k].0));
        let frames = [0, 1].map(|k| own[k].1.inverse() * joint.frames[k]);
        // Of shadows that start apart from their bodies, too, what is open is not theirs to mend.
        let sides = shadows.map(|i| &self.shadows[i as usize]);
        let [first, second] = [0, 1].map(|k| sides[k].com + sides[k].rot * anchors[k]);
        let axes = sides[0].rot * frames[0];
        let along = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| (second - first).dot(axes * axis));
        let per_mass = joint.per_mass;
        let joint = Joint {
            shadows,
            anchors,
            frames,
            axes: joint.axes,
            open: DVec3::from_array(along),
            closes: shadows.into_iter().any(|i| self.was_put(i)),
        };
        let row = JointRow::new(joint, per_mass, &self.shadows);
        self.rows.joints.push(row);
    }

    fn add_rigid_contact(&mut self, shadows: [u32; 2], contact: &RigidContact, slop: f64, dt: f64) {
        // As Rapier has it: both give way at one point, half way between the surfaces.
        let point = 0.5 * (contact.points[0] + contact.points[1]);
        let arm = |k: usize| point - self.body_at(shadows[k]).0;
        let gap = (contact.points[1] - contact.points[0]).dot(contact.normal);
        let sides = shadows.map(|i| &self.shadows[i as usize]);
        let response: f64 = (0..2)
            .map(|k| contact.shares[k] * sides[k].response(arm(k), contact.normal))
            .sum();
        let row = RigidRow {
            shadows,
            arms: [arm(0), arm(1)],
            gap,
            gap_at_start: gap,
            slop: shadows.into_iter().any(|i| self.was_put(i)).then_some(slop),
            normal: contact.normal,
            shares: contact.shares,
            friction: contact.friction,
            belt: contact.belt,
            // A force for now, until the length of a substep is known.
            normal_impulse: contact.impulse / dt,
            bears: contact.spring.bears(-gap, dt) / response,
            ..RigidRow::default()
        };
        self.rows.rigid.push(row);
    }

    /// Whether any of these bodies hangs on a joint.
    pub fn bears(&self, stiffly: &BTreeSet<BodyKey>) -> bool {
        let on_joints = self.rows.joints.iter().flat_map(|row| row.joint.shadows);
        let mut touched = on_joints.filter_map(|i| self.touched.get((i as usize).checked_sub(1)?));
        !stiffly.is_empty() && touched.any(|t| stiffly.contains(&t.body.into_raw_parts()))
    }

    /// Where the centre of mass of a shadow's body is, and its orientation.
    fn body_at(&self, shadow: u32) -> (DVec3, DQuat) {
        let touched = (shadow as usize).checked_sub(1).map(|i| &self.touched[i]);
        touched.map_or((DVec3::ZERO, DQuat::IDENTITY), |t| t.at)
    }

    /// Makes the forces that rigid contacts start from impulses of substeps of h s.
    pub fn start_rigid_contacts(&mut self, h: f64) {
        for row in &mut self.rows.rigid {
            row.normal_impulse *= h;
        }
    }
}
