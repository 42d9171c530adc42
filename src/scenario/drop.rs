//! `drop`: boxes onto a soft block, and a soft block onto boxes, until all is at rest.
//!
//! The plainest scene there is, and the one most couplings fail: bodies must come to rest, stay at rest, and not sink in.

use super::{Cast, Figures, Options, Run, Scene, SceneError};
use crate::body::Material;
use crate::math::{Real, Vector};
use crate::shape::lattice;
use crate::world::{DeformableBuilder, DeformableWorld, Substeps};
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "drop",
    about: "rigid boxes fall onto a soft block, and a soft block onto rigid boxes",
    options: Options {
        dt: 1.0 / 60.0,
        duration: 4.0,
        safety: 0.9,
        cell: 0.1,
    },
    build,
    figures,
};

/// A rubber foam: soft enough to be seen to give, damped enough to come to rest.
fn foam() -> Material {
    Material::elastic(0.1e6, 100.0).viscosity(1.2e3)
}

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    let (_, ground) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(6.0, 0.5, 6.0).friction(0.7),
    );
    cast.rigid.push(("ground".into(), None, ground));
    let mut boxes = |name: &str, at: Vector, half: Real, mass: Real| {
        let (body, collider) = world.insert(
            RigidBodyBuilder::dynamic().translation(at),
            ColliderBuilder::cuboid(half, half, half)
                .mass(mass)
                .friction(0.6),
        );
        cast.rigid.push((name.into(), Some(body), collider));
    };
    boxes("above_1", Vector::new(-1.55, 0.70, -0.20), 0.17, 20.0);
    boxes("above_2", Vector::new(-0.95, 0.90, -0.20), 0.17, 40.0);
    boxes("above_3", Vector::new(-1.25, 0.75, 0.30), 0.12, 5.0);
    boxes("below_1", Vector::new(0.95, 0.20, -0.25), 0.20, 30.0);
    boxes("below_2", Vector::new(1.55, 0.20, -0.25), 0.20, 30.0);
    boxes("below_3", Vector::new(1.25, 0.20, 0.28), 0.20, 30.0);
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    for (name, at) in [
        ("block_below", Vector::new(-1.25, 0.25, 0.0)),
        ("block_above", Vector::new(1.25, 0.95, 0.0)),
    ] {
        let net = lattice(Vector::new(1.2, 0.4, 1.0), options.cell as Real)?;
        let handle = deformables.insert(
            DeformableBuilder::new(net)
                .material(foam())
                .translation(at)
                .friction(0.6)
                .substeps(Substeps::Auto {
                    safety: options.safety,
                    min_h: 1.0e-7,
                }),
        )?;
        cast.deformables.push((name.into(), handle));
    }
    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = [0.0, 0.05, 0.075, 0.1, 0.25, 1.0]
        .into_iter()
        .map(|share: f64| share * options.duration)
        .collect();
    // Long and calm: what matters changes slowly.
    run.recorder.sampling.history = 2.0e-3;
    run.recorder.sampling.energy = 1.0e-2;
    Ok(run)
}

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let mut f = Figures::default();
    for (name, key, label) in [
        (
            "block_below",
            "block_below_height_m",
            "block below boxes, rest height",
        ),
        (
            "block_above",
            "block_above_height_m",
            "block above boxes, rest height",
        ),
    ] {
        let handle = run
            .cast
            .deformable(name)
            .ok_or(SceneError::Missing("block"))?;
        let y = run
            .deformables
            .get(handle)
            .map_or(0.0, |b| b.center_of_mass().y);
        f.add(key, label, y, "m");
    }
    for (name, key, label) in [
        ("above_1", "box_20kg_height_m", "box of 20 kg, rest height"),
        ("above_2", "box_40kg_height_m", "box of 40 kg, rest height"),
        ("above_3", "box_5kg_height_m", "box of 5 kg, rest height"),
    ] {
        let body = run.cast.rigid(name).and_then(|h| run.world.bodies.get(h));
        let y = body.map_or(0.0, |b| f64::from(b.translation().y));
        f.add(key, label, y, "m");
    }
    f.add("soft_jitter_mps", "fastest node", fastest_node(run), "m/s");
    let movable = run.cast.rigid.iter().filter_map(|(_, b, _)| *b);
    let bodies: Vec<_> = movable.filter_map(|b| run.world.bodies.get(b)).collect();
    let fastest = bodies.iter().map(|b| f64::from(b.linvel().length()));
    f.add(
        "rigid_jitter_mps",
        "fastest box",
        fastest.fold(0.0, f64::max),
        "m/s",
    );
    let asleep = bodies.iter().filter(|b| b.is_sleeping()).count();
    f.add("asleep", "boxes asleep", asleep as f64, "");
    f.add("boxes", "boxes", bodies.len() as f64, "");
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

/// Speed of the fastest node of any block at the end \[m/s\].
fn fastest_node(run: &Run) -> f64 {
    let nodes = run.deformables.iter().flat_map(|(_, b)| b.velocities());
    nodes.map(|v| f64::from(v.length())).fold(0.0, f64::max)
}
