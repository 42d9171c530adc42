//! Candidate nodes: those that can reach a target before the list is made again.
//!
//! A list holds the nodes within a margin of the target. It stays valid while the fastest node and the target together
//! have moved by less than the margin, so that most substeps look only at nodes near a surface. All nodes count, inner
//! ones too: in a crumpled body an inner node may well be the one that meets the wall.

use super::target::{Frame, Target};
use crate::body::state::State;
use crate::math::{DVec3, Real};
use crate::solve::rows::{Row, RowNode, Rows};
use crate::solve::shadow::Shadow;

/// The nodes of one body near one target.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// The target.
    pub target: Target,
    /// Which body–collider pair this is in the group.
    pub pair: u32,
    /// Nodes in ascending order.
    pub nodes: Vec<u32>,
    /// How far things may still move before the list is stale \[m\].
    budget: f64,
}

impl Candidates {
    /// A list to be filled at first use.
    pub fn new(target: Target, pair: u32) -> Self {
        Self {
            target,
            pair,
            nodes: Vec::new(),
            budget: -1.0,
        }
    }

    /// Makes the list anew if, after `moved` m since the last look, it might lack a node that can get a row in the coming
    /// substep, which is any within `farthest` m.
    pub fn refresh(
        &mut self,
        state: &State<Real>,
        shadow: &Shadow,
        moved: f64,
        margin: f64,
        farthest: f64,
    ) {
        self.budget -= moved;
        if self.budget >= farthest {
            return;
        }
        let margin = margin.max(4.0 * farthest);
        self.budget = margin;
        let frame = self.target.frame(shadow);
        let shift = state.origin - frame.position;
        let target = &self.target;
        self.nodes.clear();
        self.nodes.extend(
            (0..state.particles.len() as u32)
                .filter(|&i| target.depth(&frame, state.local(i as usize) + shift).0 > -margin),
        );
    }

    /// Adds a row for every candidate that can touch within h s. `slots` maps nodes to row nodes (`u32::MAX`: none yet).
    pub fn add_rows(
        &self,
        body: u32,
        state: &State<Real>,
        shadow: &Shadow,
        slots: &mut [u32],
        rows: &mut Rows,
        reach: Reach,
    ) {
        let frame = self.target.frame(shadow);
        let shift = state.origin - frame.position;
        for &i in &self.nodes {
            let node = i as usize;
            let relative = state.local(node) + shift;
            let (depth, normal) = self.target.depth(&frame, relative);
            // A bound first: most candidates are farther off than anything can go in a substep.
            if depth < -reach.farthest {
                continue;
            }
            let arm = relative + (frame.position - shadow.com);
            let v = state.velocity(node);
            let closing = (v - shadow.velocity_at(arm)).length();
            if depth < -(reach.touching + 2.0 * reach.h * closing + reach.slack) {
                continue;
            }
            let node = slot(body, i, state, slots, rows);
            rows.contacts.push(Row {
                node,
                shadow: self.target.shadow,
                pair: self.pair,
                normal,
                depth,
                arm,
                friction: self.target.friction,
                normal_impulse: 0.0,
                friction_impulse: DVec3::ZERO,
                mass: 0.0,
            });
        }
    }

    /// Whether any candidate lies within `distance` m of the target.
    pub fn any_within(&self, state: &State<Real>, shadow: &Shadow, distance: f64) -> bool {
        let frame: Frame = self.target.frame(shadow);
        let shift = state.origin - frame.position;
        self.nodes
            .iter()
            .any(|&i| self.target.depth(&frame, state.local(i as usize) + shift).0 > -distance)
    }
}

/// How far a node may be from a surface and still get a row.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Substep \[s\].
    pub h: f64,
    /// Distance that counts as touching \[m\].
    pub touching: f64,
    /// What the fastest node and the target can do in a substep \[m\].
    pub farthest: f64,
    /// What forces can add to that within a substep \[m\].
    pub slack: f64,
}

/// The row node of node `i`, made if it has none yet.
pub fn slot(body: u32, i: u32, state: &State<Real>, slots: &mut [u32], rows: &mut Rows) -> u32 {
    let slot = &mut slots[i as usize];
    if *slot == u32::MAX {
        *slot = rows.nodes.len() as u32;
        let v = state.velocity(i as usize);
        rows.nodes.push(RowNode {
            body,
            node: i,
            inv_mass: state.particles[i as usize].inv_mass.into(),
            v,
            free: v,
            before: v,
        });
    }
    *slot
}
