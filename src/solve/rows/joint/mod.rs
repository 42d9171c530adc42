//! Joints between shadows.
//!
//! What hangs on a joint feels what pushes its partner. All locked axes of a joint are solved at once, because at the end
//! of a long lever each of them alone undoes what the others did. An axis with limits or a motor gets its impulse together
//! with what that takes of the locked ones, for the same reason: the stop of a flap answers with the inertia about its hinge.

mod place;

use crate::law::joint::{Axes, Drive};
use crate::math::na::{Cholesky, Const, SMatrix, SVector};
use crate::math::{DQuat, DVec3};
use crate::solve::shadow::Shadow;
use place::Place;

/// How much of a joint's opening is taken back in a substep.
const PULL_BACK: f64 = 0.2;
/// What keeps directions in which nothing moves from dividing by zero.
const FLOOR: f64 = 1e-9;

type Vec6 = SVector<f64, 6>;
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
    /// How far the joint is open along locked axes at the start of the rigid step \[m\]: for Rapier to mend.
    pub open: DVec3,
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
    /// Velocity that takes back what has opened \[m/s\].
    bias: Vec6,
    /// Factors of the response of the locked axes to their impulses; `None` if nothing moves.
    factors: Option<Cholesky<f64, Const<6>>>,
    /// Axes with limits or motors.
    driven: [Option<Driven>; 6],
    /// Which of them were at a limit in the last visit.
    at_limit: [bool; 6],
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
            place: Place::of(&joint, sides),
            ..Self::default()
        };
        for i in (0..6).filter(|i| per_mass[*i]) {
            let response = row.place.along(i, &row.unit_motions(sides, i));
            let motor = row.joint.axes.motors[i].as_mut();
            if let Some(motor) = motor.filter(|_| response > 0.0) {
                motor.stiffness /= response;
                motor.damping /= response;
            }
        }
        row
    }

    /// Whether a motor drives it.
    pub fn has_motor(&self) -> bool {
        self.joint.axes.motors.iter().any(Option::is_some)
    }

    /// Finds the axes at the start of a substep of h s, and lets the shadows take the impulses of the last one.
    pub(super) fn start(&mut self, shadows: &mut [Shadow], h: f64) {
        let sides = self.joint.shadows.map(|i| &shadows[i as usize]);
        self.place = Place::of(&self.joint, sides);
        let mut response = SMatrix::<f64, 6, 6>::zeros();
        for i in 0..6 {
            self.bias[i] = 0.0;
            if !self.joint.axes.locked[i] {
                response[(i, i)] = 1.0;
                continue;
            }
            if i < 3 {
                let opened = self.place.displacement(i) - self.joint.open[i];
                self.bias[i] = -PULL_BACK * opened / h;
            }
            let moved = self.unit_motions(sides, i);
            for k in (0..6).filter(|k| self.joint.axes.locked[*k]) {
                response[(k, i)] = self.place.along(k, &moved);
            }
        }
        let trace: f64 = (0..6)
            .filter(|i| self.joint.axes.locked[*i])
            .map(|i| response[(i, i)])
            .sum();
        for i in (0..6).filter(|i| self.joint.axes.locked[*i]) {
            response[(i, i)] += FLOOR * trace;
        }
        self.factors = (trace > 0.0).then(|| Cholesky::new(response)).flatten();
        for i in 0..6 {
            self.driven[i] = self.drive(i, sides, h);
            if self.driven[i].is_none() && !self.joint.axes.locked[i] {
                self.impulses[i] = 0.0;
            }
        }
        let impulses = self.impulses;
        self.push(shadows, &impulses);
        // What a limit gave in the last substep may be wrong in this one, and nothing else shall answer it before it is seen.
        if self.at_limit.contains(&true) {
            self.solve(shadows, 0.0);
        }
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
            let moved = self.unit_motions(sides, i);
            for k in (0..6).filter(|k| self.joint.axes.locked[*k]) {
                impulses[k] = -self.place.along(k, &moved);
            }
            factors.solve_mut(&mut impulses);
        }
        impulses[i] = 1.0;
        let response = self.place.along(i, &self.motions(sides, &impulses));
        if let Some(motor) = motor {
            let alone = self.place.along(i, &self.unit_motions(sides, i));
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
            for i in (0..6).filter(|i| self.joint.axes.locked[*i]) {
                change[i] = self.bias[i] - self.place.along(i, &motions);
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

    fn unit_motions(&self, sides: [&Shadow; 2], i: usize) -> Motions {
        let mut unit = Vec6::zeros();
        unit[i] = 1.0;
        self.motions(sides, &unit)
    }

    /// The motions that impulses give to both sides.
    fn motions(&self, sides: [&Shadow; 2], impulses: &Vec6) -> Motions {
        [0, 1].map(|side| {
            let mut still = Shadow {
                v: DVec3::ZERO,
                w: DVec3::ZERO,
                ..*sides[side]
            };
            self.place.give(&mut still, side, impulses);
            (still.v, still.w)
        })
    }

    fn push(&self, shadows: &mut [Shadow], impulses: &Vec6) {
        for side in 0..2 {
            let shadow = &mut shadows[self.joint.shadows[side] as usize];
            self.place.give(shadow, side, impulses);
        }
    }
}
