//! Candidates as a snapshot has them: what is remembered of a pair, without the shape, which Rapier's colliders have.

use super::Candidates;
use crate::contact::feature;
use crate::contact::nodes::Nodes;
use crate::contact::target::{Frame, Target};
use crate::math::Fnv;
use rapier3d::geometry::SharedShape;

/// What is remembered of a body near a target.
#[derive(serde::Serialize, serde::Deserialize)]
pub struct Saved {
    /// What tells the target's shape from another.
    shape: u64,
    nodes: Nodes,
    features: Option<feature::Saved>,
    frame: Option<Frame>,
    way: f64,
    edits: u64,
}

impl Candidates {
    /// What is to be saved; `None` for a shape that Rapier can't save.
    pub fn save(&self) -> Option<Saved> {
        Some(Saved {
            shape: fingerprint(&self.target.shape)?,
            nodes: self.nodes.clone(),
            features: self.features.as_ref().map(|f| f.save()),
            frame: self.frame,
            way: self.way,
            edits: self.edits,
        })
    }

    /// What was saved of a body of this spacing \[m\]; `None` where the target has got another shape.
    pub fn restore(saved: Saved, target: Target, spacing: f64) -> Option<Self> {
        if fingerprint(&target.shape) != Some(saved.shape) {
            return None;
        }
        let mut candidates = Self::new(target, 0, spacing);
        match (&mut candidates.features, saved.features) {
            (Some(features), Some(saved)) => features.restore(saved)?,
            (None, None) => {}
            _ => return None,
        }
        Some(Self {
            nodes: saved.nodes,
            frame: saved.frame,
            way: saved.way,
            edits: saved.edits,
            ..candidates
        })
    }
}

/// Hash of a shape as it is saved; `None` for one that Rapier can't save.
pub fn fingerprint(shape: &SharedShape) -> Option<u64> {
    let hash = postcard::to_extend(shape, Fnv::new());
    hash.ok().map(Fnv::finish)
}
