//! Contact of nodes with every shape a collider can have.

mod across;
mod blow;
mod brinks;
mod changes;
mod coarse;
pub mod embed;
mod fast;
mod features;
mod hollows;
mod pinned;
mod presses;
mod ridges;
mod seams;
mod shapes;
mod shots;
mod slabs;
mod slides;
mod spinning;
mod squeezed;
mod surface;
mod tears;
mod tubes;
mod yielding;

pub use crate::support::Random;
use crumple::prelude::*;
use crumple::rapier3d::parry::utils::Array2;
use crumple::rapier3d::prelude::*;

/// A soft, damped cube of .3 m with 4 nodes along each edge.
pub fn block() -> DeformableBuilder {
    DeformableBuilder::new(lattice(Vector::splat(0.3), 0.1))
        .material(Material::elastic(2.0e5, 200.0).viscosity(2.0e3))
}

/// Corners of a box.
pub fn corners(lo: Vector, hi: Vector) -> Vec<Vector> {
    let pick = |i: u32, axis: u32, lo: f32, hi: f32| if i >> axis & 1 == 1 { hi } else { lo };
    (0..8)
        .map(|i| {
            Vector::new(
                pick(i, 0, lo.x, hi.x),
                pick(i, 1, lo.y, hi.y),
                pick(i, 2, lo.z, hi.z),
            )
        })
        .collect()
}

/// The surface of a box, wound outwards.
pub fn box_mesh(lo: Vector, hi: Vector, flags: TriMeshFlags) -> ColliderBuilder {
    let indices = vec![
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ];
    ColliderBuilder::trimesh_with_flags(corners(lo, hi), indices, flags).unwrap()
}

/// A flat mesh in y = 0 of `n` by `m` cells over `x` by `z` m, its corner at (`x0`, `z0`).
pub fn grid_mesh(
    (x0, z0): (f32, f32),
    (x, z): (f32, f32),
    (n, m): (u32, u32),
    flags: TriMeshFlags,
) -> ColliderBuilder {
    let mut vertices = Vec::new();
    let mut indices = Vec::new();
    for i in 0..=n {
        for j in 0..=m {
            vertices.push(Vector::new(
                x0 + x * i as f32 / n as f32,
                0.0,
                z0 + z * j as f32 / m as f32,
            ));
        }
    }
    let at = |i: u32, j: u32| i * (m + 1) + j;
    for i in 0..n {
        for j in 0..m {
            indices.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            indices.push([at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
        }
    }
    ColliderBuilder::trimesh_with_flags(vertices, indices, flags).unwrap()
}

/// A flat height field at y = 0, of cells of `cell` m, `x` by `z` m about the origin.
pub fn flat_field(x: f32, z: f32, cell: f32) -> ColliderBuilder {
    let (rows, columns) = ((z / cell) as usize + 1, (x / cell) as usize + 1);
    ColliderBuilder::heightfield(Array2::repeat(rows, columns, 0.0), Vector::new(x, 1.0, z))
}

/// A floor of voxels with its top at y = 0.
pub fn voxel_floor(from: [i32; 2], to: [i32; 2], size: f32) -> ColliderBuilder {
    let mut cells = Vec::new();
    for x in from[0]..to[0] {
        for z in from[1]..to[1] {
            cells.push(IVector::new(x, -1, z));
        }
    }
    ColliderBuilder::voxels(Vector::splat(size), &cells)
}
