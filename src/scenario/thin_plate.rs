//! `thin_plate`: blocks at 50 m/s on a plate 2 mm thick.
//!
//! At the usual step of the world a block moves 0.8 m at a time and in a substep more than the plate is thick, so a
//! contact that looks for overlaps finds none, or pushes out on the far side. One block lands flat, one on an edge.

use super::{Figures, Options, Run, Scene, SceneError};

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

/// Half the thickness of the plate \[m\]; its middle is at y = 0.
const HALF_THICKNESS: f64 = 0.001;
fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("thin_plate", options)
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
        lowest - HALF_THICKNESS,
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
