//! Rigid bodies that carry heavier nodes.
//!
//! What is welded to a body moves with it, but Rapier, which stops the body at a contact, knows only the body's own mass. The
//! nodes follow at the end of the step, and are stopped as hard as the body was: too much, the heavier they are, and with the
//! energy of the step. In shorter steps there is less to stop. Joints are no calmer by that.

use super::{DeformableWorld, RapierParts};
use crate::coupling::attach::Hold;
use rapier3d::dynamics::{RigidBody, RigidBodyHandle};
use std::collections::BTreeMap;

/// How many times as heavy as their body nodes may be for a step of usual length. On a plate of a ninth or an 18th of the mass
/// of the nodes welded to it a block on a floor shakes in steps of 1/240 s and not in half of that, on a 36th it needs a quarter,
/// on a 90th an eighth; one of finer cells half already where its nodes are 4.5 times as heavy.
const CALM: f64 = 3.0;

impl DeformableWorld {
    /// Into how many more steps Rapier's, of `dt` s, are to be cut.
    pub(super) fn finer_steps(&self, parts: &RapierParts, dt: f64) -> usize {
        let mut loads: BTreeMap<(u32, u32), f64> = BTreeMap::new();
        for (_, bond) in self.attachments.iter() {
            let owner = self.get(bond.deformable).filter(|b| b.is_active());
            let (Some(owner), Some(body)) = (owner, bond.body()) else {
                continue;
            };
            if bond.is_broken() {
                continue;
            }
            // What a link can do within a step is as good as no more mass than this.
            let most = match bond.hold {
                Hold::Link { stiffness, .. } => stiffness * dt * dt,
                _ => f64::INFINITY,
            };
            let masses = bond.nodes.iter().filter_map(|&n| {
                let free = owner.state.particles[n as usize].inv_mass > 0.0;
                free.then(|| f64::from(owner.blueprint.nodes[n as usize].mass).min(most))
            });
            *loads.entry(body.into_raw_parts()).or_default() += masses.sum::<f64>();
        }
        let most = loads.into_iter().filter_map(|((index, generation), load)| {
            let handle = RigidBodyHandle::from_raw_parts(index, generation);
            let body = parts.bodies.get(handle)?;
            // What has no mass does not move.
            let mass = f64::from(body.mass());
            let ratio = if mass > 0.0 { load / mass } else { 0.0 };
            (ratio > CALM && is_stopped(handle, body, parts)).then_some(ratio)
        });
        (most.fold(0.0, f64::max) / CALM).ceil().max(1.0) as usize
    }
}

/// Whether a body that has no joints touches another one.
fn is_stopped(handle: RigidBodyHandle, body: &RigidBody, parts: &RapierParts) -> bool {
    if !body.is_dynamic() || body.is_sleeping() || !body.is_enabled() {
        return false;
    }
    let touches = |&collider: &_| {
        let mut pairs = parts.narrow_phase.contact_pairs_with(collider);
        pairs.any(|pair| pair.has_any_active_contact())
    };
    let mut joints = parts.impulse_joints.attached_joints(handle);
    let is_link = parts.multibody_joints.rigid_body_link(handle).is_some();
    joints.next().is_none() && !is_link && body.colliders().iter().any(touches)
}
