//! `wall`: the car into a fixed wall at 56 km/h, the full-width rigid barrier test.
//!
//! The speed and the figures are those of FMVSS 208 and of the New Car Assessment Program, so that they can be held
//! against real cars: 15.6 m/s, 0.5 to 0.7 m of crush, 20 g on the mean, standstill after 60 to 80 ms. Crates stand beside
//! the wall, some so close that the front's bulge pushes them, to show that one world holds both kinds of body.

use super::car::{self, Car};
use super::{Cast, Figures, Options, Run, Scene, SceneError};
use crate::math::{Real, Vector};
use crate::record::{BodyRecord, Cfc, Interface, NodeSet, Resampled, SignalError};
use crate::world::{DeformableWorld, Energies, Substeps};
use rapier3d::dynamics::{CoefficientCombineRule, RigidBodyBuilder};
use rapier3d::geometry::{ColliderBuilder, Group, InteractionGroups, InteractionTestMode};
use rapier3d::pipeline::PhysicsWorld;

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
    figures,
};

/// Speed of the car \[m/s\]: 56 km/h.
pub const SPEED: f64 = 56.0 / 3.6;
/// Distance of the front from the wall at the start \[m\].
pub const GAP: f64 = 0.03;
/// When pictures are taken \[s\].
pub const FRAMES: [f64; 6] = [0.0, 0.025, 0.050, 0.075, 0.100, 0.150];
/// Bins of forces and accelerations \[s\].
const BIN: f64 = 1.0e-4;
/// Standard gravity \[m/s²\].
const G: f64 = 9.80665;

/// Half the side of a crate, its mass, and where they stand: x \[m\], how many crates lie below, z \[m\]. The camera looks
/// from +z, so they stand on the other side.
const CRATE: Real = 0.22;
const CRATE_MASS: Real = 12.0;
const CRATES: [[Real; 3]; 8] = [
    [-0.30, 0.0, -1.125],
    [-0.76, 0.0, -1.125],
    [-0.30, 0.0, -1.60],
    [-0.76, 0.0, -1.60],
    [-0.53, 1.0, -1.095],
    [-0.30, 1.0, -1.60],
    [-0.76, 1.0, -1.60],
    [-0.53, 2.0, -1.36],
];

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    // The wheels roll, which nodes can't: a rolling resistance stands for the friction between car and ground.
    let (_, ground) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(-4.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(10.0, 0.5, 6.0)
            .friction(0.015)
            .friction_combine_rule(CoefficientCombineRule::Min),
    );
    cast.rigid.push(("ground".into(), None, ground));
    let (_, wall) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.3, 0.9, 0.0)),
        ColliderBuilder::cuboid(0.3, 0.9, 1.9).friction(0.4),
    );
    cast.rigid.push(("wall".into(), None, wall));
    for (i, [x, level, z]) in CRATES.into_iter().enumerate() {
        let at = Vector::new(x, CRATE * (1.0 + 2.0 * level), z);
        let (body, collider) = world.insert(
            RigidBodyBuilder::dynamic().translation(at),
            ColliderBuilder::cuboid(CRATE, CRATE, CRATE)
                .mass(CRATE_MASS)
                .friction(0.5)
                .friction_combine_rule(CoefficientCombineRule::Max),
        );
        let name = format!("crate_{}", i + 1);
        cast.rigid.push((name, Some(body), collider));
    }

    let mut car = Car::new(options.cell)?;
    let (lo, hi) = car.net.bounds();
    let shift = Vector::new(-(GAP as Real) - hi.x, -lo.y, 0.0);
    let speed = Vector::new(SPEED as Real, 0.0, 0.0);
    let (cabin, carriers) = (car.cabin_nodes(), car.engine_nodes(options.cell));
    let front = car.nodes(|p| p.x > hi.x - 0.3 * options.cell as Real);
    cast.parts = std::mem::take(&mut car.parts);
    car.builder = car
        .builder
        .translation(shift)
        .linvel(speed)
        .friction(0.4)
        .substeps(Substeps::Auto {
            safety: options.safety,
            min_h: 1.0e-7,
        });
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    let handle = deformables.insert(car.builder)?;
    cast.deformables.push(("car".into(), handle));

    let half = car::ENGINE_HALF;
    let (engine, collider) = world.insert(
        RigidBodyBuilder::dynamic()
            .translation(shift + car::ENGINE_AT)
            .linvel(speed),
        ColliderBuilder::cuboid(half.x, half.y, half.z)
            .mass(car::ENGINE_MASS as Real)
            .friction(0.4)
            .collision_groups(InteractionGroups::new(
                car::ENGINE_GROUP,
                Group::ALL,
                InteractionTestMode::And,
            )),
    );
    cast.rigid.push(("engine".into(), Some(engine), collider));
    let mount = deformables.attach(handle, &carriers, engine, &world.bodies)?;
    cast.attachments.push(("engine_mount".into(), mount));

    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = FRAMES.to_vec();
    run.recorder
        .follow("cabin", &run.deformables, handle, cabin)?;
    run.recorder
        .follow("front", &run.deformables, handle, front)?;
    Ok(run)
}

/// Force of the wall on the car, against its motion \[N\].
///
/// # Errors
/// [`SceneError::Missing`] for a run of another scene.
pub fn wall_force(run: &Run) -> Result<Resampled, SceneError> {
    let wall = run
        .cast
        .collider("wall")
        .ok_or(SceneError::Missing("wall"))?;
    let force = run.recorder.collider_force(wall, 0, BIN);
    Ok(force.map_err(SignalError::from)?.scaled(-1.0))
}

/// Deceleration of the cabin \[m/s²\].
///
/// # Errors
/// [`SceneError::Missing`] for a run of another scene.
pub fn cabin_deceleration(run: &Run) -> Result<Resampled, SceneError> {
    let a = run.recorder.acceleration(set(run, "cabin")?, 0, BIN);
    Ok(a.map_err(SignalError::from)?.scaled(-1.0))
}

fn set<'a>(run: &'a Run, name: &str) -> Result<&'a NodeSet, SceneError> {
    let mut sets = run.recorder.sets.iter();
    sets.find(|s| s.name == name)
        .ok_or(SceneError::Missing("cabin"))
}

/// Crush is what the cabin (the B-pillars) comes nearer to the wall from the first contact on; absorbed is the car's and
/// the engine's kinetic energy at contact less what is left of the cabin's rebound speed times the whole mass.
fn figures(run: &Run) -> Result<Figures, SceneError> {
    let car = run
        .cast
        .deformable("car")
        .ok_or(SceneError::Missing("car"))?;
    let record = run
        .recorder
        .body(car)
        .ok_or(SceneError::Missing("record of the car"))?;
    let wall = run
        .cast
        .collider("wall")
        .ok_or(SceneError::Missing("wall"))?;
    let cabin = &set(run, "cabin")?.history;
    let touched = record
        .find(Interface::Collider(wall))
        .and_then(|c| c.touched);
    let [begin, end] = touched.ok_or(SceneError::Missing("contact with the wall"))?;
    let at = |t: f64| {
        cabin
            .times
            .partition_point(|x| *x < t)
            .min(cabin.times.len() - 1)
    };
    let contact = at(begin);
    let x0 = cabin.positions[contact].x;
    let (stop, crush) = (contact..cabin.times.len())
        .map(|i| (i, cabin.positions[i].x - x0))
        .fold(
            (contact, 0.0),
            |best, next| {
                if next.1 > best.1 { next } else { best }
            },
        );
    let time_of_crush = cabin.times[stop] - cabin.times[contact];
    let approach = cabin.velocities[contact].x;
    let rebound = -whole_velocity(run, record);
    let deceleration = cabin_deceleration(run)?;
    let signal = SignalError::from;
    let decel = deceleration.filtered(Cfc::Cfc60).map_err(signal)?.peak();
    let raw = wall_force(run)?;
    let force = raw.filtered(Cfc::Cfc60).map_err(signal)?.peak();
    let kinetic = 0.5 * car::MASS * approach * approach;
    let absorbed = kinetic - 0.5 * car::MASS * rebound * rebound;

    let mut f = Figures::default();
    f.add("speed_mps", "speed at contact", approach, "m/s");
    f.add("peak_force_n", "peak wall force (CFC 60)", force.1, "N");
    f.add(
        "mean_force_n",
        "mean force over the crush",
        kinetic / crush,
        "N",
    );
    f.add("crush_m", "crush", crush, "m");
    f.add("time_of_crush_s", "cabin at rest after", time_of_crush, "s");
    f.add("contact_end_s", "off the wall after", end - begin, "s");
    f.add("delta_v_mps", "velocity change", approach + rebound, "m/s");
    f.add("restitution", "restitution", rebound / approach, "");
    let mean = approach * approach / (2.0 * crush) / G;
    f.add("mean_decel_g", "mean deceleration", mean, "g");
    f.add(
        "peak_decel_g",
        "peak cabin deceleration (CFC 60)",
        decel.1 / G,
        "g",
    );
    f.add(
        "peak_decel_time_s",
        "its time after contact",
        decel.0 - begin,
        "s",
    );
    f.add("absorbed_j", "absorbed", absorbed, "J");
    f.add(
        "plastic_j",
        "plastic work",
        last(record, |e| e.work.plastic),
        "J",
    );
    f.add(
        "damping_j",
        "damping",
        last(record, |e| e.work.damping),
        "J",
    );
    let set = shortening(run)?;
    f.add("shortening_m", "bumper to B-pillar, lasting", set, "m");
    f.add(
        "cabin_strain",
        "plastic strain of the cabin, mean",
        cabin_strain(run),
        "",
    );
    f.add("mass_kg", "mass", record.mass + car::ENGINE_MASS, "kg");
    let pushed = run.cast.rigid.iter().filter(|(name, body, _)| {
        let body = body.and_then(|b| run.world.bodies.get(b));
        name.starts_with("crate") && body.is_some_and(|b| b.linvel().length() > 0.05)
    });
    f.add("crates_moving", "crates moving", pushed.count() as f64, "");
    let depth = |collider| {
        let channel = record.find(Interface::Collider(collider));
        channel.map_or(0.0, |c| c.max_depth)
    };
    f.add(
        "max_penetration_m",
        "deepest node in the wall",
        depth(wall),
        "m",
    );
    let crates = run.cast.rigid.iter().filter(|r| r.0.starts_with("crate"));
    let deepest = crates.map(|r| depth(r.2)).fold(0.0, f64::max);
    f.add(
        "crate_penetration_m",
        "deepest node in a crate",
        deepest,
        "m",
    );
    run.common_figures(&mut f);
    Ok(f)
}

fn last(record: &BodyRecord, term: impl Fn(&Energies) -> f64) -> f64 {
    record.ledger.last().map_or(0.0, |s| term(&s.energies))
}

/// Velocity of car and engine together along x at the end \[m/s\].
fn whole_velocity(run: &Run, record: &BodyRecord) -> f64 {
    let car = record.center.velocities.last().map_or(0.0, |v| v.x) * record.mass;
    let engine = run
        .cast
        .rigid("engine")
        .and_then(|h| run.world.bodies.get(h));
    let (p, m) = engine.map_or((0.0, 0.0), |b| {
        let m = f64::from(b.mass());
        (m * f64::from(b.linvel().x), m)
    });
    (car + p) / (record.mass + m)
}

/// What the distance from the bumper to the cabin has lost at the end \[m\].
fn shortening(run: &Run) -> Result<f64, SceneError> {
    let (front, cabin) = (&set(run, "front")?.history, &set(run, "cabin")?.history);
    let length = |i: usize| front.positions[i].x - cabin.positions[i].x;
    Ok(length(0) - length(cabin.positions.len() - 1))
}

/// Mean plastic strain of the springs at the cabin's nodes at the end.
fn cabin_strain(run: &Run) -> f64 {
    let Ok(set) = set(run, "cabin") else {
        return 0.0;
    };
    let strain = run
        .deformables
        .get(set.deformable)
        .map(|b| b.node_plastic_strain())
        .unwrap_or_default();
    let values = set.nodes.iter().filter_map(|n| strain.get(n.index()));
    values.map(|s| f64::from(*s)).sum::<f64>() / set.nodes.len().max(1) as f64
}
