//! `trampoline`: ten boxes of 10 kg on a pinned sheet of 10 kg, and ten on a sheet of 1 kg.
//!
//! A load a hundred times as heavy as the cloth that carries it is what constraints with a fixed number of iterations
//! stretch without bound or let through. The springs have k = 2·10⁴ N/m whatever the sheet weighs, so both sheets must
//! sag alike.

mod figures;

use super::{Cast, Options, Run, Scene, SceneError};
use crate::body::{BuildError, Net};
use crate::math::{Real, Vector};
use crate::shape::sheet_with_bending;
use crate::world::{DeformableBuilder, DeformableWorld, Substeps};
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "trampoline",
    about: "ten boxes of 10 kg fall 5 cm onto a pinned sheet of 10 kg, and ten onto a sheet of 1 kg",
    options: Options {
        dt: 1.0 / 60.0,
        duration: 5.0,
        safety: 0.9,
        cell: SIDE as f64 / 29.0,
    },
    build,
    figures: figures::figures,
};

/// Side of a sheet \[m\].
pub const SIDE: Real = 3.0;
/// Stiffness of every spring \[N/m\].
pub const STIFFNESS: Real = 2.0e4;
/// Damping of a spring between two of the sheet's nodes, as a share of 2·√(k·m).
pub const DAMPING: Real = 0.3;
/// Half the side of a box \[m\], its mass \[kg\], and how far it falls \[m\].
pub const HALF: Real = 0.15;
/// Mass of a box \[kg\].
pub const BOX_MASS: Real = 10.0;
/// Height of the boxes above the sheet \[m\].
pub const DROP: Real = 0.05;
/// Distance of the middles of neighbouring boxes \[m\].
pub const SPACING: Real = 0.45;
/// The sheets: name, mass \[kg\], and where the middle is along x \[m\].
pub const SHEETS: [(&str, Real, Real); 2] = [("10kg", 10.0, -1.8), ("1kg", 1.0, 1.8)];
/// Height of the floor under the sheets \[m\]; a box that gets through lands there.
pub const FLOOR: Real = -1.2;

/// The sheet about the origin: squares with both diagonals, every spring alike, the border pinned.
///
/// # Errors
/// [`BuildError`] for a mass or a number of nodes that a sheet can't have.
pub fn net(mass: Real, nodes: usize) -> Result<Net, BuildError> {
    // The thickness only tells how the mass is shared: every node by the cells about it.
    let mut net = sheet_with_bending(SIDE, SIDE, nodes, nodes, 1.0e-3, 0.0)?;
    let volume: Real = net.nodes.iter().map(|n| n.volume).sum();
    for node in &mut net.nodes {
        node.mass = mass * node.volume / volume;
        node.volume = 0.0;
    }
    let inner = net.nodes.iter().map(|n| n.mass).fold(0.0, Real::max);
    for spring in &mut net.springs {
        spring.section = 0.0;
        spring.stiffness = STIFFNESS;
        spring.damping = 2.0 * DAMPING * (STIFFNESS * inner).sqrt();
    }
    Ok(net.pin_border())
}

/// Middles of the boxes over a sheet whose middle is at `x` \[m\].
pub fn places(x: Real) -> impl Iterator<Item = Vector> {
    (0..10).map(move |i| {
        let (column, row) = ((i % 5) as Real, (i / 5) as Real);
        Vector::new(
            x + SPACING * (column - 2.0),
            DROP + HALF,
            SPACING * (row - 0.5),
        )
    })
}

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    let (_, ground) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, FLOOR - 0.5, 0.0)),
        ColliderBuilder::cuboid(8.0, 0.5, 6.0),
    );
    cast.rigid.push(("ground".into(), None, ground));
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    let nodes = (f64::from(SIDE) / options.cell).round() as usize + 1;
    for (name, mass, x) in SHEETS {
        let handle = deformables.insert(
            DeformableBuilder::new(net(mass, nodes)?)
                .translation(Vector::new(x, 0.0, 0.0))
                .substeps(Substeps::Auto {
                    safety: options.safety,
                    min_h: 1.0e-7,
                }),
        )?;
        cast.deformables.push((format!("sheet_{name}"), handle));
        for (i, at) in places(x).enumerate() {
            let (body, collider) = world.insert(
                RigidBodyBuilder::dynamic().translation(at),
                ColliderBuilder::cuboid(HALF, HALF, HALF)
                    .mass(BOX_MASS)
                    .friction(0.5),
            );
            let name = format!("box_{name}_{}", i + 1);
            cast.rigid.push((name, Some(body), collider));
        }
    }
    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = [0.0, 0.06, 0.1, 0.2, 0.4, 1.0]
        .into_iter()
        .map(|share: f64| share * options.duration)
        .collect();
    // Long, and after the first second calm.
    run.recorder.sampling.history = 1.0e-3;
    run.recorder.sampling.energy = 5.0e-3;
    Ok(run)
}
