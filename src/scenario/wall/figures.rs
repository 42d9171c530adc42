//! What the crash comes to, in the words of crash laboratories.
//!
//! Time zero is the first impulse of the wall. *Crush* is how far the cabin (the body's slice at the B-pillars) goes on from
//! there until it stands still: since the bumper stays at the wall, that is what the car has become shorter by. *Δv* is the
//! speed at contact plus the speed of car and engine together at the end, *restitution* their ratio, *absorbed* the
//! difference of the kinetic energies of the two. *Mean deceleration* is v²/2 over the crush, in units of gravity, *mean
//! force* the kinetic energy over the crush; peaks are those of channels in CFC 60, as SAE J211 wants them.

use super::super::{Figures, Run, SceneError, car};
use super::SPEED;
use crate::math::{DVec3, wide};
use crate::record::{BodyRecord, Cfc, Interface, NodeSet, Resampled, SignalError};
use crate::world::Energies;
use rapier3d::geometry::ColliderHandle;

/// Bins of forces and accelerations \[s\].
const BIN: f64 = 1.0e-4;
/// Standard gravity \[m/s²\].
const G: f64 = 9.80665;

/// Force of the wall on the car, against its motion \[N\].
///
/// # Errors
/// [`SceneError::Missing`] for a run of another scene.
pub fn wall_force(run: &Run) -> Result<Resampled, SceneError> {
    let force = run.recorder.collider_force(wall(run)?, 0, BIN);
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

fn wall(run: &Run) -> Result<ColliderHandle, SceneError> {
    let wall = run.cast.collider("wall");
    wall.ok_or(SceneError::Missing("wall"))
}

/// All figures of a run.
pub(super) fn figures(run: &Run) -> Result<Figures, SceneError> {
    let car = run.cast.deformable("car");
    let record = car.and_then(|car| run.recorder.body(car));
    let record = record.ok_or(SceneError::Missing("car"))?;
    let mut figures = Figures::default();
    add_pulse(&mut figures, run, record)?;
    add_damage(&mut figures, run, record)?;
    add_crates(&mut figures, run, record)?;
    let closure = system_closure(run, record).max(run.recorder.momentum_closure());
    figures.add("momentum_closure", "momentum closure", closure, "");
    run.common_figures(&mut figures);
    Ok(figures)
}

/// How fast it came, how it was stopped, and how it left.
fn add_pulse(f: &mut Figures, run: &Run, record: &BodyRecord) -> Result<(), SceneError> {
    let cabin = &set(run, "cabin")?.history;
    let channel = record.find(Interface::Collider(wall(run)?));
    let touched = channel.and_then(|c| c.touched);
    let [begin, end] = touched.ok_or(SceneError::Missing("contact with the wall"))?;
    let after = cabin.times.partition_point(|t| *t < begin);
    let contact = after.min(cabin.times.len() - 1);
    let x0 = cabin.positions[contact].x;
    let mut crush = (contact, 0.0);
    for (i, position) in cabin.positions.iter().enumerate().skip(contact) {
        if position.x - x0 > crush.1 {
            crush = (i, position.x - x0);
        }
    }
    let (stop, crush) = crush;
    let time_of_crush = cabin.times[stop] - cabin.times[contact];
    let approach = cabin.velocities[contact].x;
    let rebound = -whole_velocity(run, record);
    let signal = SignalError::from;
    let filtered = |signal: Resampled| signal.filtered(Cfc::Cfc60).map(|s| s.peak());
    let decel = filtered(cabin_deceleration(run)?).map_err(signal)?;
    let force = filtered(wall_force(run)?).map_err(signal)?;
    let kinetic = 0.5 * car::MASS * approach * approach;
    let absorbed = kinetic - 0.5 * car::MASS * rebound * rebound;
    let mean_force = kinetic / crush;
    let mean_decel = approach * approach / (2.0 * crush) / G;
    let peak = "peak cabin deceleration (CFC 60)";
    f.add("speed_mps", "speed at contact", approach, "m/s");
    f.add("peak_force_n", "peak wall force (CFC 60)", force.1, "N");
    f.add("mean_force_n", "mean force over the crush", mean_force, "N");
    f.add("crush_m", "crush", crush, "m");
    f.add("time_of_crush_s", "cabin at rest after", time_of_crush, "s");
    f.add("contact_end_s", "off the wall after", end - begin, "s");
    f.add("delta_v_mps", "velocity change", approach + rebound, "m/s");
    f.add("restitution", "restitution", rebound / approach, "");
    f.add("mean_decel_g", "mean deceleration", mean_decel, "g");
    f.add("peak_decel_g", peak, decel.1 / G, "g");
    let peak_time = decel.0 - begin;
    f.add(
        "peak_decel_time_s",
        "its time after contact",
        peak_time,
        "s",
    );
    f.add("absorbed_j", "absorbed", absorbed, "J");
    Ok(())
}

/// What is left of the car.
fn add_damage(f: &mut Figures, run: &Run, record: &BodyRecord) -> Result<(), SceneError> {
    let plastic = last(record, |e| e.work.plastic);
    f.add("plastic_j", "plastic work", plastic, "J");
    f.add(
        "damping_j",
        "damping",
        last(record, |e| e.work.damping),
        "J",
    );
    let set = shortening(run)?;
    f.add("shortening_m", "bumper to B-pillar, lasting", set, "m");
    let strain = cabin_strain(run);
    f.add(
        "cabin_strain",
        "plastic strain of the cabin, mean",
        strain,
        "",
    );
    f.add("mass_kg", "mass", record.mass + car::ENGINE_MASS, "kg");
    Ok(())
}

/// What became of the crates, and how deep the car was in them and in the wall.
fn add_crates(f: &mut Figures, run: &Run, record: &BodyRecord) -> Result<(), SceneError> {
    let start = super::super::file("wall", &run.options)?;
    let crates = || run.cast.rigid.iter().filter(|r| r.0.starts_with("crate"));
    let pushed = crates().filter(|(name, body, _)| {
        let start = start.rigid.iter().find(|r| r.name == *name);
        let now = body.and_then(|b| run.world.bodies.get(b));
        start.zip(now).is_some_and(|(start, now)| {
            let from = DVec3::from_array(start.translation);
            wide(now.translation()).distance(from) > 0.01
        })
    });
    let pushed = pushed.count() as f64;
    f.add("crates_pushed", "crates pushed aside", pushed, "");
    let deepest = depth(record, wall(run)?);
    f.add(
        "max_penetration_m",
        "deepest node in the wall",
        deepest,
        "m",
    );
    let depths = crates().map(|r| depth(record, r.2));
    let deepest = depths.fold(0.0, f64::max);
    f.add(
        "crate_penetration_m",
        "deepest node in a crate",
        deepest,
        "m",
    );
    Ok(())
}

/// How deep a node of the car was in a collider at most \[m\].
fn depth(record: &BodyRecord, collider: ColliderHandle) -> f64 {
    let channel = record.find(Interface::Collider(collider));
    channel.map_or(0.0, |c| c.max_depth)
}

fn last(record: &BodyRecord, term: impl Fn(&Energies) -> f64) -> f64 {
    record.ledger.last().map_or(0.0, |s| term(&s.energies))
}

/// How well the impulses on the car and its engine together explain their change of momentum along x, over that change
/// \[1\]. What rigid bodies do to the engine is not seen, so a contact of the engine with the wall would show here.
fn system_closure(run: &Run, record: &BodyRecord) -> f64 {
    let closure = &record.closure;
    let change = closure.change.x + car::ENGINE_MASS * (engine_velocity(run) - SPEED);
    (closure.contact.x - change).abs() / change.abs().max(f64::MIN_POSITIVE)
}

/// Velocity of the engine along x at the end \[m/s\].
fn engine_velocity(run: &Run) -> f64 {
    let engine = run.cast.rigid("engine");
    let engine = engine.and_then(|h| run.world.bodies.get(h));
    engine.map_or(0.0, |b| f64::from(b.linvel().x))
}

/// Velocity of car and engine together along x at the end \[m/s\].
fn whole_velocity(run: &Run, record: &BodyRecord) -> f64 {
    let car = record.center.velocities.last().map_or(0.0, |v| v.x) * record.mass;
    (car + car::ENGINE_MASS * engine_velocity(run)) / (record.mass + car::ENGINE_MASS)
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
