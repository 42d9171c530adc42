//! Against Rapier itself.

use super::*;
use crate::math::Vector;
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::{ColliderBuilder, SharedShape};
use rapier3d::pipeline::PhysicsWorld;

/// A crate on a crate of its size, their corners over each other, and one on a plate of many triangles: four points each, none
/// of them twice, which bear all of Rapier's impulse.
#[test]
fn no_point_of_a_pair_is_listed_twice() {
    let ground = SharedShape::cuboid(1.0, 0.1, 1.0);
    let plate = {
        let mut at = Vec::new();
        let mut triangles = Vec::new();
        for i in 0..5_u32 {
            for k in 0..5_u32 {
                at.push(
                    Vector::new(i as f32 - 2.0, 0.1, k as f32 - 2.0) * Vector::new(0.2, 1.0, 0.2),
                );
                if i < 4 && k < 4 {
                    let a = 5 * i + k;
                    triangles.extend([[a, a + 1, a + 6], [a, a + 6, a + 5]]);
                }
            }
        }
        SharedShape::trimesh(at, triangles).expect("a mesh")
    };
    for below in [ground, plate] {
        let mut world = PhysicsWorld::default();
        world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::new(below));
        let crates = [0.2, 0.4].map(|y| {
            let body = RigidBodyBuilder::dynamic().translation(Vector::Y * y);
            world.insert(body, ColliderBuilder::cuboid(0.1, 0.1, 0.1)).0
        });
        for _ in 0..20 {
            world.step();
        }
        let around = Surroundings::from(&world);
        let dt = f64::from(world.integration_parameters.dt);
        let found = RigidConstraints::gather(crates, &around, dt);
        let apart = f64::from(0.25 * world.integration_parameters.prediction_distance());
        for (i, a) in found.contacts.iter().enumerate() {
            for b in &found.contacts[..i] {
                let far = a.points[0].distance(b.points[0]);
                let alike = a.bodies == b.bodies && a.normal.dot(b.normal) > 0.99;
                assert!(!alike || far > apart, "{a:?} and {b:?}");
            }
        }
        let upper = |c: &&RigidContact| c.bodies == crates.map(Some);
        let upper: Vec<_> = found.contacts.iter().filter(upper).collect();
        assert_eq!(upper.len(), 4, "{upper:?}");
        let weight = f64::from(world.bodies[crates[1]].mass() * 9.81) * dt;
        let given: f64 = upper.iter().map(|c| c.impulse).sum();
        assert!(
            (given / weight - 1.0).abs() < 0.1,
            "{given} of {weight} N·s"
        );
    }
}

/// A ball that is pressed on the ground by what its contact bears in a step goes as deep as it may, or a little less: Rapier has it gain
/// speed first.
#[test]
fn a_contact_gives_way_to_what_it_bears_by_what_it_may() {
    for (mass, iterations) in [(0.2_f32, 4), (3.0, 16)] {
        let mut world = PhysicsWorld {
            gravity: Vector::ZERO,
            ..PhysicsWorld::default()
        };
        world.integration_parameters.dt = 1.0 / 240.0;
        world.integration_parameters.num_solver_iterations = iterations;
        let ground = ColliderBuilder::cuboid(1.0, 0.1, 1.0).translation(Vector::Y * -0.1);
        world.insert(RigidBodyBuilder::fixed(), ground);
        let ball = ColliderBuilder::ball(0.1).density(0.0).mass(mass);
        let at_rest = RigidBodyBuilder::dynamic().translation(Vector::Y * 0.1);
        let (ball, _) = world.insert(at_rest, ball);
        world.step();
        let dt = f64::from(world.integration_parameters.dt);
        let around = Surroundings::from(&world);
        let found = RigidConstraints::gather([ball], &around, dt);
        let bears = found.contacts[0].spring.bears(0.0, dt) * f64::from(mass);
        world.bodies[ball].add_force(Vector::Y * -bears as f32, true);
        world.step();
        let depth = 0.1 - world.bodies[ball].translation().y;
        assert!((4e-4..1e-3).contains(&depth), "{depth} m for {mass} kg");
    }
}

/// No force pulls on contacts, whatever they are told to be.
#[test]
fn contacts_of_any_softness_bear_no_less_than_nothing() {
    for (omega, ratio) in [(30.0, -5.0), (0.0, 0.0), (f32::INFINITY, 1.0)] {
        let spring = SpringCoefficients::new(omega, ratio);
        for sag in [-1.0, 0.0, 1e-3] {
            let spring = ContactSpring::of(&spring, sag);
            assert!(spring.bears(0.1, 0.01) >= 0.0 && spring.bears(-0.1, 0.01) >= 0.0);
        }
    }
}
