//! Friction that holds: a rigid box kept awake on a deformable slope.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape;

/// A box of `mass` kg on a deformable slab under gravity tilted by 20°, both at rest against each other; how far the box
/// creeps along the slope in 10 s after two of settling \[m\].
fn creep(mass: f32, mu: f32, dt: f32) -> f64 {
    let angle = 20.0_f32.to_radians();
    let mut world = PhysicsWorld {
        gravity: 9.81 * Vector::new(angle.sin(), -angle.cos(), 0.0),
        ..PhysicsWorld::default()
    };
    world.integration_parameters.dt = dt;
    let mut net = shape::lattice(Vector::new(1.0, 0.2, 0.6), 0.1).unwrap();
    for node in &mut net.nodes {
        node.pinned = node.position.y < -0.09;
    }
    let mut deformables = DeformableWorld::default();
    deformables
        .insert(
            DeformableBuilder::new(net)
                .material(Material::elastic(1.0e6, 200.0).viscosity(1.0e3))
                .friction(mu)
                .translation(Vector::new(0.0, -0.1, 0.0)),
        )
        .unwrap();
    let side = 0.25;
    let (body, _) = world.insert(
        RigidBodyBuilder::dynamic()
            .translation(Vector::new(0.0, 0.5 * side, 0.0))
            .can_sleep(false),
        ColliderBuilder::cuboid(0.5 * side, 0.5 * side, 0.5 * side)
            .mass(mass)
            .friction(mu),
    );
    let seconds = |s: f32| (s / dt).round() as usize;
    for _ in 0..seconds(2.0) {
        deformables.step(&mut world);
    }
    let start = world.bodies[body].translation();
    for _ in 0..seconds(10.0) {
        deformables.step(&mut world);
    }
    f64::from((world.bodies[body].translation() - start).length())
}

#[test]
fn an_awake_box_does_not_creep_down_a_deformable_slope() {
    for (mass, mu) in [(1.0, 0.6), (10.0, 0.6), (10.0, 1.0), (50.0, 0.6)] {
        let way = creep(mass, mu, 1.0 / 60.0);
        assert!(
            way < 1e-4,
            "{mass} kg, μ = {mu}: creeps {way:.2e} m in 10 s"
        );
    }
}

/// A block of E Pa that goes along on a table turning at 1.6 rad/s, 1 m from its axis, where μ > 0.261 holds it: how fast it
/// moves on the table, in 3 s after one of settling \[m/s\].
fn on_a_turntable(young: f32, mu: f32) -> f64 {
    let spin = 1.6_f32;
    let mut world = PhysicsWorld::default();
    let (table, _) = world.insert(
        RigidBodyBuilder::kinematic_velocity_based()
            .angvel(Vector::Y * spin)
            .translation(Vector::new(0.0, -0.1, 0.0)),
        ColliderBuilder::cuboid(2.0, 0.1, 2.0).friction(mu),
    );
    let mut set = DeformableWorld::default();
    let material = Material::elastic(young, 1000.0).viscosity(1e-3 * young);
    let block = DeformableBuilder::new(shape::lattice(Vector::new(0.2, 0.1, 0.2), 0.1).unwrap())
        .material(material)
        .friction(mu)
        .translation(Vector::new(1.0, 0.05, 0.0))
        .linvel(Vector::Z * -spin)
        .angvel(Vector::Y * spin);
    let block = set.insert(block).unwrap();
    let place = |world: &PhysicsWorld, set: &DeformableWorld| {
        let turned = world.bodies[table].rotation().inverse();
        turned * set[block].center_of_mass().as_vec3()
    };
    let mut step = |seconds: f32| {
        for _ in 0..(seconds * 60.0) as usize {
            set.step(&mut world);
        }
        place(&world, &set)
    };
    let (start, end) = (step(1.0), step(3.0));
    f64::from((end - start).length()) / 3.0
}

/// Symptom: stiff blocks crept outward by ½hω²r, 0.3 mm/s. Cause: friction gave their nodes the velocity of the table at the
/// start of each substep, a tangent of their circle; only anchors brought them back, and what slides has none.
#[test]
fn a_stiff_block_does_not_creep_on_a_turntable() {
    for young in [1e6, 1e7, 1e8] {
        for mu in [0.27, 0.3, 0.5, 1.0] {
            let speed = on_a_turntable(young, mu);
            assert!(speed < 1e-5, "E = {young:e}, μ = {mu}: {speed:.2e} m/s");
        }
    }
}
