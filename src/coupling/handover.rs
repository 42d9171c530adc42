//! The hand-over: what a rigid body gets, before and after Rapier's step, so that it ends where its shadow is, as fast as
//! its shadow is, and with exactly the momentum the deformables gave, of free bodies also made good for what Rapier's step does to
//! the angular one. Where Rapier's contacts are too soft for that, it gets what contacts of its shadow answered as well, and so does
//! what they press on.
//!
//! An impulse J before the step displaces J·dt/m, one after it nothing; a force F held over it s·F·dt²/m. A free body
//! gets a first part that puts it at the shadow's position, and the rest of the impulse afterwards; likewise a spin that turns it
//! as its shadow has turned, and then its shadow's. A body with rigid contacts or joints gets it within the step, so that Rapier's
//! own constraints can answer it: a part at the start or at the end, and the rest as a force, split so that it ends where its
//! shadow is. (The mean force alone, which does not know when in the step the impulse came, lets a jointed pair leave a hard impact
//! 3 % too slow.) A link of a multibody gets it all as a force, for impulses are lost on it. Where the shadow can't foresee the
//! answer, it is the mean force, and the answer is measured.
//!
//! Rapier damps what a body has at the end of its step without the impulses still to come, which may be what bears its weight. So it gets
//! that back, and what damping has taken of its shadow instead: a free body afterwards, one that has rigid contacts, or joints
//! that its shadow keeps, at the start, for what these stop is not damped any more. Of what hangs on other joints Rapier's own damping stays.

use super::flight::{Flight, rotation_vector};
use super::linkage::Mobility;
use super::memory::BodyMemory;
use super::observe::{Answer, displacement_share, inv_inertia};
use crate::contact::target::wide_rotation;
use crate::math::{DMat3, DQuat, DVec3, Pose, Vector, narrow, wide};
use crate::solve::shadow::Shadow;
use rapier3d::dynamics::{IntegrationParameters, RigidBody};

/// An orientation that differs from its shadow's by more than this is not what Rapier makes by the right spin \[rad\].
const OFF: f64 = 1e-5;
/// And one that differs by less than this from what was expected is that, but for rounding \[rad\].
const MET: f64 = 1e-4;

/// An impulse \[N·s\] and an angular impulse about the centre of mass \[N·m·s\].
pub type Wrench = (DVec3, DVec3);

/// What of a body's impulses it gets at the start of Rapier's step and at its end; the rest it gets as a force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Split {
    /// At the start.
    pub early: Wrench,
    /// At the end.
    pub late: Wrench,
}

/// What a body still has to get after Rapier's step.
#[derive(Clone, Copy, Debug)]
pub struct Pending {
    answer: Answer,
    /// Impulse of a free body given before the step \[N·s\].
    given: DVec3,
    /// Orientation and spin that it is expected to have after the step, if it got another spin for that \[rad/s\].
    turned: Option<(DQuat, DVec3)>,
    /// To be given after it.
    late: Wrench,
    /// The user's own force and torque, to be restored exactly.
    user: (Vector, Vector),
    /// The length of the step \[s\].
    dt: f64,
    /// Velocity before the step, and the change a free body would make.
    before: (DVec3, DVec3),
    free: (DVec3, DVec3),
}

impl Pending {
    /// Whether the body has anything still to get.
    pub fn is_something(&self) -> bool {
        self.answer != Answer::None
    }

    /// For a body that nothing touched, or that does not answer.
    pub fn nothing() -> Self {
        Self {
            answer: Answer::None,
            given: DVec3::ZERO,
            turned: None,
            late: Default::default(),
            user: (Vector::ZERO, Vector::ZERO),
            dt: 0.0,
            before: Default::default(),
            free: Default::default(),
        }
    }
}

/// Gives `body` its part before Rapier's step of `dt` s. `start` and `end` are its shadow before and after the substeps.
pub fn before_step(
    body: &mut RigidBody,
    answer: Answer,
    mobility: &Mobility,
    [start, end]: [&Shadow; 2],
    split: Split,
    parameters: &IntegrationParameters,
    dt: f64,
) -> Pending {
    let mut pending = Pending {
        answer,
        dt,
        user: (body.user_force(), body.user_torque()),
        before: (wide(body.linvel()), wide(body.angvel())),
        ..Pending::nothing()
    };
    match answer {
        Answer::None => {}
        Answer::Free => {
            let (acceleration, spin_up) = (mobility.acceleration, mobility.spin_up);
            let share = displacement_share(body, parameters);
            let inv_mass = wide(body.mass_properties().effective_inv_mass);
            let drift = end.com - start.com - start.v * dt - acceleration * (share * dt * dt);
            let impulse = per_axis(drift / dt, inv_mass);
            give(body, (impulse, DVec3::ZERO));
            pending.given = impulse;
            // Some axis that is not locked is enough: about the others its shadow has not turned either.
            if inv_inertia(body) != DMat3::ZERO {
                let flight = Flight::new(body, spin_up, parameters, dt);
                let spin = flight.spin_to(end.rot, 0.5 * (start.w + end.w));
                body.set_angvel(narrow(spin), false);
                pending.turned = Some(flight.end(wide(body.angvel())));
            }
        }
        Answer::Constrained | Answer::Linked | Answer::Jointed | Answer::Link => {
            let (impulse, torque) = end.given();
            pending.free = mobility.answer(impulse, torque, dt);
            give(body, split.early);
            pending.late = split.late;
            if answer == Answer::Constrained {
                let damped = momentum(body, end.damped);
                give(body, (-damped.0, -damped.1));
            }
            let force = impulse - split.early.0 - split.late.0;
            let torque = torque - split.early.1 - split.late.1;
            body.add_force(narrow(force / dt), false);
            body.add_torque(narrow(torque / dt), false);
        }
    }
    pending
}

/// Gives a body that was expected to end with an orientation and spin those of its shadow. A torque would depend on how well
/// Rapier met the orientation, the more the thinner the body: it turns nothing by more than an eighth of a turn, and what is
/// slender and spins about its axis not as a free body turns. Where Rapier found something in the way, it knows better.
fn turn_to(body: &mut RigidBody, end: &Shadow, (expected, spin): (DQuat, DVec3)) {
    let rot = wide_rotation(*body.rotation());
    let apart = |other: DQuat| rotation_vector(other * rot.inverse()).length();
    let mut now = rot;
    if apart(end.rot) > OFF && apart(expected) < MET {
        let (com, local) = (body.center_of_mass(), body.local_center_of_mass());
        let rotation = end.rot.as_quat();
        let at = com - rotation * local;
        body.set_position(Pose::from_parts(at, rotation), false);
        now = end.rot;
    }
    // Turned along with the body: its energy and the size of its momentum are those of the shadow.
    let spin = wide(body.angvel()) - spin + now * end.rot.inverse() * end.w;
    if spin.is_finite() {
        body.set_angvel(narrow(spin), false);
    }
}

/// Twice the energy of what a body's velocity is off that of its shadow, and of what a free body would have got of its impulses \[J\].
/// What is asleep is off by all.
pub fn off_shadow(body: &RigidBody, pending: &Pending, end: &Shadow) -> (f64, f64) {
    let size = |(v, w): Wrench| {
        let (p, l) = momentum(body, (v, w));
        p.dot(v) + l.dot(w)
    };
    let (v, w) = (wide(body.linvel()), wide(body.angvel()));
    let off = if body.is_sleeping() {
        f64::INFINITY
    } else {
        size((v - end.v, w - end.w))
    };
    (off, size(pending.free))
}

/// The energy of the way from where a body is to where its shadow is within `dt` s \[J\].
pub fn cost_to_put(body: &RigidBody, end: &Shadow, dt: f64) -> f64 {
    let by = end.com - wide(body.center_of_mass());
    let turn = rotation_vector(end.rot * wide_rotation(*body.rotation()).inverse());
    let (p, l) = momentum(body, (by, turn));
    0.5 * (p.dot(by) + l.dot(turn)) / (dt * dt)
}

/// Puts a body where its shadow is, as fast as this is after a step of `dt` s. What it is ahead of Rapier's velocities because it falls
/// is taken from what falls, and not from what something bears.
pub fn become_shadow(
    body: &mut RigidBody,
    mobility: &Mobility,
    [start, end]: [&Shadow; 2],
    dt: f64,
) {
    let told = |change: DVec3, falls: DVec3, ahead: DVec3| {
        let share = change.dot(falls) / (falls.length_squared() * dt);
        if share.is_finite() {
            ahead * share.clamp(0.0, 1.0)
        } else {
            ahead
        }
    };
    let v = told(end.v - start.v, mobility.acceleration, end.ahead.0);
    let w = told(end.w - start.w, mobility.spin_up, end.ahead.1);
    put_at(body, end);
    body.set_linvel(narrow(end.v - v), false);
    body.set_angvel(narrow(end.w - w), false);
}

/// Puts a body where its shadow is.
pub fn put_at(body: &mut RigidBody, end: &Shadow) {
    let at = narrow(end.com) - end.rot.as_quat() * body.local_center_of_mass();
    body.set_position(Pose::from_parts(at, end.rot.as_quat()), false);
}

fn give(body: &mut RigidBody, (impulse, torque): Wrench) {
    body.apply_impulse(narrow(impulse), false);
    body.apply_torque_impulse(narrow(torque), false);
}

/// What Rapier's damping has taken of the velocity and spin of a body in a step of `dt` s; none is known where it takes all.
fn damped_by_rapier(body: &RigidBody, dt: f64) -> (DVec3, DVec3) {
    // 1/(1 + d·dt) of it are left.
    let taken = |left: Vector, damping: f32| {
        let share = f64::from(damping) * dt;
        if share.is_finite() {
            wide(left) * share
        } else {
            DVec3::ZERO
        }
    };
    (
        taken(body.linvel(), body.linear_damping()),
        taken(body.angvel(), body.angular_damping()),
    )
}

/// What damping has taken of a body's shadow along and about locked axes, where no momentum can take it.
fn damped_where_locked(body: &RigidBody, end: &Shadow) -> (DVec3, DVec3) {
    let inv_mass = wide(body.mass_properties().effective_inv_mass);
    let inv_inertia = inv_inertia(body);
    let axes = |locked: [bool; 3], v: DVec3| v * DVec3::from_array(locked.map(f64::from));
    (
        axes(inv_mass.to_array().map(|w| w == 0.0), end.damped.0),
        axes(
            [0, 1, 2].map(|k| inv_inertia.col(k) == DVec3::ZERO),
            end.damped.1,
        ),
    )
}

/// The momentum of a body of this velocity and spin. What it says about locked axes moves nothing.
fn momentum(body: &RigidBody, (v, w): Wrench) -> Wrench {
    let inv_mass = wide(body.mass_properties().effective_inv_mass);
    let mut inv_inertia = inv_inertia(body);
    for k in 0..3 {
        if inv_inertia.col(k) == DVec3::ZERO {
            *inv_inertia.col_mut(k) = DVec3::AXES[k];
        }
    }
    (per_axis(v, inv_mass), inv_inertia.inverse() * w)
}

/// Momentum for a velocity, axis by axis; 0 along locked axes and for bodies that don't answer at all.
fn per_axis(velocity: DVec3, inv_mass: DVec3) -> DVec3 {
    let along = |v: f64, w: f64| if w > 0.0 { v / w } else { 0.0 };
    DVec3::new(
        along(velocity.x, inv_mass.x),
        along(velocity.y, inv_mass.y),
        along(velocity.z, inv_mass.z),
    )
}

/// Gives `body` the rest after Rapier's step, and learns from what it did.
pub fn after_step(body: &mut RigidBody, pending: &Pending, end: &Shadow, memory: &mut BodyMemory) {
    match pending.answer {
        Answer::None => {}
        // Rapier has put it to sleep in this step and its velocity to zero: it stays that way.
        Answer::Free if body.is_sleeping() => {}
        Answer::Free => {
            let taken = damped_by_rapier(body, pending.dt);
            let (v, w) = (taken.0 - end.damped.0, taken.1 - end.damped.1);
            let impulse = end.impulse - pending.given;
            if let Some(turned) = pending.turned {
                give(body, (impulse, DVec3::ZERO));
                turn_to(body, end, turned);
            } else {
                give(body, (impulse, end.torque));
                body.set_angvel(body.angvel() + narrow(w), false);
            }
            body.set_linvel(body.linvel() + narrow(v), false);
        }
        Answer::Constrained | Answer::Linked | Answer::Jointed | Answer::Link => {
            body.reset_forces(false);
            body.reset_torques(false);
            body.add_force(pending.user.0, false);
            body.add_torque(pending.user.1, false);
            // Not to one that Rapier has put to sleep in this step.
            if !body.is_sleeping() {
                let (v, w) = match pending.answer {
                    Answer::Constrained => {
                        let taken = damped_by_rapier(body, pending.dt);
                        let locked = damped_where_locked(body, end);
                        (taken.0 - locked.0, taken.1 - locked.1)
                    }
                    _ => Default::default(),
                };
                give(body, pending.late);
                body.set_linvel(body.linvel() + narrow(v), false);
                body.set_angvel(body.angvel() + narrow(w), false);
            }
            if !pending.answer.is_kept() {
                let (v, w) = pending.before;
                memory.answer(
                    wide(body.linvel()) - v,
                    pending.free.0,
                    wide(body.angvel()) - w,
                    pending.free.1,
                );
            }
        }
    }
}

/// The coupling defect of a body that has got everything \[J\]: by what the work on its shadow differs from that done on it.
pub fn defect(body: &RigidBody, pending: &Pending, end: &Shadow) -> f64 {
    if !pending.is_something() || pending.answer == Answer::Free && body.is_sleeping() {
        return 0.0;
    }
    let turned = end.torque.dot(end.w - end.ahead.1 - wide(body.angvel()));
    let defect = |v: DVec3| 0.5 * (end.impulse.dot(v - wide(body.linvel())) + turned);
    let free = defect(end.v - end.ahead.0);
    if pending.answer == Answer::Free || end.lead.is_none() {
        return free;
    }
    // By what its shadow was ahead, contacts and joints of a body may have taken from it since, all or a part: that much is not known
    // of its velocity.
    let held = defect(end.v);
    if free * held <= 0.0 {
        0.0
    } else if free.abs() < held.abs() {
        free
    } else {
        held
    }
}
