//! Small scenes for tests of daily use and of bad input.

use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// A body of one node at the origin: the smallest thing that falls, lands and is pushed.
pub fn bead(mass: f32) -> DeformableBuilder {
    DeformableBuilder::new(Net::new(vec![Node::new(Vector::ZERO, mass)], vec![]))
}

/// Two nodes of 1 kg, 1 m apart along x, and a damped spring.
pub fn pair() -> Net {
    Net::new(
        vec![Node::new(Vector::ZERO, 1.0), Node::new(Vector::X, 1.0)],
        vec![Spring::new(0, 1, 1000.0).damping(2.0)],
    )
}

/// A soft, damped cube of `side` m about the origin with 4 nodes along each edge.
pub fn cube(side: f32) -> DeformableBuilder {
    DeformableBuilder::new(lattice(Vector::splat(side), side / 3.0))
        .material(Material::elastic(2.0e5, 200.0).viscosity(2.0e3))
}

/// A Rapier world with a fixed floor whose top is y = 0, and the floor's collider.
pub fn floored(dt: f32) -> (PhysicsWorld, ColliderHandle) {
    let mut world = PhysicsWorld::default();
    world.integration_parameters.dt = dt;
    let (_, collider) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(5.0, 0.5, 5.0),
    );
    (world, collider)
}

/// Poses and velocities of all rigid bodies, bit for bit.
pub fn bits(world: &PhysicsWorld) -> Vec<[u32; 13]> {
    let of = |b: &RigidBody| {
        let (p, v) = (b.position(), (b.linvel(), b.angvel()));
        [
            p.translation.x,
            p.translation.y,
            p.translation.z,
            p.rotation.x,
            p.rotation.y,
            p.rotation.z,
            p.rotation.w,
            v.0.x,
            v.0.y,
            v.0.z,
            v.1.x,
            v.1.y,
            v.1.z,
        ]
        .map(f32::to_bits)
    };
    world.bodies.iter().map(|(_, b)| of(b)).collect()
}

/// Whether every rigid body's pose and velocity are finite.
pub fn all_finite(world: &PhysicsWorld) -> bool {
    bits(world)
        .iter()
        .flatten()
        .all(|&b| f32::from_bits(b).is_finite())
}

/// Height and vertical velocity of node 0.
pub fn height(body: &Deformable) -> (f64, f64) {
    (
        body.position(NodeId(0)).unwrap().y,
        body.linvel_of(NodeId(0)).unwrap().y,
    )
}
