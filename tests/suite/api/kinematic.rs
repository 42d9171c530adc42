//! Kinematic bodies push deformables at their own speed.

use crate::fixtures::bead;
use crate::support::{close, weightless};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Both kinds, alone and beside a dynamic body that makes Rapier take short steps.
#[test]
fn both_kinds_push_at_the_right_speed() {
    for by_position in [false, true] {
        for near in [false, true] {
            let mut world = weightless(1.0 / 60.0);
            let builder = if by_position {
                RigidBodyBuilder::kinematic_position_based()
            } else {
                RigidBodyBuilder::kinematic_velocity_based().linvel(Vector::X * 3.0)
            };
            let (wall, _) = world.insert(builder, ColliderBuilder::cuboid(0.5, 1.0, 1.0));
            if near {
                world.insert(
                    RigidBodyBuilder::dynamic()
                        .translation(Vector::new(0.6, 0.0, 0.08))
                        .linvel(Vector::X * 3.0)
                        .can_sleep(false),
                    ColliderBuilder::ball(0.05),
                );
            }
            let mut set = DeformableWorld::new();
            let handle = set
                .insert(bead(1.0).translation(Vector::new(0.52, 0.0, 0.0)))
                .unwrap();
            for i in 1..=30 {
                let x = 3.0 * i as f32 / 60.0;
                if by_position {
                    world.bodies[wall].set_next_kinematic_translation(Vector::X * x);
                }
                set.step(&mut world);
                assert_eq!(set.report().rigid_steps, if near { 4 } else { 1 });
                let face = f64::from(world.bodies[wall].translation().x) + 0.5;
                close("the wall's own place", face, f64::from(x) + 0.5, 1e-5);
                let ahead = set[handle].position(NodeId(0)).unwrap().x - face;
                assert!(
                    i < 3 || ahead.abs() < 1e-4,
                    "by position {by_position}, near {near}, step {i}: {ahead} m ahead"
                );
            }
            close("speed", set[handle].linvel().x, 3.0, 1e-3);
        }
    }
}

/// A turning table carries a node that sticks to it along a circle.
#[test]
fn a_turntable_carries() {
    let mut world = PhysicsWorld::default();
    world.insert(
        RigidBodyBuilder::kinematic_velocity_based().angvel(Vector::Y),
        ColliderBuilder::cuboid(2.0, 0.1, 2.0),
    );
    let mut set = DeformableWorld::new();
    let handle = set
        .insert(
            bead(1.0)
                .friction(2.0)
                .friction_combine_rule(CoefficientCombineRule::Max)
                .translation(Vector::new(1.0, 0.1, 0.0))
                .linvel(Vector::new(0.0, 0.0, -1.0)),
        )
        .unwrap();
    for _ in 0..60 {
        set.step(&mut world);
    }
    let at = set[handle].position(NodeId(0)).unwrap();
    let (r, angle) = (at.x.hypot(at.z), (-at.z).atan2(at.x));
    close("radius", r, 1.0, 0.02);
    close("angle", angle, 1.0, 0.02);
}
