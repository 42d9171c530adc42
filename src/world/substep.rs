//! One substep of a group, readable at once: bodies move freely, rows answer, shadows follow.

use super::group::Touched;
use super::observer::{
    AttachmentImpulse, Observer, PairImpulse, SpringEvent, SpringEventKind, Substep,
};
use super::{AttachmentHandle, Deformable, DeformableHandle};
use crate::body::SpringId;
use crate::contact::candidates::{Candidates, Reach};
use crate::coupling::attach::Attachment;
use crate::coupling::observe::Answer;
use crate::law::row::push_out;
use crate::math::DVec3;
use crate::solve::rows::{RowNode, Rows};
use crate::solve::shadow::Shadow;
use rapier3d::geometry::ColliderHandle;

/// An attachment while its group is advanced.
#[derive(Clone, Debug)]
pub(super) struct Attached {
    pub handle: AttachmentHandle,
    pub member: u32,
    pub shadow: u32,
    pub attachment: Attachment<DeformableHandle>,
    /// Impulse and angular impulse on the rigid body in this rigid step.
    pub impulse: DVec3,
    pub torque: DVec3,
}

/// Deformables that share substeps and rows, and the shadows of what they can touch.
#[derive(Debug)]
pub(super) struct Group {
    pub members: Vec<(DeformableHandle, Box<Deformable>)>,
    /// Per member, sorted by collider.
    pub candidates: Vec<Vec<Candidates>>,
    /// The first is the fixed world, the others belong to `touched`.
    pub shadows: Vec<Shadow>,
    pub touched: Vec<Touched>,
    pub attachments: Vec<Attached>,
    pairs: Vec<PairImpulse>,
    tied: Vec<AttachmentImpulse>,
    rows: Rows,
}

/// Settings of a substep.
#[derive(Clone, Copy)]
pub(super) struct Settings {
    pub passes: usize,
    /// Speed of the push-out \[m/s\].
    pub push_out: f64,
    /// Margin of candidate lists \[m\].
    pub margin: f64,
    /// Distance that counts as touching \[m\].
    pub touching: f64,
    /// The world's length unit.
    pub length_unit: f64,
}

impl Group {
    pub fn empty() -> Self {
        Self {
            members: Vec::new(),
            candidates: Vec::new(),
            shadows: vec![Shadow::FIXED],
            touched: Vec::new(),
            attachments: Vec::new(),
            pairs: Vec::new(),
            tied: Vec::new(),
            rows: Rows::default(),
        }
    }

    pub fn add_pair(&mut self, member: usize, collider: ColliderHandle) -> u32 {
        self.pairs.push(PairImpulse {
            deformable: self.members[member].0,
            collider,
            impulse: DVec3::ZERO,
            depth: 0.0,
            touching: 0,
        });
        self.pairs.len() as u32 - 1
    }

    pub fn add_attachment(
        &mut self,
        member: usize,
        handle: AttachmentHandle,
        shadow: u32,
        attachment: Attachment<DeformableHandle>,
    ) {
        self.tied.push(AttachmentImpulse {
            attachment: handle,
            deformable: attachment.deformable,
            impulse: DVec3::ZERO,
        });
        self.attachments.push(Attached {
            handle,
            member: member as u32,
            shadow,
            attachment,
            impulse: DVec3::ZERO,
            torque: DVec3::ZERO,
        });
    }

    /// Brings the velocities of shadows to the instants of the group's substeps.
    pub fn synchronise(&mut self, h: f64) {
        for shadow in &mut self.shadows[1..] {
            shadow.synchronise(h);
        }
    }

    /// Advances the group by h s, to `time`. `reversed` picks the order of the rows. `false` if a body has become
    /// non-finite; it is then frozen and the group's impulses are worthless.
    pub fn substep(
        &mut self,
        h: f64,
        time: f64,
        reversed: bool,
        s: &Settings,
        observer: &mut dyn Observer,
    ) -> bool {
        for shadow in &mut self.shadows[1..] {
            shadow.accelerate(h);
        }
        self.find_rows(h, s);
        for (_, body) in &mut self.members {
            body.predict(h);
        }
        self.read_free_velocities(h);
        self.rows.solve(&mut self.shadows, h, s.passes, reversed);
        self.write_velocities(h);
        self.push_out(h, s);
        self.book_work();
        for (_, body) in &mut self.members {
            body.finish(h);
        }
        for shadow in &mut self.shadows[1..] {
            shadow.advance(h);
        }
        if !self.freeze_broken() {
            return false;
        }
        self.report(h, time, observer);
        true
    }

    /// Contacts and ties at the positions the substep starts from.
    fn find_rows(&mut self, h: f64, s: &Settings) {
        self.rows.clear();
        for (m, ((_, body), candidates)) in
            (0..).zip(self.members.iter_mut().zip(&mut self.candidates))
        {
            let speed = f64::from(body.solver.speed_squared).sqrt();
            for c in candidates.iter_mut() {
                let shadow = &self.shadows[c.target.shadow as usize];
                let moved = h * (speed + c.target.speed(shadow));
                let slack = h * s.length_unit;
                let reach = Reach {
                    h,
                    touching: s.touching,
                    slack,
                    farthest: s.touching + slack + 2.0 * moved,
                };
                c.refresh(&body.state, shadow, moved, s.margin, reach.farthest);
                c.add_rows(
                    m,
                    &body.state,
                    shadow,
                    &mut body.slots,
                    &mut self.rows,
                    reach,
                );
            }
            for (i, a) in (0..).zip(&self.attachments).filter(|(_, a)| a.member == m) {
                let shadow = (a.shadow, &self.shadows[a.shadow as usize]);
                a.attachment
                    .add_ties(i, m, shadow, &body.state, &mut body.slots, &mut self.rows);
            }
        }
    }

    fn read_free_velocities(&mut self, h: f64) {
        for node in &mut self.rows.nodes {
            let body = &self.members[node.body as usize].1;
            node.free = body.free_velocity(node.node as usize, h);
            node.v = node.free;
        }
    }

    fn write_velocities(&mut self, h: f64) {
        // Row nodes come member by member, because rows are found so.
        for nodes in self.rows.nodes.chunk_by(|a, b| a.body == b.body) {
            let body = &mut self.members[nodes[0].body as usize].1;
            for node in nodes {
                body.slots[node.node as usize] = u32::MAX;
            }
            let changed = nodes.iter().filter(|n| n.v != n.free);
            body.take_impulses(changed.map(|n| (n.node as usize, n.v - n.free)), h);
        }
    }

    /// Mends depth and tie errors at position level, on the node alone, which gives nothing any velocity. What that changes
    /// in stored energy is booked; the angular momentum that a moved node loses goes to the body it is moved out of, if
    /// that is free.
    fn push_out(&mut self, h: f64, s: &Settings) {
        let Self {
            rows,
            members,
            shadows,
            touched,
            ..
        } = self;
        let mut mend = |node: u32, shadow: u32, by: DVec3| {
            let node = &rows.nodes[node as usize];
            // A pinned node stays where it is put.
            if node.inv_mass == 0.0 {
                return;
            }
            let lost = displace(members, node, by);
            if (shadow as usize)
                .checked_sub(1)
                .is_some_and(|i| touched[i].answer == Answer::Free)
            {
                let shadow = &mut shadows[shadow as usize];
                shadow.w += shadow.inv_inertia * lost;
                shadow.torque += lost;
            }
        };
        for row in rows.contacts.iter().filter(|r| r.depth > 0.0) {
            let by = row.normal * push_out(row.depth, h, s.push_out);
            mend(row.node, row.shadow, by);
        }
        for tie in &rows.ties {
            let length = tie.error.length();
            if length > 0.0 {
                let by = tie.error * (-push_out(length, h, s.push_out) / length);
                mend(tie.node, tie.shadow, by);
            }
        }
    }

    /// Work of every row by the trapezoid rule over the displacements actually made.
    fn book_work(&mut self) {
        for row in &self.rows.contacts {
            let impulse = row.normal * row.normal_impulse + row.friction_impulse;
            let shadow = &self.shadows[row.shadow as usize];
            let (mean, work) = mean_velocity(
                &mut self.members,
                &self.rows.nodes[row.node as usize],
                impulse,
            );
            let rigid = 0.5 * (shadow.velocity_before(row.arm) + shadow.velocity_at(row.arm));
            work.contact_normal -= row.normal_impulse * row.normal.dot(mean - rigid);
            work.contact_friction -= row.friction_impulse.dot(mean - rigid);
            work.rigid += impulse.dot(rigid);
            let pair = &mut self.pairs[row.pair as usize];
            pair.impulse += impulse;
            pair.depth = pair.depth.max(row.depth);
            pair.touching += u32::from(row.normal_impulse > 0.0);
        }
        for tie in &self.rows.ties {
            let (mean, work) = mean_velocity(
                &mut self.members,
                &self.rows.nodes[tie.node as usize],
                tie.impulse,
            );
            work.rigid += tie.impulse.dot(mean);
            let attached = &mut self.attachments[tie.attachment as usize];
            attached.impulse -= tie.impulse;
            attached.torque -= tie.arm.cross(tie.impulse);
            self.tied[tie.attachment as usize].impulse += tie.impulse;
        }
    }

    /// Freezes bodies whose state is not finite any more; `false` if there are any.
    pub fn freeze_non_finite(&mut self) -> bool {
        let mut sound = true;
        for (_, body) in &mut self.members {
            if !body.state.is_finite() {
                body.freeze();
                sound = false;
            }
        }
        sound
    }

    /// The same by the speeds that the integration pass has seen, which costs nothing.
    fn freeze_broken(&mut self) -> bool {
        let mut sound = true;
        for (_, body) in &mut self.members {
            if !body.solver.speed_squared.is_finite() {
                body.freeze();
                sound = false;
            }
        }
        sound
    }

    fn report(&mut self, h: f64, time: f64, observer: &mut dyn Observer) {
        for (handle, body) in &mut self.members {
            let Deformable {
                solver,
                state,
                blueprint,
                ..
            } = &mut **body;
            for e in solver.events.drain(..) {
                let [a, b] = blueprint.springs[e.spring as usize].nodes;
                observer.event(&SpringEvent {
                    kind: if e.broke {
                        SpringEventKind::Broke
                    } else {
                        SpringEventKind::YieldBegan
                    },
                    deformable: *handle,
                    spring: SpringId(e.spring),
                    position: (state.position(a as usize) + state.position(b as usize)) * 0.5,
                    time,
                    force: e.tension.into(),
                    energy: e.energy.into(),
                });
            }
        }
        observer.substep(&Substep {
            time,
            h,
            deformables: &self.members,
            contacts: &self.pairs,
            attachments: &self.tied,
        });
        for pair in &mut self.pairs {
            (pair.impulse, pair.depth, pair.touching) = (DVec3::ZERO, 0.0, 0);
        }
        for tied in &mut self.tied {
            tied.impulse = DVec3::ZERO;
        }
    }

    /// Per touched body, whether any node lies within `distance` m of it.
    pub fn near_bodies(&self, distance: f64) -> Vec<bool> {
        let mut near = vec![false; self.touched.len()];
        for ((_, body), candidates) in self.members.iter().zip(&self.candidates) {
            for c in candidates {
                let Some(i) = (c.target.shadow as usize).checked_sub(1) else {
                    continue;
                };
                near[i] = near[i] || c.any_within(&body.state, &self.shadows[i + 1], distance);
            }
        }
        for a in &self.attachments {
            if let Some(i) = (a.shadow as usize).checked_sub(1) {
                near[i] = true;
            }
        }
        near
    }
}

type Members = [(DeformableHandle, Box<Deformable>)];

/// Moves a node, books what that adds to the stored energy, and returns what it takes from the angular momentum.
fn displace(members: &mut Members, node: &RowNode, by: DVec3) -> DVec3 {
    let body = &mut members[node.body as usize].1;
    let i = node.node as usize;
    let mass = f64::from(body.blueprint.nodes[i].mass);
    let force = body.solver.force(i) + body.gravity() * mass;
    body.solver.work.push_out -= force.dot(by);
    let step = by.as_vec3().to_array();
    body.state.displace(i, step);
    -by.cross(body.state.velocity(i) * mass)
}

/// The velocity whose product with an impulse on a node is its work, and where to book it. Whatever holds a pinned node
/// takes up the work of the impulse.
fn mean_velocity<'a>(
    members: &'a mut Members,
    node: &RowNode,
    impulse: DVec3,
) -> (DVec3, &'a mut crate::solve::work::Work) {
    let body = &mut members[node.body as usize].1;
    // Leapfrog velocities stand at half substeps: the trapezoid of the displacements before and after the impulse. The
    // other schemes know the velocity at the impulse itself, just before it and just after.
    let mean = if body.integrator().takes_late_impulses() {
        0.5 * (node.before + node.v)
    } else {
        node.before + 0.5 * (node.v - node.free)
    };
    let work = &mut body.solver.work;
    if node.inv_mass == 0.0 {
        work.external -= impulse.dot(mean);
    }
    (mean, work)
}
