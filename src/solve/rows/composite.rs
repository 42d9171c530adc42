//! Nodes that are tied to one shadow, and that shadow: a composite body, whose ties are solved at once.
//!
//! One after the other, ties of nodes that are heavier than what they are tied to undo each other, the more so about its
//! centre, where a light body gives way to every lever. What few passes leave of that would be mended at position level,
//! against the forces that it stretches, and put energy into them in every substep: eight nodes welded to a body of a
//! third of their mass shook themselves to pieces within two seconds.
//!
//! With B the response of the shadow, J the motion of the points that its ties hold, m what these feel alone, and
//! G = Σ Jᵀ·m·J, an impulse on the shadow moves all of them by C = (1 + B·G)⁻¹·B. While rows are solved the shadow
//! answers everything with C, as the composite does. A node follows when it is next asked for, and has the shadow answer
//! what was done to the node itself: either is exact and costs the same however many nodes there are.
//!
//! Only ties of one node that has no other tie are taken in, and points that give way to nothing, see [`super::supports`].
//! Other points of several nodes are solved one by one.

use super::Tie;
use super::pass::Pass;
use super::points::Points;
use super::settled::Felt;
use super::supports::{Inertia, Mat6, bearing, response};
use crate::math::{DMat3, DVec3};
use crate::solve::shadow::Shadow;

pub(super) const NONE: u32 = u32::MAX;

/// A shadow and the nodes that are tied to it and to nothing else.
#[derive(Clone, Copy, Debug)]
pub(super) struct Composite {
    pub shadow: u32,
    /// Its first tie.
    pub first: u32,
    /// How the shadow answers alone.
    alone: (DMat3, Option<DMat3>, DMat3),
    /// What its nodes feel alone.
    nodes: Inertia,
    /// Its supports, as if of 1 kg each.
    pub supports: Inertia,
    /// How these bear it.
    pub bearing: Option<Mat6>,
}

/// The composites of a substep.
#[derive(Clone, Debug, Default)]
pub(super) struct Composites {
    pub list: Vec<Composite>,
    /// Per shadow, its composite.
    of_shadow: Vec<u32>,
    /// Per tie, its composite.
    of_tie: Vec<u32>,
    /// Per tie, the next one of its composite.
    pub next: Vec<u32>,
    /// Per tie, what its point feels alone \[kg\]; 0 for a support, which nothing is done to.
    masses: Vec<f64>,
    /// Per tie, the velocities of the shadow that its node has followed, or its support has borne.
    pub followed: Vec<(DVec3, DVec3)>,
    /// Per node, how many ties it has.
    uses: Vec<u8>,
}

impl Composites {
    /// Finds the composites, and has their shadows answer as these until [`Self::end`]. Their ties start from nothing: what
    /// they need follows from all the other rows.
    pub fn start(&mut self, points: &Points, ties: &mut [Tie], shadows: &mut [Shadow]) {
        self.list.clear();
        self.next.clear();
        self.of_tie.clear();
        if ties.is_empty() {
            return;
        }
        let fill = |list: &mut Vec<u32>, count: usize| {
            list.clear();
            list.resize(count, NONE);
        };
        fill(&mut self.of_shadow, shadows.len());
        fill(&mut self.of_tie, ties.len());
        fill(&mut self.next, ties.len());
        self.masses.clear();
        self.masses.resize(ties.len(), 0.0);
        self.followed.clear();
        self.followed.resize(ties.len(), Default::default());
        self.uses.clear();
        self.uses.resize(points.nodes.len(), 0);
        for term in ties.iter().flat_map(|t| points.terms_of(t.terms)) {
            let uses = &mut self.uses[term.node as usize];
            *uses = uses.saturating_add(1);
        }
        for (i, tie) in ties.iter_mut().enumerate().rev() {
            let own = points.response(tie.terms) + tie.softness;
            let supports = own <= 0.0;
            let alone = || match points.terms_of(tie.terms) {
                [only] => self.uses[only.node as usize] == 1,
                _ => false,
            };
            let shadow = &shadows[tie.shadow as usize];
            if !shadow.gives_way() || !(supports || alone()) {
                continue;
            }
            let known = &mut self.of_shadow[tie.shadow as usize];
            if *known == NONE {
                *known = self.list.len() as u32;
                self.list.push(Composite::of(tie.shadow, shadow));
            }
            let composite = &mut self.list[*known as usize];
            tie.impulse = DVec3::ZERO;
            self.of_tie[i] = *known;
            self.next[i] = std::mem::replace(&mut composite.first, i as u32);
            self.followed[i] = (shadow.v, shadow.w);
            if supports {
                composite.supports.add(1.0, tie.arm);
            } else {
                self.masses[i] = 1.0 / own;
                composite.nodes.add(1.0 / own, tie.arm);
            }
        }
        for composite in &mut self.list {
            composite.answer_as_one(&mut shadows[composite.shadow as usize]);
        }
    }

    /// Whether a tie of a composite gives way to nothing.
    pub fn is_support(&self, tie: usize) -> bool {
        self.masses[tie] == 0.0
    }

    /// Shadows answer alone again.
    pub fn end(&self, shadows: &mut [Shadow]) {
        for c in &self.list {
            let shadow = &mut shadows[c.shadow as usize];
            (shadow.inv_mass, shadow.cross, shadow.inv_inertia) = c.alone;
        }
    }

    /// The composite that a tie belongs to.
    #[inline(always)]
    pub fn of_tie(&self, tie: usize) -> Option<usize> {
        let found = *self.of_tie.get(tie)?;
        (found != NONE).then_some(found as usize)
    }

    /// Whether supports bear the composite of a shadow.
    pub fn has_supports(&self, shadow: u32) -> bool {
        let found = self.of_shadow.get(shadow as usize);
        let found = found.and_then(|c| self.list.get(*c as usize));
        found.is_some_and(|composite| composite.bearing.is_some())
    }

    /// The first tie of a shadow's composite.
    pub fn of_shadow(&self, shadow: u32) -> Option<usize> {
        let found = *self.of_shadow.get(shadow as usize)?;
        Some(self.list.get(found as usize)?.first as usize)
    }

    /// How the composite of a tie answers an error of this tie alone: −impulse by error \[kg\]. `None` if it has none.
    /// `response` is that of its shadow there \[1/kg\].
    pub fn mass(&self, i: usize, response: impl FnOnce() -> DMat3) -> Option<DMat3> {
        self.of_tie(i)?;
        let m = self.masses[i];
        Some(DMat3::from_diagonal(DVec3::splat(m)) - response() * (m * m))
    }

    /// Pairs of ties of the same composite, enough to lead from each to all others.
    pub fn neighbours(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let next = self.next.iter().enumerate();
        next.filter(|(_, next)| **next != NONE)
            .map(|(i, next)| (i, *next as usize))
    }
}

impl Composite {
    fn of(number: u32, shadow: &Shadow) -> Self {
        Self {
            shadow: number,
            first: NONE,
            alone: (shadow.inv_mass, shadow.cross, shadow.inv_inertia),
            nodes: Inertia::NONE,
            supports: Inertia::NONE,
            bearing: None,
        }
    }

    /// Puts C in the place of B, and finds how supports bear what answers so.
    fn answer_as_one(&mut self, shadow: &mut Shadow) {
        if self.nodes.mass != 0.0 {
            let b = response(shadow);
            let g = self.nodes.matrix();
            // B and G have no negative eigenvalues, so there is a solution unless a number is not finite, which is seen after
            // the substep.
            let c = (Mat6::identity() + b * g).lu().solve(&b).unwrap_or(b);
            shadow.inv_mass = block(&c, 0, 0);
            shadow.cross = Some(block(&c, 0, 3));
            shadow.inv_inertia = block(&c, 3, 3);
        }
        if self.supports.mass > 0.0 {
            self.bearing = bearing(&response(shadow), &self.supports);
        }
    }
}

impl Pass<'_> {
    /// Has the composite answer what was done to the node of a tie, and the node follow what was done to the shadow; whether
    /// anybody feels it.
    pub(super) fn follow(&mut self, i: usize) -> bool {
        if self.composites.is_support(i) {
            return self.bear_again(i);
        }
        let push = self.push_of(i);
        let Tie { shadow, arm, .. } = self.ties[i];
        self.shadows[shadow as usize].push(arm, push);
        let change = self.let_follow(i);
        let tie = &self.ties[i];
        let square = tie.impulse.length_squared();
        let felt = |change: DVec3| self.settled.felt(change.length_squared(), square, tie.give);
        let felt = Felt {
            nodes: felt(change).nodes,
            shadows: felt(push).shadows,
        };
        if felt.any() {
            let terms = self.points.terms_of(tie.terms);
            self.worklist.change(terms, [shadow; 2], felt);
        }
        felt.any()
    }

    /// The same for all ties of all composites: what was done to a node does not depend on how its shadow moves since, so all
    /// of it is answered at once, then borne by what supports there are, and then all nodes follow.
    pub(super) fn follow_all(&mut self) {
        for c in 0..self.composites.list.len() {
            let Composite { shadow, first, .. } = self.composites.list[c];
            let (mut impulse, mut torque) = (DVec3::ZERO, DVec3::ZERO);
            let mut i = first as usize;
            while i != NONE as usize {
                let push = self.push_of(i);
                impulse += push;
                torque += self.ties[i].arm.cross(push);
                i = self.composites.next[i] as usize;
            }
            self.shadows[shadow as usize].take(impulse, torque);
            self.bear(c);
            let mut i = first as usize;
            while i != NONE as usize {
                self.let_follow(i);
                i = self.composites.next[i] as usize;
            }
        }
    }

    /// Ties of composites that nothing has disturbed since all nodes followed need no visit until something does.
    pub(super) fn pass_over_still(&mut self) {
        let first = self.contacts.len();
        for c in &self.composites.list {
            let shadow = &self.shadows[c.shadow as usize];
            let mut i = c.first as usize;
            let followed = (shadow.v, shadow.w) == self.composites.followed[i];
            while followed && i != NONE as usize {
                self.worklist.pass_over(first + i);
                i = self.composites.next[i] as usize;
            }
        }
    }

    /// What has been done to the node of a tie and not been answered by its composite yet \[N·s\].
    fn push_of(&self, i: usize) -> DVec3 {
        self.tie_error_of(i, self.composites.followed[i]) * self.composites.masses[i]
    }

    /// Gives the node of a tie the velocity of its anchor, and returns the impulse \[N·s\].
    fn let_follow(&mut self, i: usize) -> DVec3 {
        let change = self.tie_error(i) * -self.composites.masses[i];
        let tie = &mut self.ties[i];
        tie.impulse += change;
        self.points.push(tie.terms, change);
        let shadow = &self.shadows[tie.shadow as usize];
        self.composites.followed[i] = (shadow.v, shadow.w);
        change
    }
}

pub(super) fn from_blocks(a: DMat3, b: DMat3, c: DMat3, d: DMat3) -> Mat6 {
    Mat6::from_fn(|i, k| {
        let block = [[a, b], [c, d]][i / 3][k / 3];
        block.col(k % 3)[i % 3]
    })
}

fn block(m: &Mat6, row: usize, column: usize) -> DMat3 {
    let col = |k: usize| {
        DVec3::new(
            m[(row, column + k)],
            m[(row + 1, column + k)],
            m[(row + 2, column + k)],
        )
    };
    DMat3::from_cols(col(0), col(1), col(2))
}
