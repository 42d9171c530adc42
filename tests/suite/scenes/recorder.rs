//! What a recorder keeps agrees with the world it watched.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::record::{Cfc, Interface};
use crumple::shape;

/// A block thrown at the ground, watched.
fn watched() -> (DeformableWorld, Recorder, ColliderHandle, DeformableHandle) {
    let mut world = PhysicsWorld::default();
    let (_, ground) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(5.0, 0.5, 5.0),
    );
    let mut deformables = DeformableWorld::default();
    let net = shape::lattice(Vector::splat(0.4), 0.1);
    let block = DeformableBuilder::new(net)
        .material(Material::elastic(1.0e6, 500.0).yielding(10.0e3, 50.0e3))
        .translation(Vector::new(0.0, 0.25, 0.0))
        .linvel(Vector::new(1.0, -4.0, 0.0));
    let block = deformables.insert(block).unwrap();
    let mut recorder = Recorder::new();
    recorder.sampling.events = 5;
    recorder.begin(&deformables);
    let all = (0..deformables[block].node_count() as u32).map(NodeId);
    recorder
        .follow("all", &deformables, block, all.collect())
        .unwrap();
    for _ in 0..30 {
        deformables.step_with(&mut world, &(), &(), &mut recorder);
    }
    (deformables, recorder, ground, block)
}

#[test]
fn impulses_momentum_and_forces_agree() {
    let (world, recorder, ground, block) = watched();
    let record = recorder.body(block).unwrap();
    let closure = recorder.momentum_closure();
    assert!(closure < 1e-5, "{closure}");
    let residual = recorder.max_residual();
    assert!(residual < 0.01, "{residual}");
    let channel = record.find(Interface::Collider(ground)).unwrap();
    let mass = world[block].mass();
    let expected = mass * (world[block].linvel().y + 4.0 + 9.81 * world.time());
    for axis in 0..3 {
        let force = recorder.collider_force(ground, axis, 1e-4).unwrap();
        let impulse = force.values.iter().sum::<f64>() * force.dt;
        assert!((impulse - channel.total().to_array()[axis]).abs() < 1e-9 * expected);
    }
    assert!((channel.total().y / expected - 1.0).abs() < 1e-4);
    // A set of all nodes is the centre of mass.
    for (a, b) in recorder.sets[0]
        .history
        .positions
        .iter()
        .zip(&record.center.positions)
    {
        assert!((*a - *b).length() < 1e-9);
    }
    // The acceleration of the whole is the force over the mass, in one filter as in the other.
    let force = recorder.collider_force(ground, 1, 1e-4).unwrap();
    let force = force.filtered(Cfc::Cfc60).unwrap().peak();
    let acceleration = recorder.acceleration(&recorder.sets[0], 1, 1e-4).unwrap();
    let acceleration = acceleration.filtered(Cfc::Cfc60).unwrap().peak();
    assert!((force.1 / mass - 9.81 - acceleration.1).abs() < 0.02 * acceleration.1);
}

#[test]
fn events_are_capped_and_counted() {
    let (.., recorder, _, _) = watched();
    assert_eq!(recorder.events.len(), 5);
    assert!(recorder.yielded > 5);
    assert_eq!(recorder.broken, 0);
}

#[test]
fn a_collider_that_was_never_touched_gives_zeros() {
    let (_, recorder, _, _) = watched();
    let force = recorder
        .collider_force(ColliderHandle::invalid(), 0, 1e-3)
        .unwrap();
    assert!((499..=501).contains(&force.values.len()));
    assert!(force.values.iter().all(|f| *f == 0.0));
}

#[test]
fn what_can_not_be_followed_is_an_error() {
    let (world, mut recorder, _, block) = watched();
    assert!(recorder.follow("none", &world, block, Vec::new()).is_err());
    let far = vec![NodeId(1_000_000)];
    assert!(recorder.follow("far", &world, block, far).is_err());
    let empty = DeformableWorld::default();
    let error = recorder.follow("gone", &empty, block, vec![NodeId(0)]);
    assert!(error.unwrap_err().to_string().contains("no deformable"));
}

/// Symptom: a body inserted later was heard from the start. Cause: channels were added bin by bin from their own beginnings.
#[test]
fn forces_of_bodies_that_come_later_are_added_at_their_time() {
    let (mut world, floor) = crate::fixtures::floored(1.0 / 240.0);
    let mut deformables = DeformableWorld::default();
    let resting =
        |mass: f32, x: f32| crate::fixtures::bead(mass).translation(Vector::new(x, 0.0, 0.0));
    deformables.insert(resting(1.0, 0.0)).unwrap();
    let mut recorder = Recorder::new();
    recorder.begin(&deformables);
    for step in 0..240 {
        if step == 120 {
            deformables.insert(resting(10.0, 1.0)).unwrap();
        }
        deformables.step_with(&mut world, &(), &(), &mut recorder);
    }
    let force = recorder.collider_force(floor, 1, 0.05).unwrap();
    let at = |t: f64| force.values[(t / force.dt) as usize].abs();
    crate::support::close("force of one bead [N]", at(0.25), 9.81, 0.01);
    crate::support::close("force of both [N]", at(0.75), 11.0 * 9.81, 0.01);
}

/// A set is in the table whenever it was followed, and without values before; masses are those of the time.
#[test]
fn what_is_followed_later_is_in_the_table() {
    let (mut world, _) = crate::fixtures::floored(1.0 / 240.0);
    let mut set = DeformableWorld::default();
    let bead = crate::fixtures::bead(1.0).translation(Vector::Y * 9.0);
    let bead = set.insert(bead.linvel(Vector::X)).unwrap();
    let mut recorder = Recorder::new();
    let node = vec![NodeId(0)];
    // Before anything is recorded of the body.
    let early = recorder.follow("early", &set, bead, node.clone());
    early.unwrap();
    for step in 0..4 {
        if step == 2 {
            set[bead].set_node_mass(NodeId(0), 2.0).unwrap();
            let late = recorder.follow("late", &set, bead, node.clone());
            late.unwrap();
        }
        set.step_with(&mut world, &(), &(), &mut recorder);
    }
    let record = recorder.body(bead).unwrap();
    let path = std::env::temp_dir().join(format!("crumple-late-{}.csv", std::process::id()));
    recorder.write_history(record, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let mut lines = text.lines();
    let headers: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    let column = |name: &str| {
        let i = headers.iter().position(|h| *h == name).unwrap();
        rows.iter().map(|row| row[i]).collect::<Vec<f64>>()
    };
    let [com, early, late] = ["com_y_m", "early_y_m", "late_y_m"].map(column);
    assert!(com.len() >= 5 && com == early, "{com:?} {early:?}");
    let known = late.iter().filter(|y| !y.is_nan()).count();
    assert!(known > 1 && known < com.len(), "{late:?}");
    assert_eq!(late[com.len() - known..], com[com.len() - known..]);
    let [v, p] = ["com_v_x_mps", "momentum_x_ns"].map(column);
    assert!(v.iter().all(|v| (v - 1.0).abs() < 1e-6), "{v:?}");
    assert!(p[0] == 1.0 && p[p.len() - 1] == 2.0, "{p:?}");
}
