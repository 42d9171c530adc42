//! `pole`: the car slides sideways at 29 km/h into a rigid pole of 254 mm at the driver's door.
//!
//! Speed, angle and pole are those of Euro NCAP's side pole test of 2000 to 2014. The car lies on a carrier that glides, so
//! the ground hardly resists. What the pole meets is no cage: lengthwise the cabin is held by sills and roof rails, sideways
//! there are doors and then seats. An isotropic lattice can't be both, so this scene gives the struck side the strength of
//! doors. A pole of 0.25 m that dents a side of 1.4 m must use up 42 kJ on some 0.3 m, 140 kN on the mean; the lattice
//! beside the pole's width carries as much again as what lies before it.
//!
//! *Intrusion* is what the distance from the struck door to the opposite side of the body has lost, at its largest and at
//! the end, between rings of nodes that do not see how the car turns.

use super::car;
use super::{Figures, Options, Run, Scene, SceneError};
use crate::math::{DVec3, Real, Vector};
use crate::record::{BodyRecord, Cfc, Interface, Resampled, SignalError};

/// The scene.
pub const SCENE: Scene = Scene {
    name: "pole",
    about: "the car slides sideways at 29 km/h into a rigid pole of 254 mm at the driver's door",
    options: Options {
        dt: 1.0 / 240.0,
        duration: 0.200,
        safety: 0.9,
        cell: 0.1,
    },
    build,
    figures,
};

/// Speed of the car \[m/s\]: 29 km/h.
pub const SPEED: f64 = 29.0 / 3.6;
/// Radius of the pole \[m\].
pub const RADIUS: f64 = 0.127;
/// Half the height of the pole \[m\].
const HALF_HEIGHT: Real = 1.0;
/// How deep a node may lie in the pole before it counts as through \[m\].
const THROUGH: f64 = 1.0e-3;
/// Bins of forces \[s\].
const BIN: f64 = 1.0e-4;

fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("pole", options)
}

/// Force of the pole on the car, against its motion \[N\].
///
/// # Errors
/// [`SceneError::Missing`] for a run of another scene.
pub fn pole_force(run: &Run) -> Result<Resampled, SceneError> {
    let pole = run.cast.collider("pole");
    let pole = pole.ok_or(SceneError::Missing("pole"))?;
    let force = run.recorder.collider_force(pole, 2, BIN);
    Ok(force.map_err(SignalError::from)?)
}

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let car = run.cast.deformable("car");
    let record = car.and_then(|car| run.recorder.body(car));
    let record = record.ok_or(SceneError::Missing("car"))?;
    let pole = run.cast.collider("pole");
    let pole = pole.ok_or(SceneError::Missing("pole"))?;
    let channel = record.find(Interface::Collider(pole));
    let [begin, end] = channel
        .and_then(|c| c.touched)
        .ok_or(SceneError::Missing("contact with the pole"))?;
    let (most, at, lasting) = intrusion(run)?;
    let raw = pole_force(run)?;
    let force = raw.filtered(Cfc::Cfc60).map_err(SignalError::from)?.peak();
    let impulse = raw.values.iter().sum::<f64>() * raw.dt;
    let [before, after] = kinetic(run, record);

    let mut f = Figures::default();
    f.add("speed_mps", "speed of the car", SPEED, "m/s");
    f.add("peak_force_n", "peak pole force (CFC 60)", force.1, "N");
    let time = force.0 - begin;
    f.add("peak_force_time_s", "its time after contact", time, "s");
    let mean = impulse / (end - begin).max(BIN);
    f.add("mean_force_n", "mean force over the contact", mean, "N");
    f.add("intrusion_m", "intrusion", most, "m");
    f.add("time_of_intrusion_s", "deepest after", at - begin, "s");
    f.add("lasting_intrusion_m", "lasting intrusion", lasting, "m");
    f.add("contact_s", "contact", end - begin, "s");
    let away = velocity(run, record);
    f.add("rebound_mps", "speed away from the pole", away, "m/s");
    f.add("absorbed_j", "absorbed", before - after, "J");
    let plastic = record
        .ledger
        .last()
        .map_or(0.0, |s| s.energies.work.plastic);
    f.add("plastic_j", "plastic work", plastic, "J");
    f.add("mass_kg", "mass", record.mass + car::ENGINE_MASS, "kg");
    let through = nodes_through(run) as f64;
    f.add("nodes_through", "nodes in or behind the pole", through, "");
    let depth = channel.map_or(0.0, |c| c.max_depth);
    f.add("max_penetration_m", "deepest node in the pole", depth, "m");
    let closure = system_closure(run, record).max(run.recorder.momentum_closure());
    f.add("momentum_closure", "momentum closure", closure, "");
    run.common_figures(&mut f);
    Ok(f)
}

/// The largest loss of the distance between the struck side and the other, when it was \[s\], and that at the end \[m\].
fn intrusion(run: &Run) -> Result<(f64, f64, f64), SceneError> {
    let set = |name: &str| {
        let found = run.recorder.sets.iter().find(|s| s.name == name);
        found.ok_or(SceneError::Missing("sides"))
    };
    let (struck, far) = (&set("struck")?.history, &set("far")?.history);
    let width: Vec<f64> = struck
        .positions
        .iter()
        .zip(&far.positions)
        .map(|(a, b)| a.distance(*b))
        .collect();
    let (Some(first), Some(last)) = (width.first(), width.last()) else {
        return Err(SceneError::Missing("sides"));
    };
    let (mut most, mut at) = (0.0, 0.0);
    for (w, t) in width.iter().zip(&struck.times) {
        if first - w > most {
            (most, at) = (first - w, *t);
        }
    }
    Ok((most, at, first - last))
}

/// Nodes that at the end lie more than a millimetre behind the pole's near face within its width and height, in it or on
/// its far side: the car comes from one side only, so each of them has gone through.
fn nodes_through(run: &Run) -> usize {
    let car = run.cast.deformable("car");
    let Some(car) = car.and_then(|c| run.deformables.get(c)) else {
        return 0;
    };
    let through = |p: &Vector| {
        let p = DVec3::new(p.x.into(), p.y.into(), p.z.into());
        let inner = RADIUS - THROUGH;
        let face = inner * inner - p.x * p.x;
        face > 0.0 && p.z < face.sqrt() && p.y < 2.0 * f64::from(HALF_HEIGHT) - THROUGH
    };
    car.positions().filter(through).count()
}

/// Kinetic energy of car and engine at the start and at the end \[J\].
fn kinetic(run: &Run, record: &BodyRecord) -> [f64; 2] {
    let engine = run.cast.rigid("engine");
    let engine = engine.and_then(|h| run.world.bodies.get(h));
    let after = engine.map_or(0.0, |b| f64::from(b.kinetic_energy()));
    let of_car = |s: Option<&crate::record::LedgerSample>| s.map_or(0.0, |s| s.energies.kinetic);
    [
        0.5 * (record.mass + car::ENGINE_MASS) * SPEED * SPEED,
        of_car(record.ledger.last()) + after,
    ]
}

/// Velocity of the engine along z at the end \[m/s\].
fn engine_velocity(run: &Run) -> f64 {
    let engine = run.cast.rigid("engine");
    let engine = engine.and_then(|h| run.world.bodies.get(h));
    engine.map_or(0.0, |b| f64::from(b.linvel().z))
}

/// Velocity of car and engine together along z at the end \[m/s\].
fn velocity(run: &Run, record: &BodyRecord) -> f64 {
    let car = record.center.velocities.last().map_or(0.0, |v| v.z);
    (car * record.mass + engine_velocity(run) * car::ENGINE_MASS) / (record.mass + car::ENGINE_MASS)
}

/// How well the impulses on the car and its engine together explain their change of momentum along z, over that change
/// \[1\].
fn system_closure(run: &Run, record: &BodyRecord) -> f64 {
    let closure = &record.closure;
    let change = closure.change.z + car::ENGINE_MASS * (engine_velocity(run) + SPEED);
    (closure.contact.z - change).abs() / change.abs().max(f64::MIN_POSITIVE)
}
