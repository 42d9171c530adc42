//! What impulses do to the measure that all rows together minimise.
//!
//! With λ the impulses of the rows, A their response, u their velocities before any of them and a those asked for, a pass
//! goes down ½·λ·A·λ + λ·(u − a). What starts at zero and only descends ends below zero: it takes energy and gives none,
//! but for what the a ask for. A guess that went uphill is known by this, whatever else it has settled.

use super::Row;
use super::pass::Pass;
use crate::law::row::Lift;
use crate::math::DVec3;

/// The slope of the measure along a change of impulses, times the change, at its start and at its end \[J\].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Climb {
    pub slope: f64,
    pub end: f64,
}

impl Climb {
    /// The share of the change that gets lowest.
    pub fn lowest(self) -> f64 {
        if self.end > self.slope {
            (-self.slope / (self.end - self.slope)).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }
}

/// Rows and ties as they were before their impulses were changed.
#[derive(Clone, Debug, Default)]
pub(super) struct Attempt {
    rows: Vec<RowBefore>,
    ties: Vec<TieBefore>,
}

#[derive(Clone, Copy, Debug)]
struct RowBefore {
    row: usize,
    normal_impulse: f64,
    friction_impulse: DVec3,
    lift: Lift,
    /// What is left of the friction impulse where the load allows no more \[N·s\].
    bounded: DVec3,
    /// Normal and friction impulse that it is compared with.
    after: (f64, DVec3),
    /// Velocities that are not as asked for \[m/s\].
    excess: f64,
    slip: DVec3,
}

#[derive(Clone, Copy, Debug)]
struct TieBefore {
    tie: usize,
    impulse: DVec3,
    after: DVec3,
    error: DVec3,
}

impl Attempt {
    /// Notes rows and ties that will be tried.
    pub fn start(
        &mut self,
        pass: &Pass,
        rows: impl Iterator<Item = usize>,
        ties: impl Iterator<Item = usize>,
    ) {
        self.rows.clear();
        self.rows.extend(rows.map(|row| {
            let Row {
                normal_impulse,
                friction_impulse,
                lift,
                ..
            } = pass.contacts[row];
            let (excess, slip) = pass.errors(row);
            RowBefore {
                row,
                normal_impulse,
                friction_impulse,
                lift,
                bounded: friction_impulse,
                after: (normal_impulse, friction_impulse),
                excess,
                slip,
            }
        }));
        self.ties.clear();
        self.ties.extend(ties.map(|tie| TieBefore {
            tie,
            impulse: pass.ties[tie].impulse,
            after: pass.ties[tie].impulse,
            error: pass.tie_error(tie),
        }));
    }

    /// Whether it is to be taken back, as the measure has risen. `fallen` is what all that was tried on the same shadow has changed of it
    /// in this substep \[J\].
    ///
    /// What friction loses with the load that bears it is no choice of a row. Where this counted, a row could not be relieved of a load
    /// that it need not bear, as friction would hold on to it: so if the load has become less, the measure counts from where
    /// friction had no more than it may have now, and may rise by as much as it has fallen before.
    pub fn is_worse(&mut self, pass: &mut Pass, fallen: &mut f64) -> bool {
        let rise = self.rise(pass);
        let relieves = self
            .rows
            .first()
            .is_some_and(|before| pass.contacts[before.row].normal_impulse < before.normal_impulse);
        let may_rise = relieves && *fallen + rise <= 0.0;
        let worse =
            rise > 0.0 && !(may_rise && self.bound_friction(pass) && self.rise(pass) <= 0.0);
        if !worse {
            *fallen += rise;
        }
        worse
    }

    /// Has it begin with no more friction than the loads allow now; `false` if it did so anyway.
    fn bound_friction(&mut self, pass: &mut Pass) -> bool {
        let mut any = false;
        for before in &mut self.rows {
            let row = &pass.contacts[before.row];
            before.after = (row.normal_impulse, row.friction_impulse);
            let limit = row.friction_limit();
            before.bounded = before.friction_impulse.clamp_length_max(limit);
            any |= before.bounded != before.friction_impulse;
        }
        if !any {
            return false;
        }
        for before in &self.rows {
            pass.set_row(before.row, before.normal_impulse, before.bounded);
        }
        for before in &mut self.ties {
            before.after = pass.ties[before.tie].impulse;
            pass.set_tie(before.tie, before.impulse);
        }
        for before in &mut self.rows {
            let (excess, slip) = pass.velocities(before.row);
            (before.excess, before.slip) = (excess - before.lift.speed, slip);
        }
        for before in &mut self.ties {
            before.error = pass.tie_error(before.tie);
        }
        for before in &self.rows {
            let (normal, friction) = before.after;
            pass.set_row(before.row, normal, friction);
        }
        for before in &self.ties {
            pass.set_tie(before.tie, before.after);
        }
        true
    }

    /// By how much the measure has risen since \[J\].
    fn rise(&self, pass: &Pass) -> f64 {
        let rows = self.rows.iter().map(|before| {
            let row = &pass.contacts[before.row];
            let pressed = row.normal_impulse - before.normal_impulse;
            let rubbed = row.friction_impulse - before.bounded;
            let (excess, slip) = pass.errors(before.row);
            pressed * (before.excess + excess) + rubbed.dot(before.slip + slip)
        });
        let ties = self.ties.iter().map(|before| {
            let change = pass.ties[before.tie].impulse - before.impulse;
            change.dot(before.error + pass.tie_error(before.tie))
        });
        0.5 * (rows.sum::<f64>() + ties.sum::<f64>())
    }

    /// Takes everything back.
    pub fn undo(&self, pass: &mut Pass) {
        for before in &self.rows {
            pass.set_row(before.row, before.normal_impulse, before.friction_impulse);
            pass.contacts[before.row].lift = before.lift;
        }
        for before in &self.ties {
            pass.set_tie(before.tie, before.impulse);
        }
    }
}

impl Pass<'_> {
    /// The slope of the measure along a row's impulse, times the impulse \[J\].
    pub fn row_slope(&self, i: usize) -> f64 {
        let Row {
            normal_impulse,
            friction_impulse,
            ..
        } = self.contacts[i];
        let (excess, slip) = self.errors(i);
        normal_impulse * excess + friction_impulse.dot(slip)
    }

    /// The same for a tie.
    pub fn tie_slope(&self, i: usize) -> f64 {
        self.ties[i].impulse.dot(self.tie_error(i))
    }

    /// By how much the normal velocity of a row exceeds what it is to be, with its lift \[m/s\].
    pub fn missed(&self, i: usize) -> f64 {
        self.errors(i).0
    }

    /// By how much the normal velocity of a row exceeds what it is to be, with its lift, and the velocity by which its point slips
    /// \[m/s\].
    #[inline(always)]
    fn errors(&self, i: usize) -> (f64, DVec3) {
        let (excess, slip) = self.velocities(i);
        (excess - self.contacts[i].lift.speed, slip)
    }

    /// The same without its lift.
    #[inline(always)]
    fn velocities(&self, i: usize) -> (f64, DVec3) {
        let (row, relative) = (&self.contacts[i], self.relative(i));
        (row.excess(relative), row.slip(relative))
    }

    /// Whether anything comes deeper at more than `fastest` m/s, or is lifted by that much slower than it is to be although it has
    /// impulse left for it.
    pub fn sinks(&self, fastest: f64) -> bool {
        let missed = |i: usize| {
            if self.contacts[i].lift.left > 0.0 {
                self.missed(i)
            } else {
                self.excess(i)
            }
        };
        (0..self.contacts.len()).any(|i| missed(i) < -fastest)
    }

    /// Gives a row other impulses.
    pub fn set_row(&mut self, i: usize, normal_impulse: f64, friction_impulse: DVec3) {
        let row = &mut self.contacts[i];
        let before = row.impulse();
        (row.normal_impulse, row.friction_impulse) = (normal_impulse, friction_impulse);
        let change = row.impulse() - before;
        self.give(i, change);
    }

    /// Gives a tie another impulse.
    pub fn set_tie(&mut self, i: usize, impulse: DVec3) {
        let tie = &mut self.ties[i];
        let change = impulse - tie.impulse;
        tie.impulse = impulse;
        self.points.push(tie.terms, change);
        self.shadows[tie.shadow as usize].push(tie.arm, -change);
    }
}
