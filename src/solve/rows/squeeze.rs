//! Nodes that have a row or a tie of their own and further rows: squeezed between bodies.
//!
//! Sequential impulses carry momentum across a node of mass m between bodies of mass M in about M/m passes, for each row
//! sees only the node. Here a row sees the node together with its other rows: what is pressed on a floor does not give
//! way at all, and what is pressed on a body moves with it. That is the Schur complement of the node's own rows in the
//! system of all rows, taken over those that are active. After every such impulse the node's own rows answer at once.
//! Which of them will be active is a guess, so what went uphill is taken back.

use super::contact::Response;
use super::pass::Pass;
use super::{Row, Term, Tie};
use crate::math::{DMat3, DVec3};

const NONE: u32 = u32::MAX;
/// Below this share of the response of its nodes alone, a row is held from both sides and can't be answered.
const HELD: f64 = 1e-6;
/// How often a row is tried in one visit, and what share of its velocity counts as settled.
const TRIES: usize = 4;
const SETTLED: f64 = 1e-3;

/// Which own rows count as holding a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hold {
    /// Those that press now, and along their surfaces those that stick.
    Active,
    /// All, in every direction: what is held more than this does not exist.
    All,
}

/// The rows that act on one node alone, per node, a tie that does, and the rows that share a node with one of them.
#[derive(Clone, Debug, Default)]
pub(super) struct Squeeze {
    /// Per node, its first own row.
    first: Vec<u32>,
    /// Per row, the next one on the same node.
    next: Vec<u32>,
    /// Per node, the last term of a row of several nodes.
    last: Vec<u32>,
    /// Per term, its row, and the term before it at the same node, of rows of several nodes.
    before: Vec<(u32, u32)>,
    /// Per node, its own tie.
    tie: Vec<u32>,
    /// Per row, whether a node of it has an own row that is another one.
    shared: Vec<bool>,
    /// Per node, whether another deformable presses on it.
    pressed: Vec<bool>,
    /// Per node, how many rows and ties it has.
    uses: Vec<u32>,
}

/// What the nodes of a row, held by their own rows, make of its impulse, as far as that has been asked for \[1/kg\].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Held {
    /// In a state of the own rows, see [`Hold::Active`].
    active: Option<(u64, DMat3)>,
    /// See [`Hold::All`].
    all: Option<DMat3>,
}

impl Squeeze {
    pub fn find(&mut self, nodes: usize, contacts: &[Row], ties: &[Tie], terms: &[Term]) {
        self.tie.clear();
        self.tie.resize(nodes, NONE);
        self.uses.clear();
        self.uses.resize(nodes, 0);
        let of_ties = ties.iter().map(|tie| tie.terms);
        let of_all = contacts.iter().map(|row| row.terms).chain(of_ties);
        for term in of_all.flat_map(|of_one| &terms[of_one.range()]) {
            self.uses[term.node as usize] += 1;
        }
        for (i, tie) in ties.iter().enumerate() {
            if let [only] = &terms[tie.terms.range()] {
                self.tie[only.node as usize] = i as u32;
            }
        }
        self.first.clear();
        self.first.resize(nodes, NONE);
        self.next.clear();
        self.next.resize(contacts.len(), NONE);
        self.last.clear();
        self.last.resize(nodes, NONE);
        self.before.clear();
        self.before.resize(terms.len(), (NONE, NONE));
        self.pressed.clear();
        self.pressed.resize(nodes, false);
        for (i, row) in contacts.iter().enumerate().rev() {
            let range = row.terms.range();
            let terms = &terms[range.clone()];
            if let [only] = terms {
                let first = &mut self.first[only.node as usize];
                self.next[i] = std::mem::replace(first, i as u32);
            } else {
                for (term, at) in terms.iter().zip(range) {
                    let last = &mut self.last[term.node as usize];
                    self.before[at] = (i as u32, std::mem::replace(last, at as u32));
                }
            }
            if row.between {
                terms
                    .iter()
                    .for_each(|t| self.pressed[t.node as usize] = true);
            }
        }
        let mut shared = std::mem::take(&mut self.shared);
        shared.clear();
        shared.extend(contacts.iter().enumerate().map(|(i, row)| {
            let mut terms = terms[row.terms.range()].iter();
            terms.any(|t| self.tie(t.node).is_some() || self.own(t.node).any(|own| own != i))
        }));
        self.shared = shared;
    }

    /// Whether a row shares a node with another row on that node alone.
    pub fn shares(&self, row: usize) -> bool {
        self.shared[row]
    }

    /// Whether a row has only one node, which has no other row and no tie.
    pub fn is_only(&self, row: &Row, terms: &[Term]) -> bool {
        matches!(&terms[row.terms.range()], [only] if self.uses[only.node as usize] == 1)
    }

    /// Whether a row has only one node, on which no other deformable presses: it needs no warm start. With one beside those of
    /// faces, a ball that rolls to and fro over nodes gains by it.
    pub fn stands_alone(&self, row: &Row, terms: &[Term]) -> bool {
        matches!(&terms[row.terms.range()], [only] if !self.pressed[only.node as usize])
    }

    /// The tie that acts on this node alone, one of them if there are several.
    pub fn tie(&self, node: u32) -> Option<usize> {
        let tie = self.tie[node as usize];
        (tie != NONE).then_some(tie as usize)
    }

    /// The rows that act on this node and others.
    pub fn with_others(&self, node: u32) -> impl Iterator<Item = usize> + '_ {
        let link = |at: u32| (at != NONE).then_some(at as usize);
        let last = link(self.last[node as usize]);
        let terms = std::iter::successors(last, move |&at| link(self.before[at].1));
        terms.map(|at| self.before[at].0 as usize)
    }

    /// The rows that act on this node alone.
    pub fn own(&self, node: u32) -> impl Iterator<Item = usize> + '_ {
        let link = |i: u32| (i != NONE).then_some(i);
        let first = link(self.first[node as usize]);
        std::iter::successors(first, move |&i| link(self.next[i as usize])).map(|i| i as usize)
    }
}

impl Pass<'_> {
    /// Solves a row whose nodes have rows of their own.
    pub(super) fn solve_squeezed(&mut self, i: usize) -> bool {
        self.follow_of(i);
        let row = &self.contacts[i];
        if row.normal_impulse == 0.0 && !row.rubs() && self.missed(i) >= 0.0 {
            return false;
        }
        let mut attempt = std::mem::take(self.attempt);
        let squeeze = self.squeeze;
        let terms = self.points.terms_of(self.contacts[i].terms);
        let own = terms.iter().flat_map(|t| squeeze.own(t.node));
        let rows = std::iter::once(i).chain(own.filter(|own| *own != i));
        let ties = terms.iter().filter_map(|t| squeeze.tie(t.node));
        let ties = ties.filter(|tie| self.composites.of_tie(*tie).is_none());
        attempt.start(self, rows, ties);
        let mut changed = self.press_squeezed(i) | self.rub_squeezed(i);
        self.follow_of(i);
        let mut rise = attempt.rise(self);
        let shadow = self.contacts[i].shadow as usize;
        if attempt.is_worse(self, rise, self.fallen[shadow]) {
            attempt.undo(self);
            changed = if self.follow_of(i) {
                self.solve_alone(i)
            } else {
                self.solve_row(i)
            };
            rise = attempt.rise(self);
        }
        self.fallen[shadow] += rise;
        *self.attempt = attempt;
        changed
    }

    /// Solves a row as if it were the only one, but for composites, which answer its normal impulse before it rubs.
    fn solve_alone(&mut self, i: usize) -> bool {
        let mut changed = self.press(i, self.contacts[i].response.mass);
        self.follow_of(i);
        let slip = self.slip(i);
        if self.contacts[i].rubs() {
            let mass = self.contacts[i].response.mass_along(slip);
            changed |= self.rub(i, slip, mass);
            self.follow_of(i);
        }
        changed
    }

    /// Has composites answer what was done to their nodes in a row, and these follow what was done to their shadows: whoever
    /// asks for either must see it. Says whether the row has any such node.
    pub(super) fn follow_of(&mut self, i: usize) -> bool {
        let terms = self.points.terms;
        let terms = &terms[self.contacts[i].terms.range()];
        let mut any = false;
        for term in terms {
            any |= self.follow_node(term.node);
        }
        if any && terms.len() > 1 {
            // The second may have moved what the first has followed.
            for term in terms {
                self.follow_node(term.node);
            }
        }
        any
    }

    /// The same for a node.
    fn follow_node(&mut self, node: u32) -> bool {
        let tie = self.squeeze.tie(node);
        let tie = tie.filter(|tie| self.composites.of_tie(*tie).is_some());
        if let Some(tie) = tie {
            self.follow(tie);
        }
        tie.is_some()
    }

    /// The normal impulse. Which own rows will be active, and which of them stick, is known only afterwards, so a row that
    /// did not come to rest is tried again. Its velocity grows with its impulse, slowly while the own rows hold and by the
    /// nodes' own response once they don't: beyond zero that steepest slope leads back without crossing it again, before
    /// zero the measured one leads on.
    fn press_squeezed(&mut self, i: usize) -> bool {
        let Row {
            normal, response, ..
        } = self.contacts[i];
        let softness = response.softness;
        let mut mass = self.squeezed_mass(i, normal, softness, Hold::Active);
        let mut changed = false;
        for _ in 0..TRIES {
            let (j, v) = (self.contacts[i].normal_impulse, self.excess(i));
            if !self.press(i, mass) {
                break;
            }
            changed = true;
            self.answer(i);
            let (change, left) = (self.contacts[i].normal_impulse - j, self.excess(i));
            if left.abs() <= SETTLED * v.abs() {
                break;
            }
            let alone = self.contacts[i].response.mass;
            mass = if left > 0.0 {
                alone
            } else {
                change / (left - v)
            };
            if mass.is_nan() || mass <= 0.0 {
                break;
            }
            mass = mass.min(self.squeezed_mass(i, normal, softness, Hold::All));
        }
        changed
    }

    /// The friction impulse, likewise.
    fn rub_squeezed(&mut self, i: usize) -> bool {
        let row = &self.contacts[i];
        let mut slip = self.slip(i);
        let speed = slip.length();
        if !row.rubs() || speed.is_nan() {
            return false;
        }
        if speed == 0.0 {
            // There is nothing to stop, but the load may allow less than it did.
            let changed = self.rub(i, slip, 0.0);
            if changed {
                self.answer(i);
            }
            return changed;
        }
        let direction = slip / speed;
        let alone = row.response.mass_along(direction);
        let mut mass = self.squeezed_mass(i, direction, 0.0, Hold::Active);
        let mut changed = false;
        for _ in 0..TRIES {
            let before = self.contacts[i].friction_impulse;
            if !self.rub(i, slip, mass) {
                break;
            }
            changed = true;
            self.answer(i);
            let change = self.contacts[i].friction_impulse - before;
            let left = self.slip(i);
            if left.length() <= SETTLED * slip.length() {
                break;
            }
            mass = if left.dot(slip) < 0.0 {
                alone
            } else {
                change.length_squared() / (left - slip).dot(change)
            };
            if mass.is_nan() || mass <= 0.0 {
                break;
            }
            slip = left;
            mass = mass.min(self.squeezed_mass(i, direction, 0.0, Hold::All));
        }
        changed
    }

    /// Lets the own rows of a row's nodes answer what it did.
    pub(super) fn answer(&mut self, i: usize) {
        let squeeze = self.squeeze;
        let terms = self.points.terms;
        for term in &terms[self.contacts[i].terms.range()] {
            if let Some(tie) = squeeze.tie(term.node) {
                self.solve_tie(tie);
            }
            for own in squeeze.own(term.node).filter(|own| *own != i) {
                self.follow_node(term.node);
                self.solve_row(own);
                self.follow_node(term.node);
            }
        }
        self.follow_of(i);
    }

    /// Effective mass of a row along `direction` with the own rows of its nodes \[kg\]. One that is held from both sides
    /// counts as if it were alone: no impulse can answer it.
    pub(super) fn squeezed_mass(
        &mut self,
        i: usize,
        direction: DVec3,
        softness: f64,
        hold: Hold,
    ) -> f64 {
        let squeezed = direction.dot(self.squeezed_response(i, hold) * direction);
        let Response { own, ref rigid, .. } = self.contacts[i].response;
        let k = squeezed.max(0.0) + direction.dot(*rigid * direction) + softness;
        if k > HELD * own {
            1.0 / k
        } else if own > 0.0 {
            1.0 / own
        } else {
            0.0
        }
    }

    /// The velocity of a row's point by its impulse while the own rows of its nodes hold these \[1/kg\]: found once for each
    /// state of the own rows, which most visits find as the last one left it.
    fn squeezed_response(&mut self, i: usize, hold: Hold) -> DMat3 {
        let state = match hold {
            Hold::Active => self.own_state(i),
            Hold::All => None,
        };
        let known = match hold {
            Hold::Active => self.held[i].active.filter(|(at, _)| Some(*at) == state),
            Hold::All => self.held[i].all.map(|response| (0, response)),
        };
        if let Some((_, response)) = known {
            return response;
        }
        let terms = self.points.terms_of(self.contacts[i].terms);
        let each = terms.iter();
        let response = each
            .map(|t| self.node_response(t.node, i, hold) * (t.weight * t.share))
            .fold(DMat3::ZERO, |sum, response| sum + response);
        match hold {
            Hold::Active => self.held[i].active = state.map(|state| (state, response)),
            Hold::All => self.held[i].all = Some(response),
        }
        response
    }

    /// Which of the own rows of a row's nodes press, and which of them stick: two bits for each; `None` where those are too
    /// many.
    fn own_state(&self, i: usize) -> Option<u64> {
        let terms = self.points.terms_of(self.contacts[i].terms).iter();
        let own = terms.flat_map(|t| self.squeeze.own(t.node));
        let (mut state, mut count) = (0, 0);
        for row in own.filter(|own| *own != i).map(|own| &self.contacts[own]) {
            let presses = row.normal_impulse > 0.0;
            state = state << 2 | u64::from(presses) << 1 | u64::from(presses && row.sticks());
            count += 2;
        }
        (count <= u64::BITS).then_some(state)
    }

    /// The inverse mass matrix of a node that is held by its own rows, but for row `but` \[1/kg\].
    fn node_response(&self, node: u32, but: usize, hold: Hold) -> DMat3 {
        let inv_mass = self.points.nodes[node as usize].inv_mass;
        let mut response = DMat3::from_diagonal(DVec3::splat(inv_mass));
        if let Some(tie) = self.squeeze.tie(node) {
            response -= self.tie_mass(tie) * inv_mass.powi(2);
        }
        for own in self.squeeze.own(node).filter(|own| *own != but) {
            let row = &self.contacts[own];
            if hold == Hold::Active && row.normal_impulse <= 0.0 {
                continue;
            }
            let mut keep = |direction: DVec3, softness: f64| {
                let given = response * direction;
                let rigid = row.response.rigid_along(direction);
                let k = direction.dot(given) + rigid + softness;
                if k > HELD * inv_mass {
                    let by = given / k;
                    response -= DMat3::from_cols(given * by.x, given * by.y, given * by.z);
                }
            };
            keep(row.normal, row.response.softness);
            if hold == Hold::All || row.sticks() {
                let side = row.normal.any_orthonormal_vector();
                keep(side, 0.0);
                keep(row.normal.cross(side), 0.0);
            }
        }
        response
    }
}
