//! Slender bodies that are struck and spin: what turns about their axis is a thousandth of what turns the axis.

use crate::support::weightless;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::sheet as sheet_net;

/// A square sheet of 1 m, held all round.
fn sheet(friction: f32) -> DeformableBuilder {
    DeformableBuilder::new(sheet_net(1.0, 1.0, 11, 11, 0.003))
        .material(Material::elastic(5e7, 1000.0).viscosity(500.0))
        .friction(friction)
        .pin(|p| p.x.abs() > 0.499 || p.z.abs() > 0.499)
}

/// A rod along y, of a capsule or a bar whose collider is turned and beside the origin of its body.
fn rod_of(half: f32, radius: f32, square: bool) -> ColliderBuilder {
    if square {
        ColliderBuilder::cuboid(half, radius, 0.8 * radius)
            .rotation(Vector::Z * std::f32::consts::FRAC_PI_2)
            .translation(Vector::new(0.05, 0.02, -0.03))
    } else {
        ColliderBuilder::capsule_y(half, radius)
    }
}

/// The most energy of rod and sheet over that at the start of the rod, which is thrown, tilted, on the sheet.
fn most_energy(
    (half, radius, mass, square): (f32, f32, f32, bool),
    speed: f32,
    tilt: f32,
    friction: f32,
) -> f64 {
    let mut world = weightless(1.0 / 60.0);
    let mut deformables = DeformableWorld::default();
    let sheet = deformables.insert(sheet(friction)).unwrap();
    let rod = RigidBodyBuilder::dynamic()
        .translation(Vector::new(0.03, half * tilt.cos() + 0.05, 0.04))
        .rotation(Vector::new(tilt, 0.0, 0.1))
        .linvel(Vector::new(0.3, -1.0, 0.1) * speed);
    let shape = rod_of(half, radius, square).mass(mass);
    let (rod, _) = world.insert(rod, shape.friction(friction));
    let start = f64::from(world.bodies[rod].kinetic_energy());
    let mut most = 0.0_f64;
    for _ in 0..(90.0 / speed) as usize + 4 {
        deformables.step(&mut world);
        let energies = deformables[sheet].energies();
        let rigid = f64::from(world.bodies[rod].kinetic_energy());
        most = most.max((rigid + energies.kinetic + energies.elastic) / start);
        assert!(most.is_finite(), "{speed} m/s, tilt {tilt}");
    }
    most
}

/// Symptom: 50 to 10¹⁴ times the energy. A step of the shadow about the axis of its spin multiplied the angle that momentum
/// made with the rod's axis by I₁/I₃·(ωh)²/2, and the rest of the torque was given at another orientation.
#[test]
fn a_thin_rod_takes_no_energy_from_a_blow() {
    let rods = [
        (0.12, 0.01, 0.5, false),
        (0.25, 0.01, 0.5, false),
        (0.3, 0.005, 3.0, false),
        (0.3, 0.01, 1.0, true),
    ];
    for rod in rods {
        for speed in [5.0, 20.0, 40.0] {
            for tilt in [0.2, 0.5, 0.9, 1.5] {
                for friction in [0.0, 0.3] {
                    let most = most_energy(rod, speed, tilt, friction);
                    assert!(
                        most < 1.005,
                        "{rod:?} at {speed} m/s, tilt {tilt}, friction {friction}: {most}"
                    );
                }
            }
        }
    }
}
