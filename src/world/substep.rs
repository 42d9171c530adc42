//! One substep of a group, readable at once: bodies move freely, rows answer, shadows follow.

use super::group::Touched;
use super::observer::{
    AttachmentImpulse, NodeImpulse, Observer, PairImpulse, Partner, SpringEvent, SpringEventKind,
    Substep,
};
use super::span::Way;
use super::ties::{Attached, mirrored};
use super::touch::PairSum;
use super::work::HalfKick;
use super::{Deformable, DeformableHandle, meet};
use crate::body::SpringId;
use crate::contact::beside::Beside;
use crate::contact::candidates::Candidates;
use crate::contact::encounter::Encounter;
use crate::contact::site::{Reach, Site};
use crate::math::DVec3;
use crate::solve::rows::{Negligible, RowNode, Rows};
use crate::solve::shadow::Shadow;

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
    pub(super) pairs: Vec<PairImpulse>,
    /// What pairs add up over the substeps.
    pub(super) sums: Vec<PairSum>,
    /// What nodes got in the substep under way, if that is wanted.
    pub(super) node_impulses: Option<Vec<NodeImpulse>>,
    pub tied: Vec<AttachmentImpulse>,
    /// The same for observers, with what attachments between deformables did to the other ones.
    told: Vec<AttachmentImpulse>,
    pub rows: Rows,
    /// Where free motion took the nodes of rows, in the frames of their bodies \[m\].
    places: Vec<DVec3>,
    /// How far nodes of rows were moved at position level \[m\].
    pub(super) mended: Vec<DVec3>,
    /// The half kicks before, of the nodes of rows; empty where nothing moves by velocity Verlet.
    pub(super) kicks: Vec<Option<HalfKick>>,
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
            told: Vec::new(),
            rows: Rows::default(),
            places: Vec::new(),
            mended: Vec::new(),
            kicks: Vec::new(),
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

    /// Goes on in substeps of h s after some of `last` s.
    pub fn change_substep(&mut self, last: f64, h: f64) {
        self.rows.change_substep(h / last);
        for shadow in &mut self.shadows[1..] {
            shadow.change_substep(last, h);
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
        self.rows.clear();
        self.rows.negligible = Negligible::of(h, s.length_unit);
        self.rows.push_out = s.push_out;
        self.members.iter_mut().for_each(|(_, body)| body.begin(h));
        self.find_rows(h, s);
        self.note_kicks();
        for (_, body) in &mut self.members {
            body.predict(h);
            body.book_moved_out();
        }
        self.note_places();
        self.solve_rows(h, s.passes, reversed);
        self.remember(s);
        self.push_out(h, s);
        self.note_ways(h, time, s);
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
        if observer.wants_springs(time, &self.members) {
            self.write_back();
        }
        self.report(h, time, observer);
        true
    }

    /// Brings the states of all members up to date for whoever may look at them.
    pub fn write_back(&mut self) {
        for (_, body) in &mut self.members {
            let Deformable { solver, state, .. } = &mut **body;
            solver.write_back(state);
        }
    }

    /// Contacts at the positions the substep starts from. Says by how much any two things may close in it at most \[m\].
    pub(super) fn look(&mut self, h: f64, s: &Settings) -> f64 {
        let mut most = 0.0_f64;
        for (m, ((_, body), candidates)) in
            (0..).zip(self.members.iter_mut().zip(&mut self.candidates))
        {
            body.follow();
            let (speed, moved) = (body.fastest(), body.moved);
            let (side, slots) = body.side(m);
            for c in candidates.iter_mut() {
                c.follow(&self.shadows[c.target.shadow as usize]);
            }
            for i in 0..candidates.len() {
                let (before, rest) = candidates.split_at_mut(i);
                let [c, after @ ..] = rest else { continue };
                let shadow = &self.shadows[c.target.shadow as usize];
                let closing = h * (speed + c.target.speed(shadow));
                most = most.max(closing);
                let slack = h * s.length_unit;
                let reach = Reach {
                    h,
                    touching: s.touching,
                    slack,
                    farthest: s.touching + slack + 2.0 * closing,
                };
                let site = Site {
                    side,
                    shadow,
                    slots,
                    rows: &mut self.rows,
                    reach,
                    beside: Beside {
                        others: [before, after],
                        shadows: &self.shadows,
                        reach,
                    },
                };
                c.find_rows(site, moved, closing, s.near);
            }
        }
        if !self.encounters.is_empty() {
            for (_, body) in &mut self.members {
                body.span = body.span_of_velocities(s.length_unit);
                if let Some(outline) = &mut body.outline {
                    outline.loosen();
                }
            }
        }
        for encounter in &mut self.encounters {
            let closing = meet::find_rows(encounter, &mut self.members, &mut self.rows, h, s);
            most = most.max(closing);
        }
        most
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
    fn note_ways(&mut self, h: f64, time: f64, s: &Settings) {
        let meets = !self.encounters.is_empty();
        for (_, body) in &mut self.members {
            body.moved = 0.0;
            body.way = (meets && body.integrator().takes_late_impulses()).then(|| Way {
                ended: time,
                h,
                span: body.span_of_velocities(s.length_unit),
            });
        }
        for (node, place) in self.rows.nodes.iter().zip(&self.places) {
            let body = &mut self.members[node.body as usize].1;
            let shift = body.state.local(node.node as usize) - *place;
            body.moved = body.moved.max(shift.length());
            if let Some(way) = &mut body.way {
                way.span = way.span.with(node.free + shift / h);
            }
        }
        for (_, body) in &mut self.members {
            let speed = body.solver.top_speed();
            // Where a node does not move at its last velocity, the mean is between that and the one before.
            let mean = if body.integrator().takes_late_impulses() {
                1.0 + 1e-6
            } else {
                2.0
            };
            body.moved = body.gain() * (body.moved + mean * h * speed);
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
            body.tear();
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
        let Self { tied, told, .. } = self;
        told.clone_from(tied);
        told.extend(mirrored(&self.attachments, tied, &self.members));
        observer.substep(&Substep {
            time,
            h,
            deformables: &self.members,
            contacts: &self.pairs,
            attachments: &self.told,
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
                    || c.any_within(
                        body.contact_state(),
                        &self.shadows[i + 1],
                        body.moved,
                        distance,
                    );
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
