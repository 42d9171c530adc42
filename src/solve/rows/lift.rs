//! Lifts: how a body gets out of what the nodes that it holds are in, and out of nodes that can't get out of it.

use super::layers::{HELD_SHARE, Seen, UNDER};
use super::pass::{Pass, inverse};
use super::{LEAD_RATE, Row, Term};
use crate::law::row::Lift;

/// How much impulse a lift may take, in what gives its speed to a free body and the nodes of the row: what rests on
/// something has its weight to lift besides, and other nodes that the body holds.
const LIFT_IMPULSE: f64 = 6.0;

impl Pass<'_> {
    /// Finds the rows that are deep, but that no node of theirs can end, and how they lift the body that can: that which the nodes
    /// are tied to, out of what can't move, see [`Self::prepare_tied_lifts`]; and what presses nodes that are pinned, or that
    /// something holds on their other side, be it through other deformables. Where no body can, what is between two of them is
    /// led half-way between.
    pub(super) fn prepare_lifts(&mut self, fastest: f64) {
        self.prepare_tied_lifts(fastest);
        let mut pinched = false;
        for i in 0..self.contacts.len() {
            let row = &self.contacts[i];
            let sinks = row.depth > 0.0 && row.softness == 0.0 && !row.between;
            if !sinks || self.held_share(i) <= HELD_SHARE {
                continue;
            }
            pinched = true;
            let row = &self.contacts[i];
            if row.rigid_share == 0.0 || !self.worklist.moves(row.shadow) {
                continue;
            }
            let shadow = &self.shadows[row.shadow as usize];
            let mass = inverse(shadow.response(row.arm, row.normal));
            if mass > 0.0 {
                let speed = (row.depth * LEAD_RATE).min(fastest);
                let left = LIFT_IMPULSE * speed * mass;
                self.contacts[i].lift = Lift { speed, left };
            }
        }
        if pinched && self.squeezed {
            for i in 0..self.contacts.len() {
                let row = &self.contacts[i];
                if row.depth > 0.0 && row.lift.speed == 0.0 && !row.between {
                    self.contacts[i].pinched = self.pinched(i);
                }
            }
        }
    }

    /// What of a row's point is held: by pins, or by something on the other side that together with the row leaves it less room
    /// than none \[1\].
    fn held_share(&self, i: usize) -> f64 {
        let row = &self.contacts[i];
        let is_held = |term: &&Term| {
            self.points.nodes[term.node as usize].inv_mass == 0.0
                || self
                    .across(i, term.node)
                    .any(|other| other.depth + row.depth > 0.0)
        };
        let terms = self.points.terms_of(row.terms).iter();
        terms.filter(is_held).map(|t| t.weight).sum()
    }

    /// How deep a row's point is in what is on its other side, where that is not lifted \[m\].
    fn pinched(&self, i: usize) -> f64 {
        let terms = self.points.terms_of(self.contacts[i].terms).iter();
        let depth = |term: &Term| {
            let others = self.across(i, term.node);
            let others = others.filter(|o| !o.between && o.lift.speed == 0.0);
            term.weight * others.map(|o| o.depth).fold(0.0, f64::max)
        };
        terms.map(depth).sum()
    }

    /// Rows at a node that press against row `i`.
    fn across(&self, i: usize, node: u32) -> impl Iterator<Item = &Row> {
        let against = || {
            let all = Seen {
                contacts: self.contacts,
                terms: self.points.terms,
                nodes: self.points.nodes,
                squeeze: self.squeeze,
            };
            self.layers.against(all, (i, node), self.contacts[i].normal)
        };
        // Nothing has been found of what is squeezed by one row alone.
        self.squeezed.then(against).into_iter().flatten()
    }

    /// Whether what does not give way is under a node, by the row `under`, and holds it against what presses on it by `row`.
    pub(super) fn is_held_by(&self, row: &Row, under: &Row) -> bool {
        self.is_fixed(under) && under.normal.dot(row.normal) < -UNDER
    }

    /// Whether a row lies on what does not give way along its normal.
    pub(super) fn is_fixed(&self, row: &Row) -> bool {
        !row.between && row.response.rigid_along(row.normal) == 0.0
    }

    /// Finds the rows of which all nodes are tied to a body that can move, and that are deep in what can't, and how they lift
    /// that body. Nodes welded into a body stay in its own colliders, and in those of bodies it is joined to.
    fn prepare_tied_lifts(&mut self, fastest: f64) {
        if self.ties.is_empty() || !self.squeezed {
            return;
        }
        for row in &mut *self.contacts {
            row.lift = Lift::default();
            let held = row.depth > 0.0 && row.softness == 0.0 && !row.between;
            if !held || self.worklist.moves(row.shadow) {
                continue;
            }
            let body_response = |term: &Term| {
                let tie = &self.ties[self.squeeze.tie(term.node)?];
                let shadow = &self.shadows[tie.shadow as usize];
                let response = shadow.response(tie.arm, row.normal);
                (tie.softness == 0.0 && response > 0.0).then_some(response)
            };
            let terms = self.points.terms_of(row.terms).iter();
            let least = terms
                .map(body_response)
                .try_fold(f64::INFINITY, |least, r| r.map(|r| least.min(r)));
            if let Some(response) = least {
                let speed = (row.depth * LEAD_RATE).min(fastest);
                // A composite has the nodes in its response.
                let apart = self.points.terms_of(row.terms).iter().any(|t| {
                    let tie = self.squeeze.tie(t.node);
                    tie.is_none_or(|tie| self.composites.of_tie(tie).is_none())
                });
                let own = if apart { row.response.own } else { 0.0 };
                let mass = inverse(response) + inverse(own);
                let left = LIFT_IMPULSE * speed * mass;
                row.lift = Lift { speed, left };
            }
        }
    }
}
