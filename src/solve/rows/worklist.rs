//! Which rows a pass must look at: those at nodes and shadows that have changed since their last visit.
//!
//! In a heap at rest most rows are settled after one visit, and a few take all passes. Visiting only those makes a pass
//! cost what there is to do.

use super::settled::Felt;
use super::{JointRow, RigidRow, Term};
use crate::solve::shadow::Shadow;

/// When nodes and shadows last changed, in visits since the substep began.
#[derive(Clone, Debug, Default)]
pub(super) struct Worklist {
    now: u32,
    nodes: Vec<u32>,
    /// Never for a shadow that can't move, whatever pushes it.
    shadows: Vec<u32>,
    moves: Vec<bool>,
    /// The last visit of each row: contacts, ties, contacts of shadows with each other, joints.
    visits: Vec<u32>,
}

impl Worklist {
    /// Starts a substep: everything has yet to be visited.
    pub fn start(&mut self, nodes: usize, shadows: &[Shadow], rows: usize) {
        self.now = 1;
        let fill = |list: &mut Vec<u32>, count: usize, value: u32| {
            list.clear();
            list.resize(count, value);
        };
        fill(&mut self.nodes, nodes, 1);
        fill(&mut self.shadows, shadows.len(), 0);
        fill(&mut self.visits, rows, 0);
        self.moves.clear();
        self.moves.extend(shadows.iter().map(Shadow::gives_way));
        for (last, moves) in self.shadows.iter_mut().zip(&self.moves) {
            *last = u32::from(*moves);
        }
    }

    /// Whether anything can move this shadow.
    pub fn moves(&self, shadow: u32) -> bool {
        self.moves[shadow as usize]
    }

    /// Whether row number `row` has anything to look at. If so, it counts as visited from now on.
    #[inline(always)]
    pub fn visit(&mut self, row: usize, terms: &[Term], shadows: [u32; 2]) -> bool {
        let last = self.visits[row];
        let due = terms.iter().any(|t| self.nodes[t.node as usize] > last)
            || shadows.iter().any(|s| self.shadows[*s as usize] > last);
        if due {
            self.visits[row] = self.now;
        }
        due
    }

    /// Row number `row` has nothing to look at until something changes.
    pub fn pass_over(&mut self, row: usize) {
        self.visits[row] = self.now;
    }

    /// A row has changed the velocities of its nodes and shadows, as far as these feel it. It will be looked at once more
    /// itself.
    #[inline(always)]
    pub fn change(&mut self, terms: &[Term], shadows: [u32; 2], felt: Felt) {
        self.now += 1;
        if felt.nodes {
            for term in terms {
                self.nodes[term.node as usize] = self.now;
            }
        }
        if felt.shadows {
            for shadow in shadows {
                if self.moves[shadow as usize] {
                    self.shadows[shadow as usize] = self.now;
                }
            }
        }
    }

    /// A pass over rows between two shadows, of which `first` is the number of the first. Says whether one changed.
    pub fn pass<R: Between>(
        &mut self,
        first: usize,
        rows: &mut [R],
        reversed: bool,
        mut solve: impl FnMut(&mut R) -> bool,
    ) -> bool {
        let mut any = false;
        let felt = Felt {
            nodes: false,
            shadows: true,
        };
        for n in 0..rows.len() {
            let i = if reversed { rows.len() - 1 - n } else { n };
            let row = &mut rows[i];
            if self.visit(first + i, &[], row.shadows()) && solve(row) {
                self.change(&[], row.shadows(), felt);
                any = true;
            }
        }
        any
    }
}

/// A row between two shadows.
pub(super) trait Between {
    fn shadows(&self) -> [u32; 2];
}

impl Between for RigidRow {
    fn shadows(&self) -> [u32; 2] {
        self.shadows
    }
}

impl Between for JointRow {
    fn shadows(&self) -> [u32; 2] {
        self.joint.shadows
    }
}
