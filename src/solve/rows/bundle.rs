//! Bundles: rows of one body whose points are near each other, as a ball has them at the border of two faces, and at a node
//! on the four around it.
//!
//! What one of them does the others feel nearly in full, and where one may come nearer than another, each visit of the one
//! undoes most of what the last of the other did: the load changes over from one face to the next in a dozen substeps, in which
//! the body sinks into the second, and on four at once it never settles. So their normal impulses are found together: j ≥ 0 with
//! velocities v + K·Δj that are what they must be, or more where j = 0, by a method of active sets (Lawson & Hanson 1974, ch. 23).

use super::Row;
use super::pass::Pass;

/// How much two rows feel of each other, as the cosine of an angle between them, to be in a bundle.
const ALIKE: f64 = 0.6;
/// How many rows are found together at most.
const MOST: usize = 8;
/// Rounds of looking for them, per row: a few are usual.
const ROUNDS: usize = 8;
/// By what share the responses of a bundle are more than they are, for rows that can't be told apart, and what is no velocity
/// \[m/s\].
const SAME: f64 = 1e-9;

/// One number per row of a bundle.
type Each = [f64; MOST];
/// One per pair.
type Pairs = [Each; MOST];

/// A row in no bundle.
const NONE: u32 = u32::MAX;

/// The bundles of a substep.
#[derive(Clone, Debug, Default)]
pub(super) struct Bundles {
    /// Per contact, its bundle.
    of: Vec<u32>,
    all: Vec<Bundle>,
}

#[derive(Clone, Copy, Debug)]
struct Bundle {
    rows: [u32; MOST],
    count: usize,
    /// What each feels of the others, and of itself \[1/kg\].
    response: Pairs,
}

impl Bundles {
    /// Puts two rows into one bundle, unless that gets too large, or each is in one already.
    fn join(&mut self, i: usize, j: usize) {
        let (bundle, new) = match (self.of[i], self.of[j]) {
            (NONE, NONE) => {
                self.of[i] = self.all.len() as u32;
                self.all.push(Bundle::of(i));
                (self.of[i], j)
            }
            (NONE, of_other) => (of_other, i),
            (own, NONE) => (own, j),
            _ => return,
        };
        let into = &mut self.all[bundle as usize];
        if into.count < MOST {
            into.rows[into.count] = new as u32;
            into.count += 1;
            self.of[new] = bundle;
        }
    }
}

impl Bundle {
    /// Of one row.
    fn of(row: usize) -> Self {
        let mut rows = [NONE; MOST];
        rows[0] = row as u32;
        Self {
            rows,
            count: 1,
            response: Pairs::default(),
        }
    }

    fn rows(&self) -> impl ExactSizeIterator<Item = usize> + use<> {
        let rows = self.rows.into_iter().take(self.count);
        rows.map(|row| row as usize)
    }

    /// What impulses make of its velocities \[m/s\].
    fn velocities(&self, impulses: &Each) -> Each {
        let by = |response: &Each| (0..self.count).map(|b| response[b] * impulses[b]).sum();
        self.response.each_ref().map(by)
    }

    /// The impulses with which velocities that would be `free` without them are 0, or more where an impulse is 0, from some that push
    /// on; `None` where rounding hides them. Every round leads downhill, so none comes twice.
    fn solve(&self, free: &Each, mut impulses: Each) -> Option<Each> {
        let is_active = |active: u32, a: &usize| active >> *a & 1 == 1;
        let pushing = (0..self.count).filter(|a| impulses[*a] > 0.0);
        let mut active = pushing.fold(0_u32, |bits, a| bits | 1 << a);
        for _ in 0..ROUNDS * self.count {
            let wanted = self.solve_active(free, active)?;
            // The first that would have to pull on the way there.
            let pulls = (0..self.count).filter(|a| is_active(active, a) && wanted[*a] <= 0.0);
            let part = |a: usize| impulses[a] / (impulses[a] - wanted[a]);
            if let Some(first) = pulls.min_by(|a, b| part(*a).total_cmp(&part(*b))) {
                let part = part(first);
                for a in (0..self.count).filter(|a| is_active(active, a)) {
                    impulses[a] += part * (wanted[a] - impulses[a]);
                }
                impulses[first] = 0.0;
                active &= !(1 << first);
                continue;
            }
            impulses = wanted;
            let left = |a: usize| {
                let by = (0..self.count).map(|b| self.response[a][b] * impulses[b]);
                let (sum, size) = by.fold((0.0, 0.0), |(sum, size), v| (sum + v, size + v.abs()));
                free[a] + sum + SAME * (free[a].abs() + size)
            };
            let sinks = (0..self.count).filter(|a| !is_active(active, a) && left(*a) < 0.0);
            match sinks.min_by(|a, b| left(*a).total_cmp(&left(*b))) {
                Some(deepest) => active |= 1 << deepest,
                None => return Some(impulses),
            }
        }
        None
    }

    /// The impulses that leave those that are active no velocity, without the others, by Cholesky's method.
    fn solve_active(&self, free: &Each, active: u32) -> Option<Each> {
        let (mut list, mut n) = ([0; MOST], 0);
        for a in (0..self.count).filter(|a| active >> a & 1 == 1) {
            list[n] = a;
            n += 1;
        }
        let (mut l, mut y) = (Pairs::default(), Each::default());
        for i in 0..n {
            for k in 0..i {
                let known: f64 = (0..k).map(|m| l[i][m] * l[k][m]).sum();
                l[i][k] = (self.response[list[i]][list[k]] - known) / l[k][k];
            }
            let known: f64 = l[i][..i].iter().map(|x| x * x).sum();
            let square = self.response[list[i]][list[i]] * (1.0 + SAME) - known;
            if square.is_nan() || square <= 0.0 {
                return None;
            }
            l[i][i] = square.sqrt();
            let known: f64 = (0..i).map(|m| l[i][m] * y[m]).sum();
            y[i] = (-free[list[i]] - known) / l[i][i];
        }
        let mut impulses = Each::default();
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|m| l[m][i] * impulses[list[m]]).sum();
            impulses[list[i]] = (y[i] - known) / l[i][i];
        }
        Some(impulses)
    }
}

impl Pass<'_> {
    /// Finds the bundles among the rows of faces and edges, and of the nodes of these.
    pub(super) fn find_bundles(&mut self) {
        let mut bundles = std::mem::take(self.bundles);
        bundles.of.clear();
        bundles.all.clear();
        if self.squeezed {
            bundles.of.resize(self.contacts.len(), NONE);
            for i in 0..self.contacts.len() {
                self.join_alike(i, &mut bundles);
            }
            for bundle in &mut bundles.all {
                for (a, i) in bundle.rows().enumerate() {
                    for (b, j) in bundle.rows().enumerate().take(a) {
                        let felt = self.coupling(i, j);
                        (bundle.response[a][b], bundle.response[b][a]) = (felt, felt);
                    }
                    bundle.response[a][a] = 1.0 / self.contacts[i].response.mass;
                }
            }
        }
        *self.bundles = bundles;
    }

    fn join_alike(&self, i: usize, bundles: &mut Bundles) {
        let row = &self.contacts[i];
        let terms = self.points.terms_of(row.terms);
        if terms.len() < 2 || !self.may_be_bundled(row) {
            return;
        }
        let heaviest = terms.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
        let at = |node: u32| self.squeeze.own(node).chain(self.squeeze.with_others(node));
        let others = heaviest.into_iter().flat_map(|t| at(t.node));
        for j in others.filter(|j| *j != i) {
            let other = &self.contacts[j];
            let limit = ALIKE * ALIKE / (row.response.mass * other.response.mass);
            if other.shadow == row.shadow
                && other.normal.dot(row.normal) > ALIKE
                && self.may_be_bundled(other)
                && self.coupling(i, j).powi(2) > limit
            {
                bundles.join(i, j);
            }
        }
    }

    /// Whether a row can be one of a bundle: nothing else presses on its nodes alone or holds them, which would answer first.
    fn may_be_bundled(&self, row: &Row) -> bool {
        let is_free = |node: u32| {
            let mut own = self.squeeze.own(node).map(|own| &self.contacts[own]);
            self.squeeze.tie(node).is_none()
                && own.all(|own| own.shadow == row.shadow && !own.between)
        };
        !row.between
            && row.lift.speed == 0.0
            && row.response.mass > 0.0
            && self.worklist.moves(row.shadow)
            && self
                .points
                .terms_of(row.terms)
                .iter()
                .all(|t| is_free(t.node))
    }

    /// What an impulse along the normal of row `j` makes of the velocity of row `i` along its own \[1/kg\].
    fn coupling(&self, i: usize, j: usize) -> f64 {
        let (row, other) = (&self.contacts[i], &self.contacts[j]);
        let mut own = 0.0;
        for term in self.points.terms_of(row.terms) {
            let of_other = self.points.terms_of(other.terms).iter();
            let share: f64 = of_other
                .filter(|t| t.node == term.node)
                .map(|t| t.share)
                .sum();
            own += term.weight * share * self.points.nodes[term.node as usize].inv_mass;
        }
        let shadow = &self.shadows[row.shadow as usize];
        let (v, w) = shadow.answer(other.normal, other.arm.cross(other.normal));
        let rigid = (v + w.cross(row.arm)).dot(row.normal);
        own * row.normal.dot(other.normal) + rigid * other.rigid_share
    }

    /// After a visit of row `i`: finds the normal impulses of its bundle. Friction that they do not allow any more is taken back.
    pub(super) fn solve_bundle(&mut self, i: usize) {
        let Some(&number) = self.bundles.of.get(i).filter(|number| **number != NONE) else {
            return;
        };
        let bundle = self.bundles.all[number as usize];
        let (mut excess, mut before) = (Each::default(), Each::default());
        let mut is_settled = true;
        for (a, row) in bundle.rows().enumerate() {
            (excess[a], before[a]) = (self.excess(row), self.contacts[row].normal_impulse);
            is_settled &= excess[a] >= -SAME && (before[a] == 0.0 || excess[a] <= SAME);
        }
        if is_settled {
            return;
        }
        let by = bundle.velocities(&before);
        let free = std::array::from_fn(|a| excess[a] - by[a]);
        let Some(impulses) = bundle.solve(&free, before) else {
            return;
        };
        for (a, i) in bundle.rows().enumerate() {
            if impulses[a] == before[a] {
                continue;
            }
            let row = self.contacts[i];
            let pressed = Row {
                normal_impulse: impulses[a],
                ..row
            };
            let friction = pressed.bounded(row.friction_impulse);
            self.set_row(i, impulses[a], friction.unwrap_or(row.friction_impulse));
            self.note(i, self.contacts[i].impulse() - row.impulse());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// K = AᵀA for rows A of three numbers and a little more: up to six rows, of which three or more can't be told apart.
    fn bundle(rows: &[[f64; 3]], alone: f64) -> Bundle {
        let mut bundle = Bundle::of(0);
        bundle.count = rows.len();
        for (a, one) in rows.iter().enumerate() {
            for (b, other) in rows.iter().enumerate() {
                let both: f64 = one.iter().zip(other).map(|(x, y)| x * y).sum();
                bundle.response[a][b] = both + if a == b { alone } else { 0.0 };
            }
        }
        bundle
    }

    proptest! {
        /// Impulses push, velocities separate, and only one of the two is not zero.
        #[test]
        fn what_is_found_satisfies_all(
            rows in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 1..6),
            free in prop::array::uniform8(-1.0..1.0f64),
            alone in prop_oneof![Just(1e-6), 1e-3..1.0f64],
            start in prop::array::uniform8(0.0..1.0f64),
        ) {
            let bundle = bundle(&rows, alone);
            let mut start = start.map(|x| (2.0 * x - 1.0).max(0.0));
            start[rows.len()..].fill(0.0);
            let impulses = bundle.solve(&free, start);
            prop_assert!(impulses.is_some());
            let impulses = impulses.unwrap_or_default();
            let by = bundle.velocities(&impulses);
            for a in 0..rows.len() {
                let left = free[a] + by[a];
                let felt = |b: usize| (bundle.response[a][b] * impulses[b]).abs();
                // Nearly singular ones take large impulses.
                let rounding = 1e-8 * (1.0 + (0..rows.len()).map(felt).sum::<f64>());
                prop_assert!(impulses[a] >= 0.0);
                prop_assert!(left > -rounding, "{left}");
                prop_assert!(impulses[a] == 0.0 || left < rounding, "{left} by {}", impulses[a]);
            }
        }
    }

    /// Two that are nearly one, of which the second is deeper: it bears all.
    #[test]
    fn the_deeper_of_two_bears_the_load() {
        let pair = bundle(&[[1.0, 0.0, 0.0], [1.0, 1e-4, 0.0]], 0.0);
        let free = [-1.0, -1.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let impulses = pair.solve(&free, Each::default()).unwrap();
        assert_eq!(impulses[0], 0.0);
        assert!((impulses[1] - 1.1).abs() < 1e-6, "{impulses:?}");
    }
}
