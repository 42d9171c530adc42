//! `gripper`: rigid jaws squeeze a soft cube and lift it; with μ = 0.6 it comes along, with μ = 0.2 it slips out.
//!
//! The jaws close by a given way, so the force with which they hold is the cube's own answer. It is chosen such that two
//! faces carry 1.9 times the weight at μ = 0.6 and 0.6 times at μ = 0.2.

use super::{Figures, Options, Run, Scene, SceneError};
use crate::math::Real;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "gripper",
    about: "jaws squeeze two soft cubes and lift them: one holds with friction 0.6, one slips with 0.2",
    options: Options {
        dt: 1.0 / 60.0,
        duration: 2.5,
        safety: 0.9,
        cell: SIDE as f64 / 4.0,
    },
    build,
    figures,
};

/// Side of a cube \[m\].
const SIDE: Real = 0.2;
/// How far the jaws rise \[m\].
pub const LIFT: Real = 0.25;
/// The cubes.
const CUBES: [&str; 2] = ["holds", "slips"];

fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("gripper", options)
}

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let mut f = Figures::default();
    for (name, keys) in CUBES.into_iter().zip([
        (
            "lifted_06_m",
            "cube at μ = 0.6 lifted by",
            "grip_06_n",
            "grip at μ = 0.6",
        ),
        (
            "lifted_02_m",
            "cube at μ = 0.2 lifted by",
            "grip_02_n",
            "grip at μ = 0.2",
        ),
    ]) {
        let handle = run
            .cast
            .deformable(name)
            .ok_or(SceneError::Missing("cube"))?;
        let body = run
            .deformables
            .get(handle)
            .ok_or(SceneError::Missing("cube"))?;
        let lifted = body.bounds().0.y;
        f.add(keys.0, keys.1, lifted, "m");
        let jaw = run.cast.collider(&format!("{name}_left"));
        let force = jaw.and_then(|jaw| run.deformables.contact_force(handle, jaw));
        f.add(keys.2, keys.3, force.map_or(0.0, |f| f.x), "N");
        if name == "holds" {
            f.add("weight_n", "weight of a cube", 9.81 * body.mass(), "N");
        }
    }
    f.add("jaws_lifted_m", "jaws lifted by", LIFT.into(), "m");
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
