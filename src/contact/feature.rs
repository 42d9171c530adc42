//! Contacts that nodes cannot see: a corner or a curved part of a rigid solid within a face, an edge of it across an edge of
//! the deformable.
//!
//! A box smaller than the spacing of the nodes, a pole between two of them, the corner of a crate on a soft block: there the
//! points that touch are inside faces and edges, and a row acts on their nodes by barycentric weights. Points of the solid
//! against faces and edges of the deformable against the solid, which is convex or a union of convex parts, are all there
//! is besides node against solid. A solid that shows the body nothing but a flat face, like a floor, costs one test of a
//! box.

use super::distance::Solid;
use super::site::{Side, Site, slot};
use super::target::{Frame, Target};
use super::touches::{Hold, Key, Touches, along};
use crate::body::topology::Topology;
use crate::math::{DMat3, DQuat, DVec3};
use crate::solve::rows::{Row, Rows, Term};

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
            let face = |nodes: &[u32; 3]| {
                let corners = nodes.map(local);
                let middle = corners.iter().sum::<DVec3>() / 3.0;
                let radius = corners.map(|c| c.distance(middle));
                near(middle, radius[0].max(radius[1]).max(radius[2]))
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
        let topology = site.side.topology;
        self.on_faces.begin();
        for &(p, f) in &self.faces {
            let part = &self.parts[p as usize];
            self.points.clear();
            Making {
                target,
                pair,
                part,
                frame: part.frame(collider),
                site,
                touches: &mut self.on_faces,
            }
            .face([p, f], topology.faces[f as usize], &mut self.points);
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
            .edge([p, e], topology.edges[e as usize]);
        }
    }
}

/// The rows of a face or an edge against a part, in the making.
struct Making<'a, 's> {
    target: &'a Target,
    pair: u32,
    part: &'a Part,
    frame: Frame,
    site: &'a mut Site<'s>,
    touches: &'a mut Touches,
}

/// A point of a face or an edge that meets the part, in the frame of the part.
struct Point<'a> {
    nodes: &'a [u32],
    corners: &'a [DVec3],
    weights: [f64; 3],
    normal: DVec3,
    depth: f64,
}

impl Making<'_, '_> {
    /// Points of the part against a face. Of a closed surface the outside is that of its winding; of an open one the side on
    /// which the middle of the part is.
    fn face(&mut self, [p, f]: [u32; 2], nodes: [u32; 3], points: &mut Vec<DVec3>) {
        let corners = nodes.map(|node| self.frame.to_local(self.site.side.state, node));
        let [a, b, c] = corners;
        let Some(mut n) = (b - a).cross(c - a).try_normalize() else {
            return;
        };
        if (self.part.centre - a).dot(n) < 0.0 {
            if self.site.side.topology.closed {
                return;
            }
            n = -n;
        }
        // What has sunk in deeper than this has come from elsewhere.
        let deepest = 0.5 * self.site.side.topology.spacing;
        self.part.solid.feature_points(n, points);
        for (i, &meets) in (0..).zip(points.iter()) {
            let depth = self.target.skin - (meets - a).dot(n);
            if depth < -self.site.reach.farthest || depth > self.target.skin + deepest {
                continue;
            }
            let Some(weights) = barycentric(meets, a, b, c) else {
                continue;
            };
            let point = Point {
                nodes: &nodes,
                corners: &corners,
                weights,
                normal: -n,
                depth,
            };
            self.add([p, f, i], point);
        }
    }

    /// An edge against the part, where its middle goes deeper than its ends: those are nodes.
    fn edge(&mut self, [p, e]: [u32; 2], nodes: [u32; 2]) {
        let corners = nodes.map(|node| self.frame.to_local(self.site.side.state, node));
        let [a, b] = corners;
        let solid = &self.part.solid;
        let (t, distance, normal) = solid.nearest_on_segment(a, b);
        let depth = self.target.skin - distance;
        if !(t > 0.0 && t < 1.0) || depth < -self.site.reach.farthest {
            return;
        }
        let ends = corners.map(|end| solid.signed_distance(end).0);
        if distance > ends[0].min(ends[1]) - self.site.reach.touching {
            return;
        }
        let point = Point {
            nodes: &nodes,
            corners: &corners,
            weights: [1.0 - t, t, 0.0],
            normal,
            depth,
        };
        self.add([p, e, 0], point);
    }

    fn add(&mut self, key: Key, point: Point) {
        let Site {
            side,
            shadow,
            slots,
            rows,
            reach,
        } = &mut *self.site;
        // Both sides take the impulse at one point, that of the deformable, or angular momentum would be lost.
        let touched = weigh(&point.weights, point.corners.iter().copied());
        let arm = self.frame.axes * touched + (self.frame.position - shadow.com);
        let velocities = point.nodes.iter().map(|&i| side.state.velocity(i as usize));
        let v = weigh(&point.weights, velocities);
        if point.depth < -reach.at((v - shadow.velocity_at(arm)).length()) {
            return;
        }
        let held = self.touches.last(key).and_then(|(_, hold)| hold);
        let hold = held.unwrap_or(Hold {
            weights: point.weights,
            anchor: touched,
        });
        let slipped = weigh(&hold.weights, point.corners.iter().copied()) - hold.anchor;
        self.touches
            .found(key, rows.contacts.len(), point.normal, hold);
        let first = rows.terms.len();
        for (&i, weight) in point.nodes.iter().zip(point.weights) {
            let node = slot(side.body, i, side.state, slots, rows);
            rows.terms.push(Term {
                node,
                weight,
                share: weight * self.target.node_share,
            });
        }
        let terms = rows.terms_since(first);
        rows.contacts.push(Row {
            normal: self.frame.axes * point.normal,
            depth: point.depth,
            arm,
            drift: self.frame.axes * along(slipped, point.normal),
            ..self.target.row(terms, self.pair, reach.h)
        });
    }
}

fn weigh(weights: &[f64; 3], values: impl Iterator<Item = DVec3>) -> DVec3 {
    values.zip(weights).map(|(v, w)| v * *w).sum()
}

/// The box of a body in a frame \[m\].
fn bounds(side: Side, frame: &Frame) -> (DVec3, DVec3) {
    (0..side.state.particles.len() as u32)
        .map(|node| frame.to_local(side.state, node))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), x| {
            (lo.min(x), hi.max(x))
        })
}

/// Weights of the corners of a triangle at the foot of a point; `None` where that is outside.
fn barycentric(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> Option<[f64; 3]> {
    let n = (b - a).cross(c - a);
    let area = n.length_squared();
    let u = (c - b).cross(p - b).dot(n) / area;
    let v = (a - c).cross(p - c).dot(n) / area;
    let weights = [u, v, 1.0 - u - v];
    weights.iter().all(|w| *w >= -1e-9).then_some(weights)
}
