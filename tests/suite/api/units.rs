//! A world in centimetres behaves as one in metres.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// A soft cube falls on a floor beside a wall, and a box falls on it, in units of 1/`unit` m.
fn run(unit: f32) -> Vec<(Vector, Vector)> {
    let mut world = PhysicsWorld {
        gravity: Vector::Y * -9.81 * unit,
        ..PhysicsWorld::default()
    };
    world.integration_parameters.length_unit = unit;
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::Y * -0.5 * unit),
        ColliderBuilder::cuboid(5.0 * unit, 0.5 * unit, 5.0 * unit),
    );
    let (rigid, _) = world.insert(
        RigidBodyBuilder::dynamic().translation(Vector::new(0.02, 0.6, 0.0) * unit),
        ColliderBuilder::cuboid(0.1 * unit, 0.05 * unit, 0.1 * unit).mass(2.0),
    );
    // k = E·A/L grows with the unit, and so must c; masses are the same.
    let material = Material::elastic(2.0e5 / unit, 200.0 / unit.powi(3)).viscosity(2.0e3 / unit);
    let mut set = DeformableWorld::new();
    let soft = set
        .insert(
            DeformableBuilder::new(lattice(Vector::splat(0.3 * unit), 0.1 * unit))
                .material(material)
                .translation(Vector::Y * 0.3 * unit)
                .angvel(Vector::new(0.0, 1.0, 0.5)),
        )
        .unwrap();
    (0..90)
        .map(|_| {
            set.step(&mut world);
            let com = set[soft].center_of_mass().as_vec3();
            (com / unit, world.bodies[rigid].translation() / unit)
        })
        .collect()
}

#[test]
fn a_length_unit_of_100_is_the_scaled_twin() {
    for (step, (metres, centimetres)) in run(1.0).iter().zip(run(100.0)).enumerate() {
        for (a, b) in [(metres.0, centimetres.0), (metres.1, centimetres.1)] {
            // One per cent of the cube's side.
            assert!((a - b).length() < 0.003, "step {step}: {a} against {b}");
        }
    }
}
