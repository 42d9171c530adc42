//! The user's filter of pairs, and solver groups.

use crate::fixtures::{cube, floored};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

fn two(set: &mut DeformableWorld) -> [DeformableHandle; 2] {
    [0.0, 1.0].map(|x| {
        let body = cube(0.3).translation(Vector::new(x, 0.17, 0.0));
        set.insert(body.user_data(x as u128)).unwrap()
    })
}

#[test]
fn one_passes_and_one_rests() {
    let (mut world, floor) = floored(1.0 / 60.0);
    let mut original = DeformableWorld::new();
    let [ghost, block] = two(&mut original);
    original.set_hooks(Arc::new(|pair: &PairContext| {
        pair.deformable.1.user_data == 1 && pair.body.is_some()
    }));
    let mut set = original.clone();
    drop(original);
    for _ in 0..60 {
        set.step(&mut world);
        assert_eq!(set.contact_force(ghost, floor), None);
    }
    assert!(set[ghost].center_of_mass().y < -2.0);
    assert!((set[block].center_of_mass().y - 0.15).abs() < 0.01);
    set.clear_hooks();
    assert!(set.may_meet(ghost, block) && !set.may_meet(block, block));
}

/// What may touch, by everything that decides on it.
#[test]
fn what_may_touch_is_known() {
    let (mut world, floor) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let [ghost, block] = two(&mut set);
    set.set_hooks(Arc::new(|pair: &PairContext| {
        pair.deformable.1.user_data == 1
    }));
    assert!(set.may_touch(block, floor, &world) && !set.may_touch(ghost, floor, &world));
    let none = InteractionGroups::new(Group::NONE, Group::NONE, InteractionTestMode::And);
    let triangle = SharedShape::triangle(Vector::ZERO, Vector::X, Vector::Y);
    let flat = SharedShape::compound(vec![(Pose::IDENTITY, triangle)]);
    for (other, touches) in [
        (ColliderBuilder::ball(0.1), true),
        (ColliderBuilder::ball(0.1).sensor(true), false),
        (ColliderBuilder::ball(0.1).enabled(false), false),
        (ColliderBuilder::ball(0.1).collision_groups(none), false),
        (ColliderBuilder::ball(0.1).solver_groups(none), false),
        (ColliderBuilder::new(flat), false),
    ] {
        let other = world.colliders.insert(other);
        assert_eq!(set.may_touch(block, other, &world), touches);
    }
    set.get_mut(block).unwrap().set_enabled(false);
    assert!(!set.may_touch(block, floor, &world));
    set.remove(block);
    assert!(!set.may_touch(block, floor, &world));
    assert!(!set.may_touch(ghost, ColliderHandle::invalid(), &world));
}

struct Counts {
    asked: AtomicUsize,
    answer: fn(usize) -> bool,
}

impl DeformableHooks for Counts {
    fn filter(&self, _: &PairContext) -> bool {
        (self.answer)(self.asked.fetch_add(1, Ordering::Relaxed))
    }

    fn filter_pair(
        &self,
        first: (DeformableHandle, &Deformable),
        second: (DeformableHandle, &Deformable),
    ) -> bool {
        first.1.user_data >= second.1.user_data
    }
}

/// Once per pair and Rapier step; not for colliders that groups keep apart, nor for disabled ones.
#[test]
fn hooks_are_asked_once() {
    let (mut world, _) = floored(1.0 / 60.0);
    let never = InteractionGroups::new(Group::NONE, Group::NONE, InteractionTestMode::And);
    for collider in [
        ColliderBuilder::ball(0.5).collision_groups(never),
        ColliderBuilder::ball(0.5).enabled(false),
    ] {
        world.insert_collider(collider, None);
    }
    // An awake body far from the first block, near the second one.
    let ball = RigidBodyBuilder::dynamic()
        .translation(Vector::new(1.22, 0.17, 0.0))
        .gravity_scale(0.0)
        .can_sleep(false);
    world.insert(ball, ColliderBuilder::ball(0.05));
    let mut set = DeformableWorld::new();
    let [a, b] = two(&mut set);
    let counts = Arc::new(Counts {
        asked: AtomicUsize::new(0),
        answer: |_| true,
    });
    set.set_hooks(counts.clone());
    set.step(&mut world);
    assert_eq!(set.report().rigid_steps, 4);
    let asked = counts.asked.load(Ordering::Relaxed);
    assert_eq!(asked, 12, "two floors and a ball, in 4 Rapier steps");
    assert!(!set.may_meet(a, b));
}

/// A hook that changes its mind in every step makes events in every other, and nothing flies off.
#[test]
fn a_fickle_hook_is_obeyed() {
    let (mut world, floor) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let block = set.insert(cube(0.3).translation(Vector::Y * 0.15)).unwrap();
    for _ in 0..30 {
        set.step(&mut world);
    }
    set.set_hooks(Arc::new(Counts {
        asked: AtomicUsize::new(0),
        answer: |n| n % 2 == 1,
    }));
    for step in 0..40 {
        set.step(&mut world);
        assert_eq!(set.contact_force(block, floor).is_some(), step % 2 == 1);
        assert_eq!(set.report().events.len(), 1, "step {step}");
    }
    let v = set[block].linvel().length();
    assert!(v < 1.0 && !set[block].is_frozen(), "{v} m/s");
}

/// Solver groups that do not agree: noticed, and not pushed. Groups that do not: not even noticed.
#[test]
fn solver_groups_notice() {
    for noticed in [true, false] {
        let (mut world, floor) = floored(1.0 / 60.0);
        let none = InteractionGroups::new(Group::NONE, Group::NONE, InteractionTestMode::And);
        if noticed {
            world.colliders[floor].set_solver_groups(none);
        } else {
            world.colliders[floor].set_collision_groups(none);
        }
        let mut set = DeformableWorld::new();
        let block = set.insert(cube(0.3).translation(Vector::Y * 0.5)).unwrap();
        let mut kinds = Vec::new();
        for _ in 0..90 {
            set.step(&mut world);
            kinds.extend(set.report().events.iter().map(|e| (e.kind, e.sensor)));
            assert_eq!(set.contact_force(block, floor), None);
        }
        assert!(set[block].center_of_mass().y < -2.0);
        let started = (TouchEventKind::Started, false);
        let stopped = (TouchEventKind::Stopped { removed: false }, false);
        let expected = if noticed {
            vec![started, stopped]
        } else {
            Vec::new()
        };
        assert_eq!(kinds, expected);
    }
}

/// A hook that panics takes neither world along.
#[test]
fn a_panic_leaves_both_worlds_whole() {
    let (mut world, _) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let block = set.insert(cube(0.3).translation(Vector::Y * 0.17)).unwrap();
    set.set_hooks(Arc::new(|_: &PairContext| -> bool { panic!("no") }));
    let hash = set.state_hash();
    let stepped = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| set.step(&mut world)));
    assert!(stepped.is_err());
    assert_eq!(set.state_hash(), hash);
    set.clear_hooks();
    for _ in 0..60 {
        set.step(&mut world);
    }
    assert!((set[block].center_of_mass().y - 0.15).abs() < 0.01);
}
