//! Encounters: contact of two deformables.
//!
//! Nodes of each against faces of the other, and edges against edges. An encounter keeps lists of what is near, in order,
//! under a motion budget as [`super::candidates`] does: they outlive substeps and steps, so that things at rest on each
//! other look at nothing else. It also keeps what touched: sides, and where friction took hold.
//!
//! Bodies must be found to be near each other first; an encounter of a body with itself would differ only in leaving out
//! what hangs together.

pub mod edge;
mod levers;
pub mod manners;
mod near;
pub mod node;
pub mod outline;
pub mod posed;
pub mod rows;
pub mod search;
pub mod touch;

use crate::solve::rows::Rows;
use edge::Kind;
use manners::Manners;
use near::Near;
use touch::Touches;

/// Two deformables that may touch.
#[derive(Clone, Debug)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Encounter {
    /// Indices of the bodies within their group, in ascending order.
    pub members: [u32; 2],
    /// Which pair of deformables this is in the group, seen from the first; the next one is the same seen from the second.
    pub pair: u32,
    /// How they treat each other.
    pub manners: Manners,
    /// Nodes of each that are attached to the other: these do not touch it.
    pub attached: [Vec<u32>; 2],
    /// Nodes of each near elements of the other, sorted.
    nodes: [Vec<Near>; 2],
    /// Edges of the first near edges of the second, sorted.
    edges: Vec<Near>,
    /// How far things may still move before the lists are stale \[m\].
    budget: f64,
    /// How far they have moved since the lists were made, or since a restart \[m\].
    #[cfg_attr(feature = "serde-serialize", serde(skip))]
    way: f64,
    node_touches: [Touches; 2],
    edge_touches: Touches,
    /// Kinds of the edges of the second that have been asked for in a substep.
    #[cfg_attr(feature = "serde-serialize", serde(skip))]
    kinds: Vec<Option<Kind>>,
    /// How much farther inside than the way of a substep something can be that did not touch \[m\]: what was done to the
    /// bodies since the last substep, without bound while nothing is known of them.
    unseen: f64,
    /// How often the nodes of each had been moved from outside when the lists were put by.
    edits: [u64; 2],
}

impl Encounter {
    /// Lists to be filled at first use.
    pub fn new(members: [u32; 2], pair: u32, manners: Manners) -> Self {
        Self {
            members,
            pair,
            manners,
            attached: Default::default(),
            nodes: Default::default(),
            edges: Vec::new(),
            budget: -1.0,
            way: 0.0,
            node_touches: Default::default(),
            edge_touches: Touches::default(),
            kinds: Vec::new(),
            unseen: f64::MAX,
            edits: [0; 2],
        }
    }

    /// Goes on in this step, after the two sides were shifted by `shifted` m against each other. After nodes were moved from
    /// outside, nothing is remembered.
    pub fn resume(
        &mut self,
        members: [u32; 2],
        pair: u32,
        manners: Manners,
        (edits, shifted): ([u64; 2], f64),
    ) {
        self.budget -= shifted;
        self.way += shifted;
        self.unseen += shifted;
        if self.edits != edits {
            self.forget();
        }
        if self.manners.distance() != manners.distance() {
            self.budget = -1.0;
        }
        (self.members, self.pair, self.manners) = (members, pair, manners);
    }

    /// Forgets what touches and what is near.
    pub fn forget(&mut self) {
        self.node_touches.iter_mut().for_each(Touches::clear);
        self.edge_touches.clear();
        self.unseen = f64::MAX;
        self.budget = -1.0;
    }

    /// Puts the lists by for the next step.
    pub fn pause(&mut self, edits: [u64; 2]) {
        self.edits = edits;
    }

    /// What touches, sticks and slides, after the rows have been solved.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        let [a, b] = &mut self.node_touches;
        for touches in [a, b, &mut self.edge_touches] {
            touches.remember(rows, touching);
        }
        self.unseen = 0.0;
    }
}
