//! Groups: deformables that touch or are attached to the same moving body share their substeps and their rows.

use super::meet::Meeting;
use super::observer::Partner;
use super::reach::Search;
use super::substep::{Group, NEAR};
use super::{
    AttachTo, AttachmentHandle, Deformable, DeformableHandle, DeformableWorld, RapierParts, reach,
};
use crate::contact::candidates::Candidates;
use crate::contact::target::Target;
use crate::coupling::constraints::RigidConstraints;
use crate::coupling::handover;
use crate::coupling::linkage::Mobility;
use crate::coupling::memory::{BodyMemory, Response};
use crate::coupling::observe::{self, Answer, Surroundings};
use crate::math::{DQuat, DVec3, wide};
use crate::solve::shadow::Shadow;
use rapier3d::dynamics::RigidBodyHandle;
use std::collections::BTreeMap;

/// A rigid body that deformables of a group can touch.
#[derive(Clone, Debug)]
pub(super) struct Touched {
    pub body: RigidBodyHandle,
    pub answer: Answer,
    pub mobility: Mobility,
    pub start: Shadow,
}

/// A body that has been handed its first part and waits for the rest.
#[derive(Clone, Debug)]
pub(super) struct Waiting {
    pub touched: Touched,
    pub end: Shadow,
    pub pending: handover::Pending,
    /// Whether any node lay within 2 mm at the end of the substeps.
    pub near: bool,
    /// Whether it holds a node that is deep in what never moves, and has to get it out.
    pub holds: bool,
}

/// A sortable key of a body.
pub(super) type BodyKey = (u32, u32);

/// Where shadows ended: centres of mass \[m\] and orientations.
pub(super) type Ends = BTreeMap<BodyKey, (DVec3, DQuat)>;

/// What one deformable can meet in this step.
pub(super) struct Reach {
    pub handle: DeformableHandle,
    pub targets: Vec<Target>,
    attachments: Vec<AttachmentHandle>,
}

impl DeformableWorld {
    /// Sorts the enabled deformables into groups for a rigid step of `dt` s. Each group takes its members out of the set
    /// until it is dissolved.
    pub(super) fn form_groups(&mut self, parts: &RapierParts, dt: f64) -> Vec<Group> {
        let mut sensing = std::mem::take(&mut self.sensing);
        sensing.clear();
        if !self.iter().any(|(_, body)| body.is_enabled()) {
            return Vec::new();
        }
        let mut gate = self.open_gate();
        let search = Search::new(&self.known, parts, dt);
        reach::remember(&mut self.known, &search.strays, parts);
        let mut unsupported = std::mem::take(&mut self.report.unsupported);
        let mut forms = std::mem::take(&mut self.forms);
        forms.forget_unused();
        let active = self.iter().filter(|(_, body)| body.is_active());
        let handles: Vec<DeformableHandle> = active.map(|(handle, _)| handle).collect();
        let (meetings, speeds) = self.find_meetings(&handles, &search);
        let active = handles.iter().filter_map(|h| Some((*h, self.get(*h)?)));
        let reaches: Vec<Reach> = active
            .zip(speeds)
            .map(|((handle, body), speed)| Reach {
                handle,
                targets: reach::targets(
                    (handle, body, speed),
                    &search,
                    &mut gate,
                    &mut forms,
                    &mut unsupported,
                    &mut sensing,
                ),
                attachments: self.attachments_of(handle, parts),
            })
            .collect();
        self.forms = forms;
        self.sensing = sensing;
        self.forget_answers(gate);
        for &collider in &unsupported {
            if !self.warned.contains(&collider) {
                self.warned.push(collider);
                log::warn!(
                    "a deformable is in reach of collider {collider:?}, whose shape its nodes can't touch: it will pass through"
                );
            }
        }
        self.report.unsupported = unsupported;
        let around = parts.surroundings();
        let touched = reaches.iter().flat_map(|r| self.touched_by(r));
        let constraints = RigidConstraints::gather(touched, &around, dt);
        let group_of = self.join(&reaches, &meetings, &constraints, &around);
        let mut kept = std::mem::take(&mut self.contacts);
        let far = 0.01 * parts.length_unit();
        let mut groups: BTreeMap<usize, Group> = BTreeMap::new();
        let mut bonds = Vec::new();
        for (i, reach) in reaches.into_iter().enumerate() {
            let group = groups.entry(group_of[i]).or_insert_with(Group::empty);
            let Some(mut body) = self.take(reach.handle) else {
                continue;
            };
            body.sleep.beside_rigid = reach.targets.iter().any(|t| t.body.is_some());
            let member = group.members.len();
            let (moved, spacing) = ((body.edits, body.shifted), body.contact_topology().spacing);
            group.members.push((reach.handle, body));
            let mut candidates = Vec::new();
            for mut target in reach.targets {
                target.shadow = shadow_of(
                    group,
                    target.body,
                    &mut self.memory,
                    &constraints,
                    &around,
                    dt,
                );
                let pair = group.add_pair(member, Partner::Collider(target.collider));
                let key = (reach.handle.key(), target.collider.into_raw_parts());
                candidates.push(match kept.remove(&key) {
                    None => Candidates::new(target, pair, spacing),
                    Some(mut c) => {
                        let shadow = &group.shadows[target.shadow as usize];
                        c.resume(target, pair, shadow, moved, far);
                        c
                    }
                });
            }
            group.candidates.push(candidates);
            let attachments = reach.attachments.into_iter();
            bonds.extend(attachments.map(|h| (group_of[i], member as u32, h)));
        }
        kept.retain(|&(key, _), _| self.is_asleep(DeformableHandle::of_key(key)));
        self.contacts = kept;
        for (number, member, handle) in bonds {
            let (Some(group), Some(bond)) =
                (groups.get_mut(&number), self.attachments.get(handle.0))
            else {
                continue;
            };
            let shadow = shadow_of(
                group,
                bond.body(),
                &mut self.memory,
                &constraints,
                &around,
                dt,
            );
            let other = match bond.target {
                AttachTo::Deformable(other) => {
                    let found = group.members.iter().position(|(h, _)| *h == other);
                    let Some(found) = found else { continue };
                    Some(found as u32)
                }
                _ => None,
            };
            let rigid = bond.body().and_then(|b| parts.bodies.get(b));
            let mut bond = bond.clone();
            bond.com = rigid.map_or(DVec3::ZERO, |b| wide(b.local_center_of_mass()));
            let asleep = rigid.is_some_and(|b| b.is_dynamic() && b.is_sleeping());
            group.add_attachment(member, other, shadow, (handle, bond), asleep);
        }
        for group in groups.values_mut() {
            group.find_rigid_constraints(&mut self.memory, &constraints, &around, dt);
        }
        self.resume_encounters(&mut groups, &group_of, &handles, &meetings);
        groups.into_values().collect()
    }

    /// The smallest member index of the group of each deformable: those that meet, or touch the same dynamic body or the
    /// same heap of them, are joined.
    fn join(
        &self,
        reaches: &[Reach],
        meetings: &[Meeting],
        constraints: &RigidConstraints,
        around: &Surroundings,
    ) -> Vec<usize> {
        let mut parent: Vec<usize> = (0..reaches.len()).collect();
        fn root(parent: &[usize], mut i: usize) -> usize {
            while parent[i] != i {
                i = parent[i];
            }
            i
        }
        let mut first: BTreeMap<BodyKey, usize> = BTreeMap::new();
        for (i, reach) in reaches.iter().enumerate() {
            for body in self.touched_by(reach) {
                if !around.bodies.get(body).is_some_and(|b| b.is_dynamic()) {
                    continue;
                }
                let others = match first.get(&body.into_raw_parts()) {
                    Some(&other) => vec![other],
                    None => {
                        let heap = constraints.heap(body, around).into_iter();
                        heap.map(|b| *first.entry(b.into_raw_parts()).or_insert(i))
                            .collect()
                    }
                };
                for other in others {
                    let (a, b) = (root(&parent, i), root(&parent, other));
                    parent[a.max(b)] = a.min(b);
                }
            }
            for handle in &reach.attachments {
                let bond = self.attachments.get(handle.0);
                let Some(AttachTo::Deformable(to)) = bond.map(|b| b.target) else {
                    continue;
                };
                if let Some(other) = reaches.iter().position(|r| r.handle == to) {
                    let (a, b) = (root(&parent, i), root(&parent, other));
                    parent[a.max(b)] = a.min(b);
                }
            }
        }
        for meeting in meetings {
            let [a, b] = meeting.map(|i| root(&parent, i));
            parent[a.max(b)] = a.min(b);
        }
        (0..reaches.len()).map(|i| root(&parent, i)).collect()
    }

    /// The bodies that a deformable can touch or is attached to.
    fn touched_by(&self, reach: &Reach) -> impl Iterator<Item = RigidBodyHandle> {
        let touched = reach.targets.iter().filter_map(|t| t.body);
        let bonds = reach.attachments.iter();
        touched.chain(bonds.filter_map(|h| self.attachments.get(h.0)?.body()))
    }

    fn attachments_of(
        &self,
        deformable: DeformableHandle,
        parts: &RapierParts,
    ) -> Vec<AttachmentHandle> {
        self.attachments
            .iter()
            .filter(|(_, a)| {
                let target_is_there = match a.target {
                    AttachTo::Body(body) => parts.bodies.get(body).is_some_and(|b| b.is_enabled()),
                    AttachTo::Deformable(other) => self.get(other).is_some_and(|b| b.is_enabled()),
                    _ => true,
                };
                a.deformable == deformable && !a.is_broken() && target_is_there
            })
            .map(|(index, _)| AttachmentHandle(index))
            .collect()
    }

    /// Puts the members of a group back and keeps what its rigid bodies wait for.
    pub(super) fn dissolve(&mut self, mut group: Group, parts: &mut RapierParts, dt: f64) {
        let finite = group
            .shadows
            .iter()
            .all(|s| s.impulse.is_finite() && s.torque.is_finite());
        group.shadows.iter_mut().for_each(Shadow::take_late);
        group.release();
        group.follow();
        let splits = group.splits(parts, dt);
        self.drowsy.extend(group.as_drowsy(dt, &self.params));
        let near = group.near_bodies(NEAR * parts.length_unit());
        let holds = group.holders(parts.length_unit(), parts.bodies);
        self.pause_encounters(&mut group);
        for (pair, sum) in group.pair_sums() {
            self.add_touch(pair, sum);
        }
        for ((handle, body), candidates) in group.members.iter().zip(group.candidates) {
            for mut c in candidates {
                c.pause(&group.shadows[c.target.shadow as usize], body.edits);
                let key = (handle.key(), c.target.collider.into_raw_parts());
                self.contacts.insert(key, c);
            }
        }
        for ((((touched, end), near), holds), split) in group
            .touched
            .into_iter()
            .zip(group.shadows.into_iter().skip(1))
            .zip(near)
            .zip(holds)
            .zip(splits)
        {
            let end = if finite { end } else { touched.start };
            if let Some(body) = parts.bodies.get(touched.body) {
                if !body.is_dynamic() {
                    continue;
                }
                let untouched =
                    end.impulse == Default::default() && end.torque == Default::default();
                let pending = if untouched || touched.answer == Answer::None {
                    handover::Pending::nothing()
                } else if let Some(body) = parts.bodies.get_mut(touched.body) {
                    handover::before_step(
                        body,
                        touched.answer,
                        &touched.mobility,
                        [&touched.start, &end],
                        split,
                        parts.integration_parameters,
                        dt,
                    )
                } else {
                    continue;
                };
                self.waiting.push(Waiting {
                    touched,
                    end,
                    pending,
                    near,
                    holds,
                });
            }
        }
        for attachment in group.attachments {
            if let Some(kept) = self.attachments.get_mut(attachment.handle.0) {
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
        for (handle, mut body) in group.members {
            body.shifted = 0.0;
            self.put_back(handle, body);
        }
    }
}

/// Index of the shadow of a body in the group, made if it is not there. Shadow 0 is the fixed world.
pub(super) fn shadow_of(
    group: &mut Group,
    body: Option<RigidBodyHandle>,
    memory: &mut BTreeMap<BodyKey, BodyMemory>,
    constraints: &RigidConstraints,
    around: &Surroundings,
    dt: f64,
) -> u32 {
    let Some((handle, body)) = body.and_then(|h| Some((h, around.bodies.get(h)?))) else {
        return 0;
    };
    if let Some(i) = group.touched.iter().position(|t| t.body == handle) {
        return i as u32 + 1;
    }
    let answer = observe::answer(handle, body, constraints, around);
    let (mobility, response) = if answer == Answer::None {
        (Mobility::free(body, around.gravity), Response::all(1.0))
    } else {
        let memory = memory.entry(handle.into_raw_parts()).or_default();
        observe::response(handle, body, answer, memory, around, dt)
    };
    let start = observe::shadow(body, answer, &mobility, response, around, dt);
    group.touched.push(Touched {
        body: handle,
        answer,
        mobility,
        start,
    });
    group.shadows.push(start);
    group.shadows.len() as u32 - 1
}

impl Deformable {
    /// A bound on how fast any node goes into the coming substep \[m/s\]: the integration pass has seen velocities before
    /// rows, and how far nodes moved tells what rows did to them.
    pub(super) fn fastest(&self) -> f64 {
        let speed = self.gain() * f64::from(self.solver.speed_squared).sqrt();
        if self.h > 0.0 {
            speed.max(self.moved / self.h)
        } else {
            speed
        }
    }

    /// Largest speed of any node \[m/s\].
    pub(super) fn max_speed(&self) -> f64 {
        f64::from(self.max_speed_squared()).sqrt()
    }

    /// Largest squared speed of any node \[m²/s²\].
    pub(super) fn max_speed_squared(&self) -> f32 {
        self.state
            .particles
            .iter()
            .map(|p| p.v.iter().map(|c| c * c).sum::<f32>())
            .fold(0.0, f32::max)
    }
}
