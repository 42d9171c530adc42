//! Ties: points of deformables held at points of rigid bodies, or of each other.

use super::Terms;
use super::pass::Pass;
use super::settled::Give;
use crate::math::{DMat3, DVec3};
use crate::solve::shadow::Norms;

/// A point held at a point of a shadow, or of another deformable.
#[derive(Clone, Copy, Debug)]
pub struct Tie {
    /// The nodes of the point; of a tie between two deformables, those of the other one with negative weights.
    pub terms: Terms,
    /// Index into the shadows; 0 for a tie between two deformables.
    pub shadow: u32,
    /// Which attachment the impulse is counted for.
    pub attachment: u32,
    /// Whether it lies between two deformables.
    pub between: bool,
    /// From the shadow's centre of mass to the anchor, of a link to its point \[m\].
    pub arm: DVec3,
    /// Point minus anchor \[m\].
    pub error: DVec3,
    /// Velocity relative to the anchor by which a link moved in the last substep, none in its first \[m/s\].
    pub before: DVec3,
    /// How much of the elongation at its end a link takes, see [`lean`](crate::law::row::lean).
    pub lean: f64,
    /// What the anchor's mean velocity over the substep differs from that at its start \[m/s\].
    pub chord: DVec3,
    /// Velocity the point must have relative to the anchor's \[m/s\].
    pub bias: DVec3,
    /// 0 for a rigid tie, that of [`link`](crate::law::row::link) for a link \[1/kg\].
    pub softness: f64,
    /// Accumulated impulse on the node \[N·s\].
    pub impulse: DVec3,
    /// Effective mass \[kg\], of one in a composite not used; set by the pass.
    pub mass: DMat3,
    /// What nodes and shadow make of its impulse, or more; set by the pass.
    pub give: Give,
}

impl Pass<'_> {
    /// What ties make of their impulses.
    pub fn prepare_ties(&mut self) {
        let mut last = (0, Norms::default());
        for (i, tie) in self.ties.iter_mut().enumerate() {
            let shadow = &self.shadows[tie.shadow as usize];
            let nodes = self.points.give(tie.terms);
            if self.composites.of_tie(i).is_some() {
                if last.0 != tie.shadow {
                    last = (tie.shadow, shadow.norms());
                }
                let shadows = last.1.response(tie.arm);
                tie.give = Give { nodes, shadows };
                continue;
            }
            let own = self.points.response(tie.terms) + tie.softness;
            let rigid = shadow.response_matrix(tie.arm);
            tie.give = Give::of(nodes, &rigid);
            tie.mass = if own > 0.0 {
                (DMat3::from_diagonal(DVec3::splat(own)) + rigid).inverse()
            } else {
                // Neither side gives way.
                DMat3::ZERO
            };
        }
    }

    /// −impulse by error of a tie alone, in a composite that with all of its other ties \[kg\].
    pub fn tie_mass(&self, i: usize) -> DMat3 {
        let tie = &self.ties[i];
        let rigid = || self.shadows[tie.shadow as usize].response_matrix(tie.arm);
        self.composites.mass(i, rigid).unwrap_or(tie.mass)
    }

    /// Visits ties in an order; whether any was not settled yet.
    pub fn solve_ties(&mut self, order: impl Iterator<Item = usize>) -> bool {
        let mut changed = false;
        for i in order {
            let tie = &self.ties[i];
            let terms = self.points.terms_of(tie.terms);
            let number = self.contacts.len() + i;
            if self.worklist.visit(number, terms, [tie.shadow; 2]) {
                changed |= self.solve_tie(i);
            }
        }
        changed
    }

    /// Solves a tie, within its composite or else as if it were the only one; whether it was not settled yet.
    pub fn solve_tie(&mut self, i: usize) -> bool {
        if self.composites.of_tie(i).is_some() {
            return self.follow(i);
        }
        let error = self.tie_error(i);
        let tie = &mut self.ties[i];
        let shadow = &mut self.shadows[tie.shadow as usize];
        let change = -(tie.mass * error);
        tie.impulse += change;
        self.points.push(tie.terms, change);
        shadow.push(tie.arm, -change);
        let tie = &self.ties[i];
        let square = tie.impulse.length_squared();
        let felt = self.settled.felt(change.length_squared(), square, tie.give);
        if felt.any() {
            let terms = self.points.terms_of(tie.terms);
            self.worklist.change(terms, [tie.shadow; 2], felt);
        }
        felt.any()
    }

    /// By how much the velocity of a tie's point differs from what it is to be \[m/s\].
    #[inline(always)]
    pub fn tie_error(&self, i: usize) -> DVec3 {
        let shadow = &self.shadows[self.ties[i].shadow as usize];
        self.tie_error_of(i, (shadow.v, shadow.w))
    }

    /// The same while the shadow moves with these velocities \[m/s, rad/s\].
    #[inline(always)]
    pub fn tie_error_of(&self, i: usize, (v, w): (DVec3, DVec3)) -> DVec3 {
        let tie = &self.ties[i];
        let anchor = v + w.cross(tie.arm);
        self.points.velocity(tie.terms) - (anchor + tie.bias - tie.impulse * tie.softness)
    }
}
