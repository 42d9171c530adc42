//! What impulses do to the measure that all rows together minimise.
//!
//! With λ the impulses of the rows, A their response, u their velocities before any of them and a those asked for, a pass
//! goes down ½·λ·A·λ + λ·(u − a). What starts at zero and only descends ends below zero: it takes energy and gives none,
//! but for what the a ask for. A guess that went uphill is known by this, whatever else it has settled.

use super::pass::Pass;
use super::{Row, Tie};
use crate::law::row::Lift;
use crate::math::DVec3;

/// Rows and ties as they were before their impulses were changed.
#[derive(Clone, Debug, Default)]
pub(super) struct Attempt {
    pub rows: Vec<RowBefore>,
    pub ties: Vec<TieBefore>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct RowBefore {
    pub row: usize,
    normal_impulse: f64,
    friction_impulse: DVec3,
    lift: Lift,
    excess: f64,
    slip: DVec3,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct TieBefore {
    pub tie: usize,
    impulse: DVec3,
    error: DVec3,
}

/// How the measure changes along a change of impulses: the slope at its start, and by how much the slope has grown at its
/// end, both times the whole change \[J\].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Climb {
    slope: f64,
    growth: f64,
}

impl Climb {
    /// Of the whole change \[J\].
    pub fn height(self) -> f64 {
        self.slope + 0.5 * self.growth
    }

    /// The share of the change that gets lowest.
    pub fn best(self) -> f64 {
        if self.growth > 0.0 {
            (-self.slope / self.growth).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }
}

impl std::ops::AddAssign for Climb {
    fn add_assign(&mut self, other: Self) {
        self.slope += other.slope;
        self.growth += other.growth;
    }
}

impl Attempt {
    pub fn clear(&mut self) {
        self.rows.clear();
        self.ties.clear();
    }
}

impl Pass<'_> {
    pub fn row_before(&self, row: usize) -> RowBefore {
        let Row {
            normal_impulse,
            friction_impulse,
            lift,
            ..
        } = self.contacts[row];
        RowBefore {
            row,
            normal_impulse,
            friction_impulse,
            lift,
            excess: self.excess(row),
            slip: self.slip_of(row),
        }
    }

    /// A row that has its impulse, but whose nodes and shadow have yet to get it: as if it had none.
    pub fn row_without(&self, row: usize) -> RowBefore {
        let Row {
            normal_impulse,
            softness,
            ..
        } = self.contacts[row];
        let before = self.row_before(row);
        RowBefore {
            normal_impulse: 0.0,
            friction_impulse: DVec3::ZERO,
            excess: before.excess - softness * normal_impulse,
            ..before
        }
    }

    pub fn tie_before(&self, tie: usize) -> TieBefore {
        TieBefore {
            tie,
            impulse: self.ties[tie].impulse,
            error: self.tie_error(tie),
        }
    }

    /// A tie likewise.
    pub fn tie_without(&self, tie: usize) -> TieBefore {
        let Tie {
            impulse, softness, ..
        } = self.ties[tie];
        TieBefore {
            tie,
            impulse: DVec3::ZERO,
            error: self.tie_error(tie) - impulse * softness,
        }
    }

    /// What a row has added since.
    pub fn row_climb(&self, before: &RowBefore) -> Climb {
        let row = &self.contacts[before.row];
        let pressed = row.normal_impulse - before.normal_impulse;
        let rubbed = row.friction_impulse - before.friction_impulse;
        Climb {
            slope: pressed * before.excess + rubbed.dot(before.slip),
            growth: pressed * (self.excess(before.row) - before.excess)
                + rubbed.dot(self.slip_of(before.row) - before.slip),
        }
    }

    /// What a tie has added since.
    pub fn tie_climb(&self, before: &TieBefore) -> Climb {
        let change = self.ties[before.tie].impulse - before.impulse;
        Climb {
            slope: change.dot(before.error),
            growth: change.dot(self.tie_error(before.tie) - before.error),
        }
    }

    /// What all of an attempt has added \[J\].
    pub fn height(&self, attempt: &Attempt) -> f64 {
        let mut sum = Climb::default();
        for row in &attempt.rows {
            sum += self.row_climb(row);
        }
        for tie in &attempt.ties {
            sum += self.tie_climb(tie);
        }
        sum.height()
    }

    /// Takes a row back to (1 − `share`) of where it was before and `share` of where it is.
    pub fn keep_of_row(&mut self, before: &RowBefore, share: f64) {
        let row = &mut self.contacts[before.row];
        let there = row.impulse();
        let between = |before: f64, now: f64| before + share * (now - before);
        row.normal_impulse = between(before.normal_impulse, row.normal_impulse);
        row.friction_impulse =
            before.friction_impulse + (row.friction_impulse - before.friction_impulse) * share;
        row.lift.left = between(before.lift.left, row.lift.left);
        let back = row.impulse() - there;
        self.points.push(row.terms, back);
        self.shadows[row.shadow as usize].push(row.arm, -back * row.rigid_share);
    }

    /// The same for a tie.
    pub fn keep_of_tie(&mut self, before: &TieBefore, share: f64) {
        let tie = &mut self.ties[before.tie];
        let there = tie.impulse;
        tie.impulse = before.impulse + (there - before.impulse) * share;
        let back = tie.impulse - there;
        self.points.push(tie.terms, back);
        self.shadows[tie.shadow as usize].push(tie.arm, -back);
    }
}
