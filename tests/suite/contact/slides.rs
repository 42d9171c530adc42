//! A block slides over the inner edges of floors as over one plate.

use super::{corners, flat_field, grid_mesh, voxel_floor};
use crate::support::close;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Mean acceleration between .4 and 1 s, down 30°, μ = .2 \[m/s²\].
fn acceleration(floor: ColliderBuilder) -> f64 {
    acceleration_on(vec![floor])
}

fn acceleration_on(floors: Vec<ColliderBuilder>) -> f64 {
    let (sin, cos) = std::f32::consts::FRAC_PI_6.sin_cos();
    let mut world = PhysicsWorld {
        gravity: 9.81 * Vector::new(sin, -cos, 0.0),
        ..PhysicsWorld::default()
    };
    for floor in floors {
        world.insert(RigidBodyBuilder::fixed(), floor.friction(0.2));
    }
    let mut deformables = DeformableWorld::default();
    let handle = deformables
        .insert(
            DeformableBuilder::new(lattice(Vector::new(0.3, 0.2, 0.3), 0.1))
                .material(Material::elastic(5.0e6, 1000.0).viscosity(1.0e4))
                .friction(0.2)
                .translation(Vector::new(0.0, 0.1, 0.0)),
        )
        .unwrap();
    let mut run = |frames| {
        for _ in 0..frames {
            deformables.step(&mut world);
        }
        deformables[handle].linvel().x
    };
    let before = run(24);
    (run(36) - before) / 0.6
}

#[test]
fn inner_edges_are_not_felt() {
    let boxes = (0..20)
        .map(|i| {
            (
                Pose::from_translation(Vector::new(-1.0 + 0.37 * i as f32, -0.5, 0.0)),
                SharedShape::cuboid(0.185, 0.5, 1.0),
            )
        })
        .collect();
    let points = corners(Vector::new(-1.0, -1.0, -1.0), Vector::new(5.0, 0.0, 1.0));
    let mesh = |flags| grid_mesh((-1.0, -1.0), (6.0, 2.0), (36, 13), flags);
    let shift = Vector::new(0.0, -0.5, 0.0);
    for (name, floor) in [
        (
            "cuboid",
            ColliderBuilder::cuboid(8.0, 0.5, 1.0).translation(shift),
        ),
        ("mesh", mesh(TriMeshFlags::empty())),
        (
            "mesh of fixed edges",
            mesh(TriMeshFlags::FIX_INTERNAL_EDGES),
        ),
        ("height field", flat_field(12.0, 2.0, 0.125)),
        ("compound", ColliderBuilder::compound(boxes)),
        ("voxels", voxel_floor([-8, -8], [40, 8], 0.125)),
        ("hull", ColliderBuilder::convex_hull(&points).unwrap()),
    ] {
        let a = acceleration(floor);
        println!("{name}: {a}");
        close(name, a, 3.205858, 0.01);
    }
}

/// Tiles that are bodies of their own: nodes a nanometre too low, and upright edges, do not meet the sides of the next one.
#[test]
fn joints_between_bodies_are_not_felt() {
    let tiles = (0..20).map(|i| {
        let middle = Vector::new(-1.0 + 0.37 * i as f32, -0.5, 0.0);
        ColliderBuilder::cuboid(0.185, 0.5, 1.0).translation(middle)
    });
    close("tiles", acceleration_on(tiles.collect()), 3.205858, 0.01);
}
