//! How a body held by joints answers: from Rapier's own joints, once per rigid step.
//!
//! Bodies in joints obey M·a = f + Jᵀλ with J·a = −J̇·v, so one of them answers an impulse at itself by a 6 × 6 matrix
//! M⁻¹ − M⁻¹Jᵀ(JM⁻¹Jᵀ)⁻¹JM⁻¹ that couples pushes with turns: what hangs on a ball joint turns when it is pushed. A ratio per
//! axis can't say that, and a wrong guess pumps energy into what is attached on a long lever, because its nodes are put
//! back where the body really went. The constraints are taken in one after the other, each by an update of rank one; a
//! redundant one finds nothing left to do.
//!
//! Shadows keep most joints themselves, with their limits and motors. This is for bodies of which one has a soft joint with limits, one with
//! a limit of the turns about two axes together, or is a link of a multibody with more to it than joints have, which they can't.
//!
//! A rigid contact that presses counts as a joint too, and holds along the surface as long as it does not slide. That is
//! right while it lasts, which nobody knows beforehand. So where there are contacts, and where there are limits, motors or
//! soft joints, which are left out here, a measured ratio scales the answer.

mod bodies;
mod contacts;
mod joints;
#[cfg(test)]
mod tests;

use super::observe::{Surroundings, free_acceleration, inv_inertia};
use crate::math::{DMat3, DVec3, Vector, wide};
use bodies::Linkage;
use rapier3d::dynamics::{RigidBody, RigidBodyHandle};

/// What a body does when pushed, turned and left alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mobility {
    /// Velocity by impulse \[1/kg\].
    pub inv_mass: DMat3,
    /// Velocity by angular impulse, and transposed, spin by impulse \[1/(kg·m)\].
    pub cross: DMat3,
    /// Spin by angular impulse \[1/(kg·m²)\].
    pub inv_inertia: DMat3,
    /// Acceleration by gravity, the user's forces and joints \[m/s²\].
    pub acceleration: DVec3,
    /// Angular acceleration likewise \[rad/s²\].
    pub spin_up: DVec3,
}

impl Mobility {
    /// Of a body that nothing holds.
    pub fn free(body: &RigidBody, gravity: Vector) -> Self {
        let (acceleration, spin_up) = free_acceleration(body, gravity);
        Self {
            inv_mass: DMat3::from_diagonal(wide(body.mass_properties().effective_inv_mass)),
            cross: DMat3::ZERO,
            inv_inertia: inv_inertia(body),
            acceleration,
            spin_up,
        }
    }

    /// Velocity and spin that an impulse and an angular impulse add to those of `dt` s.
    pub fn answer(&self, impulse: DVec3, torque: DVec3, dt: f64) -> (DVec3, DVec3) {
        (
            self.inv_mass * impulse + self.cross * torque + self.acceleration * dt,
            self.cross.transpose() * impulse + self.inv_inertia * torque + self.spin_up * dt,
        )
    }
}

/// How a body answers through its joints.
pub fn mobility(body: RigidBodyHandle, around: &Surroundings, dt: f64) -> Mobility {
    let mut linkage = Linkage::gather(body, around);
    for i in 0..linkage.bodies.len() {
        linkage.join(i, around, dt);
        linkage.press(i, around, dt);
    }
    let part = |i: usize| DVec3::from_slice(&linkage.acceleration[i..]);
    Mobility {
        inv_mass: linkage.block(0, 0),
        cross: linkage.block(0, 3),
        inv_inertia: linkage.block(3, 3),
        acceleration: part(0),
        spin_up: part(3),
    }
}
