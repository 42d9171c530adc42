//! Rigid bodies asleep on deformables, and what must wake them.

use crate::fixtures::{cube, floored};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// A box asleep on a soft cube, 1 s after it fell asleep.
fn asleep() -> (
    PhysicsWorld,
    DeformableWorld,
    DeformableHandle,
    RigidBodyHandle,
) {
    let (mut world, _) = floored(1.0 / 60.0);
    let (rigid, _) = world.insert(
        RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.36, 0.0)),
        ColliderBuilder::cuboid(0.1, 0.05, 0.1).density(1000.0),
    );
    let mut set = DeformableWorld::new();
    let soft = set
        .insert(cube(0.3).translation(Vector::new(0.0, 0.15, 0.0)))
        .unwrap();
    let mut slept = 0;
    for _ in 0..600 {
        set.step(&mut world);
        slept += usize::from(world.bodies[rigid].is_sleeping());
        if slept > 60 {
            return (world, set, soft, rigid);
        }
    }
    panic!(
        "the box does not fall asleep: {:?}",
        world.bodies[rigid].linvel()
    );
}

fn falls(world: &mut PhysicsWorld, set: &mut DeformableWorld, rigid: RigidBodyHandle, way: f32) {
    let from = world.bodies[rigid].translation().y;
    for _ in 0..12 {
        set.step(world);
    }
    let moved = world.bodies[rigid].translation().y - from;
    assert!(!world.bodies[rigid].is_sleeping());
    assert!(moved * way > 0.08, "moved {moved} m");
}

#[test]
fn removing_or_disabling_the_deformable_wakes() {
    let (mut world, mut set, soft, rigid) = asleep();
    set.remove(soft);
    falls(&mut world, &mut set, rigid, -1.0);
    let (mut world, mut set, soft, rigid) = asleep();
    set[soft].set_enabled(false);
    falls(&mut world, &mut set, rigid, -1.0);
    let (mut world, mut set, soft, rigid) = asleep();
    set[soft].transform(Pose::from_translation(Vector::X * 3.0));
    falls(&mut world, &mut set, rigid, -1.0);
}

#[test]
fn new_gravity_wakes() {
    let (mut world, mut set, _, rigid) = asleep();
    world.gravity = Vector::Y * 9.81;
    falls(&mut world, &mut set, rigid, 1.0);
}

#[test]
fn nothing_wakes_without_a_cause() {
    let (mut world, mut set, _, rigid) = asleep();
    for _ in 0..120 {
        set.step(&mut world);
        assert!(world.bodies[rigid].is_sleeping());
        assert_eq!(set.report().rigid_steps, 1);
    }
}

/// A box that slept on the floor long before a deformable came near.
#[test]
fn a_hit_wakes_a_sleeper_it_never_touched_before() {
    let (mut world, _) = floored(1.0 / 60.0);
    let (rigid, _) = world.insert(
        RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.2, 0.0)),
        ColliderBuilder::cuboid(0.2, 0.2, 0.2).density(200.0),
    );
    let mut set = DeformableWorld::new();
    for _ in 0..120 {
        set.step(&mut world);
    }
    assert!(world.bodies[rigid].is_sleeping());
    let soft = set
        .insert(
            cube(0.3)
                .translation(Vector::new(-1.5, 0.2, 0.0))
                .linvel(Vector::X * 10.0),
        )
        .unwrap();
    for _ in 0..40 {
        set.step(&mut world);
    }
    assert!(!world.bodies[rigid].is_sleeping(), "it must wake");
    let x = world.bodies[rigid].translation().x;
    assert!(x > 0.05, "the box was pushed to {x} m");
    assert!(set[soft].linvel().is_finite());
}
