//! Scenes here and in Rapier's own soft bodies: the same nodes, masses, springs, ground and steps, both in turn in one run.

use super::clock::{Clock, median};
use super::native::{Edges, Native, floor, of_net};
use super::{SceneError, Sizes};
use crate::body::{Material, Net};
use crate::math::Vector;
use crate::shape::{lattice, sheet};
use crate::world::{DeformableBuilder, DeformableHandle, DeformableWorld};
use rapier3d::dynamics::{RigidBodyBuilder, SoftBodyBuilder, SoftBodyMaterial};
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

/// A scene here and there.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PeerRow {
    /// Which scene.
    pub scene: &'static str,
    /// Springs of the body.
    pub springs: usize,
    /// Milliseconds per step of 1/60 s, of crumple and of Rapier's own soft body.
    pub ms_per_frame: [f64; 2],
    /// Largest |length/first length − 1| of any spring after any step, the same way round.
    pub strain: [f64; 2],
    /// Rapier's time over ours, median over pairs \[1\].
    pub ratio: f64,
}

/// A world of one body, ours or Rapier's.
pub trait Scene {
    /// Moves it by 1/60 s.
    fn step(&mut self);
    /// Largest strain of any edge now.
    fn strain(&self) -> f64;
}

struct Ours {
    world: PhysicsWorld,
    deformables: DeformableWorld,
    body: DeformableHandle,
    edges: Edges,
}

impl Ours {
    fn new(world: PhysicsWorld, net: &Net, body: DeformableBuilder) -> Result<Self, SceneError> {
        let mut deformables = DeformableWorld::default();
        Ok(Self {
            world,
            body: deformables.insert(body)?,
            deformables,
            edges: Edges::of(net),
        })
    }
}

impl Scene for Ours {
    fn step(&mut self) {
        self.deformables.step(&mut self.world);
    }

    fn strain(&self) -> f64 {
        let Some(body) = self.deformables.get(self.body) else {
            return f64::NAN;
        };
        let places: Vec<Vector> = body.positions().collect();
        self.edges.strain(|i| places[i as usize])
    }
}

type Build<'a> = &'a dyn Fn() -> Result<Box<dyn Scene>, SceneError>;

/// Milliseconds per frame, of as many runs as it takes to measure them.
fn time(build: Build, frames: usize, least: f64) -> Result<f64, SceneError> {
    let (mut spent, mut runs) = (0.0, 0);
    while runs == 0 || spent < least {
        let mut scene = build()?;
        let clock = Clock::start();
        for _ in 0..frames {
            scene.step();
        }
        spent += clock.spent().as_secs_f64();
        runs += 1;
    }
    Ok(1e3 * spent / (runs * frames) as f64)
}

fn strain(build: Build, frames: usize) -> Result<f64, SceneError> {
    let mut scene = build()?;
    let strains = (0..frames).map(|_| {
        scene.step();
        scene.strain()
    });
    Ok(strains.fold(0.0, f64::max))
}

fn compare(
    name: &'static str,
    springs: usize,
    [ours, native]: [Build; 2],
    sizes: &Sizes,
    frames: usize,
) -> Result<PeerRow, SceneError> {
    let frames = frames.min(sizes.frames);
    let time = |build| time(build, frames, 4.0 * sizes.long);
    let pairs: Result<Vec<[f64; 2]>, SceneError> = (0..sizes.rounds)
        .map(|_| Ok([time(ours)?, time(native)?]))
        .collect();
    let pairs = pairs?;
    Ok(PeerRow {
        scene: name,
        springs,
        ms_per_frame: [0, 1].map(|k| median(pairs.iter().map(|p| p[k]))),
        strain: [strain(ours, frames)?, strain(native, frames)?],
        ratio: median(pairs.iter().map(|[ours, native]| native / ours)),
    })
}

/// A cloth of 2 m and 1 kg, held at two corners, falls for a second. There are no contacts.
///
/// # Errors
/// [`SceneError`] where it can't be built.
pub fn cloth(sizes: &Sizes) -> Result<PeerRow, SceneError> {
    let n = sizes.cloth;
    let net = sheet(2.0, 2.0, n, n, 1e-3)?;
    let ours = || {
        let held = |x: Vector| x.x < -0.999 && x.z.abs() > 0.999;
        let body = DeformableBuilder::new(net.clone())
            .material(Material::elastic(CLOTH_YOUNG, 1.0))
            .total_mass(1.0)
            .pin(held);
        Ok(Box::new(Ours::new(PhysicsWorld::default(), &net, body)?) as Box<dyn Scene>)
    };
    let native = || {
        let cell = 2.0 / (n - 1) as f32;
        let corner = Vector::new(-1.0, 0.0, -1.0);
        let body = SoftBodyBuilder::cloth(corner, Vector::X * cell, Vector::Z * cell, n, n)
            .mass(1.0)
            .no_surface_collider()
            .pinned_particles([0, n as u32 - 1]);
        let native = Native::new(PhysicsWorld::default(), body, Vector::ZERO);
        Ok(Box::new(native) as Box<dyn Scene>)
    };
    compare("cloth", net.springs.len(), [&ours, &native], sizes, 60)
}

/// Young's modulus of the cloth \[Pa\], with which it stretches no more than Rapier's. It is undamped: nothing needs damping to be
/// stable, and after a second its nodes are 2.8 mm off those of a run with ten times the substeps, 4.0 mm with a damping time of
/// 0.1 ms (root mean square).
const CLOTH_YOUNG: f32 = 2.5e4;

/// A solid of 1 m and 100 kg, about to fall 1 m onto a floor.
///
/// # Errors
/// [`SceneError`] where it can't be built.
pub fn falling(net: &Net, young: f32) -> Result<Box<dyn Scene>, SceneError> {
    let damping = 0.02 * (young * BLOCK_MASS).sqrt();
    let body = DeformableBuilder::new(net.clone())
        .material(Material::elastic(young, 1.0).viscosity(damping))
        .total_mass(BLOCK_MASS)
        .translation(ABOVE);
    Ok(Box::new(Ours::new(floor(), net, body)?))
}

/// A solid of 1 m and 100 kg falls 1 m onto a floor.
///
/// # Errors
/// [`SceneError`] where it can't be built.
pub fn block(sizes: &Sizes) -> Result<PeerRow, SceneError> {
    let net = lattice(Vector::ONE, 1.0 / (sizes.block - 1) as f32)?;
    let ours = || falling(&net, BLOCK_YOUNG);
    let native = || {
        let body = of_net(&net, BLOCK_MASS).translated(ABOVE);
        Ok(Box::new(Native::new(floor(), body, Vector::ZERO)) as Box<dyn Scene>)
    };
    compare("block", net.springs.len(), [&ours, &native], sizes, 90)
}

/// Young's modulus of the block \[Pa\]: it deforms no more than Rapier's.
const BLOCK_YOUNG: f32 = 0.08e6;
/// Its mass \[kg\].
pub const BLOCK_MASS: f32 = 100.0;
/// Where its middle is at first \[m\].
pub const ABOVE: Vector = Vector::new(0.0, 1.5, 0.0);

/// A solid of 1 m and 100 kg that yields meets a wall at 15 m/s.
///
/// # Errors
/// [`SceneError`] where it can't be built.
pub fn wall(sizes: &Sizes) -> Result<PeerRow, SceneError> {
    let net = lattice(Vector::ONE, 1.0 / (sizes.wall - 1) as f32)?;
    let speed = Vector::X * 15.0;
    let wall = || {
        let mut world = PhysicsWorld {
            gravity: Vector::ZERO,
            ..PhysicsWorld::default()
        };
        world.insert(
            RigidBodyBuilder::fixed().translation(Vector::X * 1.05),
            ColliderBuilder::cuboid(0.5, 5.0, 5.0),
        );
        world
    };
    let ours = || {
        let yields = WALL_YOUNG * WALL_YIELD;
        let body = DeformableBuilder::new(net.clone())
            .material(Material::elastic(WALL_YOUNG, 1.0).yielding(yields, 0.0))
            .total_mass(WALL_MASS)
            .linvel(speed);
        Ok(Box::new(Ours::new(wall(), &net, body)?) as Box<dyn Scene>)
    };
    let native = || {
        let body = of_net(&net, WALL_MASS).material(SoftBodyMaterial {
            edge_plastic_yield: WALL_YIELD,
            edge_plastic_creep: f32::INFINITY,
            ..SoftBodyMaterial::default()
        });
        Ok(Box::new(Native::new(wall(), body, speed)) as Box<dyn Scene>)
    };
    compare("wall", net.springs.len(), [&ours, &native], sizes, 10)
}

/// Young's modulus \[Pa\] and yield strain of what meets the wall.
const WALL_YOUNG: f32 = 1.0e6;
const WALL_YIELD: f32 = 0.1;
const WALL_MASS: f32 = 100.0;
