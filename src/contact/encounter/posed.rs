//! An outline where its body stands now: corners and normals.

use super::outline::{NONE, Outline};
use crate::body::State;
use crate::contact::closest::{Feature, Nearest, on_side, on_triangle};
use crate::math::{DVec3, Real};

/// An outline at the positions of a state, in the frame of the encounter.
#[derive(Clone, Copy)]
pub struct Posed<'a> {
    /// The outline.
    pub outline: &'a Outline,
    /// Where its nodes are.
    pub state: &'a State<Real>,
    /// From the body's own frame to that of the encounter \[m\].
    pub shift: DVec3,
}

/// A nearest point and the way from it.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// The element.
    pub element: u32,
    /// The point.
    pub nearest: Nearest,
    /// From there to the node \[m\].
    pub way: DVec3,
    /// Its squared length \[m²\].
    pub squared: f64,
}

impl<'a> Posed<'a> {
    /// An outline in a frame that stands at `origin` in the world \[m\].
    pub fn new(outline: &'a Outline, state: &'a State<Real>, origin: DVec3) -> Self {
        Self {
            outline,
            state,
            shift: state.origin - origin,
        }
    }

    /// Where a node is \[m\].
    #[inline(always)]
    pub fn at(&self, node: u32) -> DVec3 {
        self.state.local(node as usize) + self.shift
    }

    /// Whether anything of the body can be within `radius` m of a point, by the box around it.
    pub fn may_hold(&self, x: DVec3, radius: f64) -> bool {
        self.outline.may_hold(x - self.shift, radius)
    }

    /// How far the boxes around the whole bodies are apart, or less \[m\].
    pub fn apart(&self, other: &Self) -> f64 {
        let corners = |body: &Self| body.outline.bounds().map(|x| x + body.shift);
        let ([from, to], [lo, hi]) = (corners(self), corners(other));
        let apart = (from - hi).max(lo - to).max(DVec3::ZERO).length();
        // Boxes are of f32.
        let size = self
            .outline
            .bounds()
            .into_iter()
            .chain(other.outline.bounds());
        apart - 1e-6 * size.map(|x| x.abs().max_element()).fold(0.0, f64::max)
    }

    /// The corners of an element \[m\].
    #[inline(always)]
    pub fn corners(&self, element: u32) -> [DVec3; 3] {
        // Not by `map`, which is a call for each of them here.
        let [a, b, c] = self.outline.elements[element as usize];
        [self.at(a), self.at(b), self.at(c)]
    }

    /// The ends of an edge \[m\].
    #[inline(always)]
    pub fn ends(&self, edge: u32) -> [DVec3; 2] {
        let [a, b] = self.outline.edges[edge as usize].nodes;
        [self.at(a), self.at(b)]
    }

    /// The point of an element nearest to `x`.
    #[inline(always)]
    pub fn nearest(&self, element: u32, x: DVec3) -> Way {
        let corners = self.corners(element);
        let [a, b, _] = self.outline.elements[element as usize];
        let nearest = if (element as usize) < self.outline.faces {
            on_triangle(x, &corners)
        } else if a != b {
            on_side(x, &corners, 0)
        } else {
            Nearest::corner(0)
        };
        let way = x - nearest.point(&corners);
        Way {
            element,
            nearest,
            way,
            squared: way.length_squared(),
        }
    }

    /// The point of an element with these weights, \[m\].
    pub fn point(&self, element: u32, weights: [f64; 3]) -> DVec3 {
        let [a, b, c] = self.corners(element);
        a * weights[0] + b * weights[1] + c * weights[2]
    }

    /// The weights of the foot of `x` on the plane of a face, which is outside of the face where some are negative; `None` where
    /// an element is no face, or one without area.
    pub fn foot(&self, element: u32, x: DVec3) -> Option<[f64; 3]> {
        if element as usize >= self.outline.faces {
            return None;
        }
        let [a, b, c] = self.corners(element);
        let (ab, ac, ax) = (b - a, c - a, x - a);
        let normal = ab.cross(ac);
        let square = normal.length_squared();
        let [u, v] = [ax.cross(ac), ab.cross(ax)].map(|n| n.dot(normal) / square);
        square.is_normal().then_some([1.0 - u - v, u, v])
    }

    /// Velocity of that point \[m/s\].
    pub fn velocity(&self, element: u32, weights: [f64; 3]) -> DVec3 {
        let nodes = self.outline.elements[element as usize];
        (0..3)
            .map(|k| self.state.velocity(nodes[k] as usize) * weights[k])
            .sum()
    }

    /// Normal of a face, by its winding, twice as long as its area \[m²\].
    #[inline(always)]
    pub fn face_area(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a)
    }

    /// Unit normal of a face; zero for a face without area.
    pub fn face_normal(&self, face: u32) -> DVec3 {
        self.face_area(face).normalize_or_zero()
    }

    /// Whether all faces around a node look against a unit `way`, each by a cosine below `cosine` < 0; so does every mean of them.
    pub fn all_against(&self, node: u32, way: DVec3, cosine: f64) -> bool {
        let mut faces = self.outline.around(node).peekable();
        faces.peek().is_some()
            && faces.all(|face| {
                let area = self.face_area(face);
                let along = area.dot(way);
                along < 0.0 && along * along > cosine * cosine * area.length_squared()
            })
    }

    /// The normal of the surface at a nearest point: of a face, or of the faces around an edge or a node weighted by their
    /// angles, whose sign tells inside from outside (Bærentzen & Aanæs 2005). Zero where there are no faces.
    pub fn normal_at(&self, element: u32, feature: Feature) -> DVec3 {
        if element as usize >= self.outline.faces {
            return DVec3::ZERO;
        }
        match feature {
            Feature::Face => self.face_normal(element),
            Feature::Side(k) => self.edge_normal(self.outline.edges_of[element as usize][k]),
            Feature::Corner(k) => self.node_normal(self.outline.elements[element as usize][k]),
        }
    }

    /// Sum of the normals of the faces at an edge.
    pub fn edge_normal(&self, edge: u32) -> DVec3 {
        let faces = self.outline.edges[edge as usize].faces;
        let faces = faces.iter().filter(|&&f| f != NONE);
        faces.map(|&f| self.face_normal(f)).sum()
    }

    /// Sum of the normals of the faces around a node, weighted by their angles there.
    pub fn node_normal(&self, node: u32) -> DVec3 {
        let angle = |face: u32| {
            let corners = self.corners(face);
            let nodes = self.outline.elements[face as usize];
            let k = nodes.iter().position(|&n| n == node).unwrap_or(0);
            let (a, b) = (
                corners[(k + 1) % 3] - corners[k],
                corners[(k + 2) % 3] - corners[k],
            );
            let cos = a.dot(b) / (a.length() * b.length());
            // NaN of a side without length becomes 0.
            cos.clamp(-1.0, 1.0).acos().max(0.0)
        };
        let faces = self.outline.around(node);
        faces.map(|f| self.face_normal(f) * angle(f)).sum()
    }

    /// Of the faces at a nearest point, the one that looks most against `against`.
    pub fn facing(&self, element: u32, feature: Feature, against: DVec3) -> DVec3 {
        let least = |faces: &mut dyn Iterator<Item = u32>| {
            let normals = faces.filter(|f| *f != NONE).map(|f| self.face_normal(f));
            let least = normals.min_by(|a, b| a.dot(against).total_cmp(&b.dot(against)));
            least.unwrap_or(DVec3::ZERO)
        };
        let outline = self.outline;
        match feature {
            Feature::Face => self.face_normal(element),
            Feature::Side(k) => {
                let edge = outline.edges_of[element as usize][k] as usize;
                least(&mut outline.edges[edge].faces.into_iter())
            }
            Feature::Corner(k) => least(&mut outline.around(outline.elements[element as usize][k])),
        }
    }
}
