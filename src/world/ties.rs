//! Attachments of a group within a substep: their ties, the work that these do, and whether they hold.

use super::AttachmentHandle;
use super::attach::AttachmentState;
use super::observer::{AttachmentBroke, AttachmentImpulse, Observer};
use super::substep::{Group, Members};
use super::work::{HalfKick, node_work};
use crate::coupling::attach::{Load, Point, Side};
use crate::coupling::ties::{Average, LinkEnergy};
use crate::math::DVec3;
use crate::solve::rows::Term;
use std::collections::BTreeMap;

/// An attachment while its group is advanced.
#[derive(Clone, Debug)]
pub(super) struct Attached {
    pub handle: AttachmentHandle,
    pub member: u32,
    pub shadow: u32,
    /// The member that it is attached to.
    pub other: Option<u32>,
    pub bond: AttachmentState,
    /// What the target got in this rigid step, added up.
    pub load: Load,
    /// What of it by points that pinned nodes alone hold.
    pub by_pins: Load,
    /// Whether the rigid body sleeps: those points bear what they bore before then.
    pub asleep: bool,
    /// The pivot, relative to what the arms of ties are relative to.
    pivot: DVec3,
    /// Energy, average and last motion at the start of the rigid step.
    start: (f64, Average, Vec<DVec3>, f64),
    /// Energy of a link's springs before the substep and after it.
    held: (f64, f64),
    /// How its points moved in the substep \[m\].
    moves: Vec<DVec3>,
    just_broke: bool,
}

/// What attachments between deformables did to those that they are attached to.
pub(super) fn mirrored<'a>(
    attachments: &'a [Attached],
    tied: &'a [AttachmentImpulse],
    members: &'a Members,
) -> impl Iterator<Item = AttachmentImpulse> + 'a {
    let pairs = attachments.iter().zip(tied);
    pairs.filter_map(|(a, tied)| {
        let (deformable, _) = members[a.other? as usize];
        Some(AttachmentImpulse {
            deformable,
            impulse: -tied.impulse,
            moment: -tied.moment,
            ..*tied
        })
    })
}

impl Attached {
    /// Back to the start of the rigid step.
    pub fn go_back(&mut self) {
        (self.bond.energy, self.bond.average) = (self.start.0, self.start.1);
        self.bond.moved.clone_from(&self.start.2);
        self.bond.moved_in = self.start.3;
        self.bond.broken = None;
        self.just_broke = false;
        (self.load, self.by_pins) = Default::default();
    }
}

impl Group {
    /// The points of each of two members that are welded or pinned to the other, or that the other is held by.
    pub(super) fn attached_nodes(&self, members: [u32; 2]) -> [Vec<u32>; 2] {
        let mut nodes: [Vec<u32>; 2] = Default::default();
        for a in &self.attachments {
            let Some(k) = members.iter().position(|m| *m == a.member) else {
                continue;
            };
            if a.other != Some(members[1 - k]) || a.bond.is_link() || a.bond.is_broken() {
                continue;
            }
            for part in a.bond.points.iter().flat_map(|p| &p.parts) {
                nodes[if part.other { 1 - k } else { k }].push(part.node);
            }
        }
        let mut of = |k: usize| {
            nodes[k].sort_unstable();
            self.members[members[k] as usize].1.points_of(&nodes[k])
        };
        [of(0), of(1)]
    }

    /// Tells targets which points of their deformables their bodies hold.
    pub(super) fn note_held(&mut self) {
        let mut held = BTreeMap::<(u32, u32), Vec<u32>>::new();
        for a in self.attachments.iter().filter(|a| a.other.is_none()) {
            if !a.bond.is_link() && !a.bond.is_broken() {
                let of = held.entry((a.member, a.shadow)).or_default();
                of.extend(a.bond.points.iter().filter_map(Point::node));
            }
        }
        let bodies = (0..).zip(self.members.iter().zip(&mut self.candidates));
        for (m, ((_, body), candidates)) in bodies {
            candidates.iter_mut().for_each(|c| c.target.held.clear());
            for (&(_, shadow), nodes) in held.range_mut((m, 0)..=(m, u32::MAX)) {
                nodes.sort_unstable();
                let points = body.points_of(nodes);
                for c in candidates.iter_mut().filter(|c| c.target.shadow == shadow) {
                    c.target.held.clone_from(&points);
                }
            }
        }
    }

    pub(super) fn add_attachment(
        &mut self,
        member: u32,
        other: Option<u32>,
        shadow: u32,
        (handle, bond): (AttachmentHandle, AttachmentState),
        asleep: bool,
    ) {
        self.tied.push(AttachmentImpulse {
            attachment: handle,
            deformable: bond.deformable,
            impulse: DVec3::ZERO,
            moment: DVec3::ZERO,
        });
        let links = if bond.is_link() { bond.points.len() } else { 0 };
        let moves = Vec::with_capacity(links);
        self.attachments.push(Attached {
            handle,
            member,
            shadow,
            other,
            start: (bond.energy, bond.average, bond.moved.clone(), bond.moved_in),
            bond,
            load: Load::default(),
            by_pins: Load::default(),
            asleep,
            pivot: DVec3::ZERO,
            held: (0.0, 0.0),
            moves,
            just_broke: false,
        });
    }

    /// Adds the ties of all attachments that hold.
    pub(super) fn find_ties(&mut self, h: f64) {
        let Self {
            members,
            shadows,
            attachments,
            rows,
            ..
        } = self;
        for (i, a) in (0..).zip(attachments).filter(|(_, a)| !a.bond.is_broken()) {
            let shadow = (a.shadow, &shadows[a.shadow as usize]);
            let pair = match a.other {
                Some(other) => members
                    .get_disjoint_mut([a.member as usize, other as usize])
                    .map(|[own, other]| (own, Some(other))),
                None => Ok((&mut members[a.member as usize], None)),
            };
            let Ok((own, other)) = pair else { continue };
            let own = Side {
                member: a.member,
                state: &own.1.state,
                slots: &mut own.1.slots,
            };
            let other = other.zip(a.other).map(|(other, member)| Side {
                member,
                state: &other.1.state,
                slots: &mut other.1.slots,
            });
            a.held = (0.0, 0.0);
            a.moves.clear();
            let first = rows.ties.len();
            a.pivot = a.bond.add_ties(i, h, shadow, own, other, rows);
            if !a.bond.is_link() {
                rows.lead_to_held_nodes(first, rows.push_out);
            }
        }
    }

    /// Work of ties: that of a link goes into its spring and its damper, which belong to the deformable that is attached.
    /// Then each attachment bears its load, or breaks.
    pub(super) fn book_ties(&mut self, h: f64, time: f64) {
        self.book_tie_work(h);
        self.go_on_bearing(h);
        let Self {
            members,
            attachments,
            tied,
            ..
        } = self;
        for (a, tied) in attachments.iter_mut().zip(tied) {
            if a.bond.is_broken() {
                continue;
            }
            let owner = &mut members[a.member as usize].1;
            if a.bond.is_link() {
                // What the spring held before differs from what was kept by what nodes were moved at position level.
                owner.solver.work.push_out += a.held.0 - a.bond.energy;
                owner.links += a.held.1 - a.bond.energy;
                a.bond.energy = a.held.1;
                std::mem::swap(&mut a.bond.moved, &mut a.moves);
                a.bond.moved_in = h;
            }
            a.just_broke = a.bond.bear(-tied.impulse, -tied.moment, h, time);
            if a.just_broke {
                owner.solver.work.fracture += a.bond.energy;
                owner.links -= a.bond.energy;
                a.bond.energy = 0.0;
            }
        }
        if self.attachments.iter().any(|a| a.just_broke) {
            self.note_held();
        }
    }

    /// Tells the observer of attachments that broke in this substep.
    pub(super) fn report_breaks(&mut self, observer: &mut dyn Observer) {
        for a in self.attachments.iter_mut().filter(|a| a.just_broke) {
            a.just_broke = false;
            if let Some(b) = a.bond.broken {
                observer.attachment_event(&AttachmentBroke {
                    attachment: a.handle,
                    deformable: a.bond.deformable,
                    force: b.force,
                    moment: b.moment,
                    time: b.time,
                });
            }
        }
    }

    /// What pinned nodes bear of a rigid body asleep no row can tell: it is what they bore.
    fn go_on_bearing(&mut self, h: f64) {
        for (a, tied) in self.attachments.iter_mut().zip(&mut self.tied) {
            if a.asleep && !a.bond.is_broken() {
                let load = a.bond.by_pins * h;
                a.load += load;
                tied.impulse -= load.force;
                tied.moment -= load.moment;
            }
        }
    }

    fn book_tie_work(&mut self, h: f64) {
        for tie in &self.rows.ties {
            let attached = &mut self.attachments[tie.attachment as usize];
            let shadow = &self.shadows[tie.shadow as usize];
            let mut velocity = DVec3::ZERO;
            for term in self.rows.terms_of(tie.terms) {
                let node = &self.rows.nodes[term.node as usize];
                let impulse = tie.impulse * term.share;
                let kick = HalfKick::noted(&self.kicks, term.node);
                let (mean, work) = node_work(&mut self.members, node, kick, impulse);
                work.rigid += impulse.dot(mean);
                velocity += node.v * term.weight;
            }
            if tie.softness > 0.0 {
                velocity -= shadow.velocity_at(tie.arm) + tie.chord;
                attached.moves.push(velocity * h);
                let link = LinkEnergy::of(attached.bond.hold, tie, velocity, h);
                let owner = &mut self.members[attached.member as usize].1;
                attached.held.0 += link.held.0;
                attached.held.1 += link.held.1;
                // By what spring and damper take, whatever the nodes or the body were told in between.
                owner.solver.work.rigid -= 0.5 * tie.impulse.dot(tie.before + velocity);
                owner.solver.work.damping += link.dissipated;
            }
            let load = Load {
                force: -tie.impulse,
                moment: (tie.arm - attached.pivot).cross(-tie.impulse),
                torque: tie.arm.cross(-tie.impulse),
            };
            attached.load += load;
            let mut terms = self.rows.terms_of(tie.terms).iter();
            let pinned = |t: &Term| self.rows.nodes[t.node as usize].inv_mass == 0.0;
            if tie.softness == 0.0 && !tie.between && terms.all(pinned) {
                attached.by_pins += load;
            }
            let tied = &mut self.tied[tie.attachment as usize];
            tied.impulse -= load.force;
            tied.moment -= load.moment;
        }
    }
}
