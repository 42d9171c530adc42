//! Where a body is met: by a ray, nearest to a point, by a shape. Everything in `f64` about the body's origin.

mod closest;
mod overlap;
pub(crate) mod tree;

pub(crate) use overlap::overlap;

use super::{Blueprint, NodeId, SpringId, State, Topology};
use crate::math::{DVec3, Real};
use closest::{on_segment, on_triangle, ray_capsule, ray_triangle, volumes};
use tree::{Bounds, Tree};

/// What of a body was met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Feature {
    /// A face, by its index in [`Blueprint::faces`].
    Face(u32),
    /// An unbroken spring of a body without faces.
    Spring(SpringId),
    /// A node of a body without faces that no unbroken spring holds.
    Node(NodeId),
}

/// A point that moves with the nodes of a body: a weighted mean of up to three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The face, spring or node it lies on.
    pub feature: Feature,
    /// The nodes of the feature; places a spring or a node has no use for repeat the last one.
    pub nodes: [NodeId; 3],
    /// Barycentric weights of the nodes, summing to 1; 0 in unused places.
    pub weights: [Real; 3],
}

/// A search through one body as it stands.
pub(crate) struct Search<'a> {
    pub blueprint: &'a Blueprint,
    pub topology: &'a Topology,
    pub state: &'a State<Real>,
    pub tree: &'a Tree,
    /// Of the nodes \[m\].
    pub bounds: Bounds,
    /// Half the thickness given to springs and lone nodes \[m\].
    pub radius: f64,
}

/// What a search found.
pub(crate) struct Met {
    /// From the origin of the ray, or from the point \[m\].
    pub distance: f64,
    pub at: SurfacePoint,
    /// The weights of its nodes, unrounded.
    pub weights: [f64; 3],
    /// Of a ray: the unit normal towards its origin, 0 if it starts within a line. Of a point: the point nearest to it \[m\].
    pub vector: DVec3,
}

/// Weights of the nodes of a leaf.
type Weights = [f64; 3];

impl Search<'_> {
    /// Whether the body shows springs and nodes, having no faces.
    pub fn is_lines(&self) -> bool {
        self.blueprint.faces.is_empty()
    }

    /// What a leaf of the tree is; `None` for a torn face, a broken spring, and a node that some spring holds.
    pub fn feature(&self, leaf: u32) -> Option<Feature> {
        if !self.is_lines() {
            return (!self.topology.is_torn(leaf)).then_some(Feature::Face(leaf));
        }
        match self.state.broken.get(leaf as usize) {
            Some(broken) => (!broken).then_some(Feature::Spring(SpringId(leaf))),
            None => {
                let node = leaf - self.state.broken.len() as u32;
                self.tree.alone[node as usize].then_some(Feature::Node(NodeId(node)))
            }
        }
    }

    /// Nodes of a feature, the last one repeated.
    fn nodes(&self, feature: Feature) -> [u32; 3] {
        match feature {
            Feature::Face(face) => self.blueprint.faces[face as usize],
            Feature::Spring(spring) => {
                let [a, b] = self.blueprint.springs[spring.index()].nodes;
                [a, b, b]
            }
            Feature::Node(node) => [node.0; 3],
        }
    }

    /// Positions of the nodes of a feature \[m\].
    pub fn corners(&self, feature: Feature) -> [DVec3; 3] {
        self.nodes(feature).map(|n| self.state.local(n as usize))
    }

    fn surface_point(&self, feature: Feature, weights: Weights) -> SurfacePoint {
        SurfacePoint {
            feature,
            nodes: self.nodes(feature).map(NodeId),
            weights: weights.map(|w| w as Real),
        }
    }

    /// The point of a feature nearest to `p`: distance \[m\] and weights.
    fn nearest_of(&self, feature: Feature, p: DVec3) -> (f64, Weights) {
        let corners = self.corners(feature);
        let weights = match feature {
            Feature::Face(_) => on_triangle(p, corners),
            Feature::Spring(_) => {
                let t = on_segment(p, corners[0], corners[1]);
                [1.0 - t, t, 0.0]
            }
            Feature::Node(_) => [1.0, 0.0, 0.0],
        };
        (p.distance(mean(corners, weights)), weights)
    }

    /// Bounds of nodes as those of what is drawn around them.
    fn padded(&self, (lo, hi): Bounds) -> Bounds {
        if self.is_lines() {
            (lo - self.radius, hi + self.radius)
        } else {
            (lo, hi)
        }
    }

    /// The first point a ray from `origin` along the unit vector `dir` meets within `limit` \[m\].
    pub fn cast_ray(&self, (origin, dir): (DVec3, DVec3), limit: f64) -> Option<Met> {
        let enter = |bounds: Bounds| slab(self.padded(bounds), origin, dir);
        let base = enter(self.bounds);
        if !base.is_finite() {
            return None;
        }
        let (leaf, t, weights) = self.tree.least(limit, base, enter, |leaf| {
            let feature = self.feature(leaf)?;
            let corners = self.corners(feature);
            if let Feature::Face(_) = feature {
                return ray_triangle(origin, dir, corners);
            }
            let t = ray_capsule(origin, dir, [corners[0], corners[1]], self.radius)?;
            let (_, weights) = self.nearest_of(feature, origin + dir * t);
            Some((t, weights))
        })?;
        let feature = self.feature(leaf)?;
        let corners = self.corners(feature);
        let normal = match feature {
            Feature::Face(_) => {
                let n = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                n.normalize_or_zero() * if n.dot(dir) > 0.0 { -1.0 } else { 1.0 }
            }
            _ if t > 0.0 => (origin + dir * t - mean(corners, weights)).normalize_or_zero(),
            _ => DVec3::ZERO,
        };
        Some(Met {
            distance: t,
            at: self.surface_point(feature, weights),
            weights,
            vector: normal,
        })
    }

    /// The point of a face, or of the axis of a line, nearest to `p` within `limit` \[m\].
    pub fn nearest(&self, p: DVec3, limit: f64) -> Option<Met> {
        let base = distance(self.bounds, p);
        let (leaf, distance, weights) = self.tree.least(
            limit,
            base,
            |b| distance(b, p),
            |leaf| Some(self.nearest_of(self.feature(leaf)?, p)),
        )?;
        let feature = self.feature(leaf)?;
        Some(Met {
            distance,
            at: self.surface_point(feature, weights),
            weights,
            vector: mean(self.corners(feature), weights),
        })
    }

    /// A unit vector from a point on the axis of a line across it; of four that differ by quarter turns, the first of those whose
    /// ends at `radius` \[m\] are farthest from all lines. Where lines meet, one can point into another.
    pub fn out_of_line(&self, met: &Met, radius: f64) -> DVec3 {
        let [a, b, _] = self.corners(met.at.feature);
        let (x, y) = (b - a)
            .try_normalize()
            .unwrap_or(DVec3::X)
            .any_orthonormal_pair();
        let apart = |way: &DVec3| {
            let met = self.nearest(met.vector + *way * radius, f64::INFINITY);
            met.map_or(0.0, |met| met.distance)
        };
        let mut best = (x, apart(&x));
        for way in [y, -x, -y] {
            let distance = apart(&way);
            // More than rounding makes of equal ones.
            if distance > best.1 * (1.0 + 1e-6) {
                best = (way, distance);
            }
        }
        best.0
    }

    /// Whether a closed body holds the point, by the number of times its faces wind around it: a body crushed into itself
    /// or turned inside out still has an inside.
    pub fn holds(&self, p: DVec3) -> bool {
        // Any direction will do; this one runs along no lattice.
        let dir = DVec3::new(0.547_722_557_5, 0.316_227_766, 0.774_596_669_2);
        let on_the_way = |b: Bounds| slab(b, p, dir).is_finite();
        self.tree.closed
            && self
                .tree
                .leaves(on_the_way)
                .map(|face| self.crossing(face, p, dir))
                .sum::<i32>()
                != 0
    }

    /// +1 where the ray from `p` leaves through a face, −1 where it enters, 0 where it misses. A ray through a side counts
    /// for one of the two faces that share it.
    fn crossing(&self, face: u32, p: DVec3, dir: DVec3) -> i32 {
        let nodes = self.blueprint.faces[face as usize];
        let corners = nodes.map(|n| self.state.local(n as usize) - p);
        let volumes = volumes(dir, corners);
        let sides: [bool; 3] = std::array::from_fn(|i| {
            let (from, to) = (nodes[(i + 1) % 3], nodes[(i + 2) % 3]);
            volumes[i] > 0.0 || (volumes[i] == 0.0 && from < to)
        });
        if sides != [sides[0]; 3] {
            return 0;
        }
        let sum: f64 = volumes.iter().sum();
        let point = mean(corners, volumes.map(|v| v / sum));
        let ahead = sum != 0.0 && point.dot(dir) > 0.0;
        i32::from(ahead) * if sides[0] { 1 } else { -1 }
    }
}

fn mean(corners: [DVec3; 3], weights: Weights) -> DVec3 {
    corners.iter().zip(weights).map(|(c, w)| *c * w).sum()
}

/// Where a ray enters a box \[m\], 0 from inside, infinite past it.
pub(crate) fn slab((lo, hi): Bounds, origin: DVec3, dir: DVec3) -> f64 {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let (lo, hi, o, d) = (lo[axis], hi[axis], origin[axis], dir[axis]);
        if d == 0.0 {
            if o < lo || o > hi {
                return f64::INFINITY;
            }
            continue;
        }
        let (a, b) = ((lo - o) / d, (hi - o) / d);
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    // The slack covers the rounding of the divisions: a face must not be missed that lies along the box.
    if enter <= leave * (1.0 + 1.0e-14) {
        enter
    } else {
        f64::INFINITY
    }
}

/// Distance of a point from a box \[m\], 0 inside.
pub(crate) fn distance((lo, hi): Bounds, p: DVec3) -> f64 {
    (lo - p).max(p - hi).max(DVec3::ZERO).length()
}
