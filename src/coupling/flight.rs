//! How Rapier turns a free body in a step, computed ahead: in substeps, the gyroscopic torque explicit and capped to conserve the
//! size of the angular momentum, the rotation linearised, and no more than an eighth of a turn in all unless that is allowed.

use super::observe::substeps;
use crate::math::{DQuat, DVec3, wide};
use rapier3d::dynamics::{IntegrationParameters, RigidBody};
use std::f64::consts::FRAC_PI_4;

/// How often the spin is corrected that leads to an orientation, and the angle that is near enough \[rad\].
const TRIES: usize = 12;
const NEAR: f64 = 1e-9;

/// A step of a body that nothing touches.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// Its orientation before.
    pub start: DQuat,
    /// From its principal axes to its own.
    frame: DQuat,
    /// Its principal moments \[kg·m²\]; `None` without gyroscopic torque.
    inertia: Option<DVec3>,
    /// What torques add in a substep \[rad/s\].
    spin_up: DVec3,
    /// The fastest spin there is \[rad/s\].
    fastest: f64,
    /// Angular damping over the step \[1\].
    damping: f64,
    /// How many substeps it has, of h s.
    count: usize,
    h: f64,
}

impl Flight {
    /// Of a body that torques make faster by `spin_up` rad/s², in a step of `dt` s.
    pub fn new(
        body: &RigidBody,
        spin_up: DVec3,
        parameters: &IntegrationParameters,
        dt: f64,
    ) -> Self {
        let props = &body.mass_properties().local_mprops;
        let count = substeps(body, parameters);
        let h = dt / count as f64;
        let wide_rotation = crate::contact::target::wide_rotation;
        let inertia = wide(props.principal_inertia());
        let gyroscopic = body.gyroscopic_forces_enabled() && inertia.min_element() > 0.0;
        Self {
            start: wide_rotation(*body.rotation()),
            frame: wide_rotation(props.principal_inertia_local_frame),
            inertia: gyroscopic.then_some(inertia),
            spin_up: spin_up * h,
            fastest: if body.is_fast_rotation_allowed() {
                f64::INFINITY
            } else {
                FRAC_PI_4 / dt
            },
            damping: 1.0 / (1.0 + dt * f64::from(body.angular_damping())),
            count,
            h,
        }
    }

    /// Orientation and spin after it for a spin \[rad/s\] before.
    pub fn end(&self, mut w: DVec3) -> (DQuat, DVec3) {
        let mut rot = self.start;
        for _ in 0..self.count {
            w += self.spin_up;
            if let Some(inertia) = self.inertia {
                w = gyroscopic(w, rot * self.frame, inertia, self.h);
            }
            w = w.clamp_length_max(self.fastest);
            let half = w * (0.5 * self.h);
            rot = (DQuat::from_xyzw(half.x, half.y, half.z, 1.0) * rot).normalize();
        }
        (rot, w * self.damping)
    }

    /// The spin before it with which it ends in an orientation, sought from one that does not lead far from it; what comes nearest
    /// where none does \[rad/s\].
    pub fn spin_to(&self, end: DQuat, from: DVec3) -> DVec3 {
        let dt = self.h * self.count as f64;
        let (mut w, mut best) = (from, (f64::INFINITY, from));
        for _ in 0..TRIES {
            let off = rotation_vector(end * self.end(w).0.inverse());
            let angle = off.length();
            if angle < best.0 {
                best = (angle, w);
            }
            if angle < NEAR || angle.is_nan() {
                break;
            }
            w = (w + off / dt).clamp_length_max(self.fastest);
        }
        best.1
    }
}

/// The axis times the angle of a rotation, no more than half a turn \[rad\].
pub fn rotation_vector(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    q.to_scaled_axis()
}

/// The spin \[rad/s\] after a substep of h s of the gyroscopic torque, for a body with these principal axes and moments.
fn gyroscopic(w: DVec3, axes: DQuat, inertia: DVec3, h: f64) -> DVec3 {
    let own = axes.inverse() * w;
    let momentum = inertia * own;
    let after = momentum - own.cross(momentum) * h;
    let square = after.length_squared();
    if square == 0.0 {
        return w;
    }
    let kept = after * (momentum.length_squared() / square).sqrt();
    axes * (kept / inertia)
}
