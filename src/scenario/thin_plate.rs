//! `thin_plate`: blocks at 50 m/s on a plate 2 mm thick.
//!
//! At the usual step of the world a block moves 0.8 m at a time and in a substep more than the plate is thick, so a
//! contact that looks for overlaps finds none, or pushes out on the far side. One block lands flat, one on an edge.

use super::{Cast, Figures, Options, Run, Scene, SceneError};
use crate::body::Material;
use crate::math::{Real, Rotation, Vector};
use crate::shape::lattice;
use crate::world::{DeformableBuilder, DeformableWorld, Substeps};
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "thin_plate",
    about: "two blocks at 50 m/s onto a fixed plate 2 mm thick, one flat, one on an edge",
    options: Options {
        dt: 1.0 / 60.0,
        duration: 0.05,
        safety: 0.9,
        cell: 0.05,
    },
    build,
    figures,
};

/// Speed of the blocks \[m/s\].
pub const SPEED: f64 = 50.0;
/// Half the thickness of the plate \[m\]; its middle is at y = 0.
pub const HALF_THICKNESS: Real = 0.001;
/// Side of a block \[m\].
pub const SIDE: Real = 0.3;
/// Distance of the blocks from the plate \[m\]: the first step of 1/60 s ends while they are squeezed.
pub const GAP: Real = 0.765;

/// Hard polyurethane, about 95 Shore A: E = 60 MPa, 1100 kg/m³; waves run at 230 m/s in it, so that 50 m/s squeeze it by a
/// fifth. The viscosity is a loss factor of 0.1 at its first mode along the block, 400 Hz.
fn polyurethane() -> Material {
    Material::elastic(60.0e6, 1100.0).viscosity(2.4e3)
}

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    let (_, plate) = world.insert(
        RigidBodyBuilder::fixed(),
        ColliderBuilder::cuboid(1.0, HALF_THICKNESS, 0.6).friction(0.3),
    );
    cast.rigid.push(("plate".into(), None, plate));
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    let edge = Rotation::from_rotation_z(std::f32::consts::FRAC_PI_4);
    for (name, x, turn, low) in [
        ("flat", -0.4, Rotation::IDENTITY, 0.5),
        ("edge", 0.4, edge, std::f32::consts::FRAC_1_SQRT_2),
    ] {
        let at = Vector::new(x, HALF_THICKNESS + GAP + low * SIDE, 0.0);
        let handle = deformables.insert(
            DeformableBuilder::new(lattice(Vector::splat(SIDE), options.cell as Real)?)
                .material(polyurethane())
                .rotation(turn)
                .translation(at)
                .linvel(Vector::new(0.0, -SPEED as Real, 0.0))
                .friction(0.3)
                .substeps(Substeps::Auto {
                    safety: options.safety,
                    min_h: 1.0e-7,
                }),
        )?;
        cast.deformables.push((name.into(), handle));
    }
    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = [0.0, 1.0, 2.0, 3.0]
        .into_iter()
        .map(|i: f64| i / 3.0 * options.duration)
        .collect();
    run.recorder.sampling.energy = 1.0e-4;
    Ok(run)
}

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let mut f = Figures::default();
    let (mut through, mut lowest) = (0, f64::INFINITY);
    for (name, key, label) in [
        ("flat", "rebound_flat_mps", "rebound of the flat block"),
        (
            "edge",
            "rebound_edge_mps",
            "rebound of the block on its edge",
        ),
    ] {
        let handle = run.cast.deformable(name);
        let body = handle.and_then(|h| Some((run.deformables.get(h)?, run.recorder.body(h)?)));
        let (body, record) = body.ok_or(SceneError::Missing("block"))?;
        f.add(key, label, body.linvel().y, "m/s");
        through += body.positions().filter(|p| p.y < 0.0).count();
        let low = record.bounds.iter().map(|[lo, _]| lo.y);
        lowest = low.fold(lowest, f64::min);
    }
    f.add("nodes_through", "nodes under the plate", through as f64, "");
    f.add(
        "lowest_node_m",
        "lowest node ever, over the plate",
        lowest - f64::from(HALF_THICKNESS),
        "m",
    );
    f.add(
        "max_penetration_m",
        "deepest node",
        run.recorder.max_depth(),
        "m",
    );
    let closure = run.recorder.momentum_closure();
    f.add("momentum_closure", "momentum closure", closure, "");
    run.common_figures(&mut f);
    Ok(f)
}
