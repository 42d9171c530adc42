//! Ground by a formula: a height field, or a mesh of the same triangles.

use super::super::check::FARTHEST;
use super::super::model::shape::Relief;
use crate::math::{Real, Vector};
use rapier3d::geometry::SharedShape;
use rapier3d::parry::shape::HeightField;
use rapier3d::parry::utils::Array2;

/// Most points of one ground.
const MOST: f64 = 1.0e6;

/// The shape over a rectangle of this size, as close to square cells of this side as fit \[m\].
pub(super) fn terrain(
    height: &Relief,
    [length, width]: [f64; 2],
    cell: f64,
    mesh: bool,
) -> Result<SharedShape, &'static str> {
    let count = |side: f64| (side / cell).round().max(1.0) + 1.0;
    if count(length) * count(width) > MOST {
        return Err("a ground has at most a million points; use larger cells");
    }
    let (rows, columns) = (count(width) as usize, count(length) as usize);
    let at = |i: usize, n: usize, side: f64| (i as f64 / (n - 1) as f64 - 0.5) * side;
    let mut heights = Array2::repeat(rows, columns, 0.0);
    for i in 0..rows {
        for j in 0..columns {
            let (x, z) = (at(j, columns, length), at(i, rows, width));
            let y = height.0.value(&[x, z]) as Real;
            if y.is_nan() || y.abs() > FARTHEST as Real {
                return Err(
                    "the height of the ground must be a number and at most 1e6 m, everywhere",
                );
            }
            heights[(i, j)] = y;
        }
    }
    let size = Vector::new(length as Real, 1.0, width as Real);
    match mesh {
        false => Ok(SharedShape::heightfield(heights, size)),
        true => triangles(&HeightField::new(heights, size), [rows, columns], size),
    }
}

/// The triangles of a height field over shared vertices.
fn triangles(
    field: &HeightField,
    [rows, columns]: [usize; 2],
    size: Vector,
) -> Result<SharedShape, &'static str> {
    let index = |x: Real, side: Real, n: usize| ((x / side + 0.5) * (n - 1) as Real).round() as u32;
    let mut vertices = vec![Vector::ZERO; rows * columns];
    let triangles = field.triangles().map(|t| {
        [t.a, t.b, t.c].map(|p| {
            let id = index(p.z, size.z, rows) * columns as u32 + index(p.x, size.x, columns);
            vertices[id as usize] = p;
            id
        })
    });
    let triangles = triangles.collect();
    SharedShape::trimesh(vertices, triangles).map_err(|_| "Rapier can't make a mesh of this ground")
}
