//! Numbers beyond all use in the midst of a run: what was booked for them is taken back with the rest, and the books stay
//! closed.

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

/// The balance of all bodies against what it was, in their scale.
fn residual(set: &DeformableWorld, balances: &[f64]) -> f64 {
    let all = set.iter().zip(balances).map(|((_, body), before)| {
        let e = body.energies();
        (e.balance() - before).abs() / e.scale()
    });
    all.fold(0.0, |most: f64, r| if r.is_nan() { r } else { most.max(r) })
}

fn balances(set: &DeformableWorld) -> Vec<f64> {
    set.iter().map(|(_, b)| b.energies().balance()).collect()
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

/// What a scheme makes of the balance by itself where the cube is stopped and goes on.
fn residual_after_a_stop(integrator: Integrator) -> f64 {
    let (mut world, mut set, bodies) = scene();
    set[bodies[0]].set_integrator(Some(integrator)).unwrap();
    set.step(&mut world);
    let start = balances(&set);
    assert!(set[bodies[0]].set_linvel(Vector::ZERO));
    for _ in 0..20 {
        set.step(&mut world);
    }
    residual(&set, &start)
}

/// A step that went wrong costs its body that step and no more, and others nothing.
#[test]
fn a_step_that_goes_wrong_leaves_the_books_as_they_were() {
    type Spoil = fn(&mut Deformable);
    type Mend = fn(&mut Deformable);
    let causes: [(&str, Spoil, Mend); 3] = [
        (
            "a gravity of 1e39 m/s²",
            |b| assert!(b.set_gravity_scale(1e38)),
            |b| assert!(b.set_gravity_scale(1.0)),
        ),
        (
            "a gravity of 1e38 m/s²",
            |b| assert!(b.set_gravity_scale(1e37)),
            |b| assert!(b.set_gravity_scale(1.0)),
        ),
        (
            "a target beyond all",
            |b| assert!(b.set_kinematic_target(NodeId(0), Vector::X * 1e19)),
            |_| (),
        ),
    ];
    for (name, spoil, mend) in causes {
        for integrator in Integrator::ALL {
            let (mut world, mut set, bodies) = scene();
            set[bodies[0]].set_integrator(Some(integrator)).unwrap();
            set.step(&mut world);
            let start = balances(&set);
            let (before, gravity) = (set[bodies[0]].energies(), set[bodies[0]].gravity());
            spoil(&mut set[bodies[0]]);
            set.step(&mut world);
            assert_eq!(set.report().frozen, [bodies[0]], "{name}, {integrator:?}");
            let after = set[bodies[0]].energies();
            // It is put to rest where it is, which is external work.
            let stopped = after.work.external - before.work.external;
            assert!(stopped.abs() < 2.0 * before.scale(), "{name}: {stopped} J");
            assert_eq!(set[bodies[0]].gravity(), gravity, "{name}");
            let off = residual(&set, &start);
            assert!(off < 1e-3, "{name}, {integrator:?}: {off:.1e}");
            mend(&mut set[bodies[0]]);
            set[bodies[0]].thaw();
            for _ in 0..20 {
                set.step(&mut world);
            }
            assert!(!set[bodies[0]].is_frozen(), "{name}, {integrator:?}");
            let off = residual(&set, &start);
            let by_itself = residual_after_a_stop(integrator);
            assert!(
                off < 2.0 * by_itself + 1e-2,
                "{name}, {integrator:?}: {off:.1e}, by itself {by_itself:.1e}"
            );
        }
    }
}

/// Places and speeds whose squares `f32` has not.
#[test]
fn what_has_no_square_is_refused() {
    let (_, mut set, bodies) = scene();
    let (hash, energies) = (set.state_hash(), set[bodies[0]].energies());
    for bad in [Vector::splat(3e38), Vector::X * 2e19] {
        let body = &mut set[bodies[0]];
        assert!(!body.set_position(NodeId(1), bad));
        assert!(!body.set_linvel_of(NodeId(1), bad));
        assert!(!body.set_linvel(bad));
        assert!(!body.set_velocities(Vector::ZERO, bad));
        assert!(!body.transform(Pose::from_translation(bad)));
        assert!(!body.set_kinematic_target(NodeId(0), bad));
    }
    assert_eq!(set.state_hash(), hash);
    assert_eq!(set[bodies[0]].energies(), energies);
}

/// Settings of the world that are none: nothing is done, and the report names the value.
#[test]
fn settings_that_are_none_are_reported() {
    type Spoil = fn(&mut DeformableParameters);
    let causes: [(&str, Spoil); 13] = [
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
        ("passes", |p| p.passes = usize::MAX),
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
