//! Rigid bodies and colliders changed between steps: the very next step knows.

use crate::fixtures::{bead, floored, height};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

const DT: f64 = 1.0 / 60.0;

type Before = fn(&mut PhysicsWorld) -> Option<ColliderHandle>;
type Change = fn(&mut PhysicsWorld, RigidBodyHandle, ColliderHandle);

/// What takes a floor away.
const AWAY: [(&str, Change); 12] = [
    ("body removed", |w, b, _| {
        w.remove_body(b);
    }),
    ("collider removed", |w, _, c| {
        w.remove_collider(c);
    }),
    ("body disabled", |w, b, _| w.bodies[b].set_enabled(false)),
    ("collider disabled", |w, _, c| {
        w.colliders[c].set_enabled(false)
    }),
    ("made a sensor", |w, _, c| w.colliders[c].set_sensor(true)),
    ("body teleported", |w, b, _| {
        w.bodies[b].set_translation(Vector::new(0.0, -9.0, 0.0), true);
    }),
    ("body turned away", |w, b, _| {
        w.bodies[b].set_position(
            Pose::from_parts(Vector::new(50.0, 0.0, 0.0), Rotation::from_rotation_z(1.0)),
            true,
        );
    }),
    ("collider moved on its body", |w, _, c| {
        w.colliders[c].set_translation_wrt_parent(Vector::new(0.0, -3.0, 0.0));
    }),
    ("smaller shape", |w, _, c| {
        w.colliders[c].set_shape(SharedShape::ball(0.2));
    }),
    ("collision groups", |w, _, c| {
        w.colliders[c].set_collision_groups(InteractionGroups::none());
    }),
    ("solver groups", |w, _, c| {
        w.colliders[c].set_solver_groups(InteractionGroups::none());
    }),
    ("a shape nodes can't touch", |w, _, c| {
        w.colliders[c].set_shape(SharedShape::cone(0.1, 0.1));
    }),
];

#[test]
fn a_floor_taken_away_lets_fall_in_the_same_step() {
    for (name, change) in AWAY {
        let (mut world, floor) = floored(DT as f32);
        let body = world.colliders[floor].parent().unwrap();
        let mut set = DeformableWorld::new();
        let handle = set.insert(bead(1.0).translation(Vector::X)).unwrap();
        for _ in 0..10 {
            set.step(&mut world);
        }
        let (y, v) = height(&set[handle]);
        assert!(y.abs() < 1e-4 && v.abs() < 1e-3, "{name}: {y} {v}");
        change(&mut world, body, floor);
        set.step(&mut world);
        let (_, v) = height(&set[handle]);
        assert!((v + 9.81 * DT).abs() < 1e-4, "{name}: {v} m/s");
        for _ in 0..20 {
            set.step(&mut world);
        }
        let fall = height(&set[handle]).1;
        assert!((fall + 9.81 * DT * 21.0).abs() < 1e-2, "{name}: {fall} m/s");
    }
}

/// What puts a floor under a node that falls past y = 0 within this step. Made before the first step, then changed.
const UNDER: [(&str, Before, Change); 9] = [
    (
        "body and collider inserted",
        |_| None,
        |w, _, _| {
            w.insert(
                RigidBodyBuilder::fixed().translation(Vector::Y * -0.5),
                ColliderBuilder::cuboid(5.0, 0.5, 5.0),
            );
        },
    ),
    (
        "collider without a body inserted",
        |_| None,
        |w, _, _| {
            w.insert_collider(
                ColliderBuilder::cuboid(5.0, 0.5, 5.0).translation(Vector::Y * -0.5),
                None,
            );
        },
    ),
    (
        "body teleported",
        |w| {
            let at = RigidBodyBuilder::fixed().translation(Vector::X * 90.0);
            Some(w.insert(at, ColliderBuilder::cuboid(5.0, 0.5, 5.0)).1)
        },
        |w, b, _| w.bodies[b].set_translation(Vector::Y * -0.5, true),
    ),
    (
        "collider without a body teleported",
        |w| {
            let far = ColliderBuilder::cuboid(5.0, 0.5, 5.0).translation(Vector::X * 90.0);
            Some(w.insert_collider(far, None))
        },
        |w, _, c| w.colliders[c].set_translation(Vector::Y * -0.5),
    ),
    (
        "collider moved on its body",
        |w| {
            let far = ColliderBuilder::cuboid(5.0, 0.5, 5.0).translation(Vector::X * 90.0);
            Some(w.insert(RigidBodyBuilder::fixed(), far).1)
        },
        |w, _, c| w.colliders[c].set_translation_wrt_parent(Vector::Y * -0.5),
    ),
    (
        "larger shape",
        |w| {
            let at = RigidBodyBuilder::fixed().translation(Vector::Y * -0.5);
            Some(w.insert(at, ColliderBuilder::ball(0.01)).1)
        },
        |w, _, c| w.colliders[c].set_shape(SharedShape::cuboid(5.0, 0.5, 5.0)),
    ),
    (
        "collider enabled",
        |w| {
            let at = RigidBodyBuilder::fixed().translation(Vector::Y * -0.5);
            Some(
                w.insert(at, ColliderBuilder::cuboid(5.0, 0.5, 5.0).enabled(false))
                    .1,
            )
        },
        |w, _, c| w.colliders[c].set_enabled(true),
    ),
    (
        "body enabled",
        |w| {
            let at = RigidBodyBuilder::fixed().translation(Vector::Y * -0.5);
            Some(
                w.insert(at.enabled(false), ColliderBuilder::cuboid(5.0, 0.5, 5.0))
                    .1,
            )
        },
        |w, b, _| w.bodies[b].set_enabled(true),
    ),
    (
        "sensor no more",
        |w| {
            let at = RigidBodyBuilder::fixed().translation(Vector::Y * -0.5);
            Some(
                w.insert(at, ColliderBuilder::cuboid(5.0, 0.5, 5.0).sensor(true))
                    .1,
            )
        },
        |w, _, c| w.colliders[c].set_sensor(false),
    ),
];

#[test]
fn a_floor_put_under_it_is_landed_on_in_the_same_step() {
    for (name, before, change) in UNDER {
        let mut world = PhysicsWorld::default();
        let collider = before(&mut world);
        let parent = collider.and_then(|c| world.colliders[c].parent());
        let mut set = DeformableWorld::new();
        let handle = set
            .insert(
                bead(1.0)
                    .translation(Vector::Y * 3.05)
                    .linvel(Vector::Y * -10.0)
                    .gravity_scale(0.0)
                    .substeps(Substeps::Fixed(4)),
            )
            .unwrap();
        for _ in 0..18 {
            set.step(&mut world);
        }
        let (y, v) = height(&set[handle]);
        assert!(
            (y - 0.05).abs() < 1e-3 && (v + 10.0).abs() < 1e-3,
            "{name}: {y} {v}"
        );
        change(
            &mut world,
            parent.unwrap_or(RigidBodyHandle::invalid()),
            collider.unwrap_or(ColliderHandle::invalid()),
        );
        set.step(&mut world);
        let (y, v) = height(&set[handle]);
        assert!(y > -1e-3 && v.abs() < 0.1, "{name}: at {y} m with {v} m/s");
    }
}

#[test]
fn groups_are_respected_both_ways() {
    let (one, two) = (Group::GROUP_1, Group::GROUP_2);
    let groups = |m, f| InteractionGroups::new(m, f, InteractionTestMode::And);
    for (own, others, meets) in [
        (groups(one, two), groups(two, one), true),
        (groups(one, one), groups(two, one), false),
        (groups(one, two), groups(two, two), false),
        (groups(one, Group::NONE), InteractionGroups::all(), false),
        (InteractionGroups::all(), groups(two, one), true),
    ] {
        let (mut world, floor) = floored(DT as f32);
        world.colliders[floor].set_collision_groups(others);
        let mut set = DeformableWorld::new();
        let handle = set
            .insert(
                bead(1.0)
                    .translation(Vector::Y * 0.05)
                    .collision_groups(own),
            )
            .unwrap();
        for _ in 0..20 {
            set.step(&mut world);
        }
        let y = height(&set[handle]).0;
        assert_eq!(y > -1e-3, meets, "{own:?} against {others:?}: {y} m");
        // They may be changed at any time.
        set[handle].surface_mut().collision_groups = InteractionGroups::none();
        let before = height(&set[handle]).1;
        set.step(&mut world);
        assert!((height(&set[handle]).1 - before + 9.81 * DT).abs() < 1e-4);
    }
}

/// A deformable on a dynamic body that is removed, disabled or retyped in contact: no panic, and it falls or stays.
#[test]
fn a_dynamic_body_may_go_in_contact() {
    let changes: [(&str, bool, Change); 6] = [
        ("removed", true, |w, b, _| {
            w.remove_body(b);
        }),
        ("disabled", true, |w, b, _| w.bodies[b].set_enabled(false)),
        ("collider removed", true, |w, _, c| {
            w.remove_collider(c);
        }),
        ("fixed", false, |w, b, _| {
            w.bodies[b].set_body_type(RigidBodyType::Fixed, true);
        }),
        ("kinematic", false, |w, b, _| {
            w.bodies[b].set_body_type(RigidBodyType::KinematicPositionBased, true);
        }),
        ("asleep", false, |w, b, _| w.bodies[b].sleep()),
    ];
    for (name, falls, change) in changes {
        let (mut world, _) = floored(DT as f32);
        let (body, collider) = world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::Y * 0.5),
            ColliderBuilder::cuboid(0.5, 0.5, 0.5),
        );
        let mut set = DeformableWorld::new();
        let handle = set.insert(bead(1.0).translation(Vector::Y)).unwrap();
        for _ in 0..10 {
            set.step(&mut world);
        }
        change(&mut world, body, collider);
        set.step(&mut world);
        let v = height(&set[handle]).1;
        let expected = if falls { -9.81 * DT } else { 0.0 };
        assert!((v - expected).abs() < 5e-3, "{name}: {v} m/s");
        for _ in 0..30 {
            set.step(&mut world);
        }
        let y = height(&set[handle]).0;
        assert!(
            if falls {
                y < 0.9
            } else {
                (y - 1.0).abs() < 0.01
            },
            "{name}: {y} m"
        );
    }
}

/// Removed between the two halves of a step, as an event handler of the user's own loop may do.
#[test]
fn a_body_may_go_between_the_halves_of_a_step() {
    use crumple::world::RapierParts;
    let (mut world, _) = floored(1.0 / 240.0);
    let (body, _) = world.insert(
        RigidBodyBuilder::dynamic().translation(Vector::Y * 0.5),
        ColliderBuilder::cuboid(0.5, 0.5, 0.5),
    );
    let mut set = DeformableWorld::new();
    let handle = set.insert(bead(1.0).translation(Vector::Y)).unwrap();
    for i in 0..10 {
        set.before_step(&mut RapierParts::from(&mut world), &mut ());
        world.step();
        if i == 5 {
            world.remove_body(body);
        }
        set.after_step(&mut RapierParts::from(&mut world));
    }
    let v = height(&set[handle]).1;
    assert!((v + 9.81 * 4.0 / 240.0).abs() < 2e-3, "{v} m/s");
}
