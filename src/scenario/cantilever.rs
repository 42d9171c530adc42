//! `cantilever`: one beam, clamped at one end and bent by its own weight, four ways over the same 189 nodes.
//!
//! 2 × 0.2 × 0.2 m, E = 12 MPa, 8 kg: a lattice of springs, linear tets, quadratic tets, and Rapier's own soft body. The answer
//! is a textbook's, so the distance from it is the error, and the time a frame takes is what it costs.

use super::{Cast, Figures, Options, Run, Scene, SceneError};
use crate::body::{Material, NodeId, Solid};
use crate::math::{Real, Vector};
use crate::shape::{TetSplit, lattice, tet_box};
use crate::world::{DeformableBuilder, DeformableWorld, Substeps};
use rapier3d::dynamics::{SoftBodyBuilder, SoftBodyCellModel, SoftBodyHandle, SoftBodyMaterial};
use rapier3d::pipeline::PhysicsWorld;
use std::time::Instant;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "cantilever",
    about: "one beam under its own weight: spring lattice, linear tets, quadratic tets, Rapier's soft body",
    options: Options {
        dt: 1.0 / 60.0,
        duration: 2.0,
        safety: 0.9,
        cell: 0.1,
    },
    build,
    figures,
};

/// Size of the beam \[m\].
pub const SIZE: Vector = Vector::new(2.0, 0.2, 0.2);
/// Young's modulus \[Pa\].
pub const YOUNG: f64 = 1.2e7;
/// Mass \[kg\].
pub const MASS: Real = 8.0;
/// Rayleigh's α \[1/s\]: twice the first angular frequency, so that the beam comes to rest without swinging.
pub const ALPHA: f64 = 35.0;

/// One way to model the beam.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Its name.
    pub name: &'static str,
    /// Deflection of the tip of a beam of this material by Timoshenko's theory \[m\]: a lattice has ν = ¼, the others 0.
    pub reference: f64,
    keys: [&'static str; 3],
    labels: [&'static str; 3],
}

/// All of them, from back to front.
pub const PATHS: [Path; 4] = [
    Path {
        name: "native",
        reference: -0.049442,
        keys: ["tip_native_m", "reference_native_m", "ms_per_frame_native"],
        labels: ["Rapier: tip", "Rapier: beam theory", "Rapier: per frame"],
    },
    Path {
        name: "lattice",
        reference: -0.04953,
        keys: [
            "tip_lattice_m",
            "reference_lattice_m",
            "ms_per_frame_lattice",
        ],
        labels: ["lattice: tip", "lattice: beam theory", "lattice: per frame"],
    },
    Path {
        name: "linear",
        reference: -0.049442,
        keys: ["tip_linear_m", "reference_linear_m", "ms_per_frame_linear"],
        labels: [
            "linear tets: tip",
            "linear tets: beam theory",
            "linear tets: per frame",
        ],
    },
    Path {
        name: "quadratic",
        reference: -0.049442,
        keys: [
            "tip_quadratic_m",
            "reference_quadratic_m",
            "ms_per_frame_quadratic",
        ],
        labels: [
            "quadratic tets: tip",
            "quadratic tets: beam theory",
            "quadratic tets: per frame",
        ],
    },
];

/// The beam as a deformable, its clamped end at x = −1.
fn deformable(path: &str, options: &Options) -> Result<DeformableBuilder, SceneError> {
    let cell = options.cell as Real;
    let clamped = -0.5 * SIZE.x + 1e-4;
    let density = f64::from(MASS) / f64::from(SIZE.x * SIZE.y * SIZE.z);
    let solid = Solid::new(YOUNG, 0.0, density).damping(ALPHA, 0.0);
    let builder = match path {
        "lattice" => {
            let net = lattice(SIZE, cell)?;
            let mean = MASS / net.nodes.len() as Real;
            DeformableBuilder::new(net)
                .material(Material::elastic(YOUNG as Real, density as Real))
                .drag(ALPHA as Real * mean)
        }
        "linear" => DeformableBuilder::tets(tet_box(SIZE, cell, TetSplit::Five), solid),
        _ => {
            let mesh = tet_box(SIZE, 2.0 * cell, TetSplit::Six)?;
            DeformableBuilder::tets(mesh.quadratic(), solid)
        }
    };
    Ok(builder
        .pin(move |x| x.x < clamped)
        .substeps(Substeps::Auto {
            safety: options.safety,
            min_h: 1.0e-7,
        }))
}

/// The beam as a soft body of Rapier's, of corotational cells.
fn native(z: Real, options: &Options) -> SoftBodyBuilder {
    let counts = (SIZE / options.cell as Real).round() + Vector::ONE;
    let [nx, ny, nz] = counts.to_array().map(|n| n as usize);
    let builder = SoftBodyBuilder::cuboid(Vector::new(0.0, 0.0, z), 0.5 * SIZE, nx, ny, nz)
        .cell_model(SoftBodyCellModel::Corotational)
        .material(SoftBodyMaterial {
            young_modulus: YOUNG as Real,
            poisson_ratio: 0.0,
            elastic_damping_ratio: 1.0,
            ..SoftBodyMaterial::default()
        })
        .mass(MASS)
        .can_sleep(false);
    let places = builder.particle_positions().to_vec();
    let clamped = (0..)
        .zip(&places)
        .filter(|(_, p)| p.x < -0.5 * SIZE.x + 1e-4);
    builder.pinned_particles(clamped.map(|(i, _)| i).collect::<Vec<u32>>())
}

/// Where a path's beam lies across \[m\].
fn across(path: usize) -> Real {
    0.5 * (path as Real - 1.5)
}

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    for (i, path) in PATHS.iter().enumerate() {
        if path.name == "native" {
            world.insert_soft_body(native(across(i), options));
            continue;
        }
        let beam = deformable(path.name, options)?;
        let beam = beam.translation(Vector::new(0.0, 0.0, across(i)));
        cast.deformables
            .push((path.name.into(), deformables.insert(beam)?));
    }
    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = vec![0.0, options.duration];
    run.view = Vector::new(0.5, 0.35, 1.0);
    run.recorder.sampling.history = 1.0e-3;
    run.recorder.sampling.energy = 5.0e-3;
    Ok(run)
}

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let mut f = Figures::default();
    for path in &PATHS {
        let (tip, ms) = alone(path.name, &run.options)?;
        let values = [tip, path.reference, ms];
        for (((key, label), value), unit) in path
            .keys
            .into_iter()
            .zip(path.labels)
            .zip(values)
            .zip(["m", "m", "ms"])
        {
            f.add(key, label, value, unit);
        }
    }
    run.common_figures(&mut f);
    Ok(f)
}

/// A beam in a world of its own: deflection of its tip at the end \[m\], and milliseconds per frame.
///
/// # Errors
/// Those of building it.
pub fn alone(path: &str, options: &Options) -> Result<(f64, f64), SceneError> {
    let mut world = PhysicsWorld::default();
    world.integration_parameters.dt = options.dt as Real;
    let steps = (options.duration / options.dt).round().max(1.0);
    if path == "native" {
        let builder = native(0.0, options);
        let places = builder.particle_positions();
        let far = (0..places.len()).filter(|&i| places[i].x > 0.5 * SIZE.x - 1e-4);
        let tip: Vec<usize> = far.collect();
        let soft = world.insert_soft_body(builder);
        let start = Instant::now();
        for _ in 0..steps as usize {
            world.step();
        }
        let ms = 1e3 * start.elapsed().as_secs_f64() / steps;
        return Ok((native_tip(&world, soft, &tip), ms));
    }
    let mut deformables = DeformableWorld::default();
    let beam = deformables.insert(deformable(path, options)?)?;
    let end = |x: Vector| x.x > 0.5 * SIZE.x - 1e-4;
    let at_rest: Vec<Vector> = deformables[beam].positions().collect();
    let start = Instant::now();
    for _ in 0..steps as usize {
        deformables.step(&mut world);
    }
    let ms = 1e3 * start.elapsed().as_secs_f64() / steps;
    let body = &deformables[beam];
    let nodes = (0..).zip(&at_rest).filter(|(_, x)| end(**x));
    let moved: Vec<f64> = nodes
        .filter_map(|(n, x)| Some(body.position(NodeId(n))?.y - f64::from(x.y)))
        .collect();
    Ok((moved.iter().sum::<f64>() / moved.len().max(1) as f64, ms))
}

/// Mean height of the nodes `tip`, which began at 0.
fn native_tip(world: &PhysicsWorld, handle: SoftBodyHandle, tip: &[usize]) -> f64 {
    let body = world.soft_bodies.get(handle);
    let height = |i: &usize| body.map_or(f64::NAN, |b| b.particle_position(*i).y.into());
    tip.iter().map(height).sum::<f64>() / tip.len().max(1) as f64
}
