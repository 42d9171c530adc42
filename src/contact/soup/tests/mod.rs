//! Soups against brute force, in motion, and at their limits.

mod differential;
mod edges;
mod fast;
mod flat;
mod limits;
mod overhang;
mod side;
mod timing;

use super::{NodeFacets, Soup, Touches, touches};
use crate::math::{DVec3, Vector};
use rapier3d::geometry::{Array2, HeightField, SharedShape, TriMeshFlags};

/// Numbers between −1 and 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector();
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

/// The surface of a box of these half extents, every side of it `n` by `n` squares, wound outwards.
fn box_mesh(half: DVec3, n: usize, flags: TriMeshFlags) -> SharedShape {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let start = vertices.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let mut p = DVec3::ZERO;
                    p[axis] = sign * half[axis];
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    p[u] = half[u] * (2.0 * i as f64 / n as f64 - 1.0);
                    p[v] = half[v] * (2.0 * j as f64 / n as f64 - 1.0);
                    vertices.push(p.as_vec3());
                }
            }
            for i in 0..n as u32 {
                for j in 0..n as u32 {
                    let at = |i: u32, j: u32| start + i * (n as u32 + 1) + j;
                    let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                    for [p, q, r] in [[a, b, c], [a, c, d]] {
                        triangles.push(if sign > 0.0 { [p, q, r] } else { [p, r, q] });
                    }
                }
            }
        }
    }
    SharedShape::trimesh_with_flags(vertices, triangles, flags).unwrap()
}

/// Heights of a bumpy field \[m\].
fn bump(i: usize, j: usize) -> f32 {
    0.15 * ((i as f32 * 1.3).sin() + (j as f32 * 0.9).cos()) + 0.04 * ((i * 7 + j * 13) % 5) as f32
}

/// A bumpy field of 2 m by 2 m in 12 by 10 cells.
fn bumpy() -> HeightField {
    let (rows, columns) = (13, 11);
    let heights = (0..rows * columns)
        .map(|k| bump(k % rows, k / rows))
        .collect();
    HeightField::new(
        Array2::new(rows, columns, heights),
        Vector::new(2.0, 1.0, 2.0),
    )
}

/// All kinds of soups, and whether they have an inside.
fn soups() -> Vec<(&'static str, SharedShape)> {
    let half = DVec3::new(0.5, 0.3, 0.8);
    let v = Vector::new;
    let zigzag = vec![
        v(-0.8, 0.0, 0.1),
        v(-0.2, 0.5, 0.0),
        v(0.3, -0.4, 0.2),
        v(0.9, 0.6, -0.5),
    ];
    let (a, b, c) = (v(-0.6, 0.1, -0.4), v(0.7, -0.2, -0.3), v(0.1, 0.4, 0.8));
    vec![
        ("plain", box_mesh(half, 3, TriMeshFlags::empty())),
        ("oriented", box_mesh(half, 3, TriMeshFlags::ORIENTED)),
        ("fixed", box_mesh(half, 3, TriMeshFlags::FIX_INTERNAL_EDGES)),
        ("field", SharedShape::new(bumpy())),
        ("triangle", SharedShape::triangle(a, b, c)),
        ("round", SharedShape::round_triangle(a, b, c, 0.05)),
        ("segment", SharedShape::segment(a, b)),
        ("polyline", SharedShape::polyline(zigzag, None)),
    ]
}

fn soup(shape: &SharedShape) -> Soup {
    Soup::of(shape).expect("a surface shape")
}

/// A node that meets one soup as a body's would.
struct Probe {
    facets: NodeFacets,
    touches: Touches,
    p: DVec3,
    v: DVec3,
    anchor: Option<DVec3>,
    offset: f64,
    reach: f64,
}

impl Probe {
    fn new(p: DVec3, v: DVec3) -> Self {
        Self {
            facets: NodeFacets::default(),
            touches: Touches::default(),
            p,
            v,
            anchor: None,
            offset: 0.0,
            reach: 0.01,
        }
    }

    /// Gathers the facets and finds the touches of a motion over `h` s; deepest depth.
    fn look(&mut self, soup: &Soup, h: f64) -> f64 {
        let motion = self.v * h;
        let margin = 2.0 * motion.length() + self.offset + 2.0 * self.reach + 0.01;
        self.facets
            .gather(soup, std::iter::once((0, self.p)), margin);
        let near = self.facets.near(0);
        touches(
            near,
            self.p,
            motion,
            self.anchor,
            self.offset,
            self.reach,
            &mut self.touches,
        );
        self.anchor = self.touches.anchor;
        let depths = self.touches.as_slice().iter().map(|t| t.depth);
        depths.fold(f64::NEG_INFINITY, f64::max)
    }

    /// A substep of h s under an acceleration, held by the touches.
    fn step(&mut self, soup: &Soup, acceleration: DVec3, h: f64) {
        self.v += acceleration * h;
        self.look(soup, h);
        for _ in 0..4 {
            for touch in self.touches.as_slice() {
                let least = touch.depth.min(0.0) / h;
                self.v += touch.normal * (least - self.v.dot(touch.normal)).max(0.0);
            }
        }
        self.p += self.v * h;
        for touch in self.touches.as_slice() {
            self.p += touch.normal * (0.5 * touch.depth).clamp(0.0, 0.3 * h);
        }
    }

    /// Lets positive depths be pushed out, without motion.
    fn settle(&mut self, soup: &Soup) {
        self.v = DVec3::ZERO;
        for _ in 0..200 {
            self.look(soup, 1.0e-3);
            for touch in self.touches.as_slice() {
                self.p += touch.normal * (0.5 * touch.depth).max(0.0);
            }
        }
    }
}
