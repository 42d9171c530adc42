//! `drop`: boxes onto a soft block, and a soft block onto boxes, until all is at rest.
//!
//! The plainest scene there is, and the one most couplings fail: bodies must come to rest, stay at rest, and not sink in.

use super::{Figures, Options, Run, Scene, SceneError};

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

fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("drop", options)
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
