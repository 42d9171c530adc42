//! `cantilever`: one beam, clamped at one end and bent by its own weight, four ways over the same 189 nodes.
//!
//! 2 × 0.2 × 0.2 m, E = 12 MPa, 8 kg: a lattice of springs, linear tets, quadratic tets, and Rapier's own soft body. The answer
//! is a textbook's, so the distance from it is the error, and the time a frame takes is what it costs.

use super::{Figures, Options, Run, Scene, SceneError};
use crate::body::NodeId;
use crate::math::{Real, Vector};
use rapier3d::dynamics::SoftBodyHandle;
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

/// Half the length of the beam \[m\].
const HALF: Real = 1.0;

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

fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("cantilever", options)
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
/// Those of building it, and [`SceneError::Missing`] for a path that is none.
pub fn alone(path: &str, options: &Options) -> Result<(f64, f64), SceneError> {
    let mut scene = super::file("cantilever", options)?;
    scene.deformables.retain(|d| d.name == path);
    scene.soft_bodies.retain(|s| s.name == path);
    let middles = scene.deformables.iter_mut().map(|d| &mut d.translation);
    let native = scene.soft_bodies.iter_mut().map(|s| &mut s.translation);
    middles.chain(native).for_each(|at| *at = [0.0; 3]);
    let run = scene.build()?;
    let (mut world, mut deformables) = (run.world, run.deformables);
    let steps = (options.duration / options.dt).round().max(1.0);
    let native = world.soft_bodies.iter().next().map(|(soft, body)| {
        let far = |i: &usize| body.particle_position(*i).x > HALF - 1e-4;
        (soft, (0..body.num_particles()).filter(far).collect())
    });
    if let Some((soft, tip)) = native {
        let tip: Vec<usize> = tip;
        let start = Instant::now();
        for _ in 0..steps as usize {
            world.step();
        }
        let ms = 1e3 * start.elapsed().as_secs_f64() / steps;
        return Ok((native_tip(&world, soft, &tip), ms));
    }
    let beam = run.cast.deformable(path);
    let beam = beam.ok_or(SceneError::Missing("beam of this name"))?;
    let at_rest: Vec<Vector> = deformables[beam].positions().collect();
    let start = Instant::now();
    for _ in 0..steps as usize {
        deformables.step(&mut world);
    }
    let ms = 1e3 * start.elapsed().as_secs_f64() / steps;
    let body = &deformables[beam];
    let nodes = (0..).zip(&at_rest).filter(|(_, x)| x.x > HALF - 1e-4);
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
