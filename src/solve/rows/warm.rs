//! Warm starts: rows that begin with their impulses of the last substep.
//!
//! A light node in a heavy grip is held by impulses that are large beside anything that it could answer alone. Where the
//! grip has gone or turned they would throw it, and no few passes undo that: a jam would last for substeps and push what it
//! is between. So what hangs together by its nodes starts with that share of its last impulses which leads farthest down.

use super::attempt::{Attempt, Climb};
use super::pass::Pass;
use super::{Row, Term, Terms, Tie};
use crate::math::DVec3;

/// Nodes that rows hold together, and how far down the warm start of each such cluster leads.
#[derive(Clone, Debug, Default)]
pub(super) struct Clusters {
    /// Per node, another one of its cluster, or itself.
    parent: Vec<u32>,
    /// Per node that stands for its cluster.
    climbs: Vec<Climb>,
    attempt: Attempt,
}

impl Clusters {
    fn find(&mut self, nodes: usize, contacts: &[Row], ties: &[Tie], terms: &[Term]) {
        self.parent.clear();
        self.parent.extend(0..nodes as u32);
        self.climbs.clear();
        self.climbs.resize(nodes, Climb::default());
        let all = contacts.iter().map(|r| r.terms);
        for of_row in all.chain(ties.iter().map(|t| t.terms)) {
            if let [first, others @ ..] = &terms[of_row.range()] {
                for other in others {
                    let (a, b) = (self.root(first.node), self.root(other.node));
                    self.parent[a.max(b) as usize] = a.min(b);
                }
            }
        }
    }

    /// Of the cluster of a row.
    fn climb(&mut self, of_row: Terms, terms: &[Term]) -> &mut Climb {
        let node = terms[of_row.range()].first().map_or(0, |t| t.node);
        let root = self.root(node);
        &mut self.climbs[root as usize]
    }

    fn root(&mut self, mut node: u32) -> u32 {
        while self.parent[node as usize] != node {
            let above = self.parent[self.parent[node as usize] as usize];
            self.parent[node as usize] = above;
            node = above;
        }
        node
    }
}

impl Pass<'_> {
    /// Gives nodes and shadows what contacts and ties start with.
    pub(super) fn start_warm(&mut self, clusters: &mut Clusters) {
        let mut attempt = std::mem::take(&mut clusters.attempt);
        attempt.clear();
        let rows = (0..self.contacts.len()).filter(|&i| self.contacts[i].impulse() != DVec3::ZERO);
        attempt.rows.extend(rows.map(|i| self.row_without(i)));
        let ties = (0..self.ties.len()).filter(|&i| self.ties[i].impulse != DVec3::ZERO);
        attempt.ties.extend(ties.map(|i| self.tie_without(i)));
        for before in &attempt.rows {
            let row = &self.contacts[before.row];
            let j = row.impulse();
            self.points.push(row.terms, j);
            self.shadows[row.shadow as usize].push(row.arm, -j * row.rigid_share);
        }
        for before in &attempt.ties {
            let tie = &self.ties[before.tie];
            self.points.push(tie.terms, tie.impulse);
            self.shadows[tie.shadow as usize].push(tie.arm, -tie.impulse);
        }
        if !attempt.rows.is_empty() || !attempt.ties.is_empty() {
            self.keep_what_leads_down(clusters, &attempt);
        }
        clusters.attempt = attempt;
    }

    fn keep_what_leads_down(&mut self, clusters: &mut Clusters, attempt: &Attempt) {
        clusters.find(
            self.points.nodes.len(),
            self.contacts,
            self.ties,
            self.points.terms,
        );
        for before in &attempt.rows {
            let climb = self.row_climb(before);
            *clusters.climb(self.contacts[before.row].terms, self.points.terms) += climb;
        }
        for before in &attempt.ties {
            let climb = self.tie_climb(before);
            *clusters.climb(self.ties[before.tie].terms, self.points.terms) += climb;
        }
        for before in &attempt.rows {
            let terms = self.contacts[before.row].terms;
            let best = clusters.climb(terms, self.points.terms).best();
            if best < 1.0 {
                self.keep_of_row(before, best);
            }
        }
        for before in &attempt.ties {
            let terms = self.ties[before.tie].terms;
            let best = clusters.climb(terms, self.points.terms).best();
            if best < 1.0 {
                self.keep_of_tie(before, best);
            }
        }
    }
}
