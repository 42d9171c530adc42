//! `gripper`: rigid jaws squeeze a soft cube and lift it; with μ = 0.6 it comes along, with μ = 0.2 it slips out.
//!
//! The jaws close by a given way, so the force with which they hold is the cube's own answer. It is chosen such that two
//! faces carry 1.9 times the weight at μ = 0.6 and 0.6 times at μ = 0.2.

use super::{Cast, Figures, Options, Run, Scene, SceneError};
use crate::body::{Solid, SolidLaw};
use crate::math::{Real, Vector};
use crate::shape::{TetSplit, tet_box};
use crate::world::{DeformableBuilder, DeformableWorld, Substeps};
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

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
pub const SIDE: Real = 0.2;
/// Soft silicone: E = 50 kPa, ν = 0.4, 1000 kg/m³; damped as a real one, a twentieth of the critical at 20 Hz.
pub const SILICONE: Solid = Solid::new(5.0e4, 0.4, 1000.0)
    .law(SolidLaw::StableNeoHookean)
    .damping(0.0, 8.0e-4);
/// How far both jaws together press into a cube \[m\].
pub const SQUEEZE: Real = 0.011;
/// How far the jaws rise \[m\].
pub const LIFT: Real = 0.25;
/// When the jaws have closed, begin to rise, and stand still again \[s\].
pub const TIMES: [f64; 3] = [0.4, 0.6, 1.8];
/// The cubes: name, friction, and where they stand along z \[m\].
pub const CUBES: [(&str, Real, Real); 2] = [("holds", 0.6, -0.25), ("slips", 0.2, 0.25)];

/// Half of a jaw \[m\].
const JAW: Vector = Vector::new(0.03, 0.12, 0.14);
/// Room between open jaws and a cube, each side \[m\].
const ROOM: Real = 0.01;

/// A smooth way from 0 to 1.
fn ease(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    0.5 - 0.5 * (std::f64::consts::PI * t).cos()
}

/// How far a jaw has moved towards the cube and up at a time \[m\].
fn way(time: f64) -> [Real; 2] {
    let [closed, lift, end] = TIMES;
    let close = f64::from(ROOM + 0.5 * SQUEEZE) * ease(time / closed);
    let rise = f64::from(LIFT) * ease((time - lift) / (end - lift));
    [close as Real, rise as Real]
}

/// Where a jaw stands at a time; `side` is −1 or 1.
fn jaw(side: Real, z: Real, time: f64) -> Vector {
    let [close, rise] = way(time);
    let open = 0.5 * SIDE + ROOM + JAW.x;
    Vector::new(side * (open - close), 0.5 * SIDE + rise, z)
}

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    let (_, ground) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(3.0, 0.5, 3.0),
    );
    cast.rigid.push(("ground".into(), None, ground));
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    for (name, friction, z) in CUBES {
        let mesh = tet_box(Vector::splat(SIDE), options.cell as Real, TetSplit::Six)?;
        let handle = deformables.insert(
            DeformableBuilder::tets(mesh.quadratic(), SILICONE)
                .translation(Vector::new(0.0, 0.5 * SIDE, z))
                .friction(friction)
                .substeps(Substeps::Auto {
                    safety: options.safety,
                    min_h: 1.0e-7,
                }),
        )?;
        cast.deformables.push((name.into(), handle));
        for side in [-1.0, 1.0] {
            let at = jaw(side, z, 0.0);
            let (body, collider) = world.insert(
                RigidBodyBuilder::kinematic_position_based().translation(at),
                ColliderBuilder::cuboid(JAW.x, JAW.y, JAW.z).friction(friction),
            );
            let which = if side < 0.0 { "left" } else { "right" };
            cast.rigid
                .push((format!("{name}_{which}"), Some(body), collider));
        }
    }
    let mut run = Run::new(world, deformables, cast, options);
    run.lead = Some(lead);
    run.frame_times = [0.0, 0.25, 0.48, 1.0]
        .into_iter()
        .map(|share: f64| share * options.duration)
        .collect();
    run.view = Vector::new(0.9, 0.35, 0.8);
    run.recorder.sampling.history = 1.0e-3;
    run.recorder.sampling.energy = 5.0e-3;
    Ok(run)
}

/// Leads the jaws to where they are at the end of the coming step.
fn lead(run: &mut Run) {
    let time = (run.steps + 1) as f64 * run.options.dt;
    for (name, _, z) in CUBES {
        for (which, side) in [("left", -1.0), ("right", 1.0)] {
            let body = run.cast.rigid(&format!("{name}_{which}"));
            if let Some(body) = body.and_then(|b| run.world.bodies.get_mut(b)) {
                body.set_next_kinematic_translation(jaw(side, z, time));
            }
        }
    }
}

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let mut f = Figures::default();
    for ((name, ..), keys) in CUBES.into_iter().zip([
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
