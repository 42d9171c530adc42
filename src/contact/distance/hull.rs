//! A convex polyhedron. Below all its planes, and over a face, the highest plane is the exact distance. Beside a face the
//! nearest point is searched from there: the distance is convex, so a walk over visible neighbours that always comes
//! nearer ends at it, and near the surface it takes one or two steps.

use super::planes::{Block, LANES, blocks, greatest};
use super::primitive;
use crate::math::DVec3;

/// Faces, their planes, and the corners they share.
#[derive(Debug, PartialEq)]
pub struct Hull {
    /// Planes in blocks of eight, so that a compiler makes vectors of them.
    blocks: Vec<Block>,
    faces: Vec<Face>,
    corners: Vec<Corner>,
    /// Corners of the body.
    vertices: Vec<DVec3>,
    /// Faces around each vertex: where its list starts, and the lists.
    starts: Vec<u32>,
    around: Vec<u32>,
    /// Smallest extent \[m\].
    width: f64,
}

/// Edges, each counted from both sides, up to which all pairs are looked at once.
const FEW_EDGES: usize = 80;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Face {
    normal: DVec3,
    offset: f64,
    /// Its corners, by index.
    first: u32,
    end: u32,
}

/// A corner of one face, and the edge from it to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    /// On the plane of the face to the last bit, so that a nearest point on it never lies above.
    point: DVec3,
    /// In the plane, away from the face, unless the edge is too short to have a direction.
    out: DVec3,
    vertex: u32,
    /// The face on the other side of the edge.
    across: u32,
}

/// The point of a face nearest to some point.
struct Nearest {
    square: f64,
    point: DVec3,
    place: Place,
}

enum Place {
    Inside,
    /// Of a corner's edge.
    Edge(u32),
    Vertex(u32),
}

impl Hull {
    /// From points and loops of them that close.
    pub fn new(points: &[DVec3], loops: &[Vec<u32>]) -> Self {
        let mut number = vec![u32::MAX; points.len()];
        let mut vertices: Vec<DVec3> = Vec::new();
        let (mut faces, mut corners): (Vec<Face>, Vec<Corner>) = Default::default();
        for list in loops {
            for &v in list {
                if number[v as usize] == u32::MAX {
                    number[v as usize] = vertices.len() as u32;
                    vertices.push(points[v as usize]);
                }
            }
            faces.push(face(points, list, corners.len() as u32));
            let Some(face) = faces.last() else { continue };
            let flat = |v: u32| {
                let p = points[v as usize];
                p - face.normal * (face.normal.dot(p) - face.offset)
            };
            for (i, &v) in list.iter().enumerate() {
                let edge = flat(list[(i + 1) % list.len()]) - flat(v);
                corners.push(Corner {
                    point: flat(v),
                    out: edge
                        .cross(face.normal)
                        .try_normalize()
                        .unwrap_or(DVec3::ZERO),
                    vertex: number[v as usize],
                    across: 0,
                });
            }
        }
        let mut hull = Self {
            blocks: blocks(faces.iter().map(|f| (f.normal, f.offset))),
            faces,
            corners,
            vertices,
            starts: Vec::new(),
            around: Vec::new(),
            width: 0.0,
        };
        hull.join();
        hull.width = hull.least_extent();
        hull
    }

    /// Finds what lies across every edge and around every vertex.
    fn join(&mut self) {
        let mut edges: Vec<(u32, u32, u32)> = Vec::new();
        let mut around: Vec<(u32, u32)> = Vec::new();
        for (f, face) in self.faces.iter().enumerate() {
            for c in face.first..face.end {
                let from = self.corners[c as usize].vertex;
                edges.push((from, self.corners[face.after(c)].vertex, f as u32));
                around.push((from, f as u32));
            }
        }
        edges.sort_unstable();
        around.sort_unstable();
        for (f, face) in self.faces.iter().enumerate() {
            for c in face.first..face.end {
                let (from, to) = (
                    self.corners[c as usize].vertex,
                    self.corners[face.after(c)].vertex,
                );
                let i = edges.partition_point(|e| (e.0, e.1) < (to, from));
                let other = edges.get(i).filter(|e| (e.0, e.1) == (to, from));
                self.corners[c as usize].across = other.map_or(f as u32, |e| e.2);
            }
        }
        self.starts = (0..=self.vertices.len() as u32)
            .map(|v| around.partition_point(|e| e.0 < v) as u32)
            .collect();
        self.around = around.into_iter().map(|e| e.1).collect();
    }

    /// Its volume \[m³\].
    pub fn volume(&self) -> f64 {
        let apex = self.vertices.first().copied().unwrap_or_default();
        let tet = |[a, b, c]: [DVec3; 3]| (a - apex).dot((b - apex).cross(c - apex)) / 6.0;
        let pyramid = |face: &Face| -> f64 {
            let corners = &self.corners[face.first as usize..face.end as usize];
            let fan = corners.windows(2);
            fan.map(|c| tet([corners[0].point, c[0].point, c[1].point]))
                .sum()
        };
        self.faces.iter().map(pyramid).sum()
    }

    /// Corners \[m\].
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Every edge once: its ends \[m\] and the outward unit normals of its faces.
    pub fn for_each_edge(&self, f: &mut dyn FnMut([DVec3; 2], [DVec3; 2])) {
        for (i, face) in (0..).zip(&self.faces) {
            for c in face.first..face.end {
                let corner = &self.corners[c as usize];
                if corner.across > i {
                    let ends = [corner.point, self.corners[face.after(c)].point];
                    f(
                        ends,
                        [face.normal, self.faces[corner.across as usize].normal],
                    );
                }
            }
        }
    }

    /// Smallest extent \[m\].
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Whether it is a polygon with two sides and nothing between, so that its planes alone do not bound it.
    pub fn is_sheet(&self) -> bool {
        self.faces.len() == 2
    }

    /// The corner farthest in a direction.
    pub fn support(&self, direction: DVec3) -> DVec3 {
        let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
        for &v in &self.vertices {
            let far = v.dot(direction);
            if far > best.0 {
                best = (far, v);
            }
        }
        best.1
    }

    /// Face planes: outward unit normals and how far `p` lies over them \[m\].
    pub fn planes(&self, p: DVec3, f: &mut dyn FnMut(f64, DVec3)) {
        for face in &self.faces {
            f(face.height(p), face.normal);
        }
    }

    /// Height over the highest plane and its normal: the same surface and inside as the distance, and convex too.
    #[inline]
    pub fn highest(&self, p: DVec3) -> (f64, DVec3) {
        let (height, face) = self.highest_face(p);
        (height, self.faces[face].normal)
    }

    #[inline]
    fn highest_face(&self, p: DVec3) -> (f64, usize) {
        let mut best = (f64::NEG_INFINITY, 0, [f64::NAN; LANES]);
        for (k, block) in self.blocks.iter().enumerate() {
            let heights = block.heights(p);
            let top = greatest(&heights);
            if top > best.0 {
                best = (top, k, heights);
            }
        }
        let (top, block, heights) = best;
        // No early end: a branch that is anyone's guess costs more than the rest of the lanes.
        let mut lane = 0;
        for (i, &height) in heights.iter().enumerate() {
            lane = if height == top { i } else { lane };
        }
        (heights[lane], block * LANES + lane)
    }

    /// Signed distance and normal.
    #[inline]
    pub fn signed_distance(&self, p: DVec3) -> (f64, DVec3) {
        let (height, face) = self.highest_face(p);
        let normal = self.faces[face].normal;
        if (height <= 0.0 || height.is_nan()) && !self.is_sheet() {
            return (height, normal);
        }
        let mut nearest = self.nearest_on(face, p);
        if let Place::Inside = nearest.place {
            return (height, normal);
        }
        // Each step comes strictly nearer, so none is taken twice.
        for _ in 0..self.faces.len() {
            let Some(next) = self.nearer(&nearest, p) else {
                break;
            };
            nearest = next;
        }
        primitive::direction(p - nearest.point, normal)
    }

    /// A nearer point on a visible face that shares the place of `from`.
    fn nearer(&self, from: &Nearest, p: DVec3) -> Option<Nearest> {
        let corner;
        let neighbours = match from.place {
            Place::Inside => return None,
            Place::Edge(c) => {
                corner = [self.corners[c as usize].across];
                &corner[..]
            }
            Place::Vertex(v) => {
                let (first, end) = (self.starts[v as usize], self.starts[v as usize + 1]);
                &self.around[first as usize..end as usize]
            }
        };
        let mut best: Option<Nearest> = None;
        let mut least = from.square * (1.0 - 1e-12);
        for &f in neighbours {
            let height = self.faces[f as usize].height(p);
            if height <= 0.0 || height * height >= least {
                continue;
            }
            let nearest = self.nearest_on(f as usize, p);
            if nearest.square < least {
                least = nearest.square;
                best = Some(nearest);
            }
        }
        best
    }

    /// The point of a face nearest to `p`. On a convex polygon it lies on an edge that `p` is beyond, if there is one.
    fn nearest_on(&self, face: usize, p: DVec3) -> Nearest {
        let face = self.faces[face];
        let height = face.height(p);
        let mut best = Nearest {
            square: f64::INFINITY,
            point: p - face.normal * height,
            place: Place::Inside,
        };
        for c in face.first..face.end {
            let corner = &self.corners[c as usize];
            let beyond = (p - corner.point).dot(corner.out);
            if beyond <= 0.0 || beyond.is_nan() {
                continue;
            }
            let next = &self.corners[face.after(c)];
            let t = primitive::along(p, corner.point, next.point);
            let point = corner.point + (next.point - corner.point) * t;
            let square = (p - point).length_squared();
            if square < best.square {
                let place = if t <= 0.0 {
                    Place::Vertex(corner.vertex)
                } else if t >= 1.0 {
                    Place::Vertex(next.vertex)
                } else {
                    Place::Edge(c)
                };
                best = Nearest {
                    square,
                    point,
                    place,
                };
            }
        }
        if let Place::Inside = best.place {
            best.square = height * height;
        }
        best
    }

    /// How far a box must grow, at least, until more than one face reaches into it and it is not wholly outside \[m\].
    pub fn edges_apart(&self, lo: DVec3, hi: DVec3) -> f64 {
        let (centre, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        let mut apart = f64::NEG_INFINITY;
        let (mut first, mut second) = (f64::INFINITY, f64::INFINITY);
        for face in &self.faces {
            let (height, slope) = (face.height(centre), face.normal.abs());
            let reach = slope.dot(half);
            // A corner rises over the face by at most this for every metre.
            let rise = slope.element_sum();
            apart = apart.max((height - reach) / rise);
            let below = (-height - reach) / rise;
            (first, second) = (first.min(below), second.min(below.max(first)));
        }
        apart.max(second)
    }

    /// Least distance between two parallel planes that hold the hull: over its faces, and for few edges over pairs of
    /// edges too, which can be closer (a tetrahedron's opposite edges are).
    fn least_extent(&self) -> f64 {
        let across = |n: DVec3| (self.support(n) - self.support(-n)).dot(n);
        let mut least = f64::INFINITY;
        for face in &self.faces {
            least = least.min(across(face.normal));
        }
        let edge = |face: &Face, c: u32| {
            self.corners[face.after(c)].point - self.corners[c as usize].point
        };
        let edges: Vec<DVec3> = self
            .faces
            .iter()
            .flat_map(|face| (face.first..face.end).map(move |c| edge(face, c)))
            .collect();
        if edges.len() <= FEW_EDGES {
            for (i, a) in edges.iter().enumerate() {
                for b in &edges[..i] {
                    if let Some(n) = a.cross(*b).try_normalize() {
                        least = least.min(across(n));
                    }
                }
            }
        }
        least
    }
}

impl Face {
    /// The index of the corner after `c`.
    #[inline]
    fn after(&self, c: u32) -> usize {
        (if c + 1 == self.end { self.first } else { c + 1 }) as usize
    }

    #[inline]
    fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// The plane of a loop: the normal of its whole area, as far out as its outermost corner.
fn face(points: &[DVec3], list: &[u32], first: u32) -> Face {
    let at = |i: usize| points[list[i % list.len()] as usize];
    let area = (1..list.len())
        .map(|i| (at(i) - at(0)).cross(at(i + 1) - at(0)))
        .fold(DVec3::ZERO, |a, b| a + b);
    let normal = area.try_normalize().unwrap_or(DVec3::Y);
    Face {
        normal,
        offset: (0..list.len())
            .map(|i| normal.dot(at(i)))
            .fold(f64::NEG_INFINITY, f64::max),
        first,
        end: first + list.len() as u32,
    }
}
