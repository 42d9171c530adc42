//! `slalom`: a soft block rides a moving platform past crates, under swinging pendulums and through a curtain.
//!
//! Everything that drives a coupling at once: a kinematic body that carries, rigid bodies on joints that strike, free ones
//! that are pushed, and deformables that touch deformables.

use super::{Figures, Options, Run, Scene, SceneError, survey};
use crate::math::Real;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "slalom",
    about: "a soft block rides a moving platform past crates, pendulums and a curtain",
    options: Options {
        dt: 1.0 / 60.0,
        duration: 8.0,
        safety: 0.9,
        cell: 0.1,
    },
    build,
    figures,
};

/// From where to where the platform goes along x \[m\], and in what time \[s\].
const WAY: [Real; 2] = [-2.0, 2.0];
const BEGINS: f64 = 0.5;
const ENDS: f64 = 6.5;
/// Where the platform is at a time, as the file has it \[m\].
fn platform_at(time: f64) -> Real {
    let s = ((time - BEGINS) / (ENDS - BEGINS)).clamp(0.0, 1.0);
    let turn = std::f64::consts::TAU * s;
    let share = s - turn.sin() / std::f64::consts::TAU;
    WAY[0] + (WAY[1] - WAY[0]) * share as Real
}

fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("slalom", options)
}

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let block = run.cast.deformable("block");
    let block = block.ok_or(SceneError::Missing("block"))?;
    let mut f = Figures::default();
    let record = run.recorder.body(block);
    let record = record.ok_or(SceneError::Missing("block"))?;
    let times = record.center.times.iter().zip(&record.center.positions);
    let slip = times.map(|(t, x)| {
        let along = x.x - f64::from(platform_at(*t));
        along.hypot(x.z)
    });
    f.add(
        "slip_m",
        "most slip on the platform",
        slip.fold(0.0, f64::max),
        "m",
    );
    let x = run.deformables.get(block).map(|b| b.center_of_mass());
    let x = x.unwrap_or_default();
    f.add("block_x_m", "block at the end, along the way", x.x, "m");
    f.add("block_height_m", "block at the end, height", x.y, "m");
    survey::figures(run, &mut f);
    let crates = run.cast.rigid.iter().filter(|r| r.0.starts_with("crate"));
    let crates = crates.filter_map(|r| run.world.bodies.get(r.1?));
    let moving = crates.filter(|b| b.linvel().length() > 0.05).count();
    f.add("crates_moving", "crates moving", moving as f64, "");
    let lowest = survey::lowest_node(&run.deformables);
    f.add("lowest_node_m", "lowest node", lowest, "m");
    run.common_figures(&mut f);
    Ok(f)
}
