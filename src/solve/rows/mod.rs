//! Rows: contacts and ties of one substep, solved together by sequential impulses.
//!
//! Contact and coupling only fill rows; this pass knows nodes, shadows and numbers. Impulses on single nodes are
//! accumulated from zero in every substep (a warm start would keep squeezed bodies awake for ever); rows that share nodes
//! start from their last impulses, or four passes would leave a light node in a heavy grip trembling. The order is fixed,
//! and reversed in every other pass, so that the bias of one order does not add up to a spin. Nodes appear once, however
//! many rows they have.
//!
//! A light node between two heavy bodies takes as many passes as they are heavier than it, if each row sees the node
//! alone. Rows that share a node with rows on that node alone see what those make of it instead, see `squeeze`, and share the
//! load of a body evenly, see `spread`. What lies on deformables that can't give way is held by them, see `layers`.
//!
//! Rows of one body at nearly the same point undo what the others do: they are solved together, see `bundle`.

mod between;
mod bundle;
mod climb;
mod composite;
mod contact;
mod joint;
mod layers;
mod lift;
mod pass;
mod points;
mod rigid;
mod settled;
mod spread;
mod squeeze;
mod stand;
mod supports;
mod tie;
mod visit;
mod warm;
mod worklist;

use crate::law::row::allowed_velocity;
use crate::math::DVec3;
use crate::solve::shadow::Shadow;
pub use between::BetweenShadows;
use bundle::Bundles;
use climb::Attempt;
use composite::Composites;
pub use contact::Row;
pub use joint::{Joint, JointRow};
use layers::{Layers, Seen};
use rigid::Answers;
pub use rigid::RigidRow;
pub use settled::{Give, Negligible};
use spread::Bearer;
use squeeze::{Held, Squeeze};
use stand::Heaps;
pub use tie::Tie;
use warm::Clusters;
use worklist::Worklist;

/// How fast a body comes to held nodes it is tied to, in errors per second, and out of what nodes that it holds are in, in
/// depths per second.
const LEAD_RATE: f64 = 20.0;

/// A node that has at least one row.
#[derive(Clone, Copy, Debug)]
pub struct RowNode {
    /// Index of the body within its group.
    pub body: u32,
    /// Index of the node within its body.
    pub node: u32,
    /// 1/m \[1/kg\].
    pub inv_mass: f64,
    /// Velocity, changed by the pass \[m/s\].
    pub v: DVec3,
    /// Velocity after the free part of the substep \[m/s\].
    pub free: DVec3,
    /// Velocity at the end of the last substep \[m/s\].
    pub before: DVec3,
}

/// A node's part in a row: the row sees the point Σ weight · node, and node k takes the impulse share · j. A row with levers
/// adds n·(lever · j) to that, and the dual of it to the velocity, see [`Row::levers`].
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// Index into the row nodes.
    pub node: u32,
    /// Weight in the point's velocity: barycentric for a point of a face, negative on the far side of a row between two
    /// deformables.
    pub weight: f64,
    /// The weight again, or 0 for a body that dominates the other side and takes nothing.
    pub share: f64,
}

/// Where the terms of a row stand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    first: u32,
    count: u32,
}

impl Terms {
    /// Which of all terms they are.
    #[inline(always)]
    pub fn range(self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// All rows of a group in a substep.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// Their nodes.
    pub nodes: Vec<RowNode>,
    /// Their terms, row after row.
    pub terms: Vec<Term>,
    /// Levers of the terms of those rows that have any, see [`Row::levers`].
    pub levers: Vec<DVec3>,
    /// Contacts, sorted by collider and node, and behind them those of what a blow has struck.
    pub contacts: Vec<Row>,
    /// Ties, sorted by attachment and node.
    pub ties: Vec<Tie>,
    /// Contacts of shadows with each other; these stay when the others are cleared.
    pub rigid: Vec<RigidRow>,
    /// Joints of shadows, which stay likewise.
    pub joints: Vec<JointRow>,
    /// Whether something strikes what rests, which takes more passes.
    pub blow: bool,
    /// Whether shadows on joints bear a stiff deformable, which takes more visits of these.
    pub bears: bool,
    /// How fast points are moved out of what they are in, and bodies lifted that hold them, at most \[m/s\].
    pub push_out: f64,
    /// What is settled.
    pub negligible: Negligible,
    squeeze: Squeeze,
    layers: Layers,
    held: Vec<Held>,
    attempt: Attempt,
    /// Per shadow, by how much attempts for rows on it have changed the measure in this substep \[J\]: the first is that of all rows on what
    /// does not move and between deformables.
    fallen: Vec<f64>,
    composites: Composites,
    clusters: Clusters,
    bearers: Vec<Bearer>,
    heaps: Heaps,
    tried: Vec<usize>,
    bundles: Bundles,
    worklist: Worklist,
    answers: Answers,
}

impl Rows {
    /// Whether nodes were tied to a shadow when rows were last solved, and answer together with it.
    pub fn is_composite(&self, shadow: u32) -> bool {
        self.composites.of_shadow(shadow).is_some()
    }

    /// Its contacts and joints of shadows, as prepared in the last substep: what answers otherwise is prepared anew.
    pub fn between_shadows(&self) -> BetweenShadows {
        BetweenShadows::of(&self.rigid, &self.joints, &self.answers)
    }

    /// Forgets the rows of a substep, keeping the memory.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.terms.clear();
        self.levers.clear();
        self.contacts.clear();
        self.ties.clear();
        self.blow = false;
    }

    /// What of a way \[m\] a node can go for the sake of row `i` without going into what can't move, if the body of row `i`
    /// can: it is that body that has to give way, see [`Row::lift`].
    pub fn free_way(&self, i: usize, node: u32, mut way: DVec3) -> DVec3 {
        let moves = |row: &Row| row.response.rigid_along(row.normal) > 0.0;
        // One row alone is squeezed by nothing, and then nothing has been found of what is.
        if self.contacts.len() <= 1 || self.contacts[i].between || !moves(&self.contacts[i]) {
            return way;
        }
        let others = self.squeeze.own(node).filter(|own| *own != i);
        for row in others.map(|own| &self.contacts[own]) {
            let into = row.normal.dot(way) + (-row.depth).max(0.0);
            if !row.between && !moves(row) && into < 0.0 {
                way -= row.normal * into;
            }
        }
        way
    }

    /// Whether a node that is to go `way` \[m\] for the sake of row `i`, one between two deformables, would go into a rigid
    /// body: the other deformable has to give way.
    pub fn is_blocked(&self, i: usize, node: u32, way: DVec3) -> bool {
        if self.contacts.len() <= 1 || !self.contacts[i].between {
            return false;
        }
        let mut others = self.layers.against(self.seen(), (i, node), way);
        others.any(|row| row.softness == 0.0 && row.depth + row.normal.dot(way).abs() > 0.0)
    }

    fn seen(&self) -> Seen<'_> {
        Seen {
            contacts: &self.contacts,
            terms: &self.terms,
            nodes: &self.nodes,
            squeeze: &self.squeeze,
        }
    }

    /// Adds a term: a row node, its weight, and how much of an impulse by that weight it takes.
    #[inline(always)]
    pub fn add_term(&mut self, node: u32, weight: f64, share: f64) {
        self.terms.push(Term {
            node,
            weight,
            share: weight * share,
        });
    }

    /// The terms that have been added since there were `first`, those of the same node as one: a node feels a row once. `levers`
    /// is where their levers begin, if they have any.
    pub fn merge_terms_since(&mut self, first: usize, levers: Option<u32>) -> Terms {
        let mut end = first;
        let behind = |i: usize| levers.map(|l| l as usize + i - first);
        for i in first..self.terms.len() {
            let term = self.terms[i];
            let lever = behind(i).map(|i| self.levers[i]);
            let known = self.terms[first..end]
                .iter()
                .position(|t| t.node == term.node);
            let to = known.map_or(end, |k| first + k);
            if known.is_some() {
                self.terms[to].weight += term.weight;
                self.terms[to].share += term.share;
            } else {
                self.terms[to] = term;
                end += 1;
            }
            if let (Some(to), Some(lever)) = (behind(to), lever) {
                let kept = known.map_or(DVec3::ZERO, |_| self.levers[to]);
                self.levers[to] = kept + lever;
            }
        }
        self.terms.truncate(end);
        self.levers
            .truncate(behind(end).unwrap_or(self.levers.len()));
        self.terms_since(first)
    }

    /// Adds the terms of a row: row nodes, weights, and what each takes of the impulse.
    pub fn add_terms(&mut self, terms: impl IntoIterator<Item = Term>) -> Terms {
        let first = self.terms.len();
        self.terms.extend(terms);
        self.terms_since(first)
    }

    /// The terms that have been added since there were `first`.
    pub fn terms_since(&self, first: usize) -> Terms {
        Terms {
            first: first as u32,
            count: (self.terms.len() - first) as u32,
        }
    }

    /// Where nodes can't be brought to a body because they are held, the body is brought to them, at `fastest` m/s at most.
    pub fn lead_to_held_nodes(&mut self, first: usize, fastest: f64) {
        for i in first..self.ties.len() {
            let terms = self.terms_of(self.ties[i].terms).iter();
            let held = terms.map(|t| &self.nodes[t.node as usize]);
            if held.into_iter().all(|n| n.inv_mass == 0.0) {
                let tie = &mut self.ties[i];
                tie.bias -= (tie.error * LEAD_RATE).clamp_length_max(fastest);
            }
        }
    }

    /// Whether a contact of nodes has to stop more than `limit` m/s in a substep of h s.
    pub fn contacts_stop(&self, shadows: &[Shadow], h: f64, limit: f64) -> bool {
        self.contacts.iter().any(|row| {
            // Levers change nothing along the normal.
            let relative = self.relative(row.terms, &shadows[row.shadow as usize], row.arm);
            allowed_velocity(row.depth, h) - relative.dot(row.normal) > limit
        })
    }

    /// Whether a contact of shadows has to stop more than that, or a tie that is not soft.
    pub fn others_stop(&self, shadows: &[Shadow], h: f64, limit: f64) -> bool {
        let mut ties = self.ties.iter().filter(|tie| tie.softness == 0.0);
        let mut rigid = self.rigid.iter();
        ties.any(|t| {
            let relative = self.relative(t.terms, &shadows[t.shadow as usize], t.arm);
            (relative - t.bias).length_squared() > limit * limit
        }) || rigid.any(|row| row.closing(shadows, h) > limit)
    }

    /// The velocity of a point relative to that of a shadow there \[m/s\].
    #[inline(always)]
    fn relative(&self, terms: Terms, shadow: &Shadow, arm: DVec3) -> DVec3 {
        points::velocity(&self.nodes, self.terms_of(terms)) - shadow.velocity_at(arm)
    }

    /// Body, node and weight of each term of a contact.
    pub fn weights_of(&self, row: &Row) -> impl Iterator<Item = (u32, u32, f64)> {
        self.terms_of(row.terms).iter().map(|t| {
            let node = &self.nodes[t.node as usize];
            (node.body, node.node, t.weight)
        })
    }

    /// The shadows that hold all nodes of contacts which are more than `depth` m deep, each with the shadow that they are in.
    pub fn held_deep(&self, depth: f64) -> impl Iterator<Item = [u32; 2]> {
        let deep = move |row: &&Row| row.depth > depth && row.softness == 0.0 && !row.between;
        let rows = self.contacts.iter().filter(deep);
        rows.filter_map(|row| {
            let mut holders = self.terms_of(row.terms).iter().map(|t| self.holder(t.node));
            let first = holders.next()??;
            holders.all(|h| h.is_some()).then_some([first, row.shadow])
        })
    }

    /// The shadow that a node is tied to, if it is.
    fn holder(&self, node: u32) -> Option<u32> {
        let holds = |tie: &&Tie| {
            let mut terms = self.terms_of(tie.terms).iter();
            tie.softness == 0.0 && !tie.between && terms.any(|t| t.node == node)
        };
        Some(self.ties.iter().find(holds)?.shadow)
    }

    /// The levers of a row's terms, if it has any.
    pub fn levers_of(&self, row: &Row) -> Option<&[DVec3]> {
        points::levers(&self.levers, row)
    }

    /// What each node of a row takes of an impulse \[N·s\].
    pub fn parts(&self, row: &Row, impulse: DVec3) -> impl Iterator<Item = (&Term, DVec3)> {
        let terms = self.terms_of(row.terms).iter().enumerate();
        let (levers, normal) = (self.levers_of(row), row.normal);
        terms.map(move |(k, term)| {
            let couple = levers.map_or(DVec3::ZERO, |l| normal * l[k].dot(impulse));
            (term, impulse * term.share + couple)
        })
    }

    /// The terms of a row.
    #[inline(always)]
    pub fn terms_of(&self, terms: Terms) -> &[Term] {
        &self.terms[terms.range()]
    }
}

#[cfg(test)]
mod tests;
