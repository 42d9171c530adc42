//! `cradle`: a bar hits one as long, and a bar hits one twice as long, end on.
//!
//! Saint-Venant's theory of longitudinal impact has exact answers: equal bars exchange their velocities, and a bar that
//! hits one of twice its length comes to rest and leaves it half its speed, the other half of the energy being waves.
//! There is no damping, so what is lost is lost to the mesh or to the contact.

use super::{Cast, Figures, Options, Run, Scene, SceneError};
use crate::body::{Net, Node, Spring};
use crate::math::{DVec3, Real, Vector};
use crate::world::{DeformableBuilder, DeformableWorld, Substeps};
use rapier3d::pipeline::PhysicsWorld;

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
pub const LENGTH: f64 = 1.0;
/// Their speed \[m/s\].
pub const SPEED: f64 = 1.0;
/// Stiffness times length of a bar, EA \[N\], and mass per length \[kg/m\]: waves run at 100 m/s.
pub const BAR: [f64; 2] = [1.0e4, 1.0];
/// Distance of the bars at the start, beyond the thickness of their ends \[m\].
pub const GAP: f64 = 1.0e-4;
/// The pairs: how many times as long the bar that is hit is, and where they are along z \[m\].
const PAIRS: [(usize, Real); 2] = [(1, -0.15), (2, 0.15)];

/// A bar of `n` springs along x from the origin, the nodes at its ends half as heavy.
fn bar(n: usize, length: f64) -> Net {
    let [ea, density] = BAR;
    let dx = length / n as f64;
    let nodes = (0..=n).map(|i| {
        let share = if i == 0 || i == n { 0.5 } else { 1.0 };
        let at = Vector::new((i as f64 * dx) as Real, 0.0, 0.0);
        Node::new(at, (share * density * dx) as Real)
    });
    let springs = (0..n as u32).map(|i| Spring::new(i, i + 1, (ea / dx) as Real));
    Net::new(nodes.collect(), springs.collect())
}

fn build(options: &Options) -> Result<Run, SceneError> {
    let world = PhysicsWorld {
        gravity: Vector::ZERO,
        ..PhysicsWorld::default()
    };
    let mut cast = Cast::default();
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    let n = ((LENGTH / options.cell).round() as usize).max(1);
    // Ends are points with a thickness, less than half of what is between two nodes.
    let thickness = 0.45 * LENGTH / n as f64;
    let start = -LENGTH - thickness - GAP;
    for (ratio, z) in PAIRS {
        for (role, times, x, v) in [("striker", 1, start, SPEED), ("struck", ratio, 0.0, 0.0)] {
            let handle = deformables.insert(
                DeformableBuilder::new(bar(n * times, LENGTH * times as f64))
                    .thickness(thickness as Real)
                    .friction(0.0)
                    .translation(Vector::new(x as Real, 0.0, z))
                    .linvel(Vector::new(v as Real, 0.0, 0.0))
                    .substeps(Substeps::Auto {
                        safety: options.safety,
                        min_h: 1.0e-9,
                    }),
            )?;
            cast.deformables.push((format!("{role}_{ratio}"), handle));
        }
    }
    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]
        .into_iter()
        .map(|share: f64| share * options.duration)
        .collect();
    Ok(run)
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
    let whole = LENGTH * BAR[1] * SPEED;
    let mut momentum_error = 0.0_f64;
    for ((ratio, _), keys) in PAIRS.into_iter().zip(KEYS) {
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
    let pairs = PAIRS.into_iter().filter_map(|(ratio, _)| {
        let get = |role| {
            let handle = run.cast.deformable(&format!("{role}_{ratio}"))?;
            run.deformables.get(handle)
        };
        let end = get("struck")?.bounds().0.x as Real;
        Some(get("striker")?.positions().filter(|p| p.x >= end).count())
    });
    pairs.sum::<usize>() as f64
}
