//! The skin of a filled surface: which eight nodes carry each vertex.
//!
//! A vertex is bound to one cell, by the weights of its trilinear map at rest, so that the skin follows shear and bending
//! of the cell and not only its corners' mean. Vertices stick out of the cells by up to about half of one; extrapolating
//! further than that by a cubic would magnify every wrinkle, so there the cell's mean affine map takes over.

use super::cells::CellGrid;
use super::hexahedron;
use crate::body::{Binding, Skin, Surface};
use crate::math::{DVec3, Real, wide};

/// How far outside a cell its trilinear weights are still used for the skin, per cell size \[1\].
const EXTRAPOLATION: f64 = 0.5;

/// Binds every vertex of the surface to the cell it is least outside of.
pub(super) fn bind(
    surface: &Surface,
    grid: &CellGrid,
    places: &[DVec3],
    node_of: &[u32],
    origin: DVec3,
    side: f64,
) -> Skin {
    let bind = |vertex: DVec3| {
        let at = ((vertex - origin) / side)
            .floor()
            .to_array()
            .map(|v| v as i64);
        let mut best: Option<(f64, usize, [f64; 8])> = None;
        for c in nearby(grid, at) {
            let corners = grid.places(c, places);
            let trilinear = hexahedron::inverse(&corners, vertex, 1.0e-7 * side)
                .map(|xi| ((xi - 0.5).abs().max_element() - 0.5, xi))
                .filter(|(outside, _)| *outside <= EXTRAPOLATION);
            let (outside, weights) = match trilinear {
                Some((outside, xi)) => (outside, hexahedron::weights(xi)),
                // Ranked behind every trilinear one, and among themselves by distance.
                None => {
                    let centre = hexahedron::blend(&corners, &[0.125; 8]);
                    let rank = EXTRAPOLATION + centre.distance(vertex) / side;
                    (rank, hexahedron::affine_weights(&corners, vertex))
                }
            };
            if best.as_ref().is_none_or(|b| outside < b.0) {
                best = Some((outside, c, weights));
            }
        }
        best.map_or_else(Binding::default, |(_, c, weights)| Binding {
            nodes: grid.corners(grid.cell_at(c)).map(|p| node_of[p]),
            weights: weights.map(|w| w as Real),
        })
    };
    Skin {
        vertices: surface.vertices.clone(),
        triangles: surface.triangles.clone(),
        bindings: surface.vertices.iter().map(|v| bind(wide(*v))).collect(),
        touches: false,
    }
}

/// The solid cells in the smallest cube of cells around `at` that has any, and in the next larger one.
fn nearby(grid: &CellGrid, at: [i64; 3]) -> Vec<usize> {
    let farthest = grid.counts.iter().max().map_or(0, |n| *n as i64) + 1;
    let within = |r: i64| {
        let mut cells = Vec::new();
        for k in -r..=r {
            for j in -r..=r {
                for i in -r..=r {
                    cells.extend(grid.solid([at[0] + i, at[1] + j, at[2] + k]));
                }
            }
        }
        cells
    };
    let first = (0..=farthest).find(|&r| !within(r).is_empty());
    within(first.unwrap_or(farthest) + 1)
}
