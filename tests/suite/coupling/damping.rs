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

/// What a wall stops has nothing left to damp. Symptom: 0.5 m/s backwards after a blow at 10 m/s late in a step. Cause: what damping had
/// taken before it was taken again after Rapier's step, where the wall could not answer.
#[test]
fn a_damped_body_stays_at_the_wall_that_stops_it() {
    let worst = |damping| (0..8).map(|n| thrown_back(damping, n)).fold(0.0, f32::max);
    // Rapier's own contacts throw back what they have let in, whether it is damped or not.
    let (free, damped) = (worst(0.0), worst(5.0));
    assert!(damped < free + 0.02, "{damped} for {free} m/s");
}

/// How fast a body of 8 kg goes back that comes to a wall at 10 m/s in the n-th eighth of a step \[m/s\].
fn thrown_back(damping: f32, n: u8) -> f32 {
    let start = f32::from(n) / 8.0 / 60.0 * 10.0;
    let mut world = PhysicsWorld::default();
    let mut deformables = DeformableWorld::default();
    world.gravity = Vector::ZERO;
    let wall = ColliderBuilder::cuboid(0.5, 1.0, 1.0).translation(Vector::X * 1.5);
    world.insert_collider(wall.friction(0.0), None);
    let body = RigidBodyBuilder::dynamic()
        .linear_damping(damping)
        .translation(Vector::X * (0.5 - start))
        .linvel(Vector::X * 10.0);
    let shape = ColliderBuilder::cuboid(0.1, 0.1, 0.1)
        .mass(8.0)
        .friction(0.0);
    let (body, _) = world.insert(body, shape);
    // A light thread behind it.
    let end = world.bodies[body].translation() - Vector::X * 0.1;
    let net = rope(end, end - Vector::X * 0.3, 3, 1e-6);
    let thread = DeformableBuilder::new(net)
        .material(Material::elastic(1e7, 1000.0).viscosity(1e5))
        .linvel(Vector::X * 10.0);
    let thread = deformables.insert(thread).unwrap();
    let pin = Attachment::pin([NodeId(0)]);
    deformables
        .attach(thread, pin, body, &world.bodies)
        .unwrap();
    let mut back = 0.0;
    for _ in 0..12 {
        deformables.step(&mut world);
        back = f32::max(back, -world.bodies[body].linvel().x);
    }
    assert!(world.bodies[body].linvel().x < 0.05);
    back
}
