//! Rigid bodies with a damping of their own.

use crate::support::close;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// A body of 8 kg that is hung from a thread of 1 m, the upper end of which `pin` holds.
fn hang(
    world: &mut PhysicsWorld,
    deformables: &mut DeformableWorld,
    damping: f32,
    pinned: bool,
) -> (DeformableHandle, AttachmentHandle, RigidBodyHandle) {
    let net = rope(Vector::Y, Vector::ZERO, 10, 1e-4);
    let thread = DeformableBuilder::new(net)
        .material(Material::elastic(1e8, 1000.0).viscosity(1e5))
        .pin(move |x| pinned && x.y > 0.99);
    let thread = deformables.insert(thread).unwrap();
    let body = RigidBodyBuilder::dynamic()
        .linear_damping(damping)
        .can_sleep(false)
        .translation(Vector::NEG_Y * 0.1);
    let (body, _) = world.insert(body, ColliderBuilder::cuboid(0.1, 0.1, 0.1).mass(8.0));
    let pin = Attachment::pin([NodeId(10)]);
    let pin = deformables
        .attach(thread, pin, body, &world.bodies)
        .unwrap();
    (thread, pin, body)
}

/// What bears a body at rest bears its weight: damping takes nothing of what stands. Symptom: 69.8 N of 78.48 N at a damping of 100/s.
/// Cause: Rapier damps a velocity without the impulses that the body still has to get.
#[test]
fn damping_does_not_lighten_what_rests() {
    for damping in [5.0, 100.0] {
        let mut world = PhysicsWorld::default();
        let mut deformables = DeformableWorld::default();
        let (_, pin, _) = hang(&mut world, &mut deformables, damping, true);
        let block = DeformableBuilder::new(lattice(Vector::splat(0.4), 0.1))
            .material(Material::elastic(1e6, 200.0).viscosity(1e4))
            .translation(Vector::new(2.0, 0.0, 0.0))
            .pin(|x| x.y < -0.19);
        let block = deformables.insert(block).unwrap();
        let body = RigidBodyBuilder::dynamic()
            .linear_damping(damping)
            .can_sleep(false)
            .translation(Vector::new(2.0, 0.3, 0.0));
        let (_, on) = world.insert(body, ColliderBuilder::cuboid(0.1, 0.1, 0.1).mass(8.0));
        let mut forces = [0.0; 2];
        for frame in 0..360 {
            deformables.step(&mut world);
            if frame >= 300 {
                let pulled = deformables.attachment_force(pin).unwrap().0.y;
                let pressed = deformables.contact_force(block, on).unwrap_or_default().y;
                forces[0] += pulled / 60.0;
                forces[1] -= pressed / 60.0;
            }
        }
        for (what, force) in ["hung", "laid"].into_iter().zip(forces) {
            close(&format!("{what}, {damping}/s"), force, 8.0 * 9.81, 1e-3);
        }
    }
}

/// A body that is let down at v pulls with m·(g − d·v), and is nowhere else than the thread's end in between. Symptom: the thread
/// was brought to it in every substep, which gave energy. Cause: nodes were solved for a velocity that was damped before the body went.
#[test]
fn a_damped_body_is_let_down() {
    let (speed, damping) = (0.5, 10.0);
    let mut world = PhysicsWorld::default();
    let mut deformables = DeformableWorld::default();
    let (thread, pin, _) = hang(&mut world, &mut deformables, damping, false);
    let winch = RigidBodyBuilder::kinematic_velocity_based().translation(Vector::Y);
    let winch = world.bodies.insert(winch);
    let held = Attachment::pin([NodeId(0)]);
    deformables
        .attach(thread, held, winch, &world.bodies)
        .unwrap();
    let mut force = 0.0;
    for frame in 0..240 {
        world.bodies[winch].set_linvel(Vector::NEG_Y * speed, true);
        deformables.step(&mut world);
        if frame >= 180 {
            force += deformables.attachment_force(pin).unwrap().0.y / 60.0;
        }
    }
    let expected = 8.0 * f64::from(9.81 - damping * speed);
    close("force", force, expected, 2e-3);
    let given = deformables.get(thread).unwrap().energies().work.push_out;
    assert!(given.abs() < 1e-3, "{given} J");
}

/// What a wall stops has nothing left to damp. Symptom: it went back. Cause: what damping had taken within the step before the blow was
/// taken again after Rapier's step, where the wall could not answer.
#[test]
fn a_damped_body_stays_at_the_wall_that_stops_it() {
    for gap in [2e-4, 5e-4, 8e-4] {
        let mut world = PhysicsWorld::default();
        let mut deformables = DeformableWorld::default();
        world.gravity = Vector::ZERO;
        let wall = ColliderBuilder::cuboid(0.1, 1.0, 1.0).translation(Vector::X * (0.2 + gap));
        world.insert_collider(wall.friction(0.0), None);
        let (.., body) = hang(&mut world, &mut deformables, 100.0, false);
        for _ in 0..2 {
            deformables.step(&mut world);
        }
        world.bodies[body].set_linvel(Vector::X * 0.5, true);
        let mut slowest = f32::INFINITY;
        for _ in 0..3 {
            deformables.step(&mut world);
            slowest = slowest.min(world.bodies[body].linvel().x);
        }
        assert!(slowest > -0.01, "{slowest} m/s from {gap} m");
        assert!(world.bodies[body].linvel().x < 0.01);
    }
}
