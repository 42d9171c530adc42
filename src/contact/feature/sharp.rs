//! Faces and edges of one body against the corners and edges of a surface, or of voxels.
//!
//! A surface may have any number of edges, so only those near the body are known: lists of pairs, each of a face and a corner
//! or of two edges, last until something has moved by their margin. Flat edges are not there at all, and gentle ones are
//! left to the nodes.

use super::making::{Making, Met};
use crate::contact::closest::bounds;
use crate::contact::form::Form;
use crate::contact::nodes::Nodes;
use crate::contact::roll::Roll;
use crate::contact::site::{Side, Site};
use crate::contact::soup::{Edge, EdgeKind, EdgeSearch, Overhang};
use crate::contact::target::{Frame, Target};
use crate::contact::touches::Touches;
use crate::contact::tree::around;
use crate::contact::watch::Watch;
use crate::math::DVec3;
use crate::solve::rows::Rows;
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};

/// The bend of two wide facets into which a face between nodes dips by a fiftieth of its length, as a sine.
pub(super) const GENTLE: f64 = 0.08;

/// Sine below which a direction lies in a plane.
pub(super) const FLAT: f64 = 1e-3;

/// How many times the present reach lists are made for, besides what is looked for now.
const AHEAD: f64 = 16.0;

/// First part of the keys of corners on faces, and of edges on them.
const CORNERS: u32 = 0;
pub(super) const LINES: u32 = 1;

/// A point where edges end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// What tells it from others of its surface.
    pub id: u32,
    pub place: DVec3,
    /// The sum of the normals of all facets there, each as often as it has edges that end there, or 0 where they do not agree on a front.
    pub front: DVec3,
    /// Which directions of the cone are its.
    cone: [u32; 2],
}

/// Faces and edges of one body near what is sharp of one target.
#[derive(Clone, Debug, Default)]
pub struct SharpFeatures {
    /// The way up to which the lists hold all that they must \[m\], once they have been made.
    until: Option<f64>,
    /// By id.
    corners: Vec<Corner>,
    /// Unit directions of edges and facets away from corners.
    cone: Vec<DVec3>,
    /// By id.
    edges: Vec<Edge>,
    /// Index of a corner and a face, in ascending order.
    points: Pairs,
    /// An edge of the body and the index of one of the target, in ascending order.
    crossings: Pairs,
    /// Index of an edge and a face, in ascending order.
    lines: Pairs,
    pub(super) on_faces: Touches,
    /// Keys are the body's edge, the target's, and whether that is a border.
    pub(super) on_edges: Touches,
    buffers: Buffers,
}

/// Pairs of something of the target and something of the body, all of which are watched.
#[derive(Clone, Debug, Default)]
struct Pairs {
    list: Vec<[u32; 2]>,
    watch: Watch,
}

impl Pairs {
    fn clear(&mut self) {
        self.list.clear();
        self.watch.reset();
    }

    /// Has all looked at that may have come near, see [`Watch::visit`].
    fn visit(&mut self, way: f64, reach: (f64, f64), mut look: impl FnMut([u32; 2]) -> f64) {
        let list = &self.list;
        self.watch
            .visit(list.len(), way, reach, |k, _| look(list[k as usize]));
    }

    /// Adds the rows of points of one kind on faces. One that was known may be `farthest` m deep under another face.
    fn add_rows(
        &mut self,
        making: &mut Making,
        kind: u32,
        (way, farthest): (f64, f64),
        met: &mut Vec<Met>,
        meet: impl Fn(&Making, [u32; 2]) -> (f64, Option<Met>),
    ) {
        let near = making.near;
        let mut look = |making: &Making, met: &mut Vec<Met>| {
            met.clear();
            self.visit(way, (making.near, near), |pair| {
                let (apart, found) = meet(making, pair);
                met.extend(found);
                if found.is_some() { 0.0 } else { apart }
            });
            met.sort_unstable_by_key(|m| (m.point, m.face));
        };
        look(making, met);
        if making.misses_some(kind, met) {
            (making.near, making.deep) = (farthest, true);
            look(making, met);
        }
        for met in met.chunk_by_mut(|a, b| a.point == b.point) {
            making.point(kind, met, false);
        }
        (making.near, making.deep) = (near, false);
    }
}

#[derive(Clone, Debug, Default)]
struct Buffers {
    places: Vec<DVec3>,
    search: EdgeSearch,
    ends: Vec<End>,
    met: Vec<Met>,
}

/// The end of an edge.
#[derive(Clone, Copy, Debug)]
struct End {
    place: DVec3,
    id: u32,
    edge: Edge,
    /// Along the edge.
    away: DVec3,
}

impl End {
    /// Appends the directions along the edge and into its facets from where it ends together with others. Of a facet that
    /// is narrower there than a right angle its two edges say all.
    fn directions(&self, all: &[Self], out: &mut Vec<DVec3>) {
        out.push(self.away);
        for (flank, normal) in self.edge.flanks().into_iter().zip(self.edge.normals) {
            let narrows = |other: &Self| {
                let in_plane = other.away.dot(normal).abs() < FLAT;
                in_plane && other.away.dot(flank) > 0.0 && other.away.dot(self.away) > 0.0
            };
            if flank != DVec3::ZERO && !all.iter().any(narrows) {
                out.push(flank);
            }
        }
    }
}

impl SharpFeatures {
    /// Forgets what touches, and the lists.
    pub fn forget(&mut self) {
        self.until = None;
        self.on_faces.forget();
        self.on_edges.forget();
    }

    /// Remembers what touches, after the rows have been solved.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        self.on_faces.end(rows, touching);
        self.on_edges.end_near(rows, touching);
    }

    /// Puts into `out` the edges of the body that touch borders, as each of their nodes has them, by node.
    pub fn overhangs(&self, side: &Side, frame: &Frame, out: &mut Vec<Overhang>) {
        let touching = self.on_edges.keys().filter(|key| key[2] != 0);
        for [edge, border, _] in touching {
            let Some(&[a, b]) = side.topology.edges.get(edge as usize) else {
                continue;
            };
            let [at_a, at_b] = [a, b].map(|i| frame.to_local(side.state, i));
            for (node, end) in [(a, at_b), (b, at_a)] {
                let length = at_a.distance(at_b);
                out.push(Overhang {
                    node,
                    border,
                    end,
                    length,
                });
            }
        }
        out.sort_unstable_by_key(|over| (over.node, over.border));
    }

    /// Adds the rows of faces and edges, which know from `nodes` on which side they are; `way` is how far body and collider have
    /// moved in all \[m\].
    pub fn add_rows(
        &mut self,
        (target, pair, nodes): (&Target, u32, &Nodes),
        collider: &Frame,
        site: &mut Site,
        way: f64,
    ) {
        self.on_faces.begin();
        self.on_edges.begin();
        let radius = match &target.form {
            Form::Soup(soup) => soup.radius(),
            Form::Solid(_) => 0.0,
        };
        let skin = target.skin + radius;
        // Rows made points faster since the reach was found, at most as fast again.
        let near = skin + 2.0 * site.reach.farthest;
        // A point that was known may be as deep as that under another face.
        let farthest = near.max(skin + 0.5 * site.side.topology.spacing);
        if self.until.is_none_or(|until| way + farthest > until) {
            let grow = farthest + AHEAD * site.reach.farthest;
            self.gather(&target.form, &site.side, collider, grow);
            self.until = Some(way + grow);
        }
        let mut making = Making {
            target,
            pair,
            nodes: Some(nodes),
            frame: *collider,
            skin,
            roll: Roll::of_any(site.shadow),
            radius,
            site,
            touches: &mut self.on_faces,
            near,
            deep: false,
        };
        let met = &mut self.buffers.met;
        let (corners, cone, edges) = (&self.corners, &self.cone, &self.edges);
        let visit = (way, farthest);
        let points = &mut self.points;
        points.add_rows(&mut making, CORNERS, visit, met, |making, [c, f]| {
            let corner = &corners[c as usize];
            let [first, end] = corner.cone;
            making.meet_corner(corner, &cone[first as usize..end as usize], f)
        });
        let lines = &mut self.lines;
        lines.add_rows(&mut making, LINES, visit, met, |making, [e, f]| {
            making.meet_line(&edges[e as usize], f)
        });
        making.touches = &mut self.on_edges;
        self.crossings.visit(way, (near, near), |[e, other]| {
            making.meet_edge(e, &edges[other as usize], edges)
        });
    }

    /// Lists what is within `grow` m of the body.
    fn gather(&mut self, form: &Form, side: &Side, frame: &Frame, grow: f64) {
        self.edges.clear();
        self.points.clear();
        self.crossings.clear();
        self.lines.clear();
        let Buffers { places, search, .. } = &mut self.buffers;
        places.clear();
        let nodes = 0..side.state.particles.len() as u32;
        places.extend(nodes.map(|i| frame.to_local(side.state, i)));
        let all = grown(places.iter().copied(), grow);
        edges_in(form, all, search, &mut self.edges);
        if self.edges.is_empty() {
            self.corners.clear();
            return;
        }
        self.edges.sort_unstable_by_key(|e| e.id);
        let spacing = side.topology.spacing;
        self.keep_corners(all, spacing);
        self.edges
            .retain(|e| !is_gentle(e.bend(), e.width.into(), spacing));
        let places = &self.buffers.places;
        let around_nodes = |nodes: &[u32]| {
            let places = nodes.iter().map(|&i| places[i as usize]);
            grown(places, grow)
        };
        let corners = self.corners.iter().map(|c| (c.place, c.place));
        let faces = side.topology.faces.iter();
        pairs(
            corners,
            faces.map(|f| around_nodes(f.nodes())),
            |corner, face| {
                self.points.list.push([corner, face]);
            },
        );
        let edges = || self.edges.iter().map(Edge::bounds);
        let own = side.topology.edges.iter();
        pairs(edges(), own.map(|e| around_nodes(e)), |edge, own| {
            self.crossings.list.push([own, edge]);
        });
        // Triangles are flat.
        let faces = &side.topology.faces;
        let quads = (0..).zip(faces).filter(|(_, face)| face.nodes().len() > 3);
        let quads: Vec<u32> = quads.map(|(f, _)| f).collect();
        let boxes = quads
            .iter()
            .map(|&f| around_nodes(faces[f as usize].nodes()));
        pairs(edges(), boxes, |edge, q| {
            self.lines.list.push([edge, quads[q as usize]]);
        });
        self.points.list.sort_unstable();
        self.crossings.list.sort_unstable();
        self.lines.list.sort_unstable();
    }

    /// Takes the corners in a box from the ends of edges.
    fn keep_corners(&mut self, (lo, hi): (DVec3, DVec3), spacing: f64) {
        let ends = &mut self.buffers.ends;
        ends.clear();
        for edge in &self.edges {
            let along = edge.along().normalize_or_zero();
            for (k, away) in [(0, along), (1, -along)] {
                let place = edge.ends[k];
                if place.cmpge(lo).all() && place.cmple(hi).all() {
                    ends.push(End {
                        place,
                        id: edge.id.wrapping_mul(2).wrapping_add(k as u32),
                        edge: *edge,
                        away,
                    });
                }
            }
        }
        let place = |end: &End| end.place.to_array().map(f64::to_bits);
        ends.sort_unstable_by_key(|end| (place(end), end.id));
        self.corners.clear();
        self.cone.clear();
        for ends in ends.chunk_by(|a, b| a.place == b.place) {
            if is_gentle_point(ends, spacing) {
                continue;
            }
            let first = self.cone.len() as u32;
            ends.iter()
                .for_each(|end| end.directions(ends, &mut self.cone));
            self.corners.push(Corner {
                id: ends[0].id,
                place: ends[0].place,
                front: if ends.iter().all(|end| end.edge.kind != EdgeKind::Free) {
                    ends.iter().map(|end| end.edge.front()).sum()
                } else {
                    DVec3::ZERO
                },
                cone: [first, self.cone.len() as u32],
            });
        }
        self.corners.sort_unstable_by_key(|c| c.id);
    }
}

/// The box around some points, grown \[m\].
fn grown(points: impl Iterator<Item = DVec3>, grow: f64) -> (DVec3, DVec3) {
    let (lo, hi) = bounds(points);
    (lo - grow, hi + grow)
}

/// Calls `found` for the indices of all boxes of two kinds that meet \[m\].
fn pairs(
    small: impl Iterator<Item = (DVec3, DVec3)>,
    large: impl Iterator<Item = (DVec3, DVec3)>,
    mut found: impl FnMut(u32, u32),
) {
    let boxes = small.map(|(lo, hi)| around(lo, hi)).enumerate();
    let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
    for (j, (lo, hi)) in (0..).zip(large) {
        tree.intersect_aabb(&around(lo, hi))
            .for_each(|i| found(i, j));
    }
}

/// Puts into `out` the edges of a form that stand out and meet a box.
fn edges_in(form: &Form, (lo, hi): (DVec3, DVec3), search: &mut EdgeSearch, out: &mut Vec<Edge>) {
    match form {
        Form::Soup(soup) => soup.convex_edges_in(lo, hi, search, out),
        Form::Solid(solid) => solid.voxel_edges_in(lo, hi, search, out),
    }
}

/// Whether a bend, given by its sine, between facets of a width \[m\] is as good as flat to faces of a size \[m\]: bends of
/// narrow facets follow each other and add up.
fn is_gentle(bend: f64, width: f64, spacing: f64) -> bool {
    bend < GENTLE * (2.0 * width / spacing).min(1.0)
}

/// Whether all facets at a point are as good as one plane.
fn is_gentle_point(ends: &[End], spacing: f64) -> bool {
    let width = |e: &End| f64::from(e.edge.width);
    let width = ends.iter().map(width).fold(f64::INFINITY, f64::min);
    let first = ends[0].edge.normals[0];
    let bend = |end: &End| {
        let normals = end.edge.normals.iter();
        let from_first = normals.map(|n| {
            if n.dot(first) > 0.0 {
                n.cross(first).length()
            } else {
                1.0
            }
        });
        from_first.fold(0.0, f64::max)
    };
    ends.iter()
        .all(|end| end.edge.kind != EdgeKind::Free && is_gentle(0.5 * bend(end), width, spacing))
}
