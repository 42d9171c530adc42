//! `trampoline`: ten boxes of 10 kg on a pinned sheet of 10 kg, and ten on a sheet of 1 kg.
//!
//! A load a hundred times as heavy as the cloth that carries it is what constraints with a fixed number of iterations
//! stretch without bound or let through. The springs have k = 2·10⁴ N/m whatever the sheet weighs, so both sheets must
//! sag alike.

mod figures;

use super::{Options, Run, Scene, SceneError};

/// The scene.
pub const SCENE: Scene = Scene {
    name: "trampoline",
    about: "ten boxes of 10 kg fall 5 cm onto a pinned sheet of 10 kg, and ten onto a sheet of 1 kg",
    options: Options {
        dt: 1.0 / 60.0,
        duration: 5.0,
        safety: 0.9,
        cell: 3.0 / 29.0,
    },
    build,
    figures: figures::figures,
};

/// Half the side of a box \[m\].
const HALF: f64 = 0.15;
/// The sheets by their masses.
const SHEETS: [&str; 2] = ["10kg", "1kg"];

fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("trampoline", options)
}
