//! Impacts on free and on jointed bodies.

use super::{Mode, block, cuboid};
use crate::support::{close, weightless};
use crumple::rapier3d::prelude::*;
use crumple::math::DVec3;

fn momentum(world: &PhysicsWorld) -> DVec3 {
    world
        .bodies
        .iter()
        .map(|(_, b)| b.linvel().as_dvec3() * f64::from(b.mass()))
        .sum()
}

/// A 4 kg block, E = 1 MPa, at 20 m/s into a free box of 5 kg.
#[test]
fn fast_block_into_a_free_box() {
    let mut speeds = Vec::new();
    for mode in Mode::BOTH {
        let mut world = weightless(1.0 / 60.0);
        let (body, _) = world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::new(0.5, 0.0, 0.0)),
            cuboid([0.2; 3], 5.0),
        );
        let mut deformables = mode.deformables();
        let soft = deformables
            .insert(block(4.0, 1e6).linvel(Vector::new(20.0, 0.0, 0.0)))
            .unwrap();
        let before = momentum(&world) + deformables[soft].momentum();
        for _ in 0..60 {
            deformables.step(&mut world);
        }
        let after = momentum(&world) + deformables[soft].momentum();
        let error = (after - before).length() / before.length();
        let v = world.bodies[body].linvel();
        eprintln!("free {mode:?} v {v} soft {} momentum {error:e} E {:?} rigid KE {}", deformables[soft].linvel(), deformables[soft].energies(), world.bodies[body].kinetic_energy());
        assert!(error < 1e-5, "{mode:?}: momentum off by {error}");
        let energy = deformables[soft].energies();
        let total = energy.kinetic + energy.elastic + f64::from(world.bodies[body].kinetic_energy());
        assert!(total <= 0.5 * 4.0 * 400.0, "{mode:?}: energy {total} J of 800 J");
        speeds.push(f64::from(v.x));
    }
    close("velocity after [m/s]", speeds[0], speeds[1], 0.03);
}

/// The same block into a pair of boxes, 5 + 15 kg, welded by a fixed joint.
#[test]
fn fast_block_into_a_jointed_pair() {
    let mut speeds = Vec::new();
    for mode in Mode::BOTH {
        let mut world = weightless(1.0 / 60.0);
        let (near, _) = world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::new(0.5, 0.0, 0.0)),
            cuboid([0.2; 3], 5.0),
        );
        let (far, _) = world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::new(1.0, 0.0, 0.0)),
            cuboid([0.2; 3], 15.0),
        );
        let weld = FixedJointBuilder::new()
            .local_anchor1(Vector::new(0.25, 0.0, 0.0))
            .local_anchor2(Vector::new(-0.25, 0.0, 0.0));
        world.insert_impulse_joint(near, far, weld);
        let mut deformables = mode.deformables();
        let soft = deformables
            .insert(block(10.0, 1e6).linvel(Vector::new(20.0, 0.0, 0.0)))
            .unwrap();
        let before = momentum(&world) + deformables[soft].momentum();
        for _ in 0..60 {
            deformables.step(&mut world);
        }
        let after = momentum(&world) + deformables[soft].momentum();
        let error = (after - before).length() / before.length();
        let mean = (world.bodies[near].linvel() * 5.0 + world.bodies[far].linvel() * 15.0) / 20.0;
        eprintln!("jointed {mode:?} v {mean} soft {} momentum {error:e}", deformables[soft].linvel());
        assert!(error < 1e-5, "{mode:?}: momentum off by {error}");
        let energy = deformables[soft].energies();
        let rigid = world.bodies[near].kinetic_energy() + world.bodies[far].kinetic_energy();
        let total = energy.kinetic + energy.elastic + f64::from(rigid);
        assert!(total <= 0.5 * 10.0 * 400.0, "{mode:?}: energy {total} J of 2000 J");
        speeds.push(f64::from(mean.x));
    }
    close("velocity after [m/s]", speeds[0], speeds[1], 0.03);
}
