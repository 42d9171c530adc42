//! Time steps of every kind, runs that repeat, and the user's own loop.

use crate::fixtures::{bead, bits, cube, floored, height};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::world::RapierParts;

/// A soft cube on a floor, hit by a ball.
fn scene(dt: f32) -> (PhysicsWorld, DeformableWorld) {
    let (mut world, _) = floored(dt);
    world.insert(
        RigidBodyBuilder::dynamic()
            .translation(Vector::new(-0.5, 0.2, 0.02))
            .linvel(Vector::new(4.0, 0.0, 0.0)),
        ColliderBuilder::ball(0.1).density(500.0),
    );
    let mut set = DeformableWorld::new();
    set.insert(cube(0.3).translation(Vector::new(0.0, 0.2, 0.0)))
        .unwrap();
    set.insert(cube(0.2).translation(Vector::new(1.0, 0.2, 0.0)))
        .unwrap();
    (world, set)
}

#[test]
fn zero_dt_applies_changes_and_moves_nothing() {
    let (mut world, mut set) = scene(1.0 / 60.0);
    for _ in 0..10 {
        set.step(&mut world);
    }
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, 3.0, 0.0)),
        ColliderBuilder::ball(0.5),
    );
    let seen = |world: &PhysicsWorld| {
        let ray = Ray::new(Vector::new(0.0, 9.0, 0.0), -Vector::Y);
        world
            .cast_ray(&ray, 20.0, true, QueryFilter::default())
            .map(|(_, t)| t)
    };
    let before = (bits(&world), set.state_hash(), set.time());
    assert!(seen(&world).is_none_or(|t| t > 6.0));
    world.integration_parameters.dt = 0.0;
    set.step(&mut world);
    assert_eq!((bits(&world), set.state_hash(), set.time()), before);
    assert!(set.report().invalid_dt.is_none());
    assert!((seen(&world).expect("the new collider is seen") - 5.5).abs() < 1e-4);
    // Forces of the coming step wait for one that takes time.
    let handle = set.iter().next().unwrap().0;
    let v = set[handle].linvel().z;
    set[handle].add_step_force(NodeId(0), Vector::Z * 60.0);
    set.step(&mut world);
    world.integration_parameters.dt = 1.0 / 60.0;
    set.step(&mut world);
    assert!((set[handle].linvel().z - v) * set[handle].mass() > 0.5);
}

/// Down to a nanosecond each is a step, and what is shorter is none; the run goes on as without either.
#[test]
fn a_dt_may_be_as_short_as_it_likes() {
    let shortest = f32::from_bits(1);
    for dt in [
        shortest, 1e-38, 1e-30, 1e-20, 1e-17, 1e-15, 1e-14, 1e-12, 1e-9, 1e-7,
    ] {
        let (mut world, mut set) = scene(1.0 / 60.0);
        let (mut plain_world, mut plain) = scene(1.0 / 60.0);
        for _ in 0..10 {
            set.step(&mut world);
            plain.step(&mut plain_world);
        }
        let balances = |set: &DeformableWorld| -> Vec<f64> {
            set.iter().map(|(_, b)| b.energies().balance()).collect()
        };
        let before = balances(&set);
        world.integration_parameters.dt = dt;
        for _ in 0..5 {
            set.step(&mut world);
            let report = set.report();
            assert!(report.frozen.is_empty(), "{dt:e}: {report:?}");
            let refused = (dt < 1e-9).then_some(f64::from(dt));
            assert_eq!(report.invalid_dt, refused);
            assert!(
                bits(&world)
                    .iter()
                    .flatten()
                    .all(|b| f32::from_bits(*b).is_finite()),
                "{dt:e}"
            );
        }
        for ((_, body), before) in set.iter().zip(before) {
            let e = body.energies();
            let off = (e.balance() - before).abs() / e.scale();
            assert!(off < 1e-4, "{dt:e}: {off:e}");
        }
        world.integration_parameters.dt = 1.0 / 60.0;
        for _ in 0..10 {
            set.step(&mut world);
            plain.step(&mut plain_world);
        }
        for ((_, body), (_, plain)) in set.iter().zip(plain.iter()) {
            let off = (body.center_of_mass() - plain.center_of_mass()).length();
            assert!(off < 1e-3, "{dt:e}: {off} m");
        }
    }
}

#[test]
fn dt_may_change_every_step() {
    let dts = [1.0 / 60.0, 1.0 / 240.0, 1.0 / 30.0, 1e-3, 1.0 / 144.0_f32];
    let mut world = PhysicsWorld::default();
    let mut set = DeformableWorld::new();
    let handle = set.insert(bead(1.0)).unwrap();
    let mut t = 0.0_f64;
    for dt in dts.iter().cycle().take(50) {
        world.integration_parameters.dt = *dt;
        set.step(&mut world);
        t += f64::from(*dt);
        let (y, v) = height(&set[handle]);
        assert!((set.time() - t).abs() < 1e-12);
        assert!((v + 9.81 * t).abs() < 1e-4);
        assert!((y + 0.5 * 9.81 * t * t).abs() < 9.81 * t / 55.0);
    }
    let (mut world, mut set) = scene(1.0 / 60.0);
    for dt in dts.iter().cycle().take(200) {
        world.integration_parameters.dt = *dt;
        set.step(&mut world);
    }
    for ((_, body), side) in set.iter().zip([0.3, 0.2]) {
        let y = body.center_of_mass().y;
        assert!((y - 0.5 * side).abs() < 0.01, "rests at {y} m");
        assert!(body.linvel().length() < 0.05, "{}", body.linvel());
    }
}

#[test]
fn the_same_scene_gives_the_same_bits() {
    let run = || {
        let (mut world, mut set) = scene(1.0 / 60.0);
        for _ in 0..60 {
            set.step(&mut world);
        }
        (bits(&world), set.state_hash())
    };
    let once = run();
    assert_eq!(once, run());
    assert_eq!(once, std::thread::spawn(run).join().unwrap());
}

#[test]
fn a_clone_goes_on_as_the_original() {
    let (mut world, mut set) = scene(1.0 / 60.0);
    let (mut twin, mut other) = scene(1.0 / 60.0);
    for _ in 0..30 {
        set.step(&mut world);
        other.step(&mut twin);
    }
    let mut clone = set.clone();
    assert_eq!(clone.state_hash(), set.state_hash());
    for _ in 0..30 {
        set.step(&mut world);
        clone.step(&mut twin);
        assert_eq!(clone.state_hash(), set.state_hash());
        assert_eq!(clone.time(), set.time());
        assert_eq!(clone.report(), set.report());
    }
    assert_eq!(bits(&world), bits(&twin));
}

#[test]
fn an_own_loop_gives_the_same_bits() {
    let (mut world, mut set) = scene(1.0 / 240.0);
    let (mut own, mut halves) = scene(1.0 / 240.0);
    for step in 0..240 {
        set.step(&mut world);
        halves.before_step(&mut RapierParts::from(&mut own), &mut ());
        own.step();
        halves.after_step(&mut RapierParts::from(&mut own));
        assert_eq!(halves.state_hash(), set.state_hash(), "step {step}");
        assert_eq!(bits(&own), bits(&world), "step {step}");
        assert_eq!(halves.report(), set.report());
    }
}

/// Rapier's parameters are the user's.
#[test]
fn the_users_parameters_are_never_written() {
    let (mut world, mut set) = scene(1.0 / 60.0);
    world.bodies.iter_mut().for_each(|(_, b)| {
        b.add_force(Vector::new(0.1, 0.2, 0.3), true);
        b.add_torque(Vector::new(0.3, 0.2, 0.1), true);
    });
    let parameters = world.integration_parameters;
    let mut several = 0;
    for _ in 0..60 {
        set.step(&mut world);
        several += usize::from(set.report().rigid_steps == 4);
        assert_eq!(
            format!("{:?}", world.integration_parameters),
            format!("{parameters:?}")
        );
    }
    assert!(several > 10);
    for (_, body) in world.bodies.iter().filter(|(_, b)| b.is_dynamic()) {
        assert_eq!(body.user_force(), Vector::new(0.1, 0.2, 0.3));
        assert_eq!(body.user_torque(), Vector::new(0.3, 0.2, 0.1));
    }
}

/// As many substeps as asked for, whatever the frame.
#[test]
fn fixed_substeps_are_what_was_asked_for() {
    for (dt, n) in [
        (1.0 / 60.0, 10),
        (1.0 / 60.0, 1),
        (1.0 / 240.0, 3),
        (1.0 / 30.0, 64),
    ] {
        for substeps in [Substeps::Fixed(n), Substeps::Unchecked(n)] {
            let mut world = PhysicsWorld::default();
            world.integration_parameters.dt = dt;
            let mut set = DeformableWorld::new();
            let handle = set.insert(bead(1.0).substeps(substeps)).unwrap();
            set.step(&mut world);
            assert_eq!(set.report().substeps, [(handle, n)], "{substeps:?} at {dt}");
        }
    }
}

/// Symptom: a user's force grew by the plugin's own. Cause: a second `before_step` before the first was completed.
#[test]
fn the_halves_of_a_step_may_come_in_any_order() {
    use crumple::world::RapierParts;
    let (mut world, _) = crate::fixtures::floored(1.0 / 240.0);
    let mut set = DeformableWorld::new();
    set.insert(crate::fixtures::bead(1.0).translation(Vector::new(0.0, 0.5, 0.0)))
        .unwrap();
    let (body, _) = world.insert(
        RigidBodyBuilder::dynamic()
            .translation(Vector::new(0.0, 0.3, 0.0))
            .can_sleep(false),
        ColliderBuilder::cuboid(0.3, 0.1, 0.3).mass(1.0),
    );
    for step in 0..200 {
        set.before_step(&mut RapierParts::from(&mut world), &mut ());
        if step % 3 == 0 {
            set.before_step(&mut RapierParts::from(&mut world), &mut ());
        }
        world.step();
        for _ in 0..step % 4 {
            set.after_step(&mut RapierParts::from(&mut world));
        }
        if step % 7 == 0 {
            set.step(&mut world);
        }
    }
    set.after_step(&mut RapierParts::from(&mut world));
    assert_eq!(world.bodies[body].user_force(), Vector::ZERO);
    assert!(world.bodies[body].translation().is_finite());
}
