//! How the load of a rigid body is spread over the nodes that it squeezes.
//!
//! What lies between two bodies that do not give way can bear the load at any of its nodes. All these answers are right, and
//! the first row that is visited would take the most. But a node takes no more friction than stops it: where a few light ones
//! bear everything, the rest of a sheet is drawn away from under the load. So each takes the same share before the passes,
//! which then find what a body that tilts needs besides.

use super::pass::Pass;
use super::squeeze::Hold;

impl Pass<'_> {
    /// Presses the rows of bodies that move on nodes that lie on what does not: the first of n rows of a body with the n-th part of
    /// what it would bear alone, the next with the (n-1)-th part of what is left, and so on. `left` is working memory, a number for
    /// each shadow.
    pub(super) fn spread_loads(&mut self, left: &mut Vec<u32>) {
        if !self.squeezed {
            return;
        }
        let (squeeze, terms) = (self.squeeze, self.points.terms);
        self.count(left, Self::lies);
        for i in 0..self.contacts.len() {
            if left[self.contacts[i].shadow as usize] > 0 && self.lies(i) {
                // What the nodes lie on has stopped them before anything presses on them.
                for term in &terms[self.contacts[i].terms.range()] {
                    for own in squeeze.own(term.node) {
                        if self.is_fixed(&self.contacts[own]) {
                            self.solve_row(own);
                        }
                    }
                }
            }
        }
        let bears = |pass: &Self, i: usize| pass.lies(i) && pass.missed(i) < 0.0;
        self.count(left, bears);
        for i in 0..self.contacts.len() {
            let shadow = self.contacts[i].shadow as usize;
            if left[shadow] > 0 && bears(self, i) {
                self.press_share(i, left[shadow]);
                left[shadow] -= 1;
            }
        }
    }

    /// How many rows of each shadow are such, or none of what has only one: that shares nothing.
    fn count(&self, left: &mut Vec<u32>, is_such: impl Fn(&Self, usize) -> bool) {
        left.clear();
        left.resize(self.shadows.len(), 0);
        for i in (0..self.contacts.len()).filter(|i| is_such(self, *i)) {
            left[self.contacts[i].shadow as usize] += 1;
        }
        left.iter_mut().filter(|n| **n == 1).for_each(|n| *n = 0);
    }

    /// Whether all nodes of a row that a moving body presses on lie on what does not move, and are not tied.
    fn lies(&self, i: usize) -> bool {
        let row = &self.contacts[i];
        let lies = |node: u32| {
            let mut own = self.squeeze.own(node).map(|own| &self.contacts[own]);
            self.squeeze.tie(node).is_none() && own.any(|under| self.is_held_by(row, under))
        };
        let presses = !row.between && self.worklist.moves(row.shadow);
        let mut terms = self.points.terms_of(row.terms).iter();
        presses && terms.all(|t| lies(t.node))
    }

    /// Presses a row as one of `rows` that bear the body together, each with the same part of its mass.
    fn press_share(&mut self, i: usize, rows: u32) {
        self.follow_of(i);
        let attempt = self.attempt_with(i);
        let row = &self.contacts[i];
        let (normal, softness) = (row.normal, row.response.softness);
        let others = f64::from(rows - 1) * row.response.rigid_along(normal);
        let mass = self.squeezed_mass(i, normal, softness, Hold::All);
        if self.press(i, mass / (1.0 + mass * others)) {
            self.answer(i);
        }
        self.end_attempt(attempt, i);
    }
}
