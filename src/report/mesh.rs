//! A triangle mesh with a colour at each vertex: what a skin, a crate or a wall is drawn from.
//!
//! Nothing about it is checked when it is made, because a diverging body has NaN positions and its picture is then wanted
//! most: drawing skips what can't be drawn, triangle by triangle.

use crate::math::Vector;
use std::collections::HashMap;

/// Triangles over common vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions \[m\].
    pub vertices: Vec<Vector>,
    /// Display RGB, 0 to 1, of each vertex; a vertex without one is a light grey.
    pub colors: Vec<[f32; 3]>,
    /// Corners of each triangle; both sides are drawn.
    pub triangles: Vec<[u32; 3]>,
    /// Shades over the edges as if the surface were curved; needs triangles that turn the same way around. Otherwise each
    /// triangle is flat.
    pub smooth: bool,
}

impl Mesh {
    /// A mesh of one colour, flat.
    pub fn new(vertices: Vec<Vector>, triangles: Vec<[u32; 3]>, color: [f32; 3]) -> Self {
        Self {
            colors: vec![color; vertices.len()],
            vertices,
            triangles,
            smooth: false,
        }
    }

    /// The same mesh with a colour for each vertex.
    pub fn colored(self, colors: Vec<[f32; 3]>) -> Self {
        Self { colors, ..self }
    }

    /// The same mesh, shaded smoothly.
    pub fn smooth(self) -> Self {
        Self {
            smooth: true,
            ..self
        }
    }

    /// The smallest box that holds every finite vertex \[m\]; `None` without any.
    pub fn bounds(&self) -> Option<(Vector, Vector)> {
        let finite = self.vertices.iter().copied().filter(|v| v.is_finite());
        finite
            .map(|v| (v, v))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Corners of a triangle, where all three exist and are finite.
    pub(super) fn corners(&self, triangle: [u32; 3]) -> Option<[Vector; 3]> {
        let at = |i: u32| {
            self.vertices
                .get(i as usize)
                .copied()
                .filter(|v| v.is_finite())
        };
        Some([at(triangle[0])?, at(triangle[1])?, at(triangle[2])?])
    }

    /// The colour of a vertex.
    pub(super) fn color(&self, vertex: u32) -> [f32; 3] {
        self.colors
            .get(vertex as usize)
            .copied()
            .unwrap_or([0.75; 3])
    }

    /// Normals of the vertices, weighted by area; zero where a vertex has no triangle.
    pub(super) fn normals(&self) -> Vec<Vector> {
        let mut normals = vec![Vector::ZERO; self.vertices.len()];
        for &triangle in &self.triangles {
            if let Some(p) = self.corners(triangle) {
                let normal = (p[1] - p[0]).cross(p[2] - p[0]);
                for i in triangle {
                    normals[i as usize] += normal;
                }
            }
        }
        normals
            .into_iter()
            .map(|n| n.try_normalize().unwrap_or(Vector::ZERO))
            .collect()
    }

    /// Edges that outline the mesh: those of one triangle only, and those over which the surface turns by more than 30°.
    pub(super) fn outline(&self) -> Vec<[Vector; 2]> {
        let mut edges: HashMap<[u32; 2], Vec<Vector>> = HashMap::new();
        for &triangle in &self.triangles {
            let Some(p) = self.corners(triangle) else {
                continue;
            };
            let Some(normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else {
                continue;
            };
            for k in 0..3 {
                let [a, b] = [triangle[k], triangle[(k + 1) % 3]];
                edges.entry([a.min(b), a.max(b)]).or_default().push(normal);
            }
        }
        let sharp = |normals: &[Vector]| match normals {
            [a, b] => a.dot(*b) < 0.866,
            _ => true,
        };
        let mut kept: Vec<[u32; 2]> = edges
            .into_iter()
            .filter(|e| sharp(&e.1))
            .map(|e| e.0)
            .collect();
        kept.sort_unstable();
        kept.into_iter()
            .map(|e| e.map(|i| self.vertices[i as usize]))
            .collect()
    }
}
