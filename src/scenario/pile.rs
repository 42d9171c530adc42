//! `pile`: thirty bodies of all kinds fall into a box and come to rest on each other.
//!
//! Half of what is near a body in a heap is held by something else, so it is here that a coupling which is right for two
//! bodies shows whether it is right for thirty: nothing may sink in, gain energy, or go on trembling.

use super::{Figures, Options, Run, Scene, SceneError, survey};
use crate::math::{Pose, Real, Rotation, Vector};

/// The scene.
pub const SCENE: Scene = Scene {
    name: "pile",
    about: "thirty rigid and deformable bodies fall into a heap between four walls",
    options: Options {
        dt: 1.0 / 60.0,
        duration: 8.0,
        safety: 0.9,
        cell: 0.1,
    },
    build,
    figures,
};

/// Half the side of the room \[m\].
pub const ROOM: Real = 0.85;
/// Places of one layer, and layers one above the other.
const PLACES: [[Real; 2]; 6] = [
    [-0.5, -0.35],
    [0.0, -0.35],
    [0.5, -0.35],
    [-0.5, 0.35],
    [0.0, 0.35],
    [0.5, 0.35],
];
const LAYERS: usize = 5;
/// Springs of a rope.
pub const ROPE_SPRINGS: usize = 11;
/// Nodes of a side of a sheet.
pub const SHEET_NODES: usize = 8;
/// Length of a rope and its thickness \[m\].
pub const ROPE: [Real; 2] = [0.44, 0.018];
/// Side of a sheet and its thickness \[m\].
pub const SHEET: [Real; 2] = [0.42, 0.01];
/// Sides of a block \[m\].
pub const BLOCK: Vector = Vector::new(0.34, 0.26, 0.3);

/// Where the bodies stand at the beginning, and whether they are deformable: two of five, so that every layer and every
/// column has both.
pub fn places() -> impl Iterator<Item = (Pose, bool)> {
    (0..LAYERS * PLACES.len()).map(|i| {
        let (layer, place) = (i / PLACES.len(), PLACES[i % PLACES.len()]);
        let lean = (i * 7 % 5) as Real - 2.0;
        let at = Vector::new(
            place[0] + 0.02 * lean,
            0.35 + 0.5 * layer as Real,
            place[1] - 0.02 * lean,
        );
        let turn = Rotation::from_scaled_axis(Vector::new(0.1 * lean, 0.4 * lean, 0.15));
        (Pose::from_parts(at, turn), i % 5 == 1 || i % 5 == 3)
    })
}

fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("pile", options)
}

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let mut f = Figures::default();
    survey::figures(run, &mut f);
    f.add("bodies", "bodies", bodies(run) as f64, "");
    let moving = run.world.bodies.iter().filter(|(_, b)| b.is_dynamic());
    let asleep = moving.filter(|(_, b)| b.is_sleeping()).count();
    f.add("asleep", "rigid bodies asleep", asleep as f64, "");
    let rise = survey::largest_rise(&run.energy);
    f.add("energy_rise", "largest rise of the energy", rise, "");
    let lowest = survey::lowest_node(&run.deformables);
    f.add("lowest_node_m", "lowest node", lowest, "m");
    let closure = run.recorder.momentum_closure();
    f.add("momentum_closure", "momentum closure", closure, "");
    run.common_figures(&mut f);
    Ok(f)
}

/// How many bodies can move.
fn bodies(run: &Run) -> usize {
    let rigid = run.world.bodies.iter().filter(|(_, b)| b.is_dynamic());
    rigid.count() + run.deformables.len()
}
