//! Candidate nodes: those that can reach a target before the list is made again.
//!
//! A list holds the nodes within a margin of the target. It stays valid while the fastest node and the target together
//! have moved by less than the margin, so that most substeps look only at nodes near a surface, and a body at rest makes
//! no list for seconds. All nodes count, inner ones too: in a crumpled body an inner node may well be the one that meets
//! the wall. Lists outlive the step: what a node touched last tells on which side of a thin plate it belongs, and where
//! friction took hold of it.

use super::target::{Frame, Target};
use crate::body::state::State;
use crate::law::row::softness;
use crate::math::{DVec3, Real};
use crate::solve::rows::{Row, RowNode, Rows, Term};
use crate::solve::shadow::Shadow;

/// The nodes of one body near one target.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// The target.
    pub target: Target,
    /// Which body–collider pair this is in the group.
    pub pair: u32,
    /// Nodes in ascending order.
    nodes: Vec<u32>,
    /// How far things may still move before the list is stale \[m\].
    budget: f64,
    /// Nodes that touch, in ascending order, and those of the substep that is under way.
    touches: Vec<Touch>,
    next: Vec<Touch>,
    /// The first of the rows of this substep.
    first_row: usize,
    /// The collider's frame when the list was put by.
    frame: Option<Frame>,
    /// How often the nodes had been moved from outside by then.
    edits: u64,
}

/// What is remembered of a node that touches, in the collider's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Touch {
    node: u32,
    normal: DVec3,
    /// Where friction holds it \[m\]; `None` while it slides.
    anchor: Option<DVec3>,
}

impl Candidates {
    /// A list to be filled at first use.
    pub fn new(target: Target, pair: u32) -> Self {
        Self {
            target,
            pair,
            nodes: Vec::new(),
            budget: -1.0,
            touches: Vec::new(),
            next: Vec::new(),
            first_row: 0,
            frame: None,
            edits: 0,
        }
    }

    /// A list of the last step goes on in this one. What was done to body and collider in between uses up its budget; after
    /// a teleport, of more than `far` m, or a change of shape, nothing is remembered.
    pub fn resume(&mut self, target: Target, pair: u32, shadow: &Shadow, edits: u64, far: f64) {
        let now = target.frame(shadow);
        let same = self.target.shape == target.shape && self.edits == edits;
        let moved = match self.frame {
            Some(frame) if same => frame.distance(&now, target.extent),
            _ => f64::INFINITY,
        };
        if moved <= far {
            self.budget -= moved;
        } else {
            self.budget = -1.0;
            self.touches.clear();
        }
        self.target = target;
        self.pair = pair;
    }

    /// Puts the list by for the next step.
    pub fn pause(&mut self, shadow: &Shadow, edits: u64) {
        self.frame = Some(self.target.frame(shadow));
        self.edits = edits;
    }

    /// Makes the list anew if, after `moved` m since the last look, it might lack a node that can get a row in the coming
    /// substep, which is any within `farthest` m. A list should last for a hundred substeps or so: the faster things move,
    /// the wider it is.
    pub fn refresh(&mut self, state: &State<Real>, shadow: &Shadow, moved: f64, farthest: f64) {
        self.budget -= moved;
        if self.budget >= farthest {
            return;
        }
        let margin = 4.0 * farthest + 100.0 * moved;
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
        &mut self,
        body: u32,
        state: &State<Real>,
        shadow: &Shadow,
        slots: &mut [u32],
        rows: &mut Rows,
        reach: Reach,
    ) {
        self.first_row = rows.contacts.len();
        self.next.clear();
        let frame = self.target.frame(shadow);
        let shift = state.origin - frame.position;
        let mut known = self.touches.iter().peekable();
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
            while known.next_if(|t| t.node < i).is_some() {}
            let touch = known.next_if(|t| t.node == i);
            let place = frame.axes.transpose() * relative;
            let drift = touch
                .and_then(|t| t.anchor)
                .map_or(DVec3::ZERO, |anchor| frame.axes * (place - anchor));
            let node = slot(body, i, state, slots, rows);
            let terms = rows.add_terms([Term {
                node,
                weight: 1.0,
                share: self.target.node_share,
            }]);
            rows.contacts.push(Row {
                terms,
                shadow: self.target.shadow,
                pair: self.pair,
                between: false,
                normal,
                depth,
                arm,
                rigid_share: self.target.rigid_share,
                friction: self.target.friction,
                softness: self
                    .target
                    .stiffness
                    .map_or(0.0, |k| softness(k, 0.0, reach.h)),
                drift: drift - normal * drift.dot(normal),
                carried: 0.0,
                normal_impulse: 0.0,
                friction_impulse: DVec3::ZERO,
                mass: 0.0,
            });
            self.next.push(Touch {
                node: i,
                normal: frame.axes.transpose() * normal,
                anchor: Some(touch.and_then(|t| t.anchor).unwrap_or(place)),
            });
        }
    }

    /// Remembers which nodes touch, after the rows have been solved. Friction keeps its hold on a node that sticks, or that
    /// leaves the surface by less than `touching` m; one that slides takes its anchor along.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        let solved = &rows.contacts[self.first_row..];
        self.touches.clear();
        for (touch, row) in self.next.iter().zip(solved) {
            let pressed = row.normal_impulse > 0.0;
            if !pressed && row.depth < -touching {
                continue;
            }
            self.touches.push(Touch {
                anchor: touch.anchor.filter(|_| !pressed || row.sticks()),
                ..*touch
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
