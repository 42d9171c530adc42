//! How Rapier turns a free body in a step, computed ahead: in substeps, the gyroscopic torque explicit and capped to conserve the
//! size of the angular momentum, the rotation linearised, and no more than an eighth of a turn in all unless that is allowed.

use super::observe::substeps;
use crate::contact::target::wide_rotation;
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
        let inertia = wide(props.principal_inertia());
        let gyroscopic = body.gyroscopic_forces_enabled() && inertia.min_element() > 0.0;
        Self {
            start: wide_rotation(*body.rotation()),
            frame: wide_rotation(props.principal_inertia_local_frame),
            inertia: gyroscopic.then_some(inertia),
            spin_up: spin_up * h,
            fastest: fastest_spin(body, dt),
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
        let mut w = from.clamp_length_max(self.fastest);
        let mut best = (f64::INFINITY, w);
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

/// The fastest that Rapier turns a body in one of its steps, of `dt` s \[rad/s\].
pub fn fastest_spin(body: &RigidBody, dt: f64) -> f64 {
    if body.is_fast_rotation_allowed() {
        f64::INFINITY
    } else {
        FRAC_PI_4 / dt
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coupling::observe::free_acceleration;
    use crate::math::Vector;
    use rapier3d::dynamics::RigidBodyBuilder;
    use rapier3d::geometry::ColliderBuilder;
    use rapier3d::pipeline::PhysicsWorld;

    /// Rods, plates and bricks, with gyroscopic torque and without, damped, driven by a torque, faster than Rapier lets them be.
    #[test]
    fn rapier_turns_bodies_as_foretold() {
        let shapes = [
            ColliderBuilder::capsule_y(0.25, 0.02),
            ColliderBuilder::cylinder(0.01, 0.2),
            ColliderBuilder::cuboid(0.3, 0.1, 0.05).rotation(Vector::new(0.3, 0.2, 0.5)),
        ];
        let spins = [Vector::new(3.0, 1.0, -2.0), Vector::new(60.0, -20.0, 150.0)];
        for (shape, w) in shapes.iter().flat_map(|s| spins.map(|w| (s, w))) {
            for (gyroscopic, fast, damping) in [
                (true, false, 0.0),
                (true, true, 0.3),
                (false, false, 0.0),
                (false, true, 0.3),
            ] {
                let mut world = PhysicsWorld::default();
                world.integration_parameters.dt = 1.0 / 240.0;
                let builder = RigidBodyBuilder::dynamic()
                    .rotation(Vector::new(0.4, -0.3, 0.8))
                    .angvel(w)
                    .angular_damping(damping)
                    .allow_fast_rotation(fast);
                let (handle, _) = world.insert(builder, shape.clone().mass(2.0));
                world.bodies[handle].enable_gyroscopic_forces(gyroscopic);
                world.step();
                world.bodies[handle].add_torque(Vector::new(0.1, 0.2, -0.3), true);
                let body = &world.bodies[handle];
                let (_, spin_up) = free_acceleration(body, Vector::ZERO);
                let dt = f64::from(world.integration_parameters.dt);
                let flight = Flight::new(body, spin_up, &world.integration_parameters, dt);
                let (rot, spin) = flight.end(wide(body.angvel()));
                world.step();
                let body = &world.bodies[handle];
                let off = rotation_vector(rot * wide_rotation(*body.rotation()).inverse());
                assert!(off.length() < 1e-5, "{w}, {gyroscopic}, {fast}: {off}");
                let off = spin - wide(body.angvel());
                assert!(
                    off.length() < 1e-4 * (1.0 + spin.length()),
                    "{w}, {gyroscopic}, {fast}: {off}"
                );
            }
        }
    }

    #[test]
    fn the_spin_that_is_found_leads_to_the_orientation() {
        let mut world = PhysicsWorld::default();
        let shape = ColliderBuilder::cuboid(0.3, 0.1, 0.05).mass(2.0);
        let (handle, _) = world.insert(RigidBodyBuilder::dynamic(), shape);
        world.step();
        let body = &world.bodies[handle];
        let dt = 1.0 / 240.0;
        let flight = Flight::new(body, DVec3::ZERO, &world.integration_parameters, dt);
        for w in [DVec3::new(3.0, 1.0, -2.0), DVec3::new(40.0, -20.0, 60.0)] {
            let (end, _) = flight.end(w);
            let found = flight.spin_to(end, DVec3::new(1.0, 2.0, 3.0));
            assert!((found - w).length() < 1e-6 * w.length(), "{found}, {w}");
        }
        // Half a turn is more than Rapier makes in a step.
        let half = DQuat::from_rotation_x(3.0);
        assert!(flight.spin_to(half, DVec3::ZERO).length() <= flight.fastest * (1.0 + 1e-9));
    }
}
