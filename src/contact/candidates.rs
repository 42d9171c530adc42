//! Candidate nodes: those that can reach a target before the list is made again.
//!
//! A list holds the nodes within a margin of the target. It stays valid while the fastest node and the target together
//! have moved by less than the margin, so that most substeps look only at nodes near a surface, and a body at rest makes
//! no list for seconds. All nodes count, inner ones too: in a crumpled body an inner node may well be the one that meets
//! the wall. Lists outlive the step: what a node touched last tells on which side of a thin plate it belongs, and where
//! friction took hold of it.

use super::feature::Features;
use super::form::{Form, address};
use super::nodes::Nodes;
use super::site::Site;
use super::target::{Frame, Target};
use crate::body::state::State;
use crate::math::Real;
use crate::solve::rows::Rows;
use crate::solve::shadow::Shadow;

/// The nodes of one body near one target.
#[derive(Clone, Debug)]
pub struct Candidates {
    /// The target.
    pub target: Target,
    /// Which body–collider pair this is in the group.
    pub pair: u32,
    nodes: Nodes,
    /// Faces and edges near the target's corners, edges and curved parts.
    features: Option<Features>,
    /// The collider's frame when the list was put by.
    frame: Option<Frame>,
    /// How often the nodes had been moved from outside by then.
    edits: u64,
}

impl Candidates {
    /// Lists to be filled at first use, for a body of this spacing \[m\].
    pub fn new(target: Target, pair: u32, spacing: f64) -> Self {
        Self {
            features: match &target.form {
                Form::Solid(solid) => Features::of(solid, spacing),
                Form::Soup(_) => None,
            },
            target,
            pair,
            nodes: Nodes::default(),
            frame: None,
            edits: 0,
        }
    }

    /// A list of the last step goes on in this one. What was done to body and collider in between, the former by `shifted` m,
    /// uses up its budget; after a teleport, of more than `far` m, or a change of shape, nothing is remembered.
    pub fn resume(
        &mut self,
        target: Target,
        pair: u32,
        shadow: &Shadow,
        (edits, shifted): (u64, f64),
        far: f64,
    ) {
        let now = target.frame(shadow);
        let alike = address(&self.target.shape) == address(&target.shape)
            || self.target.form == target.form;
        let same = alike && self.edits == edits;
        let moved = match self.frame {
            Some(frame) if same => frame.distance(&now, target.extent),
            _ => f64::INFINITY,
        };
        if moved <= far {
            self.spend(moved + shifted);
        } else {
            self.spend(f64::INFINITY);
            self.nodes.forget();
            if let Some(features) = &mut self.features {
                features.forget();
            }
        }
        self.target = target;
        self.pair = pair;
    }

    fn spend(&mut self, moved: f64) {
        self.nodes.spend(moved);
        if let Some(features) = &mut self.features {
            features.spend(moved);
        }
    }

    /// Puts the list by for the next step.
    pub fn pause(&mut self, shadow: &Shadow, edits: u64) {
        self.frame = Some(self.target.frame(shadow));
        self.edits = edits;
    }

    /// Adds the rows of this substep to those of the group, after things have moved by `moved` m at most since the last.
    /// Whatever lies within `near` m stays in the lists.
    pub fn find_rows(&mut self, mut site: Site, moved: f64, near: f64) {
        let farthest = site.reach.farthest.max(near);
        let frame = self.target.frame(site.shadow);
        self.nodes
            .refresh(&self.target, site.side.state, &frame, moved, farthest);
        self.nodes
            .add_rows(&self.target, self.pair, &frame, &mut site);
        if let Some(features) = &mut self.features {
            features.refresh(site.side, &frame, moved, farthest);
            features.add_rows(&self.target, self.pair, &frame, &mut site);
        }
    }

    /// Remembers which nodes touch, after the rows have been solved.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        self.nodes.remember(rows, touching);
        if let Some(features) = &mut self.features {
            features.remember(rows, touching);
        }
    }

    /// Whether any candidate lies within `distance` m of the target.
    pub fn any_within(&self, state: &State<Real>, shadow: &Shadow, distance: f64) -> bool {
        let frame = self.target.frame(shadow);
        self.nodes.any_within(&self.target, state, &frame, distance)
    }
}
