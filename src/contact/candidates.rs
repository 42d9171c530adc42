//! Candidates: nodes, faces and edges of a body that can reach a target.
//!
//! How far each was from the target when it was last looked at tells when it must be looked at again, so that a substep
//! looks only at what is near the surface, and at rest only at what touches. All nodes count, inner ones too: in a
//! crumpled body an inner node may well be the one that meets the wall. What is known outlives the step: what a node
//! touched last tells on which side of a thin plate it belongs, and where friction took hold of it.

#[cfg(feature = "serde-serialize")]
mod saved;

#[cfg(feature = "serde-serialize")]
pub use saved::{Saved, fingerprint};

use super::feature::Features;
use super::form::address;
use super::nodes::Nodes;
use super::site::Site;
use super::target::{Frame, Target};
use crate::body::state::State;
use crate::math::{DVec3, Real};
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
    /// The collider's frame when it was last looked at.
    frame: Option<Frame>,
    /// How far body and collider have moved in all, or more \[m\].
    way: f64,
    /// How often the nodes had been moved from outside by then.
    edits: u64,
    /// Of the body \[m\].
    spacing: f64,
}

impl Candidates {
    /// Lists to be filled at first use, for a body of this spacing \[m\].
    pub fn new(target: Target, pair: u32, spacing: f64) -> Self {
        Self {
            features: Features::of(&target.form, spacing),
            target,
            pair,
            nodes: Nodes::default(),
            frame: None,
            way: 0.0,
            edits: 0,
            spacing,
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
            self.way += moved + shifted;
            self.nodes.spend(moved + shifted);
        } else {
            self.forget();
            if !alike {
                self.features = Features::of(&target.form, self.spacing);
            }
        }
        self.frame = Some(now);
        self.target = target;
        self.pair = pair;
        self.look_anew();
    }

    /// Has all be looked for in the next substep, as after anything that is not motion.
    pub fn look_anew(&mut self) {
        if let Some(features) = &mut self.features {
            features.look_anew();
        }
    }

    /// Forgets what touches and how far off things are.
    pub fn forget(&mut self) {
        self.way = 0.0;
        self.nodes.reset();
        if let Some(features) = &mut self.features {
            features.forget();
        }
    }

    /// Takes in that the collider has moved to where its shadow stands.
    pub fn follow(&mut self, shadow: &Shadow) {
        let now = self.target.frame(shadow);
        if let Some(last) = self.frame.replace(now) {
            self.way += last.distance(&now, self.target.extent);
        }
    }

    /// The collider's frame when it was last followed.
    pub fn frame(&self) -> Option<&Frame> {
        self.frame.as_ref()
    }

    /// The normal with which a node touched a solid last, in the collider's frame.
    pub fn touched(&self, node: u32) -> Option<DVec3> {
        self.nodes.touched(node)
    }

    /// Puts the lists by for the next step.
    pub fn pause(&mut self, shadow: &Shadow, edits: u64) {
        self.follow(shadow);
        self.edits = edits;
    }

    /// Adds the rows of this substep to those of the group, once it has followed the collider. In the last one nodes moved by up to
    /// `moved` m, in this one nodes and collider may come nearer by `closing` m. Whatever lies within `near` m stays in the lists of soups.
    pub fn find_rows(&mut self, mut site: Site, moved: f64, closing: f64, near: f64) {
        let frame = self.frame.unwrap_or_else(|| self.target.frame(site.shadow));
        self.way += moved;
        let farthest = site.reach.farthest.max(near);
        self.nodes
            .refresh(&self.target, site.side.state, &frame, closing, farthest);
        let on_edges = self.features.as_ref();
        let nodes = (&self.target, self.pair, on_edges);
        self.nodes.add_rows(nodes, &frame, &mut site, self.way);
        if let Some(features) = &mut self.features {
            let nodes = (&self.target, self.pair, &self.nodes);
            features.add_rows(nodes, &frame, &mut site, self.way);
        }
    }

    /// Remembers which nodes touch, after the rows have been solved.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        self.nodes.remember(rows, touching);
        if let Some(features) = &mut self.features {
            features.remember(rows, touching);
        }
    }

    /// Whether any node lies within `distance` m of the target, after the nodes moved by up to `moved` m in the last
    /// substep.
    pub fn any_within(
        &self,
        state: &State<Real>,
        shadow: &Shadow,
        moved: f64,
        distance: f64,
    ) -> bool {
        let frame = self.target.frame(shadow);
        let last = self.frame.unwrap_or(frame);
        let way = self.way + moved + last.distance(&frame, self.target.extent);
        self.nodes
            .any_within(&self.target, state, (&frame, way), distance)
    }
}
