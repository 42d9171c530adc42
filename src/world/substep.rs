//! One substep of a group, readable at once: bodies move freely, rows answer, shadows follow.

use super::group::Touched;
use super::observer::{
    AttachmentImpulse, NodeImpulse, Observer, PairImpulse, Partner, SpringEvent, SpringEventKind,
    Substep,
};
use super::ties::Attached;
use super::touch::PairSum;
use super::{Deformable, DeformableHandle, meet};
use crate::body::{NodeId, SpringId};
use crate::contact::candidates::Candidates;
use crate::contact::encounter::Encounter;
use crate::contact::site::{Reach, Side, Site};
use crate::coupling::observe::Answer;
use crate::law::row::{pull_back, push_out};
use crate::math::DVec3;
use crate::solve::rows::{RowNode, Rows, Term, Terms};
use crate::solve::shadow::Shadow;
use crate::solve::work::Work;

/// Deformables that share substeps and rows, and the shadows of what they can touch.
#[derive(Debug)]
pub(super) struct Group {
    pub members: Vec<(DeformableHandle, Box<Deformable>)>,
    /// Per member, sorted by collider.
    pub candidates: Vec<Vec<Candidates>>,
    /// Pairs of members that may touch, sorted.
    pub encounters: Vec<Encounter>,
    /// The first is the fixed world, the others belong to `touched`.
    pub shadows: Vec<Shadow>,
    /// The shadows as they wait for the rows' answer.
    pub waiting: Vec<Shadow>,
    pub touched: Vec<Touched>,
    pub attachments: Vec<Attached>,
    pairs: Vec<PairImpulse>,
    /// What pairs add up over the substeps.
    sums: Vec<PairSum>,
    /// What nodes got in the substep under way, if that is wanted.
    node_impulses: Option<Vec<NodeImpulse>>,
    pub tied: Vec<AttachmentImpulse>,
    pub rows: Rows,
    /// Where free motion took the nodes of rows, in the frames of their bodies \[m\].
    places: Vec<DVec3>,
}

/// Distance within which a node counts as near a sleeping body, in length units.
pub(super) const NEAR: f64 = 2e-3;

/// Settings of a substep.
#[derive(Clone, Copy)]
pub(super) struct Settings {
    pub passes: usize,
    /// Speed of the push-out \[m/s\].
    pub push_out: f64,
    /// Distance within which a node counts as near a sleeping body \[m\].
    pub near: f64,
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
            encounters: Vec::new(),
            shadows: vec![Shadow::FIXED],
            waiting: Vec::new(),
            touched: Vec::new(),
            attachments: Vec::new(),
            pairs: Vec::new(),
            sums: Vec::new(),
            node_impulses: None,
            tied: Vec::new(),
            rows: Rows::default(),
            places: Vec::new(),
        }
    }

    pub fn add_pair(&mut self, member: usize, partner: Partner) -> u32 {
        self.pairs.push(PairImpulse {
            deformable: self.members[member].0,
            partner,
            impulse: DVec3::ZERO,
            depth: 0.0,
            touching: 0,
        });
        self.sums.push(PairSum::default());
        self.pairs.len() as u32 - 1
    }

    /// What each pair has done in this rigid step.
    pub fn pair_sums(&self) -> impl Iterator<Item = (&PairImpulse, &PairSum)> {
        self.pairs.iter().zip(&self.sums)
    }

    /// After a step that went wrong, nothing counts as touched, and what was found near was found at places that do not
    /// count.
    pub fn forget_contacts(&mut self) {
        self.sums.fill(PairSum::default());
        self.candidates
            .iter_mut()
            .flatten()
            .for_each(Candidates::forget);
        self.encounters.iter_mut().for_each(Encounter::forget);
    }

    /// Brings the velocities of shadows to the instants of the group's substeps.
    pub fn synchronise(&mut self, h: f64) {
        self.start_rigid_contacts(h);
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
        self.note_places();
        self.solve_rows(h, s.passes, reversed);
        self.remember(s);
        self.push_out(h, s);
        self.note_ways(h);
        self.list_node_impulses(observer.wants_node_impulses());
        self.book_work();
        self.book_ties(h, time);
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
                let closing = h * (speed + c.target.speed(shadow));
                let slack = h * s.length_unit;
                let reach = Reach {
                    h,
                    touching: s.touching,
                    slack,
                    farthest: s.touching + slack + 2.0 * closing,
                };
                let site = Site {
                    side: Side {
                        body: m,
                        state: &body.state,
                        topology: &body.topology,
                    },
                    shadow,
                    slots: &mut body.slots,
                    rows: &mut self.rows,
                    reach,
                };
                c.find_rows(site, body.moved, closing, s.near);
            }
        }
        for encounter in &mut self.encounters {
            meet::find_rows(encounter, &mut self.members, &mut self.rows, h, s);
        }
        self.find_ties(h);
    }

    /// What touches, sticks and slides, for the next substep.
    fn remember(&mut self, s: &Settings) {
        for c in self.candidates.iter_mut().flatten() {
            c.remember(&self.rows, s.touching);
        }
        for e in &mut self.encounters {
            e.remember(&self.rows, s.touching);
        }
    }

    /// Where free motion took the nodes of rows.
    fn note_places(&mut self) {
        let Self {
            rows,
            members,
            places,
            ..
        } = self;
        let place = |n: &RowNode| members[n.body as usize].1.state.local(n.node as usize);
        places.clear();
        places.extend(rows.nodes.iter().map(place));
    }

    /// How far every body has moved in the substep at most: what it moved freely, and what rows did to its nodes.
    fn note_ways(&mut self, h: f64) {
        for (_, body) in &mut self.members {
            body.moved = 0.0;
        }
        for (node, place) in self.rows.nodes.iter().zip(&self.places) {
            let body = &mut self.members[node.body as usize].1;
            let shift = body.state.local(node.node as usize).distance(*place);
            body.moved = body.moved.max(shift);
        }
        for (_, body) in &mut self.members {
            let speed = f64::from(body.solver.speed_squared).sqrt();
            // Where a node does not move at its last velocity, the mean is between that and the one before.
            let mean = if body.integrator().takes_late_impulses() {
                1.0 + 1e-6
            } else {
                2.0
            };
            body.moved += mean * h * speed;
        }
    }

    /// Mends depth, creep of what sticks, and errors of ties at position level, on the nodes alone, which gives nothing any
    /// velocity. Ties are mended in full, and at a limited rate only while something moved from outside is on its way back. What that changes in stored energy is booked; the angular momentum that a moved node loses goes to the
    /// body it is moved out of, if that is free.
    fn push_out(&mut self, h: f64, s: &Settings) {
        let Self {
            rows,
            members,
            shadows,
            touched,
            attachments,
            ..
        } = self;
        let mut mend = |terms: Terms, shadow: u32, by: DVec3| {
            let lost = displace(members, &rows.nodes, rows.terms_of(terms), by);
            if (shadow as usize)
                .checked_sub(1)
                .is_some_and(|i| touched[i].answer == Answer::Free)
            {
                let shadow = &mut shadows[shadow as usize];
                shadow.w += shadow.inv_inertia * lost;
                shadow.torque += lost;
            }
        };
        for row in &rows.contacts {
            let mut by = DVec3::ZERO;
            if row.depth > 0.0 && row.softness == 0.0 {
                by += row.normal * push_out(row.depth, h, s.push_out);
            }
            if row.drift != DVec3::ZERO && row.sticks() {
                by -= row.drift * pull_back(h);
            }
            if by != DVec3::ZERO {
                mend(row.terms, row.shadow, by);
            }
        }
        for tie in rows.ties.iter().filter(|t| t.softness == 0.0) {
            let length = tie.error.length();
            if length > 0.0 {
                let loose = attachments[tie.attachment as usize].bond.loose;
                let most = if loose { s.push_out * h } else { length };
                mend(tie.terms, tie.shadow, -towards(tie.error, length.min(most)));
            }
        }
    }

    /// Work of every row by the trapezoid rule over the displacements actually made. It is booked where the two sides meet:
    /// at the collider's velocity, or half-way between the points of two deformables.
    fn book_work(&mut self) {
        for row in &self.rows.contacts {
            let terms = self.rows.terms_of(row.terms);
            let shadow = &self.shadows[row.shadow as usize];
            let meeting = if row.between {
                0.5 * mean_velocity(&self.members, &self.rows.nodes, terms, f64::abs)
            } else {
                0.5 * (shadow.velocity_before(row.arm) + shadow.velocity_at(row.arm))
            };
            let impulse = row.impulse();
            let along = row.normal * row.normal_impulse;
            for term in terms {
                let node = &self.rows.nodes[term.node as usize];
                let (mean, work) = node_work(&mut self.members, node, impulse * term.share);
                work.contact_normal -= term.share * along.dot(mean - meeting);
                work.contact_friction -= term.share * row.friction_impulse.dot(mean - meeting);
                work.rigid += term.share * impulse.dot(meeting);
            }
            let pair = row.pair as usize;
            let pressed = row.normal_impulse > 0.0;
            // Two deformables are two pairs, the second with the impulse on the other one.
            for (i, sign) in [1.0, -1.0].into_iter().enumerate() {
                if i == 1 && !row.between {
                    break;
                }
                let of_this = |t: &&Term| t.weight * sign > 0.0;
                let share: f64 = terms.iter().filter(of_this).map(|t| t.share).sum();
                let sums = &mut self.pairs[pair + i];
                sums.impulse += impulse * share;
                sums.depth = sums.depth.max(row.depth);
                sums.touching += u32::from(pressed);
                if pressed {
                    let point = point(&self.members, &self.rows.nodes, terms, sign);
                    self.sums[pair + i].add_row(point, row.normal * sign, row.normal_impulse);
                }
            }
        }
    }

    /// What each node got of each row.
    fn list_node_impulses(&mut self, wanted: bool) {
        if !wanted {
            self.node_impulses = None;
            return;
        }
        let list = self.node_impulses.get_or_insert_default();
        list.clear();
        for row in &self.rows.contacts {
            let impulse = row.impulse();
            if impulse == DVec3::ZERO {
                continue;
            }
            list.extend(self.rows.terms_of(row.terms).iter().map(|term| {
                let node = &self.rows.nodes[term.node as usize];
                // The nodes of the other deformable belong to the second pair.
                let pair = row.pair as usize + usize::from(row.between && term.weight < 0.0);
                NodeImpulse {
                    deformable: self.members[node.body as usize].0,
                    node: NodeId(node.node),
                    partner: self.pairs[pair].partner,
                    impulse: impulse * term.share,
                }
            }));
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
        self.report_breaks(observer);
        observer.substep(&Substep {
            time,
            h,
            deformables: &self.members,
            contacts: &self.pairs,
            attachments: &self.tied,
            node_impulses: self.node_impulses.as_deref().unwrap_or_default(),
        });
        for (pair, sum) in self.pairs.iter_mut().zip(&mut self.sums) {
            sum.add(pair, h);
            (pair.impulse, pair.depth, pair.touching) = (DVec3::ZERO, 0.0, 0);
        }
        for tied in &mut self.tied {
            (tied.impulse, tied.moment) = Default::default();
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
                near[i] = near[i]
                    || c.any_within(&body.state, &self.shadows[i + 1], body.moved, distance);
            }
        }
        for a in self.attachments.iter().filter(|a| !a.bond.is_broken()) {
            if let Some(i) = (a.shadow as usize).checked_sub(1) {
                near[i] = true;
            }
        }
        near
    }
}

pub(super) type Members = [(DeformableHandle, Box<Deformable>)];

/// A vector of length `length` along `v`.
fn towards(v: DVec3, length: f64) -> DVec3 {
    v * (length / v.length())
}

/// Moves a point by moving its nodes as an impulse would, books what that adds to the stored energy, and returns what it
/// takes from the angular momentum. A pinned node stays where it is put.
fn displace(members: &mut Members, nodes: &[RowNode], terms: &[Term], by: DVec3) -> DVec3 {
    let response: f64 = terms
        .iter()
        .map(|t| t.weight * t.share * nodes[t.node as usize].inv_mass)
        .sum();
    let mut lost = DVec3::ZERO;
    if response <= 0.0 {
        return lost;
    }
    for term in terms {
        let node = &nodes[term.node as usize];
        let by = by * (term.share * node.inv_mass / response);
        if by == DVec3::ZERO {
            continue;
        }
        let body = &mut members[node.body as usize].1;
        let i = node.node as usize;
        let mass = f64::from(body.blueprint.nodes[i].mass);
        let force = body.solver.force(i) + body.gravity() * mass;
        body.solver.work.push_out -= force.dot(by);
        body.state.displace(i, by.as_vec3().to_array());
        lost -= by.cross(body.state.velocity(i) * mass);
    }
    lost
}

/// Where a row acts on its first body, or with a sign of −1 on its second \[m\].
fn point(members: &Members, nodes: &[RowNode], terms: &[Term], sign: f64) -> DVec3 {
    let place = |t: &Term| {
        let node = &nodes[t.node as usize];
        let body = &members[node.body as usize].1;
        body.state.position(node.node as usize) * (t.weight * sign).max(0.0)
    };
    terms.iter().map(place).sum()
}

/// Leapfrog velocities stand at half substeps: the trapezoid of the displacements before and after the impulse. The other
/// schemes know the velocity at the impulse itself, just before it and just after.
fn mean(body: &Deformable, node: &RowNode) -> DVec3 {
    if body.integrator().takes_late_impulses() {
        0.5 * (node.before + node.v)
    } else {
        node.before + 0.5 * (node.v - node.free)
    }
}

/// The sum of the nodes' mean velocities by the weights after `of` \[m/s\].
fn mean_velocity(
    members: &Members,
    nodes: &[RowNode],
    terms: &[Term],
    of: impl Fn(f64) -> f64,
) -> DVec3 {
    let velocity = |t: &Term| {
        let node = &nodes[t.node as usize];
        mean(&members[node.body as usize].1, node) * of(t.weight)
    };
    terms.iter().map(velocity).sum()
}

/// The velocity whose product with an impulse on a node is its work, and where to book it. Whatever holds a pinned node
/// takes up the work of the impulse.
pub(super) fn node_work<'a>(
    members: &'a mut Members,
    node: &RowNode,
    impulse: DVec3,
) -> (DVec3, &'a mut Work) {
    let body = &mut members[node.body as usize].1;
    let mean = mean(body, node);
    let work = &mut body.solver.work;
    if node.inv_mass == 0.0 {
        work.external -= impulse.dot(mean);
    }
    (mean, work)
}
