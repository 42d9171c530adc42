//! The points that rows act on: weighted sums of nodes.

use super::{Row, RowNode, Term, Terms};
use crate::math::{DMat3, DVec3};

pub(super) struct Points<'a> {
    pub nodes: &'a mut [RowNode],
    pub terms: &'a [Term],
    pub levers: &'a [DVec3],
}

/// The levers of a row's terms, if it has any.
#[inline(always)]
pub(super) fn levers<'a>(levers: &'a [DVec3], row: &Row) -> Option<&'a [DVec3]> {
    let first = row.levers? as usize;
    Some(&levers[first..][..row.terms.range().len()])
}

impl Points<'_> {
    #[inline(always)]
    pub fn terms_of(&self, terms: Terms) -> &[Term] {
        &self.terms[terms.range()]
    }

    #[inline(always)]
    pub fn velocity(&self, terms: Terms) -> DVec3 {
        velocity(self.nodes, self.terms_of(terms))
    }

    /// The velocity of a row's point \[m/s\].
    #[inline(always)]
    pub fn velocity_of(&self, row: &Row) -> DVec3 {
        self.motion_of(row, |node| node.v)
    }

    /// The same at the end of the last substep \[m/s\].
    pub fn velocity_before(&self, row: &Row) -> DVec3 {
        self.motion_of(row, |node| node.before)
    }

    #[inline(always)]
    fn motion_of(&self, row: &Row, of: impl Fn(&RowNode) -> DVec3) -> DVec3 {
        let terms = self.terms_of(row.terms);
        let mut v = weighed(self.nodes, terms, &of);
        if let Some(levers) = levers(self.levers, row) {
            for (term, lever) in terms.iter().zip(levers) {
                v += *lever * row.normal.dot(of(&self.nodes[term.node as usize]));
            }
        }
        v
    }

    /// What its levers add to the response of a row's point \[1/kg\].
    pub fn lever_response(&self, row: &Row, levers: &[DVec3]) -> DMat3 {
        let mut k = DMat3::ZERO;
        for (term, &l) in self.terms_of(row.terms).iter().zip(levers) {
            let (w, n) = (term.weight, row.normal);
            let both = outer(l, n) + outer(n, l);
            let each = both * w + outer(l, l);
            k += each * self.nodes[term.node as usize].inv_mass;
        }
        k
    }

    /// Gives the nodes of a row an impulse \[N·s\].
    #[inline(always)]
    pub fn push_row(&mut self, row: &Row, impulse: DVec3) {
        self.push(row.terms, impulse);
        if let Some(levers) = levers(self.levers, row) {
            for (term, lever) in self.terms[row.terms.range()].iter().zip(levers) {
                let node = &mut self.nodes[term.node as usize];
                node.v += row.normal * (node.inv_mass * lever.dot(impulse));
            }
        }
    }

    /// Inverse of the mass felt at a point \[1/kg\].
    #[inline(always)]
    pub fn response(&self, terms: Terms) -> f64 {
        let mut k = 0.0;
        for term in self.terms_of(terms) {
            k += term.weight * term.share * self.nodes[term.node as usize].inv_mass;
        }
        k
    }

    /// How much faster an impulse makes one of the nodes of a point, at most \[1/kg\].
    pub fn give(&self, terms: Terms) -> f64 {
        let give = |t: &Term| t.share.abs() * self.nodes[t.node as usize].inv_mass;
        self.terms_of(terms).iter().map(give).fold(0.0, f64::max)
    }

    /// The same of a row with levers.
    pub fn give_by_levers(&self, row: &Row) -> f64 {
        let levers = levers(self.levers, row).unwrap_or_default();
        let terms = self.terms_of(row.terms).iter().zip(levers);
        let give = |(t, l): (&Term, &DVec3)| {
            (t.share.abs() + l.length()) * self.nodes[t.node as usize].inv_mass
        };
        terms.map(give).fold(0.0, f64::max)
    }

    #[inline(always)]
    pub fn push(&mut self, terms: Terms, impulse: DVec3) {
        for term in &self.terms[terms.range()] {
            let node = &mut self.nodes[term.node as usize];
            node.v += impulse * (node.inv_mass * term.share);
        }
    }
}

/// a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The velocity of a weighted sum of nodes \[m/s\].
#[inline(always)]
pub(super) fn velocity(nodes: &[RowNode], terms: &[Term]) -> DVec3 {
    weighed(nodes, terms, |node| node.v)
}

#[inline(always)]
fn weighed(nodes: &[RowNode], terms: &[Term], of: impl Fn(&RowNode) -> DVec3) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for term in terms {
        sum += of(&nodes[term.node as usize]) * term.weight;
    }
    sum
}
