//! Contacts that nodes cannot see: a corner or a curved part of a rigid solid within a face, an edge of it across an edge of
//! the deformable.
//!
//! A box smaller than the spacing of the nodes, a pole between two of them, the corner of a crate on a soft block: there the
//! points that touch are inside faces and edges, and a row acts on their nodes by barycentric weights. Points of the solid
//! against faces and edges of the deformable against the solid, which is convex or a union of convex parts, are all there
//! is besides node against solid. A solid that shows the body nothing but a flat face, like a floor, costs one test of a
//! box, and what is far from edges is not looked at until it has moved.

mod making;
mod part;
mod patch;
#[cfg(feature = "serde-serialize")]
mod saved;

use super::distance::Solid;
use super::site::Site;
use super::target::{Frame, Target};
use super::touches::Touches;
use crate::math::DVec3;
use crate::solve::rows::Rows;
use making::{Making, Met};
use part::Part;
#[cfg(feature = "serde-serialize")]
pub use saved::Saved;

/// A convex part rounder than this many spacings needs no feature contacts: an edge dips into it by a fiftieth of its length.
const ROUND: f64 = 6.0;

/// Faces and edges of one body near the convex parts of one target.
#[derive(Clone, Debug)]
pub struct Features {
    parts: Vec<Part>,
    points: Vec<DVec3>,
    met: Vec<Met>,
    on_faces: Touches,
    on_edges: Touches,
}

impl Features {
    /// The features of a solid that a body with this spacing \[m\] needs; `None` if all its parts are too round to need any.
    pub fn of(solid: &Solid, spacing: f64) -> Option<Self> {
        let mut parts = Vec::new();
        solid.for_each_convex(&mut |offset, turn, part| {
            let (lo, hi) = part.bounds();
            if (hi - lo).is_finite() && part.edge_radius() < ROUND * spacing {
                parts.push(Part::new(offset, turn, part.clone()));
            }
        });
        (!parts.is_empty()).then_some(Self {
            parts,
            points: Vec::new(),
            met: Vec::new(),
            on_faces: Touches::default(),
            on_edges: Touches::default(),
        })
    }

    /// Forgets all distances.
    pub fn reset(&mut self) {
        self.parts.iter_mut().for_each(Part::reset);
    }

    /// Forgets what touches.
    pub fn forget(&mut self) {
        self.on_faces.forget();
        self.on_edges.forget();
    }

    /// Remembers what touches, after the rows have been solved.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        self.on_faces.end(rows, touching);
        self.on_edges.end(rows, touching);
    }

    /// Adds the rows of faces and edges; `way` is how far body and collider have moved in all \[m\].
    pub fn add_rows(
        &mut self,
        target: &Target,
        pair: u32,
        collider: &Frame,
        site: &mut Site,
        way: f64,
    ) {
        self.on_faces.begin();
        self.on_edges.begin();
        // Rows made points faster since the reach was found, at most as fast again.
        let near = target.skin + 2.0 * site.reach.farthest;
        let mut bounds = None;
        for part in &mut self.parts {
            let mut bounds = || *bounds.get_or_insert_with(|| site.side.bounds(collider));
            part.awake(&mut bounds, way, near);
        }
        for (p, part) in (0..)
            .zip(&mut self.parts)
            .filter(|(_, part)| part.is_awake())
        {
            let mut making = Making {
                target,
                pair,
                part: &part.convex,
                frame: part.convex.frame(collider),
                site,
                touches: &mut self.on_faces,
                near,
            };
            let count = making.site.side.topology.faces.len();
            let (points, met) = (&mut self.points, &mut self.met);
            let mut look = |making: &mut Making, met: &mut Vec<Met>| {
                met.clear();
                let reach = (making.near, near);
                part.faces
                    .visit(count, way, reach, |f| making.meet(p, f, points, met));
                met.sort_unstable_by_key(|m| (m.point, m.face));
            };
            look(&mut making, met);
            if making.misses_some(p, met) {
                // A point that was known may have come deep under another face.
                making.near = near.max(making.deepest_point());
                look(&mut making, met);
            }
            for met in met.chunk_by(|a, b| a.point == b.point) {
                making.point(p, met);
            }
        }
        for (p, part) in (0..)
            .zip(&mut self.parts)
            .filter(|(_, part)| part.is_awake())
        {
            let mut making = Making {
                target,
                pair,
                part: &part.convex,
                frame: part.convex.frame(collider),
                site,
                touches: &mut self.on_edges,
                near,
            };
            let count = making.site.side.topology.edges.len();
            let reach = (near, near);
            part.edges.visit(count, way, reach, |e| making.edge(p, e));
        }
    }
}
