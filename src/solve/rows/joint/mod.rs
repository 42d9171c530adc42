//! Joints between shadows.
//!
//! What hangs on a joint feels what pushes its partner. All locked axes of a joint are solved at once, because at the end
//! of a long lever each of them alone undoes what the others did. An axis with limits or a motor gets its impulse together
//! with what that takes of the locked ones, for the same reason: the stop of a flap answers with the inertia about its hinge.
//!
//! Locked axes of a soft joint drift back as Rapier has it, besides what velocities tell, see [`Softness`](crate::law::joint::Softness).
//! Shadows move with both, for nodes hang on them. Where that drift turns with the bodies, their velocities have to follow it.

mod place;

use crate::law::joint::{Axes, Drive};
use crate::math::na::{Cholesky, Const, SMatrix, SVector};
use crate::math::{DMat3, DQuat, DVec3};
use crate::solve::shadow::Shadow;
use place::Place;

/// How much of a joint's opening is taken back in a substep.
const PULL_BACK: f64 = 0.2;
/// How fast shadows close what is open, where that is theirs to do \[1/s\].
const CLOSING: f64 = 60.0;
/// What keeps directions in which nothing moves from dividing by zero.
const FLOOR: f64 = 1e-9;

type Vec6 = SVector<f64, 6>;
type Mat6 = SMatrix<f64, 6, 6>;
type Motions = [(DVec3, DVec3); 2];

/// What joins two shadows: displacements along three axes, and turns about them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Joint {
    /// Indices into the shadows; 0 for the fixed world.
    pub shadows: [u32; 2],
    /// The anchor on each, from its centre of mass in its own axes \[m\].
    pub anchors: [DVec3; 2],
    /// The joint's axes on each, in its own axes. Those on the first count.
    pub frames: [DQuat; 2],
    /// What it does along and about them.
    pub axes: Axes,
    /// How far the joint is open along locked axes at the start of the rigid step \[m\].
    pub open: DVec3,
    /// Whether shadows close that: where Rapier has put bodies it does, but these go where their shadows are.
    pub closes: bool,
}

/// A joint, and what a pass makes of it.
#[derive(Clone, Debug, Default)]
pub struct JointRow {
    /// The joint.
    pub joint: Joint,
    /// Accumulated impulses of this substep, at its start those of the last one \[N·s\], \[N·m·s\].
    pub impulses: Vec6,
    /// Where it is at the start of the substep.
    place: Place,
    /// How far locked axes are still open from before the rigid step \[m\].
    left: DVec3,
    /// Velocity that takes back what has opened \[m/s\], \[rad/s\].
    bias: Vec6,
    /// Factors of the response of the locked axes to their impulses; `None` if nothing moves.
    factors: Option<Cholesky<f64, Const<6>>>,
    /// How the two sides of a soft joint answer without what is tied to them, of which Rapier knows nothing \[1/kg\],
    /// \[1/(kg·m²)\].
    alone: Option<[(DMat3, DMat3); 2]>,
    /// What velocities impulses leave its locked axes because they are soft.
    softness: Mat6,
    /// How it drifted in the last substep, and how it does in this one.
    drift: Option<Drift>,
    drifts: Option<Drift>,
    /// Axes with limits or motors.
    driven: [Option<Driven>; 6],
    /// Which of them were at a limit in the last visit.
    at_limit: [bool; 6],
}

/// How a soft joint drifts back: what it takes of velocities, and by what impulses it would, where it is.
#[derive(Clone, Copy, Debug)]
struct Drift {
    place: Place,
    velocities: Vec6,
    impulses: Vec6,
}

/// An axis with limits or a motor.
#[derive(Clone, Copy, Debug)]
struct Driven {
    drive: Drive,
    /// A unit impulse along it, and what locked axes give so that they stay as they are.
    impulses: Vec6,
    /// What velocity that adds along it.
    response: f64,
}

impl JointRow {
    /// That of `joint`. Motors that are given `per_mass`, or per moment of inertia, become what they are for these shadows.
    pub fn new(joint: Joint, per_mass: [bool; 6], shadows: &[Shadow]) -> Self {
        let sides = joint.shadows.map(|i| &shadows[i as usize]);
        let mut row = Self {
            joint,
            left: joint.open,
            place: Place::of(&joint, sides),
            ..Self::default()
        };
        for i in (0..6).filter(|i| per_mass[*i]) {
            let response = row.place.along(i, &row.place.unit_motions(sides, i));
            let motor = row.joint.axes.motors[i].as_mut();
            if let Some(motor) = motor.filter(|_| response > 0.0) {
                motor.stiffness /= response;
                motor.damping /= response;
            }
        }
        let alone = sides.map(|side| (side.inv_mass, side.inv_inertia));
        row.alone = row.joint.axes.softness.map(|_| alone);
        row
    }

    /// Whether it is a spring, by a motor or because it is soft.
    pub fn is_spring(&self) -> bool {
        self.is_soft() || self.joint.axes.motors.iter().any(Option::is_some)
    }

    /// Whether its locked axes give way.
    pub fn is_soft(&self) -> bool {
        self.alone.is_some()
    }

    /// By how much both shadows, as they move, are ahead of Rapier's velocities and spins because it is soft. With velocities as Rapier
    /// has `told` them, by how much they will be.
    pub fn ahead(&self, shadows: &[Shadow], told: bool) -> Option<[(DVec3, DVec3); 2]> {
        let Axes {
            locked,
            softness,
            solver_step,
            ..
        } = self.joint.axes;
        let sides = self.joint.shadows.map(|i| &shadows[i as usize]);
        let [a, b] = alone(sides, self.alone?);
        let place = Place::of(&self.joint, [&a, &b]);
        let factors = factors(place.response([&a, &b], locked), locked)?;
        let drift = softness?.drift;
        let motions = self.velocities(shadows);
        let mut opened = place.opened(locked);
        for i in (0..6).filter(|i| locked[*i]) {
            opened[i] -= solver_step * place.along(i, &motions);
        }
        let share = if told {
            drift / (1.0 - drift * solver_step)
        } else {
            drift
        };
        Some(place.motions([&a, &b], &factors.solve(&(opened * -share))))
    }

    /// Finds the axes at the start of a substep of h s, and lets the shadows take the impulses of the last one.
    pub(super) fn start(&mut self, shadows: &mut [Shadow], h: f64) {
        let sides = self.joint.shadows.map(|i| &shadows[i as usize]);
        self.place = Place::of(&self.joint, sides);
        let Axes {
            locked,
            softness,
            solver_step,
            ..
        } = self.joint.axes;
        let mut response = self.place.response(sides, locked);
        let mut drifts = None;
        if let (Some(soft), Some(known)) = (softness, self.alone) {
            // As a motor, see [`Drive::new`].
            let pull = soft.stiffness * (0.5 * (h + solver_step)) + soft.damping;
            let [a, b] = alone(sides, known);
            let alone = self.place.response([&a, &b], locked);
            self.softness = alone / (h * pull);
            let opened = self.place.opened(locked);
            self.bias = opened * (-soft.stiffness / pull);
            response += self.softness;
            drifts = self.drift_on(alone, opened * soft.drift);
        } else {
            if self.joint.closes {
                self.bias = self.place.opened(locked) * -CLOSING;
            }
            for i in (0..3).filter(|i| locked[*i]) {
                let opened = self.place.displacement(i) - self.left[i];
                self.bias[i] = -PULL_BACK * opened / h - self.closing() * self.left[i];
            }
        }
        self.factors = factors(response, locked);
        for i in 0..6 {
            self.driven[i] = self.drive(i, sides, h);
            if self.driven[i].is_none() && !self.joint.axes.locked[i] {
                self.impulses[i] = 0.0;
            }
        }
        let impulses = self.impulses;
        self.push(shadows, &impulses);
        for (place, impulses) in drifts.into_iter().flatten() {
            for (side, i) in self.joint.shadows.into_iter().enumerate() {
                place.give(&mut shadows[i as usize], side, &impulses);
            }
        }
        // What a limit gave in the last substep may be wrong in this one, and nothing else shall answer it before it is seen.
        if self.at_limit.contains(&true) {
            self.solve(shadows, 0.0);
        }
    }

    /// Drifts back by these velocities. What drift there was goes where the joint has turned to: where the impulses of both act, and
    /// what they are. `alone` is the response of the rigid bodies alone.
    fn drift_on(&mut self, alone: Mat6, velocities: Vec6) -> Option<[(Place, Vec6); 2]> {
        let factors = factors(alone, self.joint.axes.locked)?;
        let drift = Drift {
            place: self.place,
            velocities,
            impulses: factors.solve(&velocities),
        };
        self.drifts = Some(drift);
        let last = self.drift?;
        let now = factors.solve(&last.velocities);
        Some([(last.place, last.impulses), (self.place, -now)])
    }

    /// How fast what was open is closed \[1/s\].
    fn closing(&self) -> f64 {
        if self.joint.closes { CLOSING } else { 0.0 }
    }

    /// Ends a substep of h s, however often its rows were started and solved.
    pub(super) fn end(&mut self, h: f64) {
        self.drift = self.drifts;
        self.left *= (-self.closing() * h).exp();
    }

    /// Back to where nothing is known of a substep before.
    pub(super) fn restart(&mut self) {
        self.impulses = Vec6::zeros();
        self.left = self.joint.open;
        (self.drift, self.drifts) = (None, None);
    }

    /// The axis with what drives it in a substep of h s, if anything does.
    fn drive(&self, i: usize, sides: [&Shadow; 2], h: f64) -> Option<Driven> {
        let motor = self.joint.axes.motors[i].as_ref();
        let Axes {
            locked,
            limits,
            drag,
            ..
        } = &self.joint.axes;
        if locked[i] || (motor.is_none() && limits[i].is_none() && drag[i] == 0.0) {
            return None;
        }
        let off = motor.map_or(0.0, |m| self.place.off(i, m.place));
        let mut drive = Drive::new(motor, off, h, self.joint.axes.solver_step);
        drive.damp(drag[i], h);
        if let Some(limits) = limits[i] {
            drive.limit(self.place.room(i, limits), h);
        }
        let mut impulses = Vec6::zeros();
        if let Some(factors) = &self.factors {
            let moved = self.place.unit_motions(sides, i);
            for k in (0..6).filter(|k| self.joint.axes.locked[*k]) {
                impulses[k] = -self.place.along(k, &moved);
            }
            factors.solve_mut(&mut impulses);
        }
        impulses[i] = 1.0;
        let response = self.place.along(i, &self.place.motions(sides, &impulses));
        if let Some(motor) = motor {
            let alone = self.place.along(i, &self.place.unit_motions(sides, i));
            let (sweeps, step) = (self.joint.axes.sweeps, self.joint.axes.solver_step);
            drive.give_way(motor, [alone, response], sweeps, h, step);
        }
        Some(Driven {
            drive,
            impulses,
            response,
        })
    }

    /// One visit of a pass; whether it was not settled yet.
    pub(super) fn solve(&mut self, shadows: &mut [Shadow], tolerance: f64) -> bool {
        let mut change = Vec6::zeros();
        if let Some(factors) = &self.factors {
            let motions = self.velocities(shadows);
            let given = self.is_soft().then(|| self.softness * self.impulses);
            for i in (0..6).filter(|i| self.joint.axes.locked[*i]) {
                change[i] = self.bias[i] - self.place.along(i, &motions);
                change[i] -= given.map_or(0.0, |given| given[i]);
            }
            factors.solve_mut(&mut change);
            self.push(shadows, &change);
        }
        for i in 0..6 {
            let Some(driven) = &self.driven[i] else {
                continue;
            };
            let velocity = self.place.along(i, &self.velocities(shadows));
            let before = self.impulses[i];
            let (impulse, at_limit) = driven.drive.impulse(before, velocity, driven.response);
            let more = driven.impulses * (impulse - before);
            self.at_limit[i] = at_limit;
            self.push(shadows, &more);
            change += more;
        }
        self.impulses += change;
        change.norm() > tolerance * self.impulses.norm()
    }

    fn velocities(&self, shadows: &[Shadow]) -> Motions {
        self.joint.shadows.map(|i| {
            let shadow = &shadows[i as usize];
            (shadow.v, shadow.w)
        })
    }

    fn push(&self, shadows: &mut [Shadow], impulses: &Vec6) {
        for side in 0..2 {
            let shadow = &mut shadows[self.joint.shadows[side] as usize];
            self.place.give(shadow, side, impulses);
        }
    }
}

/// Two sides as they answer without what is tied to them.
fn alone(sides: [&Shadow; 2], known: [(DMat3, DMat3); 2]) -> [Shadow; 2] {
    [0, 1].map(|k| {
        let (inv_mass, inv_inertia) = known[k];
        Shadow {
            inv_mass,
            cross: None,
            inv_inertia,
            ..*sides[k]
        }
    })
}

/// Factors of the response of locked axes, which leave what is not locked as it is; `None` if nothing moves.
fn factors(mut response: Mat6, locked: [bool; 6]) -> Option<Cholesky<f64, Const<6>>> {
    let trace = response.trace();
    for i in 0..6 {
        response[(i, i)] += if locked[i] { FLOOR * trace } else { 1.0 };
    }
    (trace > 0.0).then(|| Cholesky::new(response)).flatten()
}
