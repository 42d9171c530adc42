//! `rubber_drop`: a block of rubber falls on a corner and a crate, a bar of rubber on its end, and they bounce.
//!
//! Natural rubber by its constants: E = 2 MPa, ν = 0.45, 1,000 kg/m³, a loss factor of some per cent. The block is of linear
//! tets, the bar of quadratic ones; a crate of 5 kg stands in the block's way.

use super::{Cast, Figures, Options, Run, Scene, SceneError};
use crate::body::{Solid, SolidLaw};
use crate::math::{DVec3, Real, Rotation, Vector};
use crate::shape::{TetSplit, tet_box};
use crate::world::{DeformableBuilder, DeformableWorld, Substeps};
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "rubber_drop",
    about: "a block of rubber falls on a corner and a crate, a bar of rubber bounces on its end",
    options: Options {
        dt: 1.0 / 60.0,
        duration: 2.0,
        safety: 0.9,
        cell: 0.05,
    },
    build,
    figures,
};

/// Rubber. The time constant is a loss factor of 0.03 at 50 Hz, where the block rings.
pub const RUBBER: Solid = Solid::new(2.0e6, 0.45, 1000.0)
    .law(SolidLaw::StableNeoHookean)
    .damping(0.0, 1.0e-4);
/// Side of the block \[m\].
pub const SIDE: Real = 0.4;
/// Size of the bar \[m\].
pub const BAR: Vector = Vector::new(0.2, 0.4, 0.2);
/// Height of the lowest points over the ground \[m\].
pub const DROP: Real = 1.0;

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    let (_, ground) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(5.0, 0.5, 5.0).friction(0.6),
    );
    cast.rigid.push(("ground".into(), None, ground));
    let (crate_body, collider) = world.insert(
        RigidBodyBuilder::dynamic().translation(Vector::new(-0.85, 0.15, 0.0)),
        ColliderBuilder::cuboid(0.15, 0.15, 0.15)
            .mass(5.0)
            .friction(0.5),
    );
    cast.rigid
        .push(("crate".into(), Some(crate_body), collider));
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    let cell = options.cell as Real;
    let block = tet_box(Vector::splat(SIDE), cell, TetSplit::Six)?;
    let bar = tet_box(BAR, 2.0 * cell, TetSplit::Six)?;
    let turn = Rotation::from_scaled_axis(Vector::new(0.5, 0.2, 0.45));
    let at = Vector::new(-0.5, DROP + 0.32, 0.0);
    for (name, builder) in [
        (
            "block",
            DeformableBuilder::tets(block, RUBBER)
                .translation(at)
                .rotation(turn),
        ),
        (
            "bar",
            DeformableBuilder::tets(bar.quadratic(), RUBBER).translation(Vector::new(
                0.45,
                DROP + 0.5 * BAR.y,
                0.0,
            )),
        ),
    ] {
        let handle = deformables.insert(builder.friction(0.6).substeps(Substeps::Auto {
            safety: options.safety,
            min_h: 1.0e-7,
        }))?;
        cast.deformables.push((name.into(), handle));
    }
    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = [0.0, 0.24, 0.45, 1.0]
        .into_iter()
        .map(|share: f64| share * options.duration)
        .collect();
    run.recorder.sampling.history = 1.0e-3;
    run.recorder.sampling.energy = 2.0e-3;
    Ok(run)
}

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let mut f = Figures::default();
    let handle = run
        .cast
        .deformable("bar")
        .ok_or(SceneError::Missing("bar"))?;
    let record = run
        .recorder
        .body(handle)
        .ok_or(SceneError::Missing("bar"))?;
    // Its lowest point on the way: down to the ground, and up again.
    let low: Vec<f64> = record.bounds.iter().map(|[lo, _]| lo.y).collect();
    let landed = low.iter().position(|y| *y <= 1.0e-4).unwrap_or(low.len());
    let rebound = low[landed..].iter().copied().fold(0.0, f64::max);
    f.add("rebound_m", "rebound of the bar", rebound, "m");
    let tallest = |[lo, hi]: &[DVec3; 2]| (hi.y - lo.y) / f64::from(BAR.y);
    // While it stands on its end, before it topples.
    let times = &record.center.times;
    let end = times.get(landed).map_or(f64::INFINITY, |t| t + 0.05);
    let standing = times.iter().zip(&record.bounds).filter(|(t, _)| **t < end);
    let flattest = standing.map(|(_, b)| tallest(b)).fold(1.0, f64::min);
    f.add(
        "flattest",
        "the bar's least height over its length",
        flattest,
        "",
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
