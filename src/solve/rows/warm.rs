//! Warm starts: rows that begin with their impulses of the last substep.
//!
//! A light node in a heavy grip is held by impulses that are large beside anything that it could answer alone. Where the
//! grip has gone or turned they would throw it, and no few passes undo that: a jam would last for substeps and push what it
//! is between. So what hangs together by its nodes starts with that share of its last impulses which leads farthest down
//! (see [`super::climb`]), and so do the contacts of shadows with each other.

use super::climb::Climb;
use super::composite::Composites;
use super::pass::Pass;
use super::{Row, Term, Terms, Tie};
use crate::math::{DVec3, Disjoint};

/// Nodes that rows hold together, and how far down the warm start of each such cluster leads.
#[derive(Clone, Debug, Default)]
pub(super) struct Clusters {
    /// Of nodes.
    sets: Disjoint,
    /// Per node that stands for its cluster.
    climbs: Vec<Climb>,
}

impl Clusters {
    fn find(
        &mut self,
        nodes: usize,
        contacts: &[Row],
        (ties, composites): (&[Tie], &Composites),
        terms: &[Term],
    ) {
        self.sets.restart(nodes);
        self.climbs.clear();
        self.climbs.resize(nodes, Climb::default());
        let all = contacts.iter().map(|r| r.terms);
        for of_row in all.chain(ties.iter().map(|t| t.terms)) {
            if let [first, others @ ..] = &terms[of_row.range()] {
                for other in others {
                    self.sets.join(first.node, other.node);
                }
            }
        }
        let node = |tie: usize| terms[ties[tie].terms.range()].first().map(|t| t.node);
        // A node that is tied gives way as the composite does, to all that presses on any part of it.
        for (one, next) in composites.neighbours() {
            if let (Some(a), Some(b)) = (node(one), node(next)) {
                self.sets.join(a, b);
            }
        }
        for row in contacts {
            let tie = composites.of_shadow(row.shadow);
            let first = terms[row.terms.range()].first().map(|t| t.node);
            if let (Some(a), Some(b)) = (first, tie.and_then(node)) {
                self.sets.join(a, b);
            }
        }
    }

    /// Of the cluster of a row.
    fn climb(&mut self, of_row: Terms, terms: &[Term]) -> &mut Climb {
        let node = terms[of_row.range()].first().map_or(0, |t| t.node);
        &mut self.climbs[self.sets.of(node) as usize]
    }
}

impl Pass<'_> {
    /// Gives nodes and shadows what contacts and ties start with.
    pub(super) fn start_warm(&mut self, clusters: &mut Clusters) {
        let cold = self.contacts.iter().all(|r| r.impulse() == DVec3::ZERO);
        let mut ties = self.ties.iter().enumerate();
        // Those of composites have been solved already.
        if cold
            && ties.all(|(i, t)| t.impulse == DVec3::ZERO || self.composites.of_tie(i).is_some())
        {
            return;
        }
        let terms = self.points.terms;
        let ties = (&*self.ties, &*self.composites);
        clusters.find(self.points.nodes.len(), self.contacts, ties, terms);
        self.follow_all();
        let rows = 0..self.contacts.len();
        let warm = |pass: &Self, i: &usize| pass.contacts[*i].impulse() != DVec3::ZERO;
        for i in rows.clone().filter(|i| warm(self, i)) {
            // Its nodes have yet to get what the row has already.
            let row = &self.contacts[i];
            let soft = row.response.softness * row.normal_impulse.powi(2);
            let slope = self.row_slope(i) - soft;
            clusters.climb(self.contacts[i].terms, terms).slope += slope;
        }
        let ties = 0..self.ties.len();
        for i in ties.clone() {
            if self.composites.of_tie(i).is_some() {
                continue;
            }
            let tie = &self.ties[i];
            let slope = self.tie_slope(i) - tie.softness * tie.impulse.length_squared();
            clusters.climb(tie.terms, terms).slope += slope;
        }
        for i in rows.clone() {
            self.give(i, self.contacts[i].impulse());
        }
        for i in ties.clone() {
            if self.composites.of_tie(i).is_some() {
                continue;
            }
            let tie = &self.ties[i];
            self.points.push(tie.terms, tie.impulse);
            self.shadows[tie.shadow as usize].push(tie.arm, -tie.impulse);
        }
        self.follow_all();
        for i in rows.clone().filter(|i| warm(self, i)) {
            clusters.climb(self.contacts[i].terms, terms).end += self.row_slope(i);
        }
        for i in ties.clone() {
            if self.composites.of_tie(i).is_some() {
                continue;
            }
            clusters.climb(self.ties[i].terms, terms).end += self.tie_slope(i);
        }
        for i in rows {
            let best = clusters.climb(self.contacts[i].terms, terms).lowest();
            if best < 1.0 && warm(self, &i) {
                let row = &self.contacts[i];
                let (normal, friction) = (row.normal_impulse * best, row.friction_impulse * best);
                self.set_row(i, normal, friction);
            }
        }
        for i in ties {
            if self.composites.of_tie(i).is_some() {
                continue;
            }
            let best = clusters.climb(self.ties[i].terms, terms).lowest();
            if best < 1.0 {
                self.set_tie(i, self.ties[i].impulse * best);
            }
        }
        self.follow_all();
    }
}
