//! Handles, the set, enabling.

use crate::fixtures::{bead, bits, cube, floored, height};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

#[test]
fn bodies_come_and_go() {
    let mut world = PhysicsWorld::default();
    let mut set = DeformableWorld::new();
    assert!(set.is_empty() && set.iter().next().is_none());
    let handles: Vec<_> = (0..3)
        .map(|i| set.insert(bead(1.0 + i as f32).user_data(i)).unwrap())
        .collect();
    assert_eq!(set.len(), 3);
    assert_eq!(set.iter().map(|(h, _)| h).collect::<Vec<_>>(), handles);
    for (_, body) in set.iter_mut() {
        body.user_data += 10;
    }
    assert_eq!(set[handles[2]].user_data, 12);
    set[handles[0]].user_data = 7;
    assert_eq!(set.get(handles[0]).unwrap().user_data, 7);
    assert_eq!(set.get_mut(handles[1]).unwrap().mass(), 2.0);

    let stale = handles[1];
    let removed = set.remove(stale).expect("it was there");
    assert_eq!(removed.user_data, 11);
    set.step(&mut world);
    let fresh = set.insert(bead(9.0)).unwrap();
    assert_ne!(fresh, stale, "a slot used again gives another handle");
    assert!(!set.contains(stale) && set.contains(fresh) && set.len() == 3);
    assert!(set.get(stale).is_none() && set.get_mut(stale).is_none());
    assert!(set.remove(stale).is_none());
    assert_eq!(set[fresh].mass(), 9.0);
    set.step(&mut world);
}

/// A body built or taken out earlier goes in as it is.
#[test]
fn a_body_goes_in_again_as_it_was() {
    let mut world = PhysicsWorld::default();
    let mut set = DeformableWorld::new();
    let first = set.insert(cube(0.3).build().unwrap()).unwrap();
    for _ in 0..3 {
        set.step(&mut world);
    }
    let body = set.remove(first).unwrap();
    let hash = body.state_hash();
    let mut other = DeformableWorld::new();
    let again = other.insert(body).unwrap();
    assert_eq!(other[again].state_hash(), hash);
    other.step(&mut world);
    assert!((other[again].linvel().y + 9.81 * 4.0 / 60.0).abs() < 1e-3);
}

#[test]
#[should_panic]
fn indexing_by_a_stale_handle_panics_as_in_rapier() {
    let mut set = DeformableWorld::new();
    let handle = set.insert(bead(1.0)).unwrap();
    set.remove(handle);
    let _ = &set[handle];
}

/// A disabled body does not move and touches nothing; enabled again it goes on from where it is.
#[test]
fn disabled_bodies_are_not_there() {
    let run = |with: bool| {
        let (mut world, _) = floored(1.0 / 60.0);
        let (ball, _) = world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 1.0, 0.0)),
            ColliderBuilder::ball(0.1),
        );
        let mut set = DeformableWorld::new();
        if with {
            let builder = cube(0.4)
                .translation(Vector::new(0.0, 0.5, 0.0))
                .linvel(Vector::new(0.0, 2.0, 0.0))
                .enabled(false);
            let handle = set.insert(builder).unwrap();
            set[handle].set_pinned(NodeId(0), true);
            set[handle].set_kinematic_target(NodeId(0), Vector::new(0.0, 3.0, 0.0));
        }
        let hash = set.state_hash();
        for _ in 0..40 {
            set.step(&mut world);
        }
        assert_eq!(set.state_hash(), hash);
        (world, set, ball)
    };
    let (mut world, mut set, ball) = run(true);
    assert_eq!(bits(&world), bits(&run(false).0));
    world.remove_body(ball);
    let handle = set.iter().next().unwrap().0;
    assert!(!set[handle].is_enabled());
    set[handle].set_enabled(true);
    set[handle].set_pinned(NodeId(0), false);
    set.step(&mut world);
    let v = set[handle].linvel().y * 64.0 / 63.0;
    assert!((v - (2.0 - 9.81 / 60.0)).abs() < 0.03, "{v} m/s");
}

/// Disabled while it lies on a floor, then enabled: it still lies there.
#[test]
fn a_resting_body_may_be_switched_off_and_on() {
    let (mut world, _) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let handle = set.insert(bead(1.0)).unwrap();
    for step in 0..30 {
        set[handle].set_enabled(step % 10 < 5);
        set.step(&mut world);
        assert!(height(&set[handle]).0.abs() < 1e-4);
    }
}

fn is_send_sync_clone<T: Send + Sync + Clone>() {}

#[test]
fn worlds_go_to_other_threads() {
    is_send_sync_clone::<DeformableWorld>();
    is_send_sync_clone::<Deformable>();
    is_send_sync_clone::<DeformableBuilder>();
}
