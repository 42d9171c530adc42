//! What a visit of one row does.

use super::pass::Pass;
use crate::math::DVec3;

impl Pass<'_> {
    /// Solves a row as if it were the only one; whether it was not settled yet.
    #[inline]
    pub fn solve_row(&mut self, i: usize) -> bool {
        let mut relative = self.relative(i);
        let row = &mut self.contacts[i];
        let pressed = row.press(relative, row.response.mass);
        let mut impulse = row.normal * pressed;
        if row.rubs() {
            relative += row.response.to(impulse);
            let slip = row.slip(relative);
            impulse += row.rub(slip, row.response.mass_along(slip));
        }
        self.give(i, impulse);
        self.note(i, impulse)
    }

    /// Velocity of a row's point relative to its shadow's surface \[m/s\].
    #[inline(always)]
    pub fn relative(&self, i: usize) -> DVec3 {
        let row = &self.contacts[i];
        let shadow = &self.shadows[row.shadow as usize];
        self.points.velocity_of(row) - shadow.velocity_at(row.arm)
    }

    /// Gives both sides of a row an impulse \[N·s\].
    #[inline(always)]
    pub fn give(&mut self, i: usize, impulse: DVec3) {
        if impulse == DVec3::ZERO {
            return;
        }
        let row = &self.contacts[i];
        self.points.push_row(row, impulse);
        if self.worklist.moves(row.shadow) {
            self.shadows[row.shadow as usize].push(row.arm, -impulse * row.rigid_share);
        }
    }

    /// By how much the normal velocity of a row exceeds what it must be at least \[m/s\].
    #[inline(always)]
    pub fn excess(&self, i: usize) -> f64 {
        self.contacts[i].excess(self.relative(i))
    }

    /// The normal impulse of a row with an effective mass of `mass` kg.
    pub fn press(&mut self, i: usize, mass: f64) -> bool {
        let relative = self.relative(i);
        let row = &mut self.contacts[i];
        let pressed = row.press(relative, mass);
        let impulse = row.normal * pressed;
        self.give(i, impulse);
        self.note(i, impulse)
    }

    /// Has those looked at again that feel this change of a row's impulse \[N·s\]; whether there are any. One visit of a row that
    /// nothing else moves is exact.
    #[inline(always)]
    pub(super) fn note(&mut self, i: usize, change: DVec3) -> bool {
        let row = &self.contacts[i];
        let is_only = self.squeezed && self.squeeze.is_only(row, self.points.terms);
        if is_only && !self.worklist.moves(row.shadow) {
            return false;
        }
        let square = row.normal_impulse * row.normal_impulse;
        let settled = if row.between {
            self.settled.between()
        } else {
            self.settled
        };
        let felt = settled.felt(change.length_squared(), square, row.response.give);
        if felt.any() {
            let terms = self.points.terms_of(row.terms);
            self.worklist.change(terms, [row.shadow; 2], felt);
        }
        felt.any()
    }

    /// The slip velocity of a row, whether there is friction or not \[m/s\].
    #[inline(always)]
    pub fn slip(&self, i: usize) -> DVec3 {
        self.contacts[i].slip(self.relative(i))
    }

    /// The friction impulse of a row against `slip` m/s, with an effective mass of `mass` kg.
    pub fn rub(&mut self, i: usize, slip: DVec3, mass: f64) -> bool {
        let row = &mut self.contacts[i];
        let rubbed = row.rub(slip, mass);
        self.give(i, rubbed);
        self.note(i, rubbed)
    }
}
