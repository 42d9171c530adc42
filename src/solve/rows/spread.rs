//! How the load of a rigid body is spread over the nodes that it squeezes.
//!
//! What lies between two bodies that do not give way can bear the load at any of its nodes. All these answers are right, and
//! the first row that is visited would take the most. But a node takes no more friction than stops it: where a few light ones
//! bear everything, the rest of a sheet is drawn away from under the load. So before the passes the rows of a body bear it together,
//! with the least sum of squares of their impulses, which is how a bed of equal springs would: the same each under the
//! centre of mass of what they hold, and more to one side of it.
//!
//! With w = (n, r×n) the motion of a row's point along its normal n by that of the body, at r from its centre of mass, J all of these
//! and e the velocities that they lack, these impulses are J·C·y with C·G·C·G·C·y = C·Jᵀ·e, where G = Jᵀ·J and C is the response of
//! the body: six equations, however many rows there are. Where the e contradict each other, that is the nearest to all of them.

use super::pass::Pass;
use super::supports::{Mat6, Vec6, motion, response};
use crate::math::na::Cholesky;

/// What is added to the squares of the motions that rows hold, in parts of the largest: it decides about those that none holds.
const LEAST_HELD: f64 = 1e-10;
/// How often rows that would have to pull are left out and the others asked again, at most.
const ROUNDS: usize = 16;

/// A row that bears a body together with others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bearer {
    shadow: u32,
    row: usize,
    motion: Vec6,
    /// What its velocity falls short of what it must be \[m/s\].
    lacks: f64,
    /// What it is to bear \[N·s\].
    load: f64,
    bears: bool,
}

impl Pass<'_> {
    /// Gives the rows of bodies that lie on nodes which lie on what does not give way their parts of the load. `bearers` and `tried` are
    /// working memory.
    pub(super) fn spread_loads(&mut self, bearers: &mut Vec<Bearer>, tried: &mut Vec<usize>) {
        if !self.squeezed {
            return;
        }
        bearers.clear();
        for i in (0..self.contacts.len()).filter(|i| self.is_squeezed(*i) && self.lies(*i)) {
            let row = &self.contacts[i];
            bearers.push(Bearer {
                shadow: row.shadow,
                row: i,
                motion: motion(row.normal, row.arm.cross(row.normal)),
                lacks: 0.0,
                load: 0.0,
                bears: false,
            });
        }
        // By colliders they are in order, of which a body may have several.
        bearers.sort_unstable_by_key(|b| (b.shadow, b.row));
        for together in bearers.chunk_by_mut(|a, b| a.shadow == b.shadow) {
            if together.len() > 1 {
                self.bear_together(together, tried);
            }
        }
    }

    /// Whether all nodes of a row that a moving body presses on lie on what does not give way, and neither they nor the body are tied to
    /// what would bear some of it.
    fn lies(&self, i: usize) -> bool {
        let row = &self.contacts[i];
        let is_held = |node: u32| {
            let mut own = self.squeeze.own(node).map(|own| &self.contacts[own]);
            self.squeeze.tie(node).is_none() && own.any(|under| self.is_held_by(row, under))
        };
        let presses = !row.between && row.softness == 0.0 && !self.is_fixed(row);
        let mut terms = self.points.terms_of(row.terms).iter();
        presses && terms.all(|t| is_held(t.node)) && !self.composites.has_supports(row.shadow)
    }

    /// Presses the rows of a body together, unless that is uphill.
    fn bear_together(&mut self, together: &mut [Bearer], tried: &mut Vec<usize>) {
        let (squeeze, terms) = (self.squeeze, self.points.terms);
        tried.clear();
        for bearer in &*together {
            let terms = &terms[self.contacts[bearer.row].terms.range()];
            tried.push(bearer.row);
            tried.extend(terms.iter().flat_map(|t| squeeze.own(t.node)));
        }
        tried.sort_unstable();
        tried.dedup();
        // What the nodes lie on has stopped them before anything presses on them.
        for i in &*tried {
            if self.is_fixed(&self.contacts[*i]) {
                self.solve_row(*i);
            }
        }
        for bearer in &mut *together {
            bearer.lacks = -self.excess(bearer.row);
            bearer.bears = bearer.lacks > 0.0 && self.reaches(bearer.row, bearer.lacks);
        }
        let shadow = together[0].shadow as usize;
        let c = response(&self.shadows[shadow]);
        if !share(&c, together) {
            return;
        }
        let mut attempt = std::mem::take(self.attempt);
        attempt.start(self, tried.iter().copied(), std::iter::empty());
        for bearer in together.iter().filter(|b| b.bears) {
            let row = &self.contacts[bearer.row];
            let load = row.normal_impulse + bearer.load;
            self.set_row(bearer.row, load, row.friction_impulse);
            self.answer(bearer.row);
        }
        let rise = attempt.rise(self);
        if rise > 0.0 {
            attempt.undo(self);
        } else {
            self.fallen[shadow] += rise;
        }
        *self.attempt = attempt;
    }

    /// Whether nodes that a row pushes at `speed` m/s would meet what they lie on.
    fn reaches(&self, i: usize, speed: f64) -> bool {
        let row = &self.contacts[i];
        self.points.terms_of(row.terms).iter().all(|term| {
            let mut own = self.squeeze.own(term.node);
            own.any(|own| self.is_held_by(row, &self.contacts[own]) && self.excess(own) < speed)
        })
    }
}

/// Finds what each of those that bear is to bear, and which of them; `false` if there is nothing to share.
fn share(c: &Mat6, together: &mut [Bearer]) -> bool {
    for _ in 0..ROUNDS {
        let (mut held, mut lacking, mut count) = (Mat6::zeros(), Vec6::zeros(), 0);
        for bearer in together.iter().filter(|b| b.bears) {
            held += bearer.motion * bearer.motion.transpose();
            lacking += bearer.motion * bearer.lacks;
            count += 1;
        }
        if count < 2 {
            return false;
        }
        let by_load = c * held * c;
        let mut matrix = by_load * held * c;
        // In units in which wrenches by torques answer as much as the others.
        let part = |from: usize| (from..from + 3).map(|i| by_load[(i, i)]).sum::<f64>();
        let (linear, angular) = (part(0), part(3));
        let turn = if angular > 0.0 && linear > 0.0 {
            (linear / angular).sqrt()
        } else {
            1.0
        };
        let scale = Vec6::from_fn(|i, _| if i < 3 { 1.0 } else { turn });
        matrix.component_mul_assign(&(scale * scale.transpose()));
        let least = matrix.diagonal().max() * LEAST_HELD;
        for i in 0..6 {
            matrix[(i, i)] += least;
        }
        let Some(matrix) = Cholesky::new(matrix) else {
            return false;
        };
        let y = matrix.solve(&(c * lacking).component_mul(&scale));
        let x = c * y.component_mul(&scale);
        let mut all = true;
        for bearer in together.iter_mut().filter(|b| b.bears) {
            bearer.load = bearer.motion.dot(&x);
            bearer.bears = bearer.load > 0.0;
            all &= bearer.bears;
        }
        if all {
            break;
        }
    }
    true
}
