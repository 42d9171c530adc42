//! Rigid bodies asleep on deformables, and what must wake them.

use crate::fixtures::{cube, floored};
use crumple::body::{Net, Node};
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

/// A rubber cube alone on the floor, 1 s after it fell asleep.
fn cube_asleep() -> (
    PhysicsWorld,
    DeformableWorld,
    DeformableHandle,
    ColliderHandle,
) {
    let (mut world, floor) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let soft = set
        .insert(cube(0.3).translation(Vector::new(0.0, 0.15, 0.0)))
        .unwrap();
    let mut slept = 0;
    for _ in 0..900 {
        set.step(&mut world);
        slept += usize::from(set[soft].is_sleeping());
        if slept > 60 {
            return (world, set, soft, floor);
        }
    }
    panic!("the cube does not fall asleep: {:?}", set[soft].linvel());
}

#[derive(Default)]
struct Given {
    impulse: f64,
    time: f64,
}

impl Observer for Given {
    fn substep(&mut self, s: &Substep) {
        let up: f64 = s.contacts.iter().map(|c| c.impulse.y).sum();
        self.impulse += up;
        self.time += s.h;
    }
}

#[test]
fn a_deformable_at_rest_falls_asleep_and_goes_on_bearing_its_weight() {
    let (mut world, mut set, soft, floor) = cube_asleep();
    let weight = set[soft].mass() * 9.81;
    let (hash, energies) = (set[soft].state_hash(), set[soft].energies());
    let mut given = Given::default();
    for _ in 0..120 {
        set.step_with(&mut world, &(), &(), &mut given);
        assert!(set[soft].is_sleeping());
        assert!(set.report().substeps.is_empty() && set.report().events.is_empty());
        let force = set.contact_force(soft, floor).unwrap();
        assert!((force.y / weight - 1.0).abs() < 1e-3, "{force}");
    }
    assert_eq!(set[soft].state_hash(), hash);
    assert_eq!(set[soft].energies(), energies);
    assert!((given.time - 2.0).abs() < 1e-6, "{}", given.time);
    let mean = given.impulse / given.time;
    assert!((mean / weight - 1.0).abs() < 1e-3, "{mean} of {weight}");
    // What its last motion held is booked, and next to nothing.
    let start = (energies.balance()).abs() / energies.scale();
    assert!(start < 1e-3, "{start:.2e}");
    set[soft].wake_up();
    set.step(&mut world);
    assert!(set.report().events.is_empty(), "the contact goes on");
    assert!(set[soft].linvel().length() < 1e-3);
}

#[test]
fn a_rigid_body_and_what_it_lies_on_sleep_together() {
    let (mut world, mut set, soft, rigid) = asleep();
    for _ in 0..300 {
        set.step(&mut world);
    }
    assert!(set[soft].is_sleeping() && world.bodies[rigid].is_sleeping());
    for _ in 0..300 {
        set.step(&mut world);
        assert!(set[soft].is_sleeping() && world.bodies[rigid].is_sleeping());
    }
    let body = &mut world.bodies[rigid];
    body.apply_impulse(Vector::Y * 3.0 * body.mass(), true);
    set.step(&mut world);
    assert!(!set[soft].is_sleeping(), "its load is gone");
    for _ in 0..10 {
        set.step(&mut world);
    }
    let risen = set[soft].center_of_mass().y;
    assert!(risen > 0.1, "{risen}");
}

/// Everything that must wake a deformable, each tried alone.
#[test]
fn what_wakes_a_deformable() {
    type Cause = fn(&mut PhysicsWorld, &mut DeformableWorld, DeformableHandle, ColliderHandle);
    let causes: [(&str, Cause); 12] = [
        ("gravity", |world, _, _, _| world.gravity = Vector::Y * -5.0),
        ("a force", |_, set, soft, _| {
            set[soft].set_node_force(NodeId(0), Vector::X);
        }),
        ("a force for one step", |_, set, soft, _| {
            set[soft].add_step_force(NodeId(0), Vector::X);
        }),
        ("a velocity", |_, set, soft, _| {
            set[soft].set_linvel(Vector::Y);
        }),
        ("friction", |_, set, soft, _| {
            set[soft].surface_mut().friction = 0.1
        }),
        ("a pin", |_, set, soft, _| {
            set[soft].set_pinned(NodeId(0), true);
        }),
        ("a floor that is gone", |world, _, _, floor| {
            world.remove_collider(floor);
        }),
        ("a floor that was moved", |world, _, _, floor| {
            let body = world.colliders[floor].parent().unwrap();
            world.bodies[body].set_translation(Vector::Y * -0.6, false);
        }),
        ("a floor of ice", |world, _, _, floor| {
            world.colliders[floor].set_friction(0.0)
        }),
        ("a ball", |world, _, _, _| {
            world.insert(
                RigidBodyBuilder::dynamic()
                    .translation(Vector::new(0.4, 0.1, 0.0))
                    .linvel(Vector::X * -10.0),
                ColliderBuilder::ball(0.05),
            );
        }),
        ("a led plate", |world, _, _, _| {
            world.insert(
                RigidBodyBuilder::kinematic_velocity_based()
                    .translation(Vector::Y * 0.33)
                    .linvel(Vector::Y * -1.0),
                ColliderBuilder::cuboid(0.2, 0.01, 0.2),
            );
        }),
        ("another one", |_, set, _, _| {
            let other = cube(0.1).linvel(Vector::X * -10.0);
            set.insert(other.translation(Vector::new(0.4, 0.1, 0.0)))
                .unwrap();
        }),
    ];
    for (name, cause) in causes {
        let (mut world, mut set, soft, floor) = cube_asleep();
        cause(&mut world, &mut set, soft, floor);
        let woke = (0..2).any(|_| {
            set.step(&mut world);
            !set[soft].is_sleeping()
        });
        assert!(woke, "{name} must wake it");
    }
}

#[test]
fn a_group_wakes_when_one_of_it_goes() {
    let (mut world, _) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let [below, above] = [0.15, 0.45].map(|y| {
        let cube = cube(0.3).translation(Vector::Y * y);
        set.insert(cube).unwrap()
    });
    for _ in 0..900 {
        set.step(&mut world);
    }
    assert!(set[below].is_sleeping() && set[above].is_sleeping());
    let before = set[above].center_of_mass().y;
    set.remove(below);
    for _ in 0..12 {
        set.step(&mut world);
    }
    let fallen = before - set[above].center_of_mass().y;
    assert!((fallen - 0.196).abs() < 0.02, "fell {fallen} m in .2 s");
}

/// Regression. Symptom: a group never fell asleep. Cause: what holds a member was looked for only behind the place in the
/// list of contacts where the member before it had been found, and the one on top is held by a contact at the list's end.
#[test]
fn a_group_sleeps_in_whatever_order_it_was_made() {
    let (mut world, _) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let places = [(0.0, 0.45), (0.32, 0.15), (0.0, 0.15)];
    let cubes = places.map(|(x, y)| {
        let cube = cube(0.3).translation(Vector::new(x, y, 0.0));
        set.insert(cube).unwrap()
    });
    for _ in 0..900 {
        set.step(&mut world);
    }
    assert!(cubes.iter().all(|&cube| set[cube].is_sleeping()));
}

/// A slow flight is not rest, nor is a small vibration that nothing damps, nor what is told not to sleep.
#[test]
fn what_does_not_sleep() {
    let (mut world, _) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let drifting = cube(0.3)
        .gravity_scale(0.0)
        .translation(Vector::Y * 2.0)
        .linvel(Vector::X * 1e-3);
    let drifting = set.insert(drifting).unwrap();
    let nodes = [4.0, 3.0].map(|y| Node::new(Vector::Y * y, 1.0));
    let spring = Net::new(nodes.into(), vec![Spring::new(0, 1, 100.0)]);
    let spring = DeformableBuilder::new(spring.pin(|x| x.y > 3.5));
    let spring = set.insert(spring.gravity_scale(0.0)).unwrap();
    set[spring].set_linvel_of(NodeId(1), Vector::Y * 1e-3);
    let sleepless = cube(0.3)
        .can_sleep(false)
        .translation(Vector::new(2.0, 0.15, 0.0));
    let sleepless = set.insert(sleepless).unwrap();
    let net = lattice(Vector::splat(0.2), 0.1).unwrap().pin(|_| true);
    let led = DeformableBuilder::new(net).material(Material::rubber());
    let led = set.insert(led.translation(Vector::X * 5.0)).unwrap();
    let pins: Vec<_> = (0..set[led].node_count() as u32).map(NodeId).collect();
    for &pin in &pins {
        assert!(set[led].set_linvel_of(pin, Vector::X * 1e-3));
    }
    let before = set[drifting].center_of_mass().x;
    let led_before = set[led].center_of_mass().x;
    for _ in 0..600 {
        set.step(&mut world);
    }
    let awake = |h| !set[h].is_sleeping();
    assert!(awake(drifting) && awake(spring) && awake(sleepless) && awake(led));
    let way = set[led].center_of_mass().x - led_before;
    assert!((way - 0.01).abs() < 1e-5, "{way}");
    let way = set[drifting].center_of_mass().x - before;
    assert!((way - 0.01).abs() < 1e-5, "{way}");
    let e = set[spring].energies();
    let held = (e.kinetic + e.elastic) / 0.5e-6;
    assert!((held - 1.0).abs() < 1e-2, "{held}");
}

/// A factor on gravity that is another one wakes its body, the same does not.
#[test]
fn another_gravity_scale_wakes() {
    let (mut world, mut set, soft, _) = cube_asleep();
    assert!(set[soft].set_gravity_scale(1.0) && set[soft].is_sleeping());
    assert!(set[soft].set_gravity_scale(-1.0) && !set[soft].is_sleeping());
    for _ in 0..30 {
        set.step(&mut world);
    }
    let height = set[soft].center_of_mass().y;
    assert!(height > 1.0, "{height}");
}

/// A saved sleeper sleeps on, and wakes like the one it is a copy of.
#[test]
fn a_restored_sleeper_sleeps_on() {
    let (mut world, mut set, soft, _) = cube_asleep();
    let bytes = set.save(&world).unwrap();
    let (mut again, mut world_again) = DeformableWorld::load(&bytes).unwrap();
    for wakes in [false, true] {
        for (set, world) in [(&mut set, &mut world), (&mut again, &mut world_again)] {
            if wakes {
                set[soft].set_linvel(Vector::Y);
            }
            for _ in 0..20 {
                set.step(world);
            }
            assert_eq!(set[soft].is_sleeping(), !wakes);
        }
        assert_eq!(again.state_hash(), set.state_hash());
    }
}

/// What lies still falls asleep, though by most schemes a pressed node reads the velocity that the next impulse of its contact
/// takes away.
#[test]
fn bodies_of_every_scheme_fall_asleep() {
    for integrator in Integrator::ALL {
        let (mut world, _) = floored(1.0 / 60.0);
        let mut set = DeformableWorld::new();
        let soft = DeformableBuilder::new(lattice(Vector::splat(0.3), 0.1))
            .material(Material::rubber())
            .translation(Vector::Y * 0.151)
            .integrator(integrator);
        let soft = set.insert(soft).unwrap();
        for _ in 0..180 {
            set.step(&mut world);
        }
        assert!(set[soft].is_sleeping(), "{}", integrator.name());
    }
}
