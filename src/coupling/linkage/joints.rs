//! Constraints of Rapier's joints.

use super::bodies::Linkage;
use crate::contact::target::wide_rotation;
use crate::coupling::constraints::is_soft;
use crate::coupling::observe::{Surroundings, velocity};
use crate::math::{DQuat, DVec3, wide};
use rapier3d::dynamics::{GenericJoint, RigidBody};
use rapier3d::math::Pose;

/// How far ahead the constraints are looked at for J̇·v \[s\].
const AHEAD: f64 = 1e-5;

/// A pose about the centre of mass, and its rates.
#[derive(Clone, Copy)]
pub(super) struct Motion {
    com: DVec3,
    rot: DQuat,
    /// From the centre of mass to the body's origin, in its axes.
    origin: DVec3,
    v: DVec3,
    w: DVec3,
}

impl Motion {
    pub(super) const STILL: Self = Self {
        com: DVec3::ZERO,
        rot: DQuat::IDENTITY,
        origin: DVec3::ZERO,
        v: DVec3::ZERO,
        w: DVec3::ZERO,
    };

    pub(super) fn of(body: &RigidBody, dt: f64) -> Self {
        let pose = body.position();
        let rot = wide_rotation(pose.rotation);
        let origin = -wide(body.local_center_of_mass());
        let (v, w) = velocity(body, dt);
        Self {
            com: wide(pose.translation) - rot * origin,
            rot,
            origin,
            v,
            w,
        }
    }

    fn after(self, t: f64) -> Self {
        Self {
            com: self.com + self.v * t,
            rot: DQuat::from_scaled_axis(self.w * t) * self.rot,
            ..self
        }
    }

    fn frame(&self, local: &Pose) -> (DVec3, DQuat) {
        let at = self.com + self.rot * (self.origin + wide(local.translation));
        (at, self.rot * wide_rotation(local.rotation))
    }
}

/// What a constraint takes of the velocities and spins of its two bodies.
pub(super) type Jacobian = [DVec3; 4];

/// The locked axes of a joint. What is free about a joint with a locked rotation are whole axes of its first frame.
fn jacobians(joint: &GenericJoint, one: &Motion, two: &Motion) -> Vec<Jacobian> {
    let (_, turn) = one.frame(&joint.local_frame1);
    let (at, _) = two.frame(&joint.local_frame2);
    let locked = joint.locked_axes.bits();
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| turn * a);
    let mut rows = Vec::with_capacity(6);
    for (i, axis) in axes.into_iter().enumerate() {
        if locked & (1 << i) != 0 {
            let arms = [(at - one.com).cross(axis), (at - two.com).cross(axis)];
            rows.push([-axis, -arms[0], axis, arms[1]]);
        }
    }
    for (i, axis) in axes.into_iter().enumerate() {
        if locked & (1 << (3 + i)) != 0 {
            rows.push([DVec3::ZERO, -axis, DVec3::ZERO, axis]);
        }
    }
    rows
}

/// How fast the constraint is violated.
pub(super) fn rate(row: &Jacobian, one: &Motion, two: &Motion) -> f64 {
    row[0].dot(one.v) + row[1].dot(one.w) + row[2].dot(two.v) + row[3].dot(two.w)
}

impl Linkage {
    /// Takes in the joints of a body with those before it and with what does not move.
    pub(super) fn join(&mut self, index: usize, around: &Surroundings, dt: f64) {
        let own = self.bodies[index];
        for (a, b, _, joint) in around.joints_of(own) {
            let other = if a == own { b } else { a };
            let partner = self.index(other);
            let dynamic = around.bodies.get(other).is_some_and(|b| b.is_dynamic());
            if partner.is_some_and(|p| p > index) || (partner.is_none() && dynamic) {
                continue;
            }
            let data = &joint.data;
            if is_soft(data, dt) {
                continue;
            }
            let (a, b) = (joint.body1(), joint.body2());
            let (Some(one), Some(two)) = (around.bodies.get(a), around.bodies.get(b)) else {
                continue;
            };
            let (one, two) = (Motion::of(one, dt), Motion::of(two, dt));
            let ahead = (one.after(AHEAD), two.after(AHEAD));
            let rows = jacobians(data, &one, &two);
            let later = jacobians(data, &ahead.0, &ahead.1);
            for (row, later) in rows.iter().zip(&later) {
                let now = rate(row, &one, &two);
                let bending = (rate(later, &one, &two) - now) / AHEAD;
                self.hold(row, [self.index(a), self.index(b)], now / dt + bending);
            }
        }
    }
}
