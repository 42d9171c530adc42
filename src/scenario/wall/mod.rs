//! `wall`: the car into a fixed wall at 56 km/h, the full-width rigid barrier test.
//!
//! The speed and the figures are those of FMVSS 208 and of the New Car Assessment Program, so that they can be held
//! against real cars: 15.6 m/s, 0.5 to 0.7 m of crush, 20 g on the mean, standstill after 60 to 80 ms. Crates stand beside
//! the wall, some so close that the front's bulge pushes them, to show that one world holds both kinds of body.

mod figures;

pub use figures::{cabin_deceleration, wall_force};

use super::{Options, Run, Scene, SceneError};

/// The scene.
pub const SCENE: Scene = Scene {
    name: "wall",
    about: "a car of 1300 kg with a rigid engine hits a rigid wall at 56 km/h, beside stacked crates",
    options: Options {
        dt: 1.0 / 240.0,
        duration: 0.150,
        safety: 0.9,
        cell: 0.1,
    },
    build,
    figures: figures::figures,
};

/// Speed of the car \[m/s\]: 56 km/h.
pub const SPEED: f64 = 56.0 / 3.6;

fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("wall", options)
}
