//! `slalom`: a soft block rides a moving platform past crates, under swinging pendulums and through a curtain.
//!
//! Everything that drives a coupling at once: a kinematic body that carries, rigid bodies on joints that strike, free ones
//! that are pushed, and deformables that touch deformables.

use super::{Cast, Figures, Options, Run, Scene, SceneError, survey};
use crate::body::{Material, NodeId};
use crate::math::{Real, Rotation, Vector};
use crate::shape::{lattice, rope, sheet};
use crate::world::{AttachTo, Attachment, DeformableBuilder, DeformableWorld, Substeps};
use rapier3d::dynamics::{RigidBodyBuilder, SphericalJointBuilder};
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

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
/// Half sizes of the platform and of the block \[m\].
const PLATFORM: Vector = Vector::new(0.45, 0.08, 0.3);
const BLOCK: Vector = Vector::new(0.3, 0.2, 0.25);
/// Where the pendulums hang along x \[m\], and the angle they are let go at \[rad\].
const PENDULUMS: [(Real, Real); 3] = [(-1.0, 0.9), (0.0, -0.9), (1.0, 0.9)];

/// Where the platform is at a time: sin² in its speed, so that no jerk throws the block off \[m\].
fn platform_at(time: f64) -> Real {
    let s = ((time - BEGINS) / (ENDS - BEGINS)).clamp(0.0, 1.0);
    let turn = std::f64::consts::TAU * s;
    let share = s - turn.sin() / std::f64::consts::TAU;
    WAY[0] + (WAY[1] - WAY[0]) * share as Real
}

/// Ground, platform, crates beside the track and pendulums over it.
fn rigid(world: &mut PhysicsWorld, cast: &mut Cast) {
    let (_, ground) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(6.0, 0.5, 4.0).friction(0.6),
    );
    cast.rigid.push(("ground".into(), None, ground));
    let start = Vector::new(WAY[0], 0.02 + PLATFORM.y, 0.0);
    let (platform, collider) = world.insert(
        RigidBodyBuilder::kinematic_position_based().translation(start),
        ColliderBuilder::cuboid(PLATFORM.x, PLATFORM.y, PLATFORM.z).friction(0.8),
    );
    cast.rigid
        .push(("platform".into(), Some(platform), collider));
    // Two stacks beside the track and one crate on it, which the platform pushes along.
    let crates = [
        Vector::new(-0.5, 0.15, 0.62),
        Vector::new(-0.5, 0.45, 0.62),
        Vector::new(0.5, 0.15, -0.62),
        Vector::new(0.5, 0.45, -0.62),
        Vector::new(-0.4, 0.15, 0.05),
    ];
    for (i, at) in crates.into_iter().enumerate() {
        let (body, collider) = world.insert(
            RigidBodyBuilder::dynamic().translation(at),
            ColliderBuilder::cuboid(0.15, 0.15, 0.15)
                .mass(3.0)
                .friction(0.5),
        );
        cast.rigid
            .push((format!("crate_{i}"), Some(body), collider));
    }
    for (i, (x, angle)) in PENDULUMS.into_iter().enumerate() {
        let (pivot, length) = (Vector::new(x, 1.75, 0.0), 1.1);
        let turn = Rotation::from_rotation_x(angle);
        let at = pivot + turn * Vector::new(0.0, -length, 0.0);
        let pose = rapier3d::math::Pose::from_parts(at, turn);
        let (bob, collider) = world.insert(
            RigidBodyBuilder::dynamic().pose(pose),
            ColliderBuilder::ball(0.12).mass(1.5).friction(0.5),
        );
        cast.rigid
            .push((format!("pendulum_{i}"), Some(bob), collider));
        let anchor = world.insert_body(RigidBodyBuilder::fixed().translation(pivot));
        // A ball joint: a hinge across the way would make a post of a pendulum.
        let hinge = SphericalJointBuilder::new()
            .local_anchor1(Vector::ZERO)
            .local_anchor2(Vector::new(0.0, length, 0.0));
        world.impulse_joints.insert(anchor, bob, hinge, true);
    }
}

/// The block, a rope that it tows, and a curtain across its way.
fn soft(
    world: &PhysicsWorld,
    cast: &mut Cast,
    options: &Options,
) -> Result<DeformableWorld, SceneError> {
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    let substeps = Substeps::Auto {
        safety: options.safety,
        min_h: 1.0e-7,
    };
    let top = 0.02 + 2.0 * PLATFORM.y;
    let middle = Vector::new(WAY[0], top + BLOCK.y + 1.0e-3, 0.0);
    let foam = Material::elastic(0.2e6, 120.0).viscosity(2.0e3);
    let block = deformables.insert(
        DeformableBuilder::new(lattice(2.0 * BLOCK, options.cell as Real)?)
            .material(foam)
            .translation(middle)
            .friction(0.8)
            .substeps(substeps),
    )?;
    cast.deformables.push(("block".into(), block));
    let (from, to) = (Vector::ZERO, Vector::new(-0.9, 0.0, 0.0));
    let hook = middle - Vector::new(BLOCK.x, 0.0, 0.0);
    let line = Material::elastic(2.0e6, 1100.0).viscosity(3.0e3);
    let tow = deformables.insert(
        DeformableBuilder::new(rope(from, to, 18, 2.0e-4)?)
            .material(line)
            .thickness(0.016)
            .translation(hook)
            .friction(0.4)
            .substeps(substeps),
    )?;
    cast.deformables.push(("rope".into(), tow));
    let held = deformables.attach(tow, Attachment::pin([NodeId(0)]), block, &world.bodies)?;
    cast.attachments.push(("hook".into(), held));
    // Width along z, hanging down: the sheet's own plane is turned upright.
    let upright = Rotation::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let cloth = Material::elastic(1.0e6, 400.0).viscosity(8.0e3);
    let curtain = deformables.insert(
        DeformableBuilder::new(sheet(0.7, 0.9, 8, 10, 2.0e-3)?)
            .material(cloth)
            .thickness(8.0e-3)
            .translation(Vector::new(1.5, 0.8, 0.0))
            .rotation(upright)
            .friction(0.3)
            .substeps(substeps),
    )?;
    cast.deformables.push(("curtain".into(), curtain));
    // With this turn x runs upwards: the nodes with the largest x of the net are the upper border.
    let upper = (0..10).map(|j| NodeId(8 * j + 7));
    let rail = Attachment::weld(upper);
    let held = deformables.attach(curtain, rail, AttachTo::World, &world.bodies)?;
    cast.attachments.push(("rail".into(), held));
    Ok(deformables)
}

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    rigid(&mut world, &mut cast);
    let deformables = soft(&world, &mut cast, options)?;
    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = [0.0, 0.3, 0.42, 0.52, 0.65, 1.0]
        .into_iter()
        .map(|share: f64| share * options.duration)
        .collect();
    run.recorder.sampling.history = 5.0e-3;
    run.recorder.sampling.energy = 1.0e-2;
    run.lead = Some(Box::new(lead));
    Ok(run)
}

/// Moves the platform to where it is at the end of the coming step.
fn lead(run: &mut Run) {
    let x = platform_at(run.deformables.time() + run.options.dt);
    let platform = run.cast.rigid("platform");
    if let Some(body) = platform.and_then(|h| run.world.bodies.get_mut(h)) {
        body.set_next_kinematic_translation(Vector::new(x, 0.02 + PLATFORM.y, 0.0));
    }
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
