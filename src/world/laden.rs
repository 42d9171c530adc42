//! Rigid bodies that hold nodes and stand on something or hang on joints: they want shorter steps of Rapier than others.
//!
//! What is welded to a body moves with it, but Rapier, which stops the body at a contact, knows only the body's own mass. The nodes
//! follow at the end of the step, and are stopped as hard as the body was: too much, the heavier they are, and with the energy of the
//! step. In shorter steps there is less to stop.
//!
//! And what presses on the nodes presses the body into the ground for a whole step: Rapier's contacts give way like a damper c = 2ζω·m,
//! which is the weaker the lighter the body is, so springs k behind the nodes that the ground has pushed by x push back by k·Δt/c
//! times that. From twice on, the two throw each other.
//!
//! Joints Rapier leaves in error by what its iterations do not get to, and where that takes a body it would take the nodes: springs that
//! swing several times within a step push it back before Rapier sees them again.

use super::group::{BodyKey, handle_of};
use super::{AttachmentState, Deformable, DeformableWorld, RapierParts};
use crate::coupling::attach::Hold;
use crate::solve::Integrator;
use rapier3d::dynamics::{RigidBody, RigidBodyHandle, SpringCoefficients};
use rapier3d::geometry::{Collider, ContactPair};
use rapier3d::parry::bounding_volume::BoundingVolume;
use std::collections::{BTreeMap, BTreeSet};

/// How many times as heavy as their body nodes may be for a step of usual length. On a plate of a ninth or an 18th of the mass
/// of the nodes welded to it a block on a floor shakes in steps of 1/240 s and not in half of that, on a 36th it needs a quarter,
/// on a 90th an eighth; one of finer cells half already where its nodes are 4.5 times as heavy.
const CALM: f64 = 3.0;
/// k·Δt/c at most, k being a bound that is about twice what it is in truth.
const PRESSED: f64 = 2.0;

/// The k/c from which on springs are stiff for the contact of a body that holds them \[1/s\]: it wants more than a step of usual length.
/// Of swift ones, see [`SWIFT`], a quarter is enough: undamped steel foam on 500 kg got 17 kJ in 5 s at 393/s, `car_body` on 50 kg 0.7 J at
/// 215/s.
const STIFF: f64 = 240.0 * PRESSED;

/// The ω·Δt from which on springs are stiff for the joints of a body that holds them, ω being the highest frequency there is, and
/// which the body's own on all of them has at most in shorter steps. Under a car of 876 kg four carriers of 20 kg with feet of
/// 20 kg on fixed joints made 1.8 kJ a second at 15.6, 0.4 kJ at 7.8 and nothing at 3.5; a block of rubber on a chain of light links
/// exploded at 4.9 as it was with a value of 5 here; one of 77 kg on wheels is calm at 4.3.
const SWIFT: f64 = 4.5;

/// The ω·Δt of a link of a multibody on the springs behind its nodes, at most: it feels them as one force over the step. An arm
/// that three motors hold, of links of 1.27 kg with a block of 2 MPa, was heated by 17 W at 4.7, by 45 at 5.8, and not at all at
/// 1.2; links of 0.5 kg by 309 W.
const LINKED: f64 = 1.2;

/// 1/h² of substeps at most, over the square of the highest frequency that springs alone would have: 0.3 is that of undamped ones, and
/// a damper that asks for 160 times as much as these is no stiffer for a step of Rapier's. With 0.3 at most a damped block that swings
/// on a soft hinge of 20 Hz took up 25 J of 25 J \[1\].
const DAMPED: f64 = 2.0;

/// How near a collider is that a body is about to touch, besides what the two go in a step, in length units.
const NEAR: f32 = 0.01;

/// What the nodes that a body holds are to it.
#[derive(Clone, Copy, Default)]
struct Load {
    /// Their mass \[kg\].
    held: f64,
    /// A bound of the stiffness behind them \[N/m\].
    stiffness: f64,
    /// A bound of the highest frequency behind them \[1/s\].
    swings: f64,
}

/// The rigid bodies that hold nodes.
#[derive(Debug, Default)]
pub(super) struct Held {
    /// All.
    nodes: BTreeSet<BodyKey>,
    /// Those that hold them stiffly, and all that hang together with one of these by joints.
    stiffly: BTreeSet<BodyKey>,
}

impl Held {
    /// Whether a body holds nodes.
    pub fn holds(&self, body: RigidBodyHandle) -> bool {
        self.nodes.contains(&body.into_raw_parts())
    }

    /// Whether springs behind nodes are stiff for it.
    pub fn is_stiff(&self, body: RigidBodyHandle) -> bool {
        self.stiffly.contains(&body.into_raw_parts())
    }
}

impl DeformableWorld {
    /// Into how many more steps Rapier's, of `dt` s, are to be cut.
    pub(super) fn finer_steps(&self, parts: &RapierParts, dt: f64) -> usize {
        let mut most = 1.0_f64;
        for (key, load) in self.loads(dt) {
            let handle = handle_of(key);
            if let Some(body) = parts.bodies.get(handle) {
                most = most.max(load.steps((handle, body), parts, dt));
            }
        }
        most.ceil() as usize
    }

    /// The rigid bodies that hold nodes, with those that did so stiffly when the step began.
    pub(super) fn held(&mut self) -> Held {
        let bonds = self.attachments.iter().filter(|(_, b)| !b.is_broken());
        let bodies = bonds.filter_map(|(_, b)| b.body());
        Held {
            nodes: bodies.map(RigidBodyHandle::into_raw_parts).collect(),
            stiffly: std::mem::take(&mut self.stiffly),
        }
    }

    /// The rigid bodies that hold nodes stiffly, see [`STIFF`] and [`SWIFT`], in a step of `dt` s that is `usual` s long or a part of
    /// such, and all that hang together with one of these by joints.
    pub(super) fn find_stiffly_held(
        &self,
        parts: &RapierParts,
        dt: f64,
        usual: f64,
    ) -> BTreeSet<BodyKey> {
        let is_stiff = |(key, load): &(BodyKey, Load)| {
            let handle = handle_of(*key);
            parts
                .moving(handle)
                .is_some_and(|body| load.is_stiff((handle, body), parts, usual))
        };
        let stiff = self.loads(dt).into_iter().filter(is_stiff);
        let mut found: BTreeSet<BodyKey> = stiff.map(|(key, _)| key).collect();
        let mut next: Vec<BodyKey> = found.iter().copied().collect();
        while let Some(key) = next.pop() {
            let joints = parts.joints_of(handle_of(key));
            let others = joints.flat_map(|(first, second, ..)| [first, second]);
            let others = others.filter(|other| parts.moving(*other).is_some());
            let others = others.map(RigidBodyHandle::into_raw_parts);
            next.extend(others.filter(|key| found.insert(*key)));
        }
        found
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
            // Not the one that finer steps have cut: they would ask for still finer ones.
            let h = owner.own_substep(dt);
            let held = owner.mass_held(bond, f64::INFINITY);
            // What is pinned bears the body, and does not swing with it.
            if held == 0.0 {
                continue;
            }
            // A stable substep is no longer than √(m/k) or so, k being that of all springs of a node, and far shorter where it is for their
            // damping. Those of other schemes tell less.
            let stiffest = owner.solver.stiffest.max(0.0);
            let stiff = match owner.integrator() {
                Integrator::SymplecticEuler => held * (1.0 / (h * h)).min(DAMPED * stiffest),
                _ => 0.0,
            };
            let swings = stiffest.sqrt();
            let (held_firmly, stiffness, swings) = match bond.hold {
                // What a link can do within a step is as good as no more mass than this.
                Hold::Link { stiffness, .. } => {
                    let all = stiffness * bond.points.len() as f64;
                    let firmly = owner.mass_held(bond, stiffness * dt * dt);
                    let lightest = owner.free_masses(bond).fold(held, f64::min);
                    let swings = swings.min((stiffness / lightest).sqrt());
                    (firmly, stiff.min(all), swings)
                }
                _ => (held, stiff, swings),
            };
            let load = loads.entry(body.into_raw_parts()).or_default();
            load.held += held_firmly;
            load.stiffness += stiffness;
            load.swings = load.swings.max(swings);
        }
        loads
    }
}

impl Deformable {
    /// The mass of the free nodes of an attachment of it, each counted up to so much \[kg\].
    fn mass_held(&self, bond: &AttachmentState, most: f64) -> f64 {
        self.free_masses(bond).map(|mass| mass.min(most)).sum()
    }

    fn free_masses(&self, bond: &AttachmentState) -> impl Iterator<Item = f64> {
        let free = |n: &&u32| self.state.particles[**n as usize].inv_mass > 0.0;
        let nodes = bond.nodes.iter().filter(free);
        nodes.map(|&n| f64::from(self.blueprint.nodes[n as usize].mass))
    }
}

impl Load {
    /// Into how many more steps of `dt` s its body wants them cut \[1\].
    fn steps(&self, body: (RigidBodyHandle, &RigidBody), parts: &RapierParts, dt: f64) -> f64 {
        let (handle, body) = body;
        let mass = f64::from(body.mass());
        // What has no mass does not move.
        if mass == 0.0 || !body.is_dynamic() || body.is_sleeping() || !body.is_enabled() {
            return 0.0;
        }
        let swings = (self.stiffness / mass).sqrt() * dt;
        match Mount::of(handle, parts) {
            Mount::Link => swings / LINKED,
            Mount::Joints if self.is_swift(dt) => swings / SWIFT,
            Mount::Joints => 0.0,
            Mount::None => softest_contact(body, parts).map_or(0.0, |contact| {
                let pressed = self.stiffness * dt / damper(&contact, body) / PRESSED;
                pressed.max(self.held / mass / CALM)
            }),
        }
    }

    /// Whether its body is not to lead the nodes where a step of Rapier's, `usual` s long if it was not cut, takes it.
    fn is_stiff(
        &self,
        (handle, body): (RigidBodyHandle, &RigidBody),
        parts: &RapierParts,
        usual: f64,
    ) -> bool {
        let contact = parts.integration_parameters.static_contact_softness;
        match Mount::of(handle, parts) {
            Mount::Link => false,
            Mount::Joints => self.is_swift(usual),
            Mount::None => {
                let stiff = if self.is_swift(usual) {
                    STIFF / 4.0
                } else {
                    STIFF
                };
                self.stiffness > stiff * damper(&contact, body)
            }
        }
    }

    fn is_swift(&self, dt: f64) -> bool {
        self.swings * dt > SWIFT
    }
}

/// What a body hangs on.
enum Mount {
    /// Nothing: it may stand on something.
    None,
    /// Joints that are enabled.
    Joints,
    /// It is a link of a multibody, whose joints Rapier leaves in no error.
    Link,
}

impl Mount {
    fn of(body: RigidBodyHandle, parts: &RapierParts) -> Self {
        if parts.multibody_joints.rigid_body_link(body).is_some() {
            Self::Link
        } else if parts.joints_of(body).next().is_some() {
            Self::Joints
        } else {
            Self::None
        }
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
    // Rapier's pairs are of what may come near within several steps.
    let meets = |pair: &&ContactPair| {
        let [one, other] = [pair.collider1, pair.collider2].map(|c| parts.colliders.get(c));
        let (Some(one), Some(other)) = (one, other) else {
            return false;
        };
        let of = |c: &Collider| c.parent().and_then(|h| parts.bodies.get(h));
        let speed = |c: &Collider| {
            of(c).map_or(0.0, |b| {
                b.linvel().length() + b.angvel().length() * b.mass_properties().max_extent()
            })
        };
        let way = (speed(one) + speed(other)) * parameters.dt + NEAR * parameters.length_unit;
        pair.has_any_active_contact()
            || one
                .compute_aabb()
                .loosened(way)
                .intersects(&other.compute_aabb())
    };
    let own = |collider| {
        let pairs = parts.narrow_phase.contact_pairs_with(collider);
        pairs.filter(meets).map(move |pair| {
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
