//! `cradle`: a bar hits one as long, and a bar hits one twice as long, end on.
//!
//! Saint-Venant's theory of longitudinal impact has exact answers: equal bars exchange their velocities, and a bar that
//! hits one of twice its length comes to rest and leaves it half its speed, the other half of the energy being waves.
//! There is no damping, so what is lost is lost to the mesh or to the contact.

use super::{Figures, Options, Run, Scene, SceneError};
use crate::math::{DVec3, Real};

/// The scene.
pub const SCENE: Scene = Scene {
    name: "cradle",
    about: "an elastic bar hits one of its length, and one hits a bar of twice its length",
    options: Options {
        dt: 1.0e-3,
        duration: 0.3,
        safety: 0.25,
        cell: LENGTH / 50.0,
    },
    build,
    figures,
};

/// Length of the striking bars \[m\].
const LENGTH: f64 = 1.0;
/// Their speed \[m/s\].
const SPEED: f64 = 1.0;
/// Mass per length of a bar \[kg/m\].
const DENSITY: f64 = 1.0;
/// The pairs: how many times as long the bar that is hit is.
const PAIRS: [usize; 2] = [1, 2];

fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("cradle", options)
}

/// Keys and labels of a pair: velocity of the striking and of the struck bar.
const KEYS: [[(&str, &str); 2]; 2] = [
    [
        ("equal_striker_v", "equal bars: striking bar after, over v0"),
        ("equal_struck_v", "equal bars: struck bar after, over v0"),
    ],
    [
        ("double_striker_v", "1 on 2: striking bar after, over v0"),
        ("double_struck_v", "1 on 2: struck bar after, over v0"),
    ],
];

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let mut f = Figures::default();
    let whole = LENGTH * DENSITY * SPEED;
    let mut momentum_error = 0.0_f64;
    for (ratio, keys) in PAIRS.into_iter().zip(KEYS) {
        let mut momentum = DVec3::ZERO;
        for (role, (key, label)) in ["striker", "struck"].into_iter().zip(keys) {
            let handle = run.cast.deformable(&format!("{role}_{ratio}"));
            let body = handle.and_then(|h| run.deformables.get(h));
            let body = body.ok_or(SceneError::Missing("bar"))?;
            f.add(key, label, body.linvel().x / SPEED, "");
            momentum += body.momentum();
        }
        let error = (momentum - DVec3::X * whole).length() / whole;
        momentum_error = momentum_error.max(error);
    }
    f.add(
        "momentum_error",
        "momentum gained or lost",
        momentum_error,
        "",
    );
    let closure = run.recorder.momentum_closure();
    f.add("momentum_closure", "momentum closure", closure, "");
    f.add(
        "nodes_through",
        "nodes past the other bar",
        through(run),
        "",
    );
    f.add(
        "max_penetration_m",
        "deepest node",
        run.recorder.max_depth(),
        "m",
    );
    run.common_figures(&mut f);
    Ok(f)
}

/// How many nodes of striking bars are past the near end of the bar they hit.
fn through(run: &Run) -> f64 {
    let pairs = PAIRS.into_iter().filter_map(|ratio| {
        let get = |role| {
            let handle = run.cast.deformable(&format!("{role}_{ratio}"))?;
            run.deformables.get(handle)
        };
        let end = get("struck")?.bounds().0.x as Real;
        Some(get("striker")?.positions().filter(|p| p.x >= end).count())
    });
    pairs.sum::<usize>() as f64
}
