//! A triangle surface, and whether it bounds a solid.
//!
//! It lives beside the net rather than in the importer, because filling a surface must work for one made in code too.
//! The checks name the first bad triangle, edge or pair: a mesh that is almost closed is repaired by looking at that
//! place, not by a message that it is bad.

use super::BuildError;
use super::crossing::{cross, longest_side, normal};
use crate::math::{DVec3, Vector, wide};
use std::collections::BTreeMap;
use std::ops::Range;

/// Triangles over shared vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Positions \[m\].
    pub vertices: Vec<Vector>,
    /// Indices of vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Named runs of triangles, such as the glass of a car; may be empty.
    pub groups: Vec<Group>,
}

/// A named run of a surface's triangles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Its name, as in the file.
    pub name: String,
    /// Indices of its triangles.
    pub triangles: Range<usize>,
}

impl Surface {
    /// A surface without groups.
    pub fn new(vertices: Vec<Vector>, triangles: Vec<[u32; 3]>) -> Self {
        Self {
            vertices,
            triangles,
            groups: Vec::new(),
        }
    }

    /// Checks that there are triangles, all of finite vertices and none without area.
    ///
    /// # Errors
    /// [`BuildError::Empty`] without triangles, [`BuildError::NodeVector`] for a vertex that is not finite,
    /// [`BuildError::IndexOutOfRange`] or [`BuildError::FlatTriangle`].
    pub fn check_triangles(&self) -> Result<(), BuildError> {
        if self.triangles.is_empty() {
            return Err(BuildError::Empty);
        }
        if let Some(node) = self.vertices.iter().position(|v| !v.is_finite()) {
            return Err(BuildError::NodeVector {
                node: node as u32,
                what: "position of the surface's vertex",
                value: self.vertices[node],
            });
        }
        let count = self.vertices.len() as u32;
        for (index, &triangle) in self.triangles.iter().enumerate() {
            if let Some(&node) = triangle.iter().find(|&&v| v >= count) {
                return Err(BuildError::IndexOutOfRange {
                    what: "surface triangle",
                    index: index as u32,
                    node,
                    count,
                });
            }
            let corners = self.corners(index);
            let area = 0.5 * normal(corners).length();
            let side = longest_side(corners);
            // Below this the normal is rounding noise of the f32 positions.
            if area <= 1.0e-9 * side * side {
                return Err(BuildError::FlatTriangle {
                    triangle: index as u32,
                    area: area as f32,
                });
            }
        }
        Ok(())
    }

    /// Checks that the surface is watertight: sound triangles, and every edge in exactly two of them, which run along it in
    /// opposite directions.
    ///
    /// # Errors
    /// Those of [`Self::check_triangles`], and [`BuildError::OpenSurface`].
    pub fn check_closed(&self) -> Result<(), BuildError> {
        self.check_triangles()?;
        // Per edge, low vertex first: uses in that direction and in the other.
        let mut edges = BTreeMap::<(u32, u32), (u32, u32)>::new();
        for &triangle in &self.triangles {
            for (a, b) in edges_of(triangle) {
                let uses = edges.entry((a.min(b), a.max(b))).or_default();
                *(if a < b { &mut uses.0 } else { &mut uses.1 }) += 1;
            }
        }
        match edges.iter().find(|(_, uses)| **uses != (1, 1)) {
            Some((&(a, b), &(along, against))) => Err(BuildError::OpenSurface {
                a,
                b,
                triangles: along + against,
            }),
            None => Ok(()),
        }
    }

    /// Checks that no two triangles cross. Triangles that share a vertex are not compared: their common point would have
    /// to be told from a crossing by rounding alone. Touching is not crossing. Call
    /// [`check_closed`](Self::check_closed) first: indices are taken as valid.
    ///
    /// # Errors
    /// [`BuildError::SelfIntersecting`] with one crossing pair.
    pub fn check_self_intersection(&self) -> Result<(), BuildError> {
        let corners: Vec<_> = (0..self.triangles.len()).map(|t| self.corners(t)).collect();
        let boxes: Vec<(DVec3, DVec3)> = corners
            .iter()
            .map(|c| (c[0].min(c[1]).min(c[2]), c[0].max(c[1]).max(c[2])))
            .collect();
        let (lo, hi) = boxes.iter().fold(
            (DVec3::INFINITY, DVec3::NEG_INFINITY),
            |(lo, hi), (a, b)| (lo.min(*a), hi.max(*b)),
        );
        // A sweep along the longest axis: few thousand triangles need no tree.
        let extent = (hi - lo).to_array();
        let axis = (0..3).fold(0, |best, d| if extent[d] > extent[best] { d } else { best });
        let mut order: Vec<usize> = (0..boxes.len()).collect();
        order.sort_by(|&a, &b| {
            boxes[a].0[axis]
                .total_cmp(&boxes[b].0[axis])
                .then(a.cmp(&b))
        });
        let tolerance = 1.0e-7 * extent[axis];
        for (place, &a) in order.iter().enumerate() {
            for &b in &order[place + 1..] {
                if boxes[b].0[axis] > boxes[a].1[axis] {
                    break;
                }
                let apart =
                    boxes[a].0.cmpgt(boxes[b].1).any() || boxes[b].0.cmpgt(boxes[a].1).any();
                let shared = || {
                    self.triangles[a]
                        .iter()
                        .any(|v| self.triangles[b].contains(v))
                };
                if !apart && !shared() && cross(corners[a], corners[b], tolerance) {
                    return Err(BuildError::SelfIntersecting {
                        first: a.min(b) as u32,
                        second: a.max(b) as u32,
                    });
                }
            }
        }
        Ok(())
    }

    /// Enclosed volume \[m³\], by the divergence theorem; negative where the triangles are clockwise seen from outside.
    pub fn volume(&self) -> f64 {
        let origin = self.vertices.first().map_or(DVec3::ZERO, |v| wide(*v));
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t).map(|p| p - origin);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    /// The corners of a triangle \[m\].
    pub(crate) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| wide(self.vertices[v as usize]))
    }
}

fn edges_of([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::math::Real;

    /// A box with corners `lo` and `hi`.
    pub(crate) fn cuboid(lo: [Real; 3], hi: [Real; 3]) -> Surface {
        let net = crate::shape::lattice(Vector::ONE, 1.0).unwrap();
        let (lo, hi) = (Vector::from_array(lo), Vector::from_array(hi));
        let at = |v: Vector| lo + (v + 0.5) * (hi - lo);
        Surface::new(
            net.nodes.iter().map(|n| at(n.position)).collect(),
            net.faces,
        )
    }

    /// Both surfaces as one.
    pub(crate) fn joined(mut a: Surface, b: &Surface) -> Surface {
        let base = a.vertices.len() as u32;
        a.vertices.extend(&b.vertices);
        a.triangles
            .extend(b.triangles.iter().map(|t| t.map(|v| v + base)));
        a
    }

    #[test]
    fn a_box_is_closed_and_has_its_volume() {
        let surface = cuboid([1.0, 2.0, 3.0], [2.0, 4.0, 6.0]);
        surface.check_closed().unwrap();
        surface.check_self_intersection().unwrap();
        assert!((surface.volume() - 6.0).abs() < 1e-6);
    }

    #[test]
    fn open_flat_and_bad_surfaces_are_named() {
        let good = cuboid([0.0; 3], [1.0; 3]);
        let mut bad = good.clone();
        bad.triangles.pop();
        assert!(matches!(
            bad.check_closed(),
            Err(BuildError::OpenSurface { triangles: 1, .. })
        ));
        let mut bad = good.clone();
        bad.triangles[0].swap(0, 1);
        assert!(matches!(
            bad.check_closed(),
            Err(BuildError::OpenSurface { triangles: 2, .. })
        ));
        let mut bad = good.clone();
        bad.triangles[3][1] = bad.triangles[3][0];
        assert!(matches!(
            bad.check_closed(),
            Err(BuildError::FlatTriangle { triangle: 3, .. })
        ));
        let mut bad = good.clone();
        bad.triangles[3][1] = 8;
        assert!(matches!(
            bad.check_closed(),
            Err(BuildError::IndexOutOfRange { node: 8, .. })
        ));
        let mut bad = good;
        bad.vertices[2].y = Real::NAN;
        assert!(matches!(
            bad.check_closed(),
            Err(BuildError::NodeVector { node: 2, .. })
        ));
        assert_eq!(Surface::default().check_closed(), Err(BuildError::Empty));
    }

    #[test]
    fn crossings_are_found_and_touching_is_not_one() {
        let a = cuboid([0.0; 3], [1.0; 3]);
        for lo in [
            [0.5, 0.5, 0.5],
            [0.3, 0.4, 0.6],
            [0.5, 0.0, 0.0],
            [0.2, 0.2, -0.5],
        ] {
            let b = cuboid(lo, lo.map(|v| v + 1.0));
            let both = joined(a.clone(), &b);
            both.check_closed().unwrap();
            let found = both.check_self_intersection();
            assert!(
                matches!(found, Err(BuildError::SelfIntersecting { .. })),
                "{lo:?}: {found:?}"
            );
        }
        for (lo, hi) in [([2.0; 3], [3.0; 3]), ([0.25; 3], [0.75; 3])] {
            joined(a.clone(), &cuboid(lo, hi))
                .check_self_intersection()
                .unwrap();
        }
    }
}
