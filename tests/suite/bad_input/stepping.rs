//! A step with a dt that is none, and bodies that turn non-finite: contained and reported, everything else goes on.

use crate::fixtures::{all_finite, bead, bits, cube, floored};
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::world::RapierParts;

#[test]
fn a_dt_that_is_none_changes_nothing() {
    let (mut world, _) = floored(1.0 / 60.0);
    world.insert(
        RigidBodyBuilder::dynamic()
            .translation(Vector::new(0.0, 1.0, 0.0))
            .angvel(Vector::new(1.0, 2.0, 3.0)),
        ColliderBuilder::ball(0.2),
    );
    let mut deformables = DeformableWorld::new();
    let handle = deformables
        .insert(cube(0.3).translation(Vector::new(0.0, 0.4, 0.0)))
        .unwrap();
    for _ in 0..5 {
        deformables.step(&mut world);
    }
    assert!(deformables[handle].add_step_force(NodeId(0), Vector::Y));
    let before = (bits(&world), deformables.state_hash(), deformables.time());
    for bad in [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        -1.0 / 60.0,
        10.1,
        1e4,
    ] {
        world.integration_parameters.dt = bad;
        deformables.step(&mut world);
        let reported = deformables.report().invalid_dt.expect("must be reported");
        assert_eq!(reported.to_bits(), f64::from(bad).to_bits());
        assert_eq!(deformables.report().rigid_steps, 0);
        // The user's own loop is told the same way.
        deformables.before_step(&mut RapierParts::from(&mut world), &mut ());
        deformables.after_step(&mut RapierParts::from(&mut world));
        assert!(deformables.report().invalid_dt.is_some());
        let after = (bits(&world), deformables.state_hash(), deformables.time());
        assert_eq!(before, after, "dt = {bad}");
    }
    world.integration_parameters.dt = 1.0 / 60.0;
    deformables.step(&mut world);
    assert_eq!(deformables.report().invalid_dt, None);
    assert_ne!(before.1, deformables.state_hash());
}

/// A force field that turns NaN while the body lies on a dynamic box which other deformables touch, too.
#[test]
fn a_force_field_of_nan_freezes_its_body_alone() {
    for integrator in Integrator::ALL {
        let (mut world, _) = floored(1.0 / 60.0);
        world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.25, 0.0)),
            ColliderBuilder::cuboid(1.0, 0.25, 1.0),
        );
        let mut deformables = DeformableWorld::new();
        deformables.params.integrator = integrator;
        let at = |x: f32| cube(0.3).translation(Vector::new(x, 0.66, 0.0));
        let sick = deformables
            .insert(
                at(-0.5).force_field(|node: NodeId, _: Vector, _: Vector, t: f64| {
                    if t > 0.1 && node.0 == 5 {
                        Vector::splat(f32::NAN)
                    } else {
                        Vector::ZERO
                    }
                }),
            )
            .unwrap();
        let sound = deformables.insert(at(0.5)).unwrap();
        let falling = deformables
            .insert(bead(1.0).translation(Vector::new(0.0, 50.0, 0.0)))
            .unwrap();
        let mut frozen_in = Vec::new();
        for step in 0..30 {
            deformables.step(&mut world);
            assert!(
                all_finite(&world),
                "{integrator:?}: NaN reached Rapier in step {step}"
            );
            if !deformables.report().frozen.is_empty() {
                assert_eq!(deformables.report().frozen, [sick]);
                frozen_in.push(step);
            }
        }
        assert_eq!(
            frozen_in.len(),
            1,
            "{integrator:?}: frozen once: {frozen_in:?}"
        );
        let body = &deformables[sick];
        assert!(body.is_frozen() && !body.is_enabled());
        assert!(
            body.positions()
                .chain(body.velocities())
                .all(|v| v.is_finite())
        );
        assert!(
            body.energies().balance().is_finite(),
            "{:?}",
            body.energies()
        );
        assert!(deformables[sound].is_enabled());
        let fall = deformables[falling].linvel().y;
        assert!(
            (fall + 9.81 * 0.5).abs() < 1e-3,
            "{integrator:?}: the bead fell on at {fall}"
        );
        let rest = deformables[sound].center_of_mass().y;
        assert!((rest - 0.65).abs() < 0.02, "{integrator:?}: {rest}");

        let stood = deformables[sick].state_hash();
        deformables[sick].set_force_field(None);
        deformables[sick].thaw();
        for _ in 0..30 {
            deformables.step(&mut world);
        }
        let body = &deformables[sick];
        assert!(body.is_enabled());
        assert_ne!(body.state_hash(), stood, "a thawed body moves");
        assert!((body.center_of_mass().y - 0.65).abs() < 0.02);
    }
}

/// The textbook's explosion, against a dynamic body that other bodies lie on.
#[test]
fn an_explosion_reaches_no_rigid_body_as_nan() {
    for n in [1, 4, 16] {
        let (mut world, _) = floored(1.0 / 60.0);
        let debris = InteractionGroups {
            filter: !Group::GROUP_2,
            ..InteractionGroups::all()
        };
        for i in 0..3 {
            world.insert(
                RigidBodyBuilder::dynamic().translation(Vector::new(
                    0.0,
                    0.25 + 0.5 * i as f32,
                    0.0,
                )),
                ColliderBuilder::cuboid(0.25, 0.25, 0.25).collision_groups(debris),
            );
        }
        let mut deformables = DeformableWorld::new();
        let bomb = deformables
            .insert(
                DeformableBuilder::new(lattice(Vector::splat(0.4), 0.2))
                    .material(Material::elastic(1.0e10, 1000.0))
                    .translation(Vector::new(0.46, 0.2, 0.0))
                    .substeps(Substeps::Unchecked(n)),
            )
            .unwrap();
        let other = deformables
            .insert(cube(0.3).translation(Vector::new(-3.0, 0.15, 0.0)))
            .unwrap();
        // Debris at 1e7 m/s would hit the other body, which is contact and not what is tested here.
        deformables[bomb].surface_mut().collision_groups = debris;
        deformables[other]
            .surface_mut()
            .collision_groups
            .memberships = Group::GROUP_2;
        let (mut unstable, mut frozen) = (false, false);
        for _ in 0..60 {
            deformables.step(&mut world);
            unstable |= deformables.report().unstable.contains(&bomb);
            frozen |= deformables.report().frozen.contains(&bomb);
            assert!(all_finite(&world));
        }
        assert!(unstable, "{n} substeps must be reported as unstable");
        assert!(
            frozen && deformables[bomb].is_frozen(),
            "{n} substeps must explode"
        );
        let body = &deformables[bomb];
        assert!(
            body.positions()
                .chain(body.velocities())
                .all(|v| v.is_finite())
        );
        assert!((deformables[other].center_of_mass().y - 0.15).abs() < 0.02);
    }
}

/// What broke in the step that went wrong is whole again, with the force of a whole spring.
#[test]
fn freezing_takes_back_what_the_step_broke() {
    let net = Net::new(
        vec![
            Node::new(Vector::ZERO, 1.0),
            Node::new(Vector::X, 1.0),
            Node::new(Vector::new(2.0, 0.0, 0.0), 1.0),
        ],
        vec![
            Spring::new(0, 1, 100.0).breaking(50.0),
            Spring::new(1, 2, 100.0).breaking(1e9),
        ],
    );
    let mut world = PhysicsWorld {
        gravity: Vector::ZERO,
        ..PhysicsWorld::default()
    };
    let mut deformables = DeformableWorld::new();
    let handle = deformables
        .insert(
            DeformableBuilder::new(net)
                .substeps(Substeps::Fixed(40))
                .force_field(|node: NodeId, _: Vector, _: Vector, t: f64| match node.0 {
                    0 if t < 0.01 => Vector::new(-1e5, 0.0, 0.0),
                    2 if t > 0.012 => Vector::splat(f32::NAN),
                    _ => Vector::ZERO,
                }),
        )
        .unwrap();
    deformables.step(&mut world);
    let body = &mut deformables[handle];
    assert!(body.is_frozen());
    assert_eq!(body.is_broken(SpringId(0)), Some(false));
    assert!(body.set_position(NodeId(0), Vector::new(-0.1, 0.0, 0.0)));
    let tension = body.tension(SpringId(0)).unwrap();
    assert!((tension - 10.0).abs() < 1e-4, "{tension} N");
    assert_eq!(body.energies().work.fracture, 0.0);
}

/// A pinned node let go makes the body need more substeps than it is allowed: taken as allowed, and reported.
#[test]
fn a_budget_that_no_longer_suffices_is_reported() {
    let net = Net::new(
        vec![
            Node::new(Vector::ZERO, 1.0),
            Node::new(Vector::X, 1e-4).pinned(),
        ],
        vec![Spring::new(0, 1, 1000.0)],
    );
    let mut world = PhysicsWorld::default();
    let mut deformables = DeformableWorld::new();
    let handle = deformables
        .insert(DeformableBuilder::new(net).substeps(Substeps::Auto {
            safety: 0.9,
            min_h: 2e-3,
        }))
        .unwrap();
    deformables.step(&mut world);
    assert!(deformables.report().unstable.is_empty());
    deformables[handle].set_pinned(NodeId(1), false);
    deformables.step(&mut world);
    assert_eq!(deformables.report().unstable, [handle]);
}
