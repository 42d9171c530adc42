//! Contacts that begin, are strong and end; contact forces that can be read; sensors.

use crate::fixtures::{bits, cube, floored};
use crate::support::{close, weightless};
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use std::sync::Mutex;

/// What happened, as letters: S started, F force, E ended, R ended by removal.
fn letters(events: &[TouchEvent]) -> String {
    let letter = |e: &TouchEvent| match e.kind {
        TouchEventKind::Started => 'S',
        TouchEventKind::Force => 'F',
        TouchEventKind::Stopped { removed: false } => 'E',
        TouchEventKind::Stopped { removed: true } => 'R',
        _ => '?',
    };
    events.iter().map(letter).collect()
}

/// Keeps what it is told.
#[derive(Default)]
struct Diary(Vec<TouchEvent>);

impl Observer for Diary {
    fn substep(&mut self, _: &Substep) {}

    fn touch_event(&mut self, event: &TouchEvent) {
        self.0.push(*event);
    }
}

#[test]
fn a_block_lands_rests_and_is_left() {
    let mut world = PhysicsWorld::default();
    let at = RigidBodyBuilder::kinematic_velocity_based().translation(Vector::Y * -0.5);
    let (floor, collider) = world.insert(at, ColliderBuilder::cuboid(5.0, 0.5, 5.0));
    let mut set = DeformableWorld::new();
    let block = |x: f32, threshold: f32| {
        cube(0.3)
            .translation(Vector::new(x, 0.3, 0.0))
            .contact_force_event_threshold(threshold)
            .can_sleep(false)
    };
    let heavy = set.insert(block(0.0, 1.0)).unwrap();
    let light = set.insert(block(1.0, 1.0e6)).unwrap();
    let mut diary = Diary::default();
    for step in 0..180 {
        set.step_with(&mut world, &(), &(), &mut diary);
        assert!(
            step < 30 || set.report().events.len() == 1,
            "only the force of one"
        );
    }
    let of = |d: &Diary, h| -> Vec<TouchEvent> {
        d.0.iter()
            .filter(|e| e.contact.deformable == h)
            .copied()
            .collect()
    };
    assert_eq!(letters(&of(&diary, light)), "S");
    let strong = letters(&of(&diary, heavy));
    assert!(strong.starts_with("SF") && !strong[1..].contains(['S', 'E', 'R']));
    let force = set.contact_force(heavy, collider).unwrap();
    let weight = set[heavy].mass() * 9.81;
    close("weight", force.y, weight, 1e-2);
    let contact = set.contacts_of(heavy).next().unwrap();
    assert_eq!((contact.force, contact.partner), (force, collider.into()));
    assert!(contact.touching >= 4 && contact.peak_force >= 0.99 * weight);
    assert!((contact.normal - DVec3::Y).length() < 1e-6);
    let com = set[heavy].center_of_mass();
    assert!((contact.point - DVec3::new(com.x, 0.0, com.z)).length() < 0.01);
    assert_eq!(set.contacts_with(collider).count(), 2);

    diary.0.clear();
    world.bodies[floor].set_linvel(Vector::Y * -20.0, true);
    for _ in 0..5 {
        set.step_with(&mut world, &(), &(), &mut diary);
    }
    assert_eq!(letters(&of(&diary, light)), "E");
    assert_eq!(letters(&of(&diary, heavy)), "E");
    assert_eq!(set.contact_force(heavy, collider), None);
    assert_eq!(set.contacts_with(collider).count(), 0);
}

#[test]
fn what_is_removed_stops_touching() {
    for remove_floor in [true, false] {
        let (mut world, floor) = floored(1.0 / 60.0);
        let mut set = DeformableWorld::new();
        let block = set.insert(cube(0.3).translation(Vector::Y * 0.16)).unwrap();
        for _ in 0..30 {
            set.step(&mut world);
        }
        assert!(set.contact_force(block, floor).is_some());
        if remove_floor {
            world.remove_collider(floor);
        } else {
            set.remove(block);
        }
        set.step(&mut world);
        assert_eq!(letters(&set.report().events), "R");
        set.step(&mut world);
        assert!(set.report().events.is_empty());
    }
}

/// What ceases to push and still is there is one end and, where it goes on noticing, one start, awake or asleep.
#[test]
fn what_becomes_a_sensor_and_back_is_told_as_two() {
    for sleeps in [false, true] {
        let (mut world, floor) = floored(1.0 / 60.0);
        let mut set = DeformableWorld::new();
        let block = cube(0.3).translation(Vector::Y * 0.15).can_sleep(sleeps);
        let block = set.insert(block).unwrap();
        for _ in 0..300 {
            set.step(&mut world);
        }
        assert_eq!(set[block].is_sleeping(), sleeps);
        let told = |world: &mut PhysicsWorld, set: &mut DeformableWorld| {
            set.step(world);
            let events = &set.report().events;
            let sensors: Vec<bool> = events.iter().map(|e| e.sensor).collect();
            assert!(events.iter().all(|e| e.contact.partner == floor.into()));
            (letters(events), sensors)
        };
        world.colliders[floor].set_sensor(true);
        let both = ("ES".to_string(), vec![false, true]);
        assert_eq!(told(&mut world, &mut set), both, "asleep: {sleeps}");
        assert_eq!(set.contact_force(block, floor), None);
        world.colliders[floor].set_sensor(false);
        let both = ("ES".to_string(), vec![true, false]);
        assert_eq!(told(&mut world, &mut set), both);
        world.colliders[floor].set_enabled(false);
        assert_eq!(told(&mut world, &mut set), ("E".to_string(), vec![false]));
        world.colliders[floor].set_enabled(true);
        assert_eq!(told(&mut world, &mut set), ("S".to_string(), vec![false]));
        world.remove_collider(floor);
        assert_eq!(told(&mut world, &mut set), ("R".to_string(), vec![false]));
    }
}

/// A springy block without damping bounces: started and stopped take turns, with or without sub-steps of Rapier.
#[test]
fn bounces_take_turns() {
    for near_a_box in [false, true] {
        let (mut world, floor) = floored(1.0 / 60.0);
        if near_a_box {
            // An awake box in reach makes Rapier step four times a frame.
            let at = RigidBodyBuilder::dynamic()
                .translation(Vector::new(0.32, 1.0, 0.0))
                .gravity_scale(0.0);
            world.insert(at.can_sleep(false), ColliderBuilder::ball(0.05));
        }
        let mut set = DeformableWorld::new();
        let body = DeformableBuilder::new(lattice(Vector::splat(0.3), 0.1))
            .material(Material::elastic(1.0e6, 500.0))
            .translation(Vector::Y * 1.0);
        let block = set.insert(body).unwrap();
        let mut told = String::new();
        let mut rigid_steps = 0;
        for _ in 0..240 {
            set.step(&mut world);
            rigid_steps = rigid_steps.max(set.report().rigid_steps);
            let events = &set.report().events;
            assert!(events.iter().all(|e| e.contact.deformable == block));
            assert!(events.iter().all(|e| e.contact.partner == floor.into()));
            told += &letters(events);
        }
        assert_eq!(rigid_steps, if near_a_box { 4 } else { 1 });
        assert!(told.len() >= 6, "{told}");
        assert!(!told.contains("SS") && !told.contains("EE"), "{told}");
        assert!(told.starts_with('S'), "{told}");
    }
}

/// Keeps what Rapier says.
#[derive(Default)]
struct Heard(Mutex<Vec<String>>);

impl EventHandler for Heard {
    fn handle_collision_event(
        &self,
        _: &RigidBodySet,
        _: &ColliderSet,
        event: CollisionEvent,
        _: Option<&ContactPair>,
    ) {
        self.0.lock().unwrap().push(format!("{event:?}"));
    }

    fn handle_soft_body_tear_event(&self, _: &SoftBodySet, _: &SoftBodyTearEvent) {}

    fn handle_contact_force_event(
        &self,
        dt: Real,
        _: &RigidBodySet,
        _: &ColliderSet,
        pair: &ContactPair,
        total: Real,
    ) {
        let told = format!("{:?} {:?} {dt} {total}", pair.collider1, pair.collider2);
        self.0.lock().unwrap().push(told);
    }
}

#[test]
fn rapiers_own_events_are_those_of_rapier_alone() {
    let scene = || {
        let (mut world, _) = floored(1.0 / 60.0);
        for i in 0..4 {
            let at = RigidBodyBuilder::dynamic().translation(Vector::new(2.0, 0.5 + i as f32, 0.0));
            let events = ActiveEvents::COLLISION_EVENTS | ActiveEvents::CONTACT_FORCE_EVENTS;
            let ball = ColliderBuilder::ball(0.2).restitution(0.7);
            world.insert(at, ball.active_events(events));
        }
        world
    };
    let (mut plain, mut mixed) = (scene(), scene());
    let (alone, beside) = (Heard::default(), Heard::default());
    let mut set = DeformableWorld::new();
    set.insert(cube(0.3).translation(Vector::new(-2.0, 0.4, 0.0)))
        .unwrap();
    let mut own = 0;
    for _ in 0..180 {
        plain.step_with_events(&(), &alone);
        set.step_with(&mut mixed, &(), &beside, &mut ());
        own += set.report().events.len();
        assert_eq!(bits(&plain), bits(&mixed));
    }
    let (alone, beside) = (
        alone.0.into_inner().unwrap(),
        beside.0.into_inner().unwrap(),
    );
    assert!(alone.len() > 20 && own > 0);
    assert_eq!(alone, beside);
}

/// Slow or fast, thick or thinner than the cells, each passage is one entry and one leaving.
#[test]
fn sensors_notice_what_flies_through() {
    for (speed, length) in [(2.0, 0.3), (20.0, 0.3), (20.0, 0.1), (200.0, 0.1)] {
        let mut world = weightless(1.0 / 60.0);
        let sensor = ColliderBuilder::cuboid(0.01, 1.0, 1.0).sensor(true);
        let (_, collider) = world.insert(RigidBodyBuilder::fixed(), sensor);
        let mut set = DeformableWorld::new();
        let body = cube(length)
            .translation(Vector::X * -1.03)
            .linvel(Vector::X * speed);
        let block = set.insert(body).unwrap();
        let mut diary = Diary::default();
        for _ in 0..(2.5 * 60.0 / speed).max(3.0) as usize {
            set.step_with(&mut world, &(), &(), &mut diary);
        }
        assert_eq!(letters(&diary.0), "SE", "at {speed} m/s, {length} m long");
        assert!(
            diary
                .0
                .iter()
                .all(|e| e.sensor && e.contact.partner == collider.into())
        );
        assert_eq!(set.contact_force(block, collider), None);
        assert_eq!(set.report().rigid_steps, 1);
        assert!((set[block].linvel().x - f64::from(speed)).abs() < 1e-3 * f64::from(speed));
    }
}

/// Symptom: a sensor that was crossed in a step during which a spring was changed noticed nothing. Cause: the change took the
/// place where nodes had been before the step for the one where they are.
#[test]
fn sensors_notice_through_changes() {
    let (mut world, _) = floored(1.0 / 60.0);
    let sensor = ColliderBuilder::cuboid(0.01, 1.0, 1.0).sensor(true);
    let sensor = sensor.translation(Vector::new(2.0, 3.0, 0.0));
    world.insert(RigidBodyBuilder::fixed(), sensor);
    let mut set = DeformableWorld::new();
    let flying = cube(0.3).translation(Vector::new(1.0, 3.0, 0.0));
    let block = set.insert(flying.linvel(Vector::X * 120.0)).unwrap();
    set.before_step(&mut RapierParts::from(&mut world), &mut ());
    world.step();
    set[block]
        .set_spring(SpringId(0), |s| s.damping *= 0.5)
        .unwrap();
    set.after_step(&mut RapierParts::from(&mut world));
    assert!(letters(&set.report().events).starts_with('S'));
}

/// Halves of a step tell the same, the second one to its own observer.
#[test]
fn halves_of_a_step_tell_as_well() {
    let (mut world, floor) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    set.insert(cube(0.3).translation(Vector::Y * 0.2)).unwrap();
    let mut diary = Diary::default();
    for _ in 0..30 {
        set.before_step(&mut RapierParts::from(&mut world), &mut ());
        world.step();
        set.after_step_with(&mut RapierParts::from(&mut world), &mut diary);
    }
    assert_eq!(letters(&diary.0), "S");
    world.remove_collider(floor);
    set.before_step(&mut RapierParts::from(&mut world), &mut ());
    world.step();
    set.after_step(&mut RapierParts::from(&mut world));
    assert_eq!(letters(&set.report().events), "R");
}

#[test]
fn thresholds_must_be_numbers() {
    for bad in [-1.0, f32::NAN] {
        let body = cube(0.3).contact_force_event_threshold(bad);
        assert!(matches!(body.build(), Err(BuildError::Value { .. })));
    }
}

/// Adds up what each partner did, by pairs and by nodes.
#[derive(Default)]
struct Books {
    pairs: Vec<(ColliderHandle, DVec3)>,
    nodes: Vec<(ColliderHandle, DVec3)>,
}

fn add(list: &mut Vec<(ColliderHandle, DVec3)>, collider: ColliderHandle, impulse: DVec3) {
    match list.iter_mut().find(|(c, _)| *c == collider) {
        Some((_, sum)) => *sum += impulse,
        None => list.push((collider, impulse)),
    }
}

impl Observer for Books {
    fn substep(&mut self, s: &Substep) {
        for pair in s.contacts.iter().filter(|p| p.touching > 0) {
            if let Partner::Collider(collider) = pair.partner {
                add(&mut self.pairs, collider, pair.impulse);
            }
        }
        for n in s.node_impulses {
            if let Partner::Collider(collider) = n.partner {
                add(&mut self.nodes, collider, n.impulse);
            }
        }
    }

    fn wants_node_impulses(&self) -> bool {
        true
    }
}

/// A tumbling body of two colliders, its centre of mass off both, hits a block: what the nodes got is what the colliders gave,
/// and what the body's momentum changed by.
#[test]
fn nodes_get_what_bodies_give() {
    let mut world = weightless(1.0 / 60.0);
    let at = RigidBodyBuilder::dynamic()
        .translation(Vector::new(-0.6, 0.05, 0.0))
        .linvel(Vector::new(6.0, 0.0, 0.5))
        .angvel(Vector::new(2.0, -3.0, 5.0));
    let (body, first) = world.insert(at, ColliderBuilder::cuboid(0.1, 0.15, 0.05).density(2000.0));
    let second = ColliderBuilder::ball(0.08)
        .translation(Vector::new(0.1, 0.2, 0.0))
        .density(500.0);
    let second = world.insert_collider(second, Some(body));
    let mut set = DeformableWorld::new();
    set.insert(cube(0.6)).unwrap();
    set.step(&mut weightless(0.0));
    let before = world.bodies[body].linvel().as_dvec3();
    let mut books = Books::default();
    for _ in 0..30 {
        set.step_with(&mut world, &(), &(), &mut books);
    }
    let rigid = &world.bodies[body];
    let gained = f64::from(rigid.mass()) * (rigid.linvel().as_dvec3() - before);
    let given: DVec3 = books.nodes.iter().map(|(_, j)| *j).sum();
    assert!(gained.length() > 1.0, "they must meet: {gained}");
    assert!(
        (gained + given).length() < 1e-4 * gained.length(),
        "{gained} {given}"
    );
    for collider in [first, second] {
        let of = |list: &[(ColliderHandle, DVec3)]| {
            list.iter().find(|(c, _)| *c == collider).map(|(_, j)| *j)
        };
        let (by_pair, by_node) = (of(&books.pairs), of(&books.nodes));
        let (Some(by_pair), Some(by_node)) = (by_pair, by_node) else {
            panic!("collider {collider:?} must touch: {by_pair:?} {by_node:?}");
        };
        assert!((by_pair - by_node).length() < 1e-12 * by_pair.length());
    }
}
