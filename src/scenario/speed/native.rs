//! The same scenes in Rapier's own soft bodies.

use super::peers::Scene;
use crate::body::Net;
use crate::math::Vector;
use rapier3d::dynamics::{RigidBodyBuilder, SoftBodyBuilder, SoftBodyHandle};
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

/// Edges and their lengths at first.
#[derive(Clone, Debug)]
pub struct Edges {
    ends: Vec<[u32; 2]>,
    lengths: Vec<f32>,
}

impl Edges {
    /// Edges between nodes of such places.
    pub fn new(ends: Vec<[u32; 2]>, places: &[Vector]) -> Self {
        let length = |[a, b]: &[u32; 2]| places[*a as usize].distance(places[*b as usize]);
        Self {
            lengths: ends.iter().map(length).collect(),
            ends,
        }
    }

    /// The springs of a net.
    pub fn of(net: &Net) -> Self {
        let places: Vec<Vector> = net.nodes.iter().map(|n| n.position).collect();
        Self::new(net.springs.iter().map(|s| s.nodes).collect(), &places)
    }

    /// Those of a soft body that is yet to be put into a world: of its cells where it has no edges.
    pub fn of_native(body: &SoftBodyBuilder) -> Self {
        let ends = if body.edges.is_empty() {
            body.cell_edges()
        } else {
            body.edges.clone()
        };
        Self::new(ends, body.particle_positions())
    }

    /// The strain of each, given where nodes are.
    fn strains(&self, place: impl Fn(u32) -> Vector) -> impl Iterator<Item = f64> {
        let each = self.ends.iter().zip(&self.lengths);
        each.map(move |([a, b], l)| f64::from(place(*a).distance(place(*b)) / l - 1.0))
    }

    /// Largest strain, given where nodes are.
    pub fn strain(&self, place: impl Fn(u32) -> Vector) -> f64 {
        self.strains(place).fold(0.0, |most, e| e.abs().max(most))
    }

    /// Mean square of the strains, given where nodes are.
    pub fn mean_square(&self, place: impl Fn(u32) -> Vector) -> f64 {
        let sum: f64 = self.strains(place).map(|e| e * e).sum();
        sum / self.ends.len().max(1) as f64
    }
}

/// A world with a floor whose top is y = 0.
pub fn floor() -> PhysicsWorld {
    let mut world = PhysicsWorld::default();
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(10.0, 0.5, 10.0),
    );
    world
}

/// A world with one soft body of Rapier's.
pub struct Native {
    world: PhysicsWorld,
    body: SoftBodyHandle,
    edges: Edges,
}

impl Native {
    /// Puts a body that moves at a speed \[m/s\] into a world.
    pub fn new(mut world: PhysicsWorld, body: SoftBodyBuilder, speed: Vector) -> Self {
        let edges = Edges::of_native(&body);
        let body = world.insert_soft_body(body.can_sleep(false));
        let soft = &mut world.soft_bodies[body];
        for i in 0..soft.num_particles() {
            soft.set_particle_velocity(i, speed);
        }
        Self { world, body, edges }
    }
}

impl Scene for Native {
    fn step(&mut self) {
        self.world.step();
    }

    fn strain(&self) -> f64 {
        let body = &self.world.soft_bodies[self.body];
        self.edges.strain(|i| body.particle_position(i as usize))
    }
}

/// A body whose distance constraints are the springs of a net.
pub fn of_net(net: &Net, mass: f32) -> SoftBodyBuilder {
    let places = net.nodes.iter().map(|n| n.position).collect();
    SoftBodyBuilder::new(places)
        .edges(net.springs.iter().map(|s| s.nodes).collect())
        .surface(net.faces.clone())
        .mass(mass)
}
