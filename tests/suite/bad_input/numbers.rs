//! Numbers beyond all use in the midst of a run.

use crate::fixtures::{bits, cube, floored};
use crumple::body::BuildError;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// A cube with a pinned corner beside one that lies on the floor, after some steps.
fn scene() -> (PhysicsWorld, DeformableWorld, [DeformableHandle; 2]) {
    let (mut world, _) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let bodies = [0.0, 1.0].map(|x| {
        let at = Vector::new(x, 0.2, 0.0);
        set.insert(cube(0.3).translation(at)).unwrap()
    });
    assert!(set[bodies[0]].set_pinned(NodeId(0), true));
    for _ in 0..20 {
        set.step(&mut world);
    }
    (world, set, bodies)
}

#[test]
fn a_gravity_that_is_none_changes_nothing() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let (mut world, mut set, bodies) = scene();
        let (mut twin_world, mut twin, _) = scene();
        let before = (bits(&world), set.state_hash(), set.time());
        let energies = bodies.map(|h| set[h].energies());
        world.gravity = Vector::new(0.0, bad, 0.0);
        set.step(&mut world);
        let reported = set.report().invalid_gravity.expect("must be reported");
        assert_eq!(reported.y.to_bits(), bad.to_bits());
        assert_eq!(set.report().rigid_steps, 0);
        set.before_step(&mut RapierParts::from(&mut world), &mut ());
        set.after_step(&mut RapierParts::from(&mut world));
        assert!(set.report().invalid_gravity.is_some());
        assert_eq!(before, (bits(&world), set.state_hash(), set.time()));
        assert_eq!(bodies.map(|h| set[h].energies()), energies);
        world.gravity = twin_world.gravity;
        for _ in 0..10 {
            set.step(&mut world);
            twin.step(&mut twin_world);
        }
        assert_eq!(set.report().invalid_gravity, None);
        assert_eq!(set.state_hash(), twin.state_hash());
    }
}

/// Settings of the world that are none: nothing is done, and the report names the value.
#[test]
fn settings_that_are_none_are_reported() {
    type Spoil = fn(&mut DeformableParameters);
    let causes: [(&str, Spoil); 12] = [
        ("Fixed(0)", |p| p.substeps = Substeps::Fixed(0)),
        ("Unchecked(0)", |p| p.substeps = Substeps::Unchecked(0)),
        ("safety 0", |p| {
            p.substeps = Substeps::Auto {
                safety: 0.0,
                min_h: 0.0,
            }
        }),
        ("safety 1.5", |p| {
            p.substeps = Substeps::Auto {
                safety: 1.5,
                min_h: 0.0,
            }
        }),
        ("safety NaN", |p| {
            p.substeps = Substeps::Auto {
                safety: f64::NAN,
                min_h: 0.0,
            }
        }),
        ("min_h", |p| {
            p.substeps = Substeps::Auto {
                safety: 0.9,
                min_h: -1.0,
            }
        }),
        ("expected_dt", |p| p.expected_dt = f64::NAN),
        ("max_rigid_dt", |p| p.max_rigid_dt = -1.0),
        ("push_out_speed", |p| p.push_out_speed = f64::NAN),
        ("review_interval", |p| p.review_interval = f64::NAN),
        ("sleep_speed", |p| p.sleep_speed = f64::NAN),
        ("sleep_after", |p| p.sleep_after = -1.0),
    ];
    let (mut world, mut set, _) = scene();
    let good = set.params;
    for (name, spoil) in causes {
        spoil(&mut set.params);
        let before = (bits(&world), set.state_hash(), set.time());
        set.step(&mut world);
        let reported = set.report().invalid_params.clone();
        assert!(
            matches!(reported, Some(BuildError::Value { .. })),
            "{name}: {reported:?}"
        );
        set.before_step(&mut RapierParts::from(&mut world), &mut ());
        assert!(set.report().invalid_params.is_some(), "{name}");
        set.after_step(&mut RapierParts::from(&mut world));
        assert_eq!(
            before,
            (bits(&world), set.state_hash(), set.time()),
            "{name}"
        );
        set.params = good;
    }
    set.step(&mut world);
    assert_eq!(set.report().invalid_params, None);
}
