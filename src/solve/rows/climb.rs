//! What impulses do to the measure that all rows together minimise.
//!
//! With λ the impulses of the rows, A their response, u their velocities before any of them and a those asked for, a pass
//! goes down ½·λ·A·λ + λ·(u − a). What starts at zero and ends below zero takes energy and gives none, but for what the a
//! ask for. A guess that went uphill is known by this, whatever else it has settled. Only what friction loses with its load may be
//! uphill, and no more than other attempts for rows on the same shadow have gone down.

use super::pass::Pass;
use super::{LEAD_RATE, Row};
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
    /// Rows and what their friction is bound to lose \[N·s\].
    lost: Vec<(usize, DVec3)>,
}

#[derive(Clone, Copy, Debug)]
struct RowBefore {
    row: usize,
    normal_impulse: f64,
    friction_impulse: DVec3,
    lift: Lift,
    /// Velocities that are not as asked for \[m/s\].
    excess: f64,
    slip: DVec3,
}

#[derive(Clone, Copy, Debug)]
struct TieBefore {
    tie: usize,
    impulse: DVec3,
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
                excess,
                slip,
            }
        }));
        self.ties.clear();
        self.ties.extend(ties.map(|tie| TieBefore {
            tie,
            impulse: pass.ties[tie].impulse,
            error: pass.tie_error(tie),
        }));
    }

    /// Whether it is to be taken back, having changed the measure by a `rise` \[J\]. `fallen` is by how much all attempts for
    /// rows on the same shadow have changed it in this substep.
    ///
    /// What friction loses with the load that bears it is no choice of a row. Where this counted, a row could not be relieved of a load
    /// that it need not bear, as friction would hold on to it: so if the load has become less, the measure counts from where
    /// friction had no more than it may have now, and may rise by as much as it has fallen before.
    pub fn is_worse(&mut self, pass: &mut Pass, rise: f64, fallen: f64) -> bool {
        if rise <= 0.0 {
            return false;
        }
        let first = self.rows.first();
        let relieves =
            first.is_some_and(|b| pass.contacts[b.row].normal_impulse < b.normal_impulse);
        !(relieves && fallen + rise <= 0.0 && rise <= self.forced(pass))
    }

    /// By how much the measure rises as friction loses what the loads don't allow any more \[J\]: d·e + ½·d·A·d for that change d of the
    /// impulses and the velocities e before the attempt.
    fn forced(&mut self, pass: &mut Pass) -> f64 {
        let mut rise = 0.0;
        self.lost.clear();
        for before in &self.rows {
            if let Some(bounded) = pass.contacts[before.row].bounded(before.friction_impulse) {
                let lost = bounded - before.friction_impulse;
                rise += lost.dot(before.slip);
                self.lost.push((before.row, lost));
            }
        }
        if self.lost.is_empty() {
            return 0.0;
        }
        let slips = |pass: &Pass| -> f64 {
            let each = self.lost.iter();
            each.map(|(row, lost)| lost.dot(pass.slip(*row))).sum()
        };
        let give = |pass: &mut Pass, sign: f64| {
            for (row, lost) in &self.lost {
                pass.give(*row, sign * *lost);
            }
            pass.follow_of(self.rows[0].row);
        };
        let now = slips(pass);
        give(pass, 1.0);
        rise += 0.5 * (slips(pass) - now);
        give(pass, -1.0);
        rise
    }

    /// By how much the measure has risen since \[J\].
    pub fn rise(&self, pass: &Pass) -> f64 {
        let rows = self.rows.iter().map(|before| {
            let row = &pass.contacts[before.row];
            let pressed = row.normal_impulse - before.normal_impulse;
            let rubbed = row.friction_impulse - before.friction_impulse;
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
        let (row, relative) = (&self.contacts[i], self.relative(i));
        (row.excess(relative) - row.lift.speed, row.slip(relative))
    }

    /// Whether anything comes deeper at more than `fastest` m/s, less what it would be moved out by at [`LEAD_RATE`] but not less than a tenth
    /// of that, or is lifted by that much slower than it is to be although it has impulse left for it.
    pub fn sinks(&self, fastest: f64) -> bool {
        let sinks = |row: usize| {
            let Row { lift, depth, .. } = self.contacts[row];
            if lift.left > 0.0 {
                return self.missed(row) < -fastest;
            }
            let slower = (fastest - LEAD_RATE * depth.max(0.0)).max(0.1 * fastest);
            self.excess(row) < -slower
        };
        let mut rigid = self.rigid.iter();
        (0..self.contacts.len()).any(sinks)
            || rigid.any(|row| row.errors(self.shadows)[0] < -fastest)
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
