//! `rubber_drop`: a block of rubber falls on a corner and a crate, a bar of rubber on its end, and they bounce.
//!
//! Natural rubber by its constants: E = 2 MPa, ν = 0.45, 1,000 kg/m³, a loss factor of some per cent. The block is of linear
//! tets, the bar of quadratic ones; a crate of 5 kg stands in the block's way.

use super::{Figures, Options, Run, Scene, SceneError};
use crate::math::DVec3;

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

/// Length of the bar \[m\].
const BAR: f64 = 0.4;
fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("rubber_drop", options)
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
    let tallest = |[lo, hi]: &[DVec3; 2]| (hi.y - lo.y) / BAR;
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
