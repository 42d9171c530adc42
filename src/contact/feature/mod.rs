//! Contact of faces and edges with what no node meets.
//!
//! A box smaller than the spacing of the nodes, a pole between two of them, the corner of a crate on a soft block, the ridge of
//! a roof: there the points that touch are inside faces and edges, and a row acts on their nodes by barycentric weights.
//! Points of the target against faces and edges of the deformable against the target are all there is besides node against
//! target. A target that shows the body nothing but a flat face, like a floor, costs one test of a box, and what is far from
//! edges is not looked at until it has moved.

mod bulge;
mod convex;
mod convex_edges;
mod convex_faces;
mod internal;
mod making;
mod meet;
mod part;
mod patch;
mod recall;
#[cfg(feature = "serde-serialize")]
mod saved;
mod sharp;

use super::form::Form;
use super::nodes::Nodes;
use super::site::{Side, Site};
use super::soup::Overhang;
use super::target::{Frame, Target};
use crate::solve::rows::Rows;
use convex::ConvexFeatures;
pub use making::BORDER;
#[cfg(feature = "serde-serialize")]
pub use saved::Saved;
use sharp::SharpFeatures;

/// Faces and edges of one body near one target.
#[derive(Clone, Debug)]
pub enum Features {
    /// Near the convex parts of a solid.
    Convex(Box<ConvexFeatures>),
    /// Near the corners and edges of a surface, or of voxels.
    Sharp(Box<SharpFeatures>),
}

impl Features {
    /// The features of a form that a body with this spacing \[m\] needs; `None` if it needs none.
    pub fn of(form: &Form, spacing: f64) -> Option<Self> {
        match form {
            Form::Solid(solid) if !solid.is_voxels() => {
                ConvexFeatures::of(solid, spacing).map(|f| Self::Convex(Box::new(f)))
            }
            _ => Some(Self::Sharp(Box::default())),
        }
    }

    /// Whether all of the target has rows of faces and edges, or some part of it is so round that nodes alone touch it.
    pub fn cover_all(&self) -> bool {
        match self {
            Self::Convex(features) => features.all_parts,
            Self::Sharp(_) => true,
        }
    }

    /// Forgets what touches and all distances.
    pub fn forget(&mut self) {
        match self {
            Self::Convex(features) => features.forget(),
            Self::Sharp(features) => features.forget(),
        }
    }

    /// Has all be looked for in the next substep, as after anything that is not motion.
    pub fn look_anew(&mut self) {
        if let Self::Convex(features) = self {
            features.look_anew();
        }
    }

    /// Remembers what touches, after the rows have been solved.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        match self {
            Self::Convex(features) => features.remember(rows, touching),
            Self::Sharp(features) => features.remember(rows, touching),
        }
    }

    /// Puts into `out` the edges of the body that touched borders of a surface, as each of their nodes has them, by node.
    pub fn overhangs(&self, side: &Side, frame: &Frame, out: &mut Vec<Overhang>) {
        if let Self::Sharp(features) = self {
            features.overhangs(side, frame, out);
        }
    }

    /// Adds the rows of faces and edges, which may depend on those of `nodes`; `way` is how far body and collider have moved in all \[m\].
    pub fn add_rows(
        &mut self,
        (target, pair, nodes): (&Target, u32, &Nodes),
        collider: &Frame,
        site: &mut Site,
        way: f64,
    ) {
        match self {
            Self::Convex(features) => features.add_rows(target, pair, collider, site, way),
            Self::Sharp(features) => {
                features.add_rows((target, pair, nodes), collider, site, way);
            }
        }
    }
}
