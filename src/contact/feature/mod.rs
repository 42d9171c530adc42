//! Contacts that nodes cannot see: a corner or a curved part of a rigid solid within a face, an edge of it across an edge of
//! the deformable.
//!
//! A box smaller than the spacing of the nodes, a pole between two of them, the corner of a crate on a soft block: there the
//! points that touch are inside faces and edges, and a row acts on their nodes by barycentric weights. Points of the solid
//! against faces and edges of the deformable against the solid, which is convex or a union of convex parts, are all there
//! is besides node against solid. A solid that shows the body nothing but a flat face, like a floor, costs one test of a
//! box.

mod making;
mod patch;

use super::distance::Solid;
use super::site::{Side, Site};
use super::target::{Frame, Target};
use super::touches::Touches;
use crate::body::topology::{Face, Topology};
use crate::math::{DMat3, DQuat, DVec3};
use crate::solve::rows::Rows;
use making::{Making, Met};

/// A convex part rounder than this many spacings needs no feature contacts: an edge dips into it by a fiftieth of its length.
const ROUND: f64 = 6.0;

/// Faces and edges of one body near the convex parts of one target.
#[derive(Clone, Debug)]
pub struct Features {
    parts: Vec<Part>,
    /// Part and face.
    faces: Vec<(u32, u32)>,
    /// Part and edge.
    edges: Vec<(u32, u32)>,
    /// How far things may still move before the lists are stale \[m\].
    budget: f64,
    points: Vec<DVec3>,
    met: Vec<Met>,
    on_faces: Touches,
    on_edges: Touches,
}

/// A convex part in the collider's frame.
#[derive(Clone, Debug)]
struct Part {
    offset: DVec3,
    turn: DQuat,
    solid: Solid,
    /// Centre of its box, in its own frame.
    centre: DVec3,
}

impl Part {
    fn frame(&self, collider: &Frame) -> Frame {
        Frame {
            position: collider.position + collider.axes * self.offset,
            axes: collider.axes * DMat3::from_quat(self.turn),
        }
    }

    /// A box of the collider's frame, wider by `margin` m, in its own.
    fn bounds(&self, (lo, hi): (DVec3, DVec3), margin: f64) -> (DVec3, DVec3) {
        let axes = DMat3::from_quat(self.turn).transpose();
        let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        let middle = axes * (middle - self.offset);
        let half = axes.x_axis.abs() * half.x
            + axes.y_axis.abs() * half.y
            + axes.z_axis.abs() * half.z
            + margin;
        (middle - half, middle + half)
    }
}

impl Features {
    /// The features of a solid that a body with this spacing \[m\] needs; `None` if all its parts are too round to need any.
    pub fn of(solid: &Solid, spacing: f64) -> Option<Self> {
        let mut parts = Vec::new();
        solid.for_each_convex(&mut |offset, turn, part| {
            let (lo, hi) = part.bounds();
            if (hi - lo).is_finite() && part.edge_radius() < ROUND * spacing {
                parts.push(Part {
                    offset,
                    turn,
                    solid: part.clone(),
                    centre: 0.5 * (lo + hi),
                });
            }
        });
        (!parts.is_empty()).then_some(Self {
            parts,
            faces: Vec::new(),
            edges: Vec::new(),
            budget: -1.0,
            points: Vec::new(),
            met: Vec::new(),
            on_faces: Touches::default(),
            on_edges: Touches::default(),
        })
    }

    /// Uses up the budget by what has moved \[m\] besides the substeps.
    pub fn spend(&mut self, moved: f64) {
        self.budget -= moved;
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

    /// Makes the lists anew when they might lack something within `farthest` m; see `Candidates::refresh`.
    pub fn refresh(&mut self, side: Side, collider: &Frame, moved: f64, farthest: f64) {
        self.budget -= moved;
        if self.budget >= farthest {
            return;
        }
        let margin = 4.0 * farthest + 100.0 * moved;
        self.budget = margin;
        self.faces.clear();
        self.edges.clear();
        let Topology { faces, edges, .. } = side.topology;
        let body = bounds(side, collider);
        for (p, part) in (0..).zip(&self.parts) {
            let (lo, hi) = part.bounds(body, margin);
            if !part.solid.has_edges_in(lo, hi) {
                continue;
            }
            let frame = part.frame(collider);
            let local = |node: u32| frame.to_local(side.state, node);
            let near =
                |middle: DVec3, radius: f64| part.solid.signed_distance(middle).0 < radius + margin;
            let face = |face: &Face| {
                let nodes = face.nodes();
                let sum: DVec3 = nodes.iter().map(|&i| local(i)).sum();
                let middle = sum / nodes.len() as f64;
                let radius = nodes.iter().map(|&i| local(i).distance(middle));
                near(middle, radius.fold(0.0, f64::max))
            };
            let edge = |nodes: &[u32; 2]| {
                let [a, b] = nodes.map(local);
                near(0.5 * (a + b), 0.5 * (a - b).length())
            };
            let chosen = (0..).zip(faces).filter(|(_, nodes)| face(nodes));
            self.faces.extend(chosen.map(|(f, _)| (p, f)));
            let chosen = (0..).zip(edges).filter(|(_, nodes)| edge(nodes));
            self.edges.extend(chosen.map(|(e, _)| (p, e)));
        }
    }

    /// Adds the rows of faces and edges.
    pub fn add_rows(&mut self, target: &Target, pair: u32, collider: &Frame, site: &mut Site) {
        self.on_faces.begin();
        for faces in self.faces.chunk_by(|a, b| a.0 == b.0) {
            let p = faces[0].0;
            let part = &self.parts[p as usize];
            let mut making = Making {
                target,
                pair,
                part,
                frame: part.frame(collider),
                site,
                touches: &mut self.on_faces,
            };
            self.met.clear();
            for &(_, f) in faces {
                making.meet(f, &mut self.points, &mut self.met);
            }
            self.met.sort_unstable_by_key(|m| (m.point, m.face));
            for met in self.met.chunk_by(|a, b| a.point == b.point) {
                making.point(p, met);
            }
        }
        self.on_edges.begin();
        for &(p, e) in &self.edges {
            let part = &self.parts[p as usize];
            Making {
                target,
                pair,
                part,
                frame: part.frame(collider),
                site,
                touches: &mut self.on_edges,
            }
            .edge(p, e);
        }
    }
}

/// The box of a body in a frame \[m\].
fn bounds(side: Side, frame: &Frame) -> (DVec3, DVec3) {
    (0..side.state.particles.len() as u32)
        .map(|node| frame.to_local(side.state, node))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), x| {
            (lo.min(x), hi.max(x))
        })
}
