//! `pile`: thirty bodies of all kinds fall into a box and come to rest on each other.
//!
//! Half of what is near a body in a heap is held by something else, so it is here that a coupling which is right for two
//! bodies shows whether it is right for thirty: nothing may sink in, gain energy, or go on trembling.

use super::{Cast, Figures, Options, Run, Scene, SceneError, survey};
use crate::body::Material;
use crate::math::{Pose, Real, Rotation, Vector};
use crate::shape::{lattice, rope, sheet};
use crate::world::{DeformableBuilder, DeformableWorld, Substeps};
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::{ColliderBuilder, SharedShape};
use rapier3d::pipeline::PhysicsWorld;

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

/// Ground and walls. The wall towards the viewer is a half-space: it holds as well and hides nothing.
fn room(world: &mut PhysicsWorld, cast: &mut Cast) {
    let mut fixed = |name: &str, at: Vector, collider: ColliderBuilder| {
        let body = RigidBodyBuilder::fixed().translation(at);
        let (_, collider) = world.insert(body, collider.friction(0.6));
        cast.rigid.push((name.into(), None, collider));
    };
    let ground = ColliderBuilder::cuboid(4.0, 0.5, 4.0);
    fixed("ground", Vector::new(0.0, -0.5, 0.0), ground);
    let out = ROOM + 0.1;
    let side = ColliderBuilder::cuboid(0.1, 0.6, ROOM + 0.2);
    fixed("wall_left", Vector::new(-out, 0.6, 0.0), side.clone());
    fixed("wall_right", Vector::new(out, 0.6, 0.0), side);
    let back = ColliderBuilder::cuboid(ROOM, 0.6, 0.1);
    fixed("wall_back", Vector::new(0.0, 0.6, -out), back);
    let front = ColliderBuilder::new(SharedShape::halfspace(-Vector::Z));
    fixed("wall_front", Vector::new(0.0, 0.0, ROOM), front);
}

/// Rigid bodies of five kinds, all of wood.
fn rigid(kind: usize) -> Result<(&'static str, ColliderBuilder), SceneError> {
    let hull = || {
        // An octahedron with one corner drawn out: no symmetry that could balance it.
        let corners = [
            Vector::new(0.18, 0.0, 0.0),
            Vector::new(-0.13, 0.0, 0.0),
            Vector::new(0.0, 0.13, 0.0),
            Vector::new(0.0, -0.13, 0.0),
            Vector::new(0.0, 0.0, 0.13),
            Vector::new(0.0, 0.0, -0.13),
        ];
        ColliderBuilder::convex_hull(&corners).ok_or(SceneError::Missing("hull"))
    };
    let (name, collider) = match kind % 5 {
        0 => ("box", ColliderBuilder::cuboid(0.15, 0.11, 0.13)),
        1 => ("ball", ColliderBuilder::ball(0.13)),
        2 => ("capsule", ColliderBuilder::capsule_x(0.11, 0.09)),
        3 => ("cylinder", ColliderBuilder::cylinder(0.11, 0.12)),
        _ => ("hull", hull()?),
    };
    Ok((name, collider.density(500.0).friction(0.6)))
}

/// Blocks of foam, ropes and sheets.
fn soft(kind: usize, options: &Options) -> Result<(&'static str, DeformableBuilder), SceneError> {
    let (name, builder) = match kind % 4 {
        1 => {
            let [length, thickness] = ROPE;
            let end = Vector::X * (0.5 * length);
            let net = rope(-end, end, ROPE_SPRINGS, 4.0e-4)?;
            let line = Material::elastic(2.0e6, 1100.0).viscosity(3.0e3);
            (
                "rope",
                DeformableBuilder::new(net)
                    .material(line)
                    .thickness(thickness),
            )
        }
        3 => {
            let [side, thickness] = SHEET;
            let net = sheet(side, side, SHEET_NODES, SHEET_NODES, thickness)?;
            let mat = Material::elastic(1.0e6, 400.0).viscosity(8.0e3);
            (
                "sheet",
                DeformableBuilder::new(net)
                    .material(mat)
                    .thickness(thickness),
            )
        }
        _ => {
            let net = lattice(BLOCK, options.cell as Real)?;
            let foam = Material::elastic(0.2e6, 150.0).viscosity(2.0e3);
            ("block", DeformableBuilder::new(net).material(foam))
        }
    };
    let substeps = Substeps::Auto {
        safety: options.safety,
        min_h: 1.0e-7,
    };
    Ok((name, builder.friction(0.6).substeps(substeps)))
}

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    room(&mut world, &mut cast);
    let (mut hard, mut yielding) = (0, 0);
    for (pose, deformable) in places() {
        if deformable {
            let (name, builder) = soft(yielding, options)?;
            let builder = builder.translation(pose.translation);
            let handle = deformables.insert(builder.rotation(pose.rotation))?;
            cast.deformables
                .push((format!("{name}_{yielding}"), handle));
            yielding += 1;
        } else {
            let (name, collider) = rigid(hard)?;
            let (body, collider) = world.insert(RigidBodyBuilder::dynamic().pose(pose), collider);
            cast.rigid
                .push((format!("{name}_{hard}"), Some(body), collider));
            hard += 1;
        }
    }
    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = [0.0, 0.04, 0.07, 0.1, 0.2, 1.0]
        .into_iter()
        .map(|share: f64| share * options.duration)
        .collect();
    run.recorder.sampling.history = 5.0e-3;
    run.recorder.sampling.energy = 1.0e-2;
    Ok(run)
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
