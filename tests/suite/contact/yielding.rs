//! Contact that yields by a stiffness: what touches is millimetres deep, and slides on from face to face there.

use super::{box_mesh, corners};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Name, collider and half height of bodies that lie flat.
fn flat_bodies() -> [(&'static str, ColliderBuilder, f32); 7] {
    let half = Vector::splat(0.02);
    let cells: Vec<IVector> = (0..8)
        .map(|i| IVector::new(i & 1, i >> 1 & 1, i >> 2) - IVector::splat(1))
        .collect();
    let hull = ColliderBuilder::convex_hull(&corners(-half, half)).unwrap();
    [
        ("cube", ColliderBuilder::cuboid(0.02, 0.02, 0.02), 0.02),
        ("hull", hull, 0.02),
        ("mesh", box_mesh(-half, half, TriMeshFlags::ORIENTED), 0.02),
        ("voxels", ColliderBuilder::voxels(half, &cells), 0.02),
        ("cylinder", ColliderBuilder::cylinder(0.02, 0.03), 0.02),
        ("cone", ColliderBuilder::cone(0.02, 0.03), 0.02),
        ("plate", ColliderBuilder::cuboid(0.05, 5e-4, 0.03), 5e-4),
    ]
}

/// Height of a small body over the undeformed top of a block of 10 cm cells, 2 s after it fell on it from 2 cm.
fn rest(small: &ColliderBuilder, half: f32, at: [f32; 2], stiffness: Option<f32>) -> f32 {
    let mut world = PhysicsWorld::default();
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::Y * -0.5),
        ColliderBuilder::cuboid(5.0, 0.5, 5.0),
    );
    let start = Vector::new(at[0], 0.2 + half + 0.02, at[1]);
    let (body, _) = world.insert(
        RigidBodyBuilder::dynamic().translation(start),
        small.clone().friction(0.5),
    );
    let block = DeformableBuilder::new(lattice(Vector::new(0.4, 0.2, 0.4), 0.1))
        .material(Material::elastic(3e5, 300.0).viscosity(3e3))
        .friction(0.5)
        .translation(Vector::Y * 0.1);
    let block = match stiffness {
        Some(stiffness) => block.contact_stiffness(stiffness),
        None => block,
    };
    let mut set = DeformableWorld::default();
    set.insert(block).unwrap();
    for _ in 0..120 {
        set.step(&mut world);
    }
    world.bodies[body].translation().y - 0.2
}

/// Symptom: what was pressed deeper than it comes in a substep, where two faces meet or from one edge to the next, sank in up to
/// its middle, or through.
#[test]
fn small_bodies_lie_as_deep_as_the_stiffness_says() {
    const STIFFNESS: f32 = 2e4;
    for (name, small, half) in flat_bodies() {
        for mass in [1.0, 10.0] {
            for at in [[0.03, 0.02], [0.0, 0.0], [0.08, 0.01], [0.05, 0.05]] {
                let small = small.clone().mass(mass);
                let hard = rest(&small, half, at, None);
                let yielding = rest(&small, half, at, Some(STIFFNESS));
                // 25 nodes bear the block and at least three points the body, not all alike.
                let deeper = hard - yielding;
                let most = 9.81 * ((9.6 + mass) / 19.0 + mass / 2.0) / STIFFNESS;
                assert!(
                    (0.0..most).contains(&deeper),
                    "{name}, {mass} kg at {at:?}: {yielding} m, {hard} m if nothing yields"
                );
            }
        }
    }
}

/// A block of 4 kg falls by 1 cm on contacts of 3 kN/m a node, at the substeps that it needs by itself. A spring gives back what it took;
/// implicit Euler kept a tenth of it at every bounce.
#[test]
fn contacts_that_give_lose_nothing() {
    for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
        let mut world = PhysicsWorld::default();
        world.integration_parameters.dt = 1.0 / 240.0;
        world.insert(
            RigidBodyBuilder::fixed().translation(Vector::Y * -0.5),
            ColliderBuilder::cuboid(5.0, 0.5, 5.0),
        );
        let drop = 0.01;
        let block = DeformableBuilder::new(lattice(Vector::splat(0.2), 0.1))
            .material(Material::elastic(2e7, 500.0))
            .translation(Vector::Y * (0.1 + drop))
            .contact_stiffness(3e3)
            .integrator(integrator);
        let mut set = DeformableWorld::default();
        let block = set.insert(block).unwrap();
        let energy = set[block].mass() * 9.81 * f64::from(drop);
        let (mut fell, mut rose) = (false, false);
        for _ in 0..60 {
            set.step(&mut world);
            let e = set[block].energies();
            let now = e.kinetic + e.elastic + e.gravity + energy;
            assert!(now <= 1.0001 * energy, "{now} J of {energy} J");
            let speed = set[block].momentum().y;
            fell |= speed < 0.0;
            rose |= fell && speed > 0.0;
            if rose && speed < 0.0 {
                break;
            }
        }
        let lost = set[block].energies().work.contact_normal / energy;
        assert!(rose && (0.0..5e-4).contains(&lost), "{lost} of the energy");
    }
}
