//! Friction of a deformable box.

use crate::support::close;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape;

/// A floor with friction `mu` under gravity tilted by `angle`, and a settled box on it.
fn scene(mu: f32, angle: f32) -> (PhysicsWorld, DeformableWorld, DeformableHandle) {
    let mut world = PhysicsWorld {
        gravity: 9.81 * Vector::new(angle.sin(), -angle.cos(), 0.0),
        ..PhysicsWorld::default()
    };
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -1.0, 0.0)),
        ColliderBuilder::cuboid(20.0, 1.0, 5.0).friction(mu),
    );
    let mut deformables = DeformableWorld::default();
    let handle = deformables
        .insert(
            DeformableBuilder::new(shape::lattice(Vector::new(0.4, 0.2, 0.4), 0.1))
                .material(Material::elastic(1.0e7, 1000.0).viscosity(1.0e4))
                .friction(mu)
                .translation(Vector::new(0.0, 0.1, 0.0)),
        )
        .unwrap();
    (world, deformables, handle)
}

/// Mean acceleration along the slope between .5 and 1.5 s.
fn acceleration(mu: f32) -> f64 {
    let (mut world, mut deformables, handle) = scene(mu, std::f32::consts::FRAC_PI_6);
    let mut v = [0.0; 2];
    for v in &mut v {
        let steps = if *v == 0.0 && deformables.time() == 0.0 {
            30
        } else {
            60
        };
        for _ in 0..steps {
            deformables.step(&mut world);
        }
        *v = deformables[handle].linvel().x;
    }
    v[1] - v[0]
}

/// V29: it slides down an incline of 30°.
#[test]
fn v29_sliding_down() {
    close(
        "acceleration at μ = .2 [m/s²]",
        acceleration(0.2),
        3.205858,
        0.01,
    );
}

/// V29: it slips if and only if μ < tan 30° = .57735.
#[test]
fn v29_slips_below_the_tangent() {
    let expected = 9.81 * (0.5 - 0.55 * 0.75_f64.sqrt());
    close(
        "acceleration at μ = .55 [m/s²]",
        acceleration(0.55),
        expected,
        0.01,
    );
    let sticking = acceleration(0.6);
    assert!(
        sticking.abs() < 1e-3,
        "μ = .60: accelerates at {sticking} m/s²"
    );
}

/// V29: it stops on the flat.
#[test]
fn v29_stopping_on_the_flat() {
    let (mut world, mut deformables, handle) = scene(0.3, 0.0);
    for _ in 0..60 {
        deformables.step(&mut world);
    }
    deformables[handle].set_linvel(Vector::new(3.0, 0.0, 0.0));
    let (start, begin) = (deformables[handle].center_of_mass().x, deformables.time());
    world.integration_parameters.dt = 1.0 / 240.0;
    let mut last = (begin, 3.0);
    let stopped = loop {
        deformables.step(&mut world);
        let now = (deformables.time(), deformables[handle].linvel().x);
        if now.1 <= 0.0 {
            break last.0 + (now.0 - last.0) * last.1 / (last.1 - now.1) - begin;
        }
        assert!(now.0 - begin < 2.0, "still sliding at {} m/s", now.1);
        last = now;
    };
    let way = deformables[handle].center_of_mass().x - start;
    close("time to stop [s]", stopped, 1.019368, 0.01);
    close("way [m]", way, 1.529052, 0.01);
}

/// V29: what sticks does not creep. The box is let go on the slope and settles for two seconds; then it must stay where it
/// is for ten, awake.
#[test]
fn v29_sticking_does_not_drift() {
    for mu in [0.6, 0.8, 1.2] {
        let (mut world, mut deformables, handle) = scene(mu, std::f32::consts::FRAC_PI_6);
        for _ in 0..120 {
            deformables.step(&mut world);
        }
        let start = deformables[handle].center_of_mass();
        for _ in 0..600 {
            deformables.step(&mut world);
        }
        let drift = (deformables[handle].center_of_mass() - start).length();
        assert!(drift < 1e-4, "μ = {mu}: drifts by {drift:.2e} m in 10 s");
    }
}
