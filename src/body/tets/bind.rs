//! Binding a surface to a mesh: which tet carries each vertex.
//!
//! The point of a tet with barycentric coordinates Lᵢ follows its corners as Σ Lᵢ·xᵢ. A quadratic tet counts as the eight
//! linear ones that its middle nodes cut it into, which is how its own surface is touched, and keeps weights positive.
//! A vertex outside of the mesh is carried by the tet that it is least outside of.

use super::{TetMesh, Tets};
use crate::body::{Binding, BuildError, Skin, Surface};
use crate::law::basis::edge;
use crate::math::{DMat3, DVec3, Real, wide};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};

/// How far outside of a tet a vertex may be, as its most negative barycentric coordinate: farther out a turn of the tet is
/// magnified to a tear.
const OUTSIDE: f64 = 1.0;

/// A tet, to find barycentric coordinates in.
struct Cell {
    nodes: [u32; 4],
    corner: DVec3,
    inverse: DMat3,
}

impl Cell {
    fn new(nodes: [u32; 4], at: &[DVec3]) -> Self {
        let [a, b, c, d] = nodes.map(|n| at[n as usize]);
        Self {
            nodes,
            corner: a,
            inverse: DMat3::from_cols(b - a, c - a, d - a).inverse(),
        }
    }

    fn barycentric(&self, x: DVec3) -> [f64; 4] {
        let l = self.inverse * (x - self.corner);
        [1.0 - l.x - l.y - l.z, l.x, l.y, l.z]
    }
}

/// The most negative coordinate.
fn least(l: [f64; 4]) -> f64 {
    l.into_iter().fold(f64::INFINITY, f64::min)
}

impl TetMesh {
    /// Binds a surface to the mesh, for [`DeformableBuilder::embed`](crate::world::DeformableBuilder::embed).
    ///
    /// # Errors
    /// [`BuildError::Empty`] for a surface without triangles, [`BuildError::NodeVector`] for a vertex that is not finite,
    /// [`BuildError::IndexOutOfRange`] for a triangle of vertices that it has not, [`BuildError::FlatTriangle`],
    /// [`BuildError::SkinOutside`] for a vertex farther from every tet than that is thick.
    pub fn bind(&self, surface: &Surface) -> Result<Skin, BuildError> {
        surface.check_triangles()?;
        let cells = self.cells();
        let boxes = cells.iter().map(|cell| {
            let corners = cell.nodes.map(|n| self.nodes[n as usize].as_vec3());
            Aabb::from_points(corners)
        });
        let boxes: Vec<Aabb> = boxes.collect();
        let tree = Bvh::from_leaves(BvhBuildStrategy::default(), &boxes);
        let mut bindings = Vec::with_capacity(surface.vertices.len());
        for (vertex, at) in surface.vertices.iter().enumerate() {
            let x = wide(*at);
            let margin = 1e-5 * (1.0 + at.abs().max_element());
            let here = Aabb::new(*at - margin, *at + margin);
            let around = tree.intersect_aabb(&here).map(|i| i as usize);
            let inside = best(around, &cells, x).filter(|(_, l)| least(*l) >= -1e-4);
            let found = inside.or_else(|| best(0..cells.len(), &cells, x));
            let (cell, l) = found.ok_or(BuildError::Empty)?;
            if least(l) < -OUTSIDE {
                return Err(BuildError::SkinOutside {
                    vertex: vertex as u32,
                    position: *at,
                });
            }
            bindings.push(binding(cells[cell].nodes, l));
        }
        Ok(Skin {
            vertices: surface.vertices.clone(),
            triangles: surface.triangles.clone(),
            bindings,
            touches: true,
        })
    }

    fn cells(&self) -> Vec<Cell> {
        let all = match &self.tets {
            Tets::Linear(tets) => tets.clone(),
            Tets::Quadratic(tets) => tets.iter().flat_map(eight).collect(),
        };
        let cells = all.into_iter().map(|nodes| Cell::new(nodes, &self.nodes));
        cells.filter(|c| c.inverse.is_finite()).collect()
    }
}

/// How far from 0 a weight is rounding noise: what lies on a node, an edge or a face is carried by its nodes alone.
const NOISE: f64 = 1e-6;

fn binding(nodes: [u32; 4], l: [f64; 4]) -> Binding {
    let mut binding = Binding::default();
    let kept = l.map(|l| if l.abs() < NOISE { 0.0 } else { l });
    let sum: f64 = kept.iter().sum();
    binding.nodes[..4].copy_from_slice(&nodes);
    binding.weights[..4].copy_from_slice(&kept.map(|l| (l / sum) as Real));
    binding
}

/// The cell that a point is least outside of.
fn best(among: impl Iterator<Item = usize>, cells: &[Cell], x: DVec3) -> Option<(usize, [f64; 4])> {
    let coordinates = among.map(|i| (i, cells[i].barycentric(x)));
    coordinates.max_by(|a, b| least(a.1).total_cmp(&least(b.1)).then(b.0.cmp(&a.0)))
}

/// The linear tets that a quadratic one is cut into: one at each corner, and the octahedron between them in four.
fn eight(t: &[u32; 10]) -> [[u32; 4]; 8] {
    let m = |a, b| t[4 + edge(a, b)];
    let [m01, m02, m03, m12, m13, m23] = [m(0, 1), m(0, 2), m(0, 3), m(1, 2), m(1, 3), m(2, 3)];
    [
        [t[0], m01, m02, m03],
        [t[1], m01, m13, m12],
        [t[2], m02, m12, m23],
        [t[3], m03, m23, m13],
        [m01, m23, m02, m03],
        [m01, m23, m03, m13],
        [m01, m23, m13, m12],
        [m01, m23, m12, m02],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::shape::{TetSplit, tet_box};
    use crate::math::Vector;

    fn at(mesh: &TetMesh, binding: &Binding) -> DVec3 {
        let parts = binding.parts();
        parts.map(|(node, weight)| mesh.nodes[node] * weight).sum()
    }

    /// Points in and around a box are where they were bound, by weights that sum to one and are positive inside.
    #[test]
    fn vertices_are_where_they_were() {
        let mesh = tet_box(Vector::splat(1.0), 0.5, TetSplit::Five).unwrap();
        for mesh in [mesh.clone(), mesh.quadratic()] {
            let grid = (0..6 * 6 * 6).map(|i| {
                let [x, y, z] = [i % 6, i / 6 % 6, i / 36].map(|c| c as f32 / 5.0 - 0.5);
                Vector::new(x, y, z) * 1.1
            });
            let surface = Surface::new(grid.collect(), vec![[0, 1, 6]]);
            let skin = mesh.bind(&surface).unwrap();
            for (vertex, binding) in surface.vertices.iter().zip(&skin.bindings) {
                let moved = at(&mesh, binding).distance(wide(*vertex));
                assert!(moved < 1e-5, "{vertex} is bound {moved} m off");
                let sum: f32 = binding.weights.iter().sum();
                assert!((sum - 1.0).abs() < 1e-5);
                let inside = vertex.abs().max_element() < 0.5;
                assert!(!inside || binding.weights.iter().all(|w| *w > -1e-4));
            }
        }
    }

    #[test]
    fn bad_surfaces_are_named() {
        let mesh = tet_box(Vector::splat(1.0), 0.5, TetSplit::Five).unwrap();
        let corners = |far: f32| vec![Vector::X * far, Vector::Y * 0.1, Vector::Z * 0.1];
        let bind = |v, t| mesh.bind(&Surface::new(v, t)).unwrap_err();
        let far = bind(corners(9.0), vec![[0, 1, 2]]);
        assert!(
            matches!(far, BuildError::SkinOutside { vertex: 0, .. }),
            "{far}"
        );
        let index = bind(corners(0.2), vec![[0, 1, 3]]);
        assert!(
            matches!(index, BuildError::IndexOutOfRange { node: 3, .. }),
            "{index}"
        );
        let nan = bind(corners(f32::NAN), vec![[0, 1, 2]]);
        assert!(
            matches!(nan, BuildError::NodeVector { node: 0, .. }),
            "{nan}"
        );
        assert_eq!(bind(corners(0.2), vec![]), BuildError::Empty);
    }
}
