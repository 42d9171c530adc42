//! Blows: what rows make faster or slower within a substep is looked at again before it moves.
//!
//! Rows are found by the velocities that a substep starts with. What stands still seems to reach nothing then; struck by
//! something fast it moves within the same substep, and would be beyond a thin plate before it is looked at again. So
//! where rows have something fast to stop they are tried out first, and what they moved is looked at once more with the
//! velocity it got. That may strike something else in its turn, so this goes on until nothing changes. Blows are events:
//! what is done here may allocate.

use super::Deformable;
use super::substep::{Group, Settings};
use crate::contact::candidates::Candidates;
use crate::contact::site::slot;
use crate::math::DVec3;
use crate::solve::rows::{Row, Rows, Term};
use crate::solve::shadow::Shadow;
use std::collections::BTreeMap;

/// How many things may strike each other in one substep, one after the other, and still be looked at.
const LAYERS: usize = 8;

/// How far things may be moved by a blow without being looked at, in length units: less than what takes a node past the
/// middle of a plate of twice that. Other deformables may have no thickness at all; where there are any, it is the slack
/// of every reach instead.
const UNSEEN: f64 = 1e-3;

/// The velocities that things are looked at with where these are not their own.
struct Ahead {
    /// Of nodes, by member.
    nodes: BTreeMap<(u32, u32), DVec3>,
    /// Of all shadows, linear and angular.
    shadows: Vec<(DVec3, DVec3)>,
}

impl Group {
    /// The rows of a substep: contacts and ties at the positions it starts from, and the contacts of what others strike.
    pub(super) fn find_rows(&mut self, h: f64, s: &Settings) {
        let closing = self.look(h, s);
        self.find_ties(h);
        let unseen = if self.encounters.is_empty() {
            UNSEEN * s.length_unit
        } else {
            h * s.length_unit
        };
        let limit = unseen / h;
        // Shadows that strike each other, and nodes that are torn along, need not be near anything yet.
        let (rows, shadows) = (&self.rows, &self.shadows);
        let fast = closing > unseen && rows.contacts_stop(shadows, h, limit);
        if !fast && !rows.others_stop(shadows, h, limit) {
            return;
        }
        self.rows.blow = true;
        let mut ahead = Ahead {
            nodes: BTreeMap::new(),
            shadows: self.shadows.iter().map(|s| (s.v, s.w)).collect(),
        };
        for _ in 0..LAYERS {
            let (mut tried, mut shadows) = (self.rows.clone(), self.shadows.clone());
            tried.solve(&mut shadows, h, s.passes, false);
            if !self.note_struck(&mut ahead, &tried, &shadows, limit) {
                return;
            }
            let found = self.look_ahead(&ahead, h, s);
            self.forget_rows();
            self.look(h, s);
            self.add_missing(&found, |_| true);
            self.add_missing(&tried, |row| row.normal_impulse > 0.0);
            self.find_ties(h);
        }
    }

    /// Forgets the rows of the substep, and which nodes have any: all is looked for anew.
    fn forget_rows(&mut self) {
        let candidates = self.candidates.iter_mut().flatten();
        candidates.for_each(Candidates::look_anew);
        for node in &self.rows.nodes {
            self.members[node.body as usize].1.slots[node.node as usize] = u32::MAX;
        }
        self.rows.clear();
        self.rows.blow = true;
    }

    /// Notes what the trial has made faster or slower by more than `limit` m/s than it was looked at with; whether there is
    /// anything.
    fn note_struck(&self, ahead: &mut Ahead, tried: &Rows, shadows: &[Shadow], limit: f64) -> bool {
        let mut any = false;
        for node in &tried.nodes {
            let looked = ahead.nodes.get(&(node.body, node.node));
            if node.v.distance(*looked.unwrap_or(&node.before)) > limit {
                ahead.nodes.insert((node.body, node.node), node.v);
                any = true;
            }
        }
        for c in self.candidates.iter().flatten() {
            let i = c.target.shadow as usize;
            let (v, w) = (shadows[i].v, shadows[i].w);
            let change = Shadow {
                v: v - ahead.shadows[i].0,
                w: w - ahead.shadows[i].1,
                ..Shadow::FIXED
            };
            if c.target.speed(&change) > limit {
                ahead.shadows[i] = (v, w);
                any = true;
            }
        }
        any
    }

    /// The contacts that are found with other velocities.
    fn look_ahead(&mut self, ahead: &Ahead, h: f64, s: &Settings) -> Rows {
        self.forget_rows();
        let speeds = self.members.iter();
        let speeds: Vec<f32> = speeds.map(|(_, body)| body.solver.speed_squared).collect();
        let shadows = self.shadows.clone();
        let mut own = Vec::with_capacity(ahead.nodes.len());
        for (&(m, node), v) in &ahead.nodes {
            let Deformable { state, solver, .. } = &mut *self.members[m as usize].1;
            own.push(state.velocity(node as usize));
            state.set_velocity(node as usize, *v);
            let square = v.length_squared() as f32 * (1.0 + 1e-6);
            solver.speed_squared = solver.speed_squared.max(square);
        }
        for (shadow, &(v, w)) in self.shadows.iter_mut().zip(&ahead.shadows) {
            shadow.before.0 += v - shadow.v;
            shadow.before.1 += w - shadow.w;
            (shadow.v, shadow.w) = (v, w);
        }
        self.look(h, s);
        self.shadows = shadows;
        for (&(m, node), own) in ahead.nodes.keys().zip(own) {
            let body = &mut self.members[m as usize].1;
            body.state.set_velocity(node as usize, own);
        }
        for ((_, body), speed) in self.members.iter_mut().zip(speeds) {
            body.solver.speed_squared = speed;
        }
        self.rows.clone()
    }

    /// Takes over those of other contacts that are wanted and not found by the nodes' own velocities. Touches are remembered
    /// of what is found by those, which is all that was near already.
    fn add_missing(&mut self, others: &Rows, wanted: impl Fn(&Row) -> bool) {
        let found = self.rows.contacts.len();
        for row in others.contacts.iter().filter(|row| wanted(row)) {
            let again = |own: &Row| {
                own.pair == row.pair
                    && own.normal.dot(row.normal) > 0.9
                    && self.rows.weights_of(own).eq(others.weights_of(row))
            };
            if self.rows.contacts[..found].iter().any(again) {
                continue;
            }
            let first = self.rows.terms.len();
            let weights = others.weights_of(row);
            for (term, (member, node, _)) in others.terms_of(row.terms).iter().zip(weights) {
                let body = &mut *self.members[member as usize].1;
                let node = slot(member, node, &body.state, &mut body.slots, &mut self.rows);
                self.rows.terms.push(Term { node, ..*term });
            }
            let terms = self.rows.terms_since(first);
            let levers = others.levers_of(row);
            let first = levers.map(|_| self.rows.levers.len() as u32);
            self.rows.levers.extend(levers.into_iter().flatten());
            self.rows.contacts.push(Row {
                terms,
                levers: first,
                ..row.fresh()
            });
        }
    }
}
