//! Free motion of tets: turning without stress, momentum, energy, and the same answer from every copy.

use crate::support::{close, weightless};
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box};

fn block(quadratic: bool) -> TetMesh {
    let mesh = tet_box(Vector::new(0.6, 0.4, 0.4), 0.2, TetSplit::Five).unwrap();
    if quadratic { mesh.quadratic() } else { mesh }
}

/// However a body is turned and moved, it has no stress beyond the rounding of `f32` strains.
#[test]
fn a_turned_body_has_no_stress() {
    for law in SolidLaw::ALL {
        for quadratic in [false, true] {
            let solid = Solid::new(1.0e6, 0.3, 1000.0).law(law);
            let mut body = DeformableBuilder::tets(block(quadratic), solid)
                .translation(Vector::new(3.0, -2.0, 5.0))
                .rotation(Rotation::from_scaled_axis(Vector::new(0.3, -1.1, 2.0)))
                .build()
                .unwrap();
            let worst = |body: &Deformable| {
                let each = body.stresses().into_iter().map(|s| s.von_mises);
                each.fold(0.0, f64::max) / 1.0e6
            };
            assert!(worst(&body) < 1e-9, "{law:?}: {:e} of E", worst(&body));
            let turn = Rotation::from_scaled_axis(Vector::new(-2.0, 0.4, 0.1));
            assert!(body.transform(Pose::from_parts(Vector::new(1.0, 2.0, 3.0), turn)));
            assert!(worst(&body) < 1e-9, "{law:?}: {:e} of E", worst(&body));
            assert!(body.energies().elastic < 1e-9, "{:?}", body.energies());
        }
    }
}

/// A block that swings, flies and spins keeps momentum and angular momentum; schemes without drift keep the energy.
#[test]
fn free_flight_conserves_momentum_and_energy() {
    for integrator in [
        Integrator::SymplecticEuler,
        Integrator::VelocityVerlet,
        Integrator::Rk4,
    ] {
        for law in SolidLaw::ALL {
            for quadratic in [false, true] {
                let solid = Solid::new(2.0e5, 0.3, 1000.0).law(law);
                let mut deformables = DeformableWorld::default();
                let body = DeformableBuilder::tets(block(quadratic), solid)
                    .linvel(Vector::new(1.0, 0.5, 0.0))
                    .angvel(Vector::new(1.0, 2.0, 3.0))
                    .integrator(integrator);
                let body = deformables.insert(body).unwrap();
                for node in (0..deformables[body].node_count() as u32).map(NodeId) {
                    let x = deformables[body].position(node).unwrap();
                    let v = deformables[body].linvel_of(node).unwrap();
                    let swing = DVec3::new(x.y * x.z, x.x, 0.0);
                    deformables[body].set_linvel_of(node, (v + swing).as_vec3());
                }
                let mut world = weightless(1.0 / 60.0);
                deformables.step(&mut world);
                let momentum = |d: &DeformableWorld| {
                    let com = d[body].center_of_mass();
                    (d[body].momentum(), d[body].angular_momentum(com))
                };
                let (p0, l0) = momentum(&deformables);
                let e0 = deformables[body].energies().balance();
                for _ in 0..120 {
                    deformables.step(&mut world);
                }
                let (p, l) = momentum(&deformables);
                let what = format!("{}, {law:?}, quadratic: {quadratic}", integrator.name());
                let (dp, dl) = (
                    (p - p0).length() / p0.length(),
                    (l - l0).length() / l0.length(),
                );
                assert!(dp < 2e-5, "{what}: momentum off by {dp:e}");
                assert!(dl < 1e-5, "{what}: angular momentum off by {dl:e}");
                close(&what, deformables[body].energies().balance(), e0, 5e-3);
            }
        }
    }
}

/// A copy of a world, made at any time, goes on as the world does, bit for bit.
#[test]
fn copies_go_on_alike() {
    let mut world = PhysicsWorld::default();
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.8, 0.0)),
        ColliderBuilder::cuboid(5.0, 0.5, 5.0),
    );
    let mut deformables = DeformableWorld::default();
    let solid = Solid::new(2.0e5, 0.4, 1000.0).law(SolidLaw::NeoHookean);
    let mesh = block(true);
    deformables
        .insert(DeformableBuilder::tets(mesh, solid))
        .unwrap();
    for _ in 0..10 {
        deformables.step(&mut world);
    }
    let mut copy = deformables.clone();
    for deformables in [&mut deformables, &mut copy] {
        for _ in 0..20 {
            deformables.step(&mut world);
        }
    }
    assert_eq!(deformables.state_hash(), copy.state_hash());
}
