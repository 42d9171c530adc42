//! How groups come about: what each deformable can meet, who shares something that moves, and what they begin with.

use super::{BodyKey, Origins};
use crate::contact::candidates::Candidates;
use crate::contact::target::Target;
use crate::coupling::constraints::RigidConstraints;
use crate::coupling::observe::Surroundings;
use crate::math::{DVec3, Disjoint, wide};
use crate::world::meet::Meeting;
use crate::world::observer::Partner;
use crate::world::reach::{self, Search};
use crate::world::substep::Group;
use crate::world::{AttachTo, AttachmentHandle, DeformableHandle, DeformableWorld, RapierParts};
use rapier3d::dynamics::RigidBodyHandle;
use rapier3d::geometry::ColliderHandle;
use std::collections::BTreeMap;

/// What one deformable can meet in this step.
struct Reach {
    handle: DeformableHandle,
    targets: Vec<Target>,
    attachments: Vec<AttachmentHandle>,
}

/// Attachments of members, by the number of their group and their index in it.
type Bonds = Vec<(usize, u32, AttachmentHandle)>;

impl DeformableWorld {
    /// Sorts the enabled deformables into groups for a rigid step of `dt` s. Each group takes its members out of the set
    /// until it is dissolved.
    pub(in crate::world) fn form_groups(&mut self, parts: &RapierParts, dt: f64) -> Vec<Group> {
        self.sensing.clear();
        if !self.iter().any(|(_, body)| body.is_enabled()) {
            return Vec::new();
        }
        let (reaches, meetings) = self.look_around(parts, dt);
        let around = parts.surroundings();
        let touched = reaches.iter().flat_map(|r| self.touched_by(r));
        let constraints = RigidConstraints::gather(touched, &around, dt);
        let group_of = self.join(&reaches, &meetings, &constraints, &around);
        let handles: Vec<DeformableHandle> = reaches.iter().map(|r| r.handle).collect();
        let mut memory = std::mem::take(&mut self.memory);
        let courses = std::mem::take(&mut self.courses);
        let mut origins = Origins {
            memory: &mut memory,
            constraints: &constraints,
            around: &around,
            courses: &courses,
            dt,
        };
        let far = 0.01 * parts.length_unit();
        let (mut groups, bonds) = self.gather(reaches, &group_of, &mut origins, far);
        self.add_bonds(&mut groups, bonds, &mut origins);
        for group in groups.values_mut() {
            group.note_held();
            group.find_rigid_constraints(&mut origins);
            group.rows.bears = group.bears(&self.stiffly);
        }
        (self.memory, self.courses) = (memory, courses);
        self.resume_encounters(&mut groups, &group_of, &handles, &meetings);
        groups.into_values().collect()
    }

    /// What every deformable that is awake can meet within `dt` s, and which of them can meet each other.
    fn look_around(&mut self, parts: &RapierParts, dt: f64) -> (Vec<Reach>, Vec<Meeting>) {
        let mut sensing = std::mem::take(&mut self.sensing);
        let mut gate = self.open_gate();
        let search = Search::new(&mut self.known, &self.attachments, parts, dt);
        self.known.remember(&search.strays, parts);
        let mut unsupported = std::mem::take(&mut self.report.unsupported);
        let mut forms = std::mem::take(&mut self.forms);
        forms.forget_unused();
        let active = self.iter().filter(|(_, body)| body.is_active());
        let handles: Vec<DeformableHandle> = active.map(|(handle, _)| handle).collect();
        let (meetings, speeds) = self.find_meetings(&handles, &search);
        let mut attachments = self.find_attachments(parts);
        let active = handles.iter().filter_map(|h| Some((*h, self.get(*h)?)));
        let reaches = active.zip(speeds).map(|((handle, body), speed)| Reach {
            handle,
            targets: reach::targets(
                (handle, body, speed),
                &search,
                &mut gate,
                &mut forms,
                &mut unsupported,
                &mut sensing,
            ),
            attachments: attachments.remove(&handle.key()).unwrap_or_default(),
        });
        let reaches = reaches.collect();
        self.forms = forms;
        self.sensing = sensing;
        self.forget_answers(gate);
        self.warn_of(&unsupported);
        self.report.unsupported = unsupported;
        (reaches, meetings)
    }

    /// Warns once of every collider whose shape nodes can't touch.
    fn warn_of(&mut self, unsupported: &[ColliderHandle]) {
        for &collider in unsupported {
            if !self.warned.contains(&collider) {
                self.warned.push(collider);
                log::warn!(
                    "a deformable is in reach of collider {collider:?}, whose shape its nodes can't touch: it will pass through"
                );
            }
        }
    }

    /// Takes the bodies out of the set into their groups, each with what it can touch; what moved by less than `far` m has
    /// its candidates still. The attachments are for later, when all members are there.
    fn gather(
        &mut self,
        reaches: Vec<Reach>,
        group_of: &[usize],
        origins: &mut Origins,
        far: f64,
    ) -> (BTreeMap<usize, Group>, Bonds) {
        let mut kept = std::mem::take(&mut self.contacts);
        let mut groups: BTreeMap<usize, Group> = BTreeMap::new();
        let mut bonds = Vec::new();
        for (reach, &number) in reaches.into_iter().zip(group_of) {
            let group = groups.entry(number).or_insert_with(Group::empty);
            let Some(mut body) = self.take(reach.handle) else {
                continue;
            };
            let moves = |b: RigidBodyHandle| {
                let body = origins.around.bodies.get(b);
                body.is_some_and(|b| !b.is_fixed())
            };
            body.sleep.beside_rigid = reach.targets.iter().any(|t| t.body.is_some_and(moves));
            let member = group.members.len();
            let (moved, spacing) = ((body.edits, body.shifted), body.contact_topology().spacing);
            group.members.push((reach.handle, body));
            let mut candidates = Vec::new();
            for mut target in reach.targets {
                target.shadow = origins.shadow(group, target.body);
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
            bonds.extend(attachments.map(|h| (number, member as u32, h)));
        }
        kept.retain(|&(key, _), _| self.is_asleep(DeformableHandle::of_key(key)));
        self.contacts = kept;
        (groups, bonds)
    }

    /// Gives the groups their attachments.
    fn add_bonds(&self, groups: &mut BTreeMap<usize, Group>, bonds: Bonds, origins: &mut Origins) {
        for (number, member, handle) in bonds {
            let (Some(group), Some(bond)) =
                (groups.get_mut(&number), self.attachments.get(handle.0))
            else {
                continue;
            };
            let shadow = origins.shadow(group, bond.body());
            let other = match bond.target {
                AttachTo::Deformable(other) => {
                    let found = group.members.iter().position(|(h, _)| *h == other);
                    let Some(found) = found else { continue };
                    Some(found as u32)
                }
                _ => None,
            };
            let rigid = bond.body().and_then(|b| origins.around.bodies.get(b));
            let mut bond = bond.clone();
            bond.com = rigid.map_or(DVec3::ZERO, |b| wide(b.local_center_of_mass()));
            let asleep = rigid.is_some_and(|b| b.is_dynamic() && b.is_sleeping());
            group.add_attachment(member, other, shadow, (handle, bond), asleep);
        }
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
        let mut sets = Disjoint::new(reaches.len());
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
                    sets.join(i as u32, other as u32);
                }
            }
            for handle in &reach.attachments {
                let bond = self.attachments.get(handle.0);
                let Some(AttachTo::Deformable(to)) = bond.map(|b| b.target) else {
                    continue;
                };
                // They are in the order of the set.
                if let Ok(other) = reaches.binary_search_by_key(&to.key(), |r| r.handle.key()) {
                    sets.join(i as u32, other as u32);
                }
            }
        }
        for [a, b] in meetings {
            sets.join(*a as u32, *b as u32);
        }
        let numbers = 0..reaches.len() as u32;
        numbers.map(|i| sets.of(i) as usize).collect()
    }

    /// The bodies that a deformable can touch or is attached to.
    fn touched_by(&self, reach: &Reach) -> impl Iterator<Item = RigidBodyHandle> {
        let touched = reach.targets.iter().filter_map(|t| t.body);
        let bonds = reach.attachments.iter();
        touched.chain(bonds.filter_map(|h| self.attachments.get(h.0)?.body()))
    }

    /// The attachments of every deformable that hold to something that is there.
    fn find_attachments(&self, parts: &RapierParts) -> BTreeMap<BodyKey, Vec<AttachmentHandle>> {
        let mut found = BTreeMap::<_, Vec<_>>::new();
        for (index, a) in self.attachments.iter() {
            let target_is_there = match a.target {
                AttachTo::Body(body) => parts.bodies.get(body).is_some_and(|b| b.is_enabled()),
                AttachTo::Deformable(other) => self.get(other).is_some_and(|b| b.is_enabled()),
                _ => true,
            };
            if !a.is_broken() && target_is_there {
                let of = found.entry(a.deformable.key()).or_default();
                of.push(AttachmentHandle(index));
            }
        }
        found
    }
}
