//! The end of groups: members go back to the set, and rigid bodies get what they were pushed by.

use super::Waiting;
use crate::coupling::handover::{self, Pending};
use crate::coupling::observe::Answer;
use crate::math::DVec3;
use crate::solve::shadow::Shadow;
use crate::world::substep::{Group, NEAR};
use crate::world::ties::Attached;
use crate::world::{DeformableWorld, RapierParts};

/// What comes nearer by less in a step than this, in length units, rests.
const ARRIVES: f64 = 1e-4;

impl DeformableWorld {
    /// Puts the members of a group back and keeps what its rigid bodies wait for.
    pub(in crate::world) fn dissolve(
        &mut self,
        mut group: Group,
        parts: &mut RapierParts,
        dt: f64,
    ) {
        group.shadows.iter_mut().for_each(Shadow::take_late);
        group.rows.spare_contacts(&mut group.shadows, dt);
        group.note_ahead(false);
        group.release(ARRIVES * parts.length_unit(), dt);
        group.follow();
        self.drowsy.extend(group.as_drowsy(dt, &self.params));
        self.pause_encounters(&mut group);
        for (pair, sum) in group.pair_sums() {
            self.add_touch(pair, sum);
        }
        self.hand_first_part(&mut group, parts, dt);
        self.keep_candidates(&mut group);
        for attachment in group.attachments {
            self.keep_attachment(attachment, dt);
        }
        for (handle, mut body) in group.members {
            body.shifted = 0.0;
            self.put_back(handle, body);
        }
    }

    /// Gives rigid bodies their first part, and keeps what they wait for; nothing where a shadow is not finite.
    fn hand_first_part(&mut self, group: &mut Group, parts: &mut RapierParts, dt: f64) {
        let mut impulses = group
            .shadows
            .iter()
            .flat_map(|s| <[DVec3; 2]>::from(s.given()));
        let finite = impulses.all(DVec3::is_finite);
        let splits = group.splits(parts, dt);
        let mut near = group.near_bodies(NEAR * parts.length_unit());
        // Faces and edges touch between nodes.
        for (near, shadow) in near.iter_mut().zip(group.shadows.iter().skip(1)) {
            *near |= shadow.impulse != DVec3::ZERO;
        }
        let holds = group.holders(parts.length_unit(), parts.bodies);
        let led = self.has_movers(group, &near, parts) || group.is_led(&near, parts.bodies, dt);
        let told = near.into_iter().zip(holds).zip(splits);
        let touched = std::mem::take(&mut group.touched).into_iter();
        let each = touched.zip(group.shadows.iter().skip(1)).zip(told);
        for ((touched, end), ((near, holds), split)) in each {
            let is_dynamic = |handle| parts.bodies.get(handle).is_some_and(|b| b.is_dynamic());
            if !is_dynamic(touched.body) {
                continue;
            }
            let end = if finite { *end } else { touched.start };
            let answers = end.given() != Default::default() || touched.lands.is_some();
            let mut pending = Pending::nothing();
            if answers && touched.answer != Answer::None {
                // Only these: Rapier takes whom it is asked for as changed.
                let Some(body) = parts.bodies.get_mut(touched.body) else {
                    continue;
                };
                pending = handover::before_step(
                    body,
                    touched.answer,
                    &touched.mobility,
                    [&touched.start, &end],
                    split,
                    parts.integration_parameters,
                    dt,
                );
            }
            self.waiting.push(Waiting {
                touched,
                end,
                pending,
                near,
                holds,
                led: near && led,
                put: false,
            });
        }
    }

    /// Keeps what members can touch for the next step.
    fn keep_candidates(&mut self, group: &mut Group) {
        let candidates = std::mem::take(&mut group.candidates);
        for ((handle, body), candidates) in group.members.iter().zip(candidates) {
            for mut c in candidates {
                c.pause(&group.shadows[c.target.shadow as usize], body.edits);
                let key = (handle.key(), c.target.collider.into_raw_parts());
                self.contacts.insert(key, c);
            }
        }
    }

    /// Keeps an attachment, with the forces of the step, and tells of it if it broke.
    fn keep_attachment(&mut self, attachment: Attached, dt: f64) {
        let Some(kept) = self.attachments.get_mut(attachment.handle.0) else {
            return;
        };
        *kept = attachment.bond;
        kept.force = attachment.load.force / dt;
        kept.torque = attachment.load.torque / dt;
        kept.moment = attachment.load.moment / dt;
        if !attachment.asleep {
            kept.by_pins = attachment.by_pins * (1.0 / dt);
        }
        if kept.is_broken() {
            self.report.broken_attachments.push(attachment.handle);
        }
    }
}
