//! Rigid bodies without joints that hold nodes and stand on something: they want shorter steps of Rapier than others.
//!
//! What is welded to a body moves with it, but Rapier, which stops the body at a contact, knows only the body's own mass. The nodes
//! follow at the end of the step, and are stopped as hard as the body was: too much, the heavier they are, and with the energy of the
//! step. In shorter steps there is less to stop.
//!
//! And what presses on the nodes presses the body into the ground for a whole step: Rapier's contacts give way like a damper c = 2ζω·m,
//! which is the weaker the lighter the body is, so springs k behind the nodes that the ground has pushed by x push back by k·Δt/c
//! times that. From twice on, the two throw each other.
//!
//! Joints are not always calmer in shorter steps.

use super::group::BodyKey;
use super::{AttachmentState, Deformable, DeformableWorld, RapierParts};
use crate::coupling::attach::Hold;
use crate::solve::Integrator;
use rapier3d::dynamics::{RigidBody, RigidBodyHandle, SpringCoefficients};
use std::collections::BTreeMap;

/// How many times as heavy as their body nodes may be for a step of usual length. On a plate of a ninth or an 18th of the mass
/// of the nodes welded to it a block on a floor shakes in steps of 1/240 s and not in half of that, on a 36th it needs a quarter,
/// on a 90th an eighth; one of finer cells half already where its nodes are 4.5 times as heavy.
const CALM: f64 = 3.0;
/// k·Δt/c at most, k being a bound that is about twice what it is in truth.
const PRESSED: f64 = 2.0;

/// The k/c from which on springs are stiff for the contact of a body that holds them \[1/s\]: it wants more than a step of usual length.
const STIFF: f64 = 240.0 * PRESSED;

/// What the nodes that a body holds are to it.
#[derive(Clone, Copy, Default)]
struct Load {
    /// Their mass \[kg\].
    held: f64,
    /// A bound of the stiffness behind them \[N/m\].
    stiffness: f64,
}

impl DeformableWorld {
    /// Into how many more steps Rapier's, of `dt` s, are to be cut.
    pub(super) fn finer_steps(&self, parts: &RapierParts, dt: f64) -> usize {
        let mut most = 1.0_f64;
        for ((index, generation), load) in self.loads(dt) {
            let handle = RigidBodyHandle::from_raw_parts(index, generation);
            if let Some(body) = parts.bodies.get(handle) {
                most = most.max(load.steps((handle, body), parts, dt));
            }
        }
        most.ceil() as usize
    }

    /// The rigid bodies that hold nodes, and whether the springs behind these are stiff for Rapier's contacts.
    pub(super) fn holding(&self, parts: &RapierParts, dt: f64) -> BTreeMap<BodyKey, bool> {
        let contact = parts.integration_parameters.static_contact_softness;
        let bonds = self.attachments.iter().filter(|(_, b)| !b.is_broken());
        let bodies = bonds.filter_map(|(_, b)| b.body());
        let mut holding: BTreeMap<_, _> = bodies.map(|b| (b.into_raw_parts(), false)).collect();
        for (key, load) in self.loads(dt) {
            let body = RigidBodyHandle::from_raw_parts(key.0, key.1);
            let body = parts.bodies.get(body);
            let is_stiff = body.is_some_and(|b| load.stiffness > STIFF * damper(&contact, b));
            holding.insert(key, is_stiff);
        }
        holding
    }

    /// What each rigid body holds, in steps of `dt` s.
    fn loads(&self, dt: f64) -> BTreeMap<BodyKey, Load> {
        let mut loads: BTreeMap<_, Load> = BTreeMap::new();
        for (_, bond) in self.attachments.iter() {
            let owner = self.get(bond.deformable).filter(|b| b.is_active());
            let (Some(owner), Some(body)) = (owner, bond.body()) else {
                continue;
            };
            if bond.is_broken() {
                continue;
            }
            let h = dt / owner.last_substeps(dt).max(1) as f64;
            let held = owner.mass_held(bond, f64::INFINITY);
            // A stable substep is no longer than √(m/k) or so, k being that of all springs of a node. Those of other schemes tell less.
            let stiff = match owner.integrator() {
                Integrator::SymplecticEuler => held / (h * h),
                _ => 0.0,
            };
            let (held_firmly, stiffness) = match bond.hold {
                // What a link can do within a step is as good as no more mass than this.
                Hold::Link { stiffness, .. } => {
                    let all = stiffness * bond.points.len() as f64;
                    (owner.mass_held(bond, stiffness * dt * dt), stiff.min(all))
                }
                _ => (held, stiff),
            };
            let load = loads.entry(body.into_raw_parts()).or_default();
            load.held += held_firmly;
            load.stiffness += stiffness;
        }
        loads
    }
}

impl Deformable {
    /// The mass of the free nodes of an attachment of it, each counted up to so much \[kg\].
    fn mass_held(&self, bond: &AttachmentState, most: f64) -> f64 {
        let mass = |&n: &u32| {
            let free = self.state.particles[n as usize].inv_mass > 0.0;
            free.then(|| f64::from(self.blueprint.nodes[n as usize].mass).min(most))
        };
        bond.nodes.iter().filter_map(mass).sum()
    }
}

impl Load {
    /// Into how many more steps of `dt` s its body wants them cut \[1\].
    fn steps(
        &self,
        (handle, body): (RigidBodyHandle, &RigidBody),
        parts: &RapierParts,
        dt: f64,
    ) -> f64 {
        let mass = f64::from(body.mass());
        // What has no mass does not move.
        if mass == 0.0 || !body.is_dynamic() || body.is_sleeping() || !body.is_enabled() {
            return 0.0;
        }
        let mut joints = parts.impulse_joints.attached_joints(handle);
        let is_link = parts.multibody_joints.rigid_body_link(handle).is_some();
        if joints.next().is_some() || is_link {
            return 0.0;
        }
        softest_contact(body, parts).map_or(0.0, |contact| {
            let pressed = self.stiffness * dt / damper(&contact, body) / PRESSED;
            pressed.max(self.held / mass / CALM)
        })
    }
}

/// The constant of the damper that Rapier's contacts of a body are \[N·s/m\].
fn damper(contact: &SpringCoefficients<f32>, body: &RigidBody) -> f64 {
    f64::from(2.0 * contact.damping_ratio * contact.angular_frequency() * body.mass())
}

/// The softest of Rapier's contacts that a body has or is about to have.
pub(super) fn softest_contact(
    body: &RigidBody,
    parts: &RapierParts,
) -> Option<SpringCoefficients<f32>> {
    let parameters = parts.integration_parameters;
    let own = |collider| {
        let pairs = parts.narrow_phase.contact_pairs_with(collider);
        pairs.map(move |pair| {
            if pair.collider1 == collider {
                pair.collider2
            } else {
                pair.collider1
            }
        })
    };
    let softness = |other| {
        let other = parts.colliders.get(other).and_then(|c| c.parent());
        let moves = other
            .and_then(|b| parts.bodies.get(b))
            .is_some_and(RigidBody::is_dynamic);
        if moves {
            parameters.contact_softness
        } else {
            parameters.static_contact_softness
        }
    };
    let all = body
        .colliders()
        .iter()
        .flat_map(|&collider| own(collider))
        .map(softness);
    all.min_by(|a, b| {
        let rate = |c: &SpringCoefficients<f32>| c.damping_ratio * c.natural_frequency;
        rate(a).total_cmp(&rate(b))
    })
}
