//! Two-way coupling with Rapier's rigid bodies: each scene runs as shipped (Rapier stepped at 1/240 s while a deformable
//! can touch an awake body) and with Rapier stepped at every substep, which is the reference.

mod attached;
mod carried;
mod cars;
mod damping;
mod heap;
mod impact;
mod joints;
mod laden;
mod landings;
mod layers;
mod light;
mod links;
mod multibody;
mod platform;
mod rest;
mod round;
mod slender;
mod soft;
mod stick;
mod supports;

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// How Rapier is stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    Shipped,
    Reference,
}

impl Mode {
    pub const BOTH: [Self; 2] = [Self::Shipped, Self::Reference];

    /// An empty world of deformables in this mode.
    pub fn deformables(self) -> DeformableWorld {
        let mut world = DeformableWorld::default();
        if self == Self::Reference {
            world.params.max_rigid_dt = 0.0;
        }
        world
    }
}

/// A cube of 125 nodes, edge .4 m, E Pa, damped with a loss factor of about .1 at its first mode, of `mass` kg.
pub fn block(mass: f32, young: f32) -> DeformableBuilder {
    let first_mode = (young * 0.4 / mass).sqrt();
    let material = Material::elastic(young, 1.0).viscosity(0.1 * young / first_mode);
    DeformableBuilder::new(lattice(Vector::splat(0.4), 0.1))
        .material(material)
        .total_mass(mass)
        .friction(0.5)
}

/// Rapier's world with gravity and a floor whose top is at y = 0.
pub fn floor() -> PhysicsWorld {
    let mut world = PhysicsWorld::default();
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(10.0, 0.5, 10.0).friction(0.5),
    );
    world
}

/// A box of half extents `half` and `mass` kg.
pub fn cuboid(half: [f32; 3], mass: f32) -> ColliderBuilder {
    ColliderBuilder::cuboid(half[0], half[1], half[2])
        .density(0.0)
        .mass(mass)
        .friction(0.5)
}
