//! What rigid bodies press on, or may press on within the coming step, and what they hang on.
//!
//! Rapier finds contacts at the start of its step and answers them within it. What it found in the last step is a step
//! old: a body that flies at 5 m/s is 2 cm farther by now, and may be stopped in this step by something that was not near
//! in the last. So the contacts are found here as Rapier is about to find them, at the poses and by the functions that
//! it will use.

mod contacts;
mod joints;
mod pairs;
#[cfg(test)]
mod tests;

use super::observe::{self, Surroundings};
use crate::math::DVec3;
pub use joints::{JointKey, RigidJoint, is_soft};
use rapier3d::dynamics::{RigidBodyHandle, SpringCoefficients};
use std::collections::{BTreeMap, BTreeSet};

/// A point where two rigid bodies press on each other, or may soon.
#[derive(Clone, Copy, Debug)]
pub struct RigidContact {
    /// The bodies; `None` for a collider without one.
    pub bodies: [Option<RigidBodyHandle>; 2],
    /// The point on the surface of each now \[m\].
    pub points: [DVec3; 2],
    /// From the first to the second.
    pub normal: DVec3,
    /// What each takes of the impulse: 1, or 0 for a body that dominates the other.
    pub shares: [f64; 2],
    /// Coulomb's μ.
    pub friction: f64,
    /// Velocity of the first one's surface over its body \[m/s\].
    pub belt: DVec3,
    /// Impulse along the normal in Rapier's last step \[N·s\].
    pub impulse: f64,
    /// How it gives way in Rapier.
    pub spring: ContactSpring,
}

/// How Rapier's contacts give way: as springs and dampers that suit the masses of the bodies.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactSpring {
    /// How deep they may be pressed \[m\].
    sag: f64,
    /// Stiffness per mass that the point feels, ω² \[1/s²\].
    stiffness: f64,
    /// Damping per mass that the point feels, 2ζω \[1/s\].
    damping: f64,
}

impl ContactSpring {
    fn of(spring: &SpringCoefficients<f32>, sag: f64) -> Self {
        let omega = f64::from(spring.angular_frequency());
        Self {
            sag,
            stiffness: omega * omega,
            damping: 2.0 * f64::from(spring.damping_ratio) * omega,
        }
    }

    /// The mean force that presses a contact that is `depth` m deep no deeper than it may be in a step of `dt` s, per mass that the point
    /// feels \[N/kg\].
    pub fn bears(&self, depth: f64, dt: f64) -> f64 {
        let sag = self.sag.max(0.0);
        let depth = depth.max(0.0).min(sag);
        (self.stiffness * depth + self.damping * (sag - depth) / dt).max(0.0)
    }
}

/// The contacts and joints of bodies that deformables can touch, of what these press on or hang on, and so forth.
#[derive(Debug, Default)]
pub struct RigidConstraints {
    contacts: Vec<RigidContact>,
    joints: Vec<RigidJoint>,
    followed: BTreeSet<(u32, u32)>,
    /// By the key of a body: the contacts it is part of, and the joints.
    of: BTreeMap<(u32, u32), [Vec<usize>; 2]>,
}

impl RigidConstraints {
    /// Those of `seeds` and of all that these lead to, for a step of `dt` s. What does not answer, and what shadows can't
    /// follow, ends a chain.
    pub fn gather(
        seeds: impl IntoIterator<Item = RigidBodyHandle>,
        around: &Surroundings,
        dt: f64,
    ) -> Self {
        let mut found = Self::default();
        let mut next: Vec<RigidBodyHandle> = seeds.into_iter().collect();
        let (mut pairs, mut held) = (BTreeSet::new(), BTreeSet::new());
        let mut known: BTreeSet<_> = next.iter().map(|b| b.into_raw_parts()).collect();
        // Those of which it is known that shadows can follow all that joints hold together with them.
        let mut kept = BTreeSet::new();
        while let Some(handle) = next.pop() {
            let Some(body) = around.bodies.get(handle) else {
                continue;
            };
            if !body.is_dynamic() || body.is_sleeping() {
                continue;
            }
            let mut others = Vec::new();
            if !kept.contains(&handle.into_raw_parts()) {
                let Some(linkage) = joints::linkage(handle, around, dt) else {
                    continue;
                };
                kept.extend(linkage.iter().map(|b| b.into_raw_parts()));
                others = linkage;
            }
            found.followed.insert(handle.into_raw_parts());
            for (number, joint) in joints::of(handle, around) {
                if held.insert(number)
                    && let Some(joint) = joints::held(&joint, around, dt)
                {
                    found.add_joint(joint);
                }
            }
            for pair in pairs::of(body, around) {
                if !pairs.insert(pair.key()) {
                    continue;
                }
                for contact in contacts::of(&pair, around, dt) {
                    found.add_contact(contact);
                }
                others.extend(pair.bodies().into_iter().flatten());
            }
            next.extend(
                others
                    .into_iter()
                    .filter(|b| known.insert(b.into_raw_parts())),
            );
        }
        found
    }

    fn add_contact(&mut self, contact: RigidContact) {
        for body in contact.bodies.into_iter().flatten() {
            let [contacts, _] = self.of.entry(body.into_raw_parts()).or_default();
            contacts.push(self.contacts.len());
        }
        self.contacts.push(contact);
    }

    fn add_joint(&mut self, joint: RigidJoint) {
        for body in joint.bodies {
            let [_, joints] = self.of.entry(body.into_raw_parts()).or_default();
            joints.push(self.joints.len());
        }
        self.joints.push(joint);
    }

    /// Whether shadows can follow what holds a body.
    pub fn follows(&self, body: RigidBodyHandle) -> bool {
        self.followed.contains(&body.into_raw_parts())
    }

    /// Whether a body may press on anything, or hangs on anything that shadows can follow.
    pub fn has(&self, body: RigidBodyHandle) -> bool {
        self.of.contains_key(&body.into_raw_parts())
    }

    /// The contacts of a body, by their numbers.
    pub fn contacts_of(
        &self,
        body: RigidBodyHandle,
    ) -> impl Iterator<Item = (usize, &RigidContact)> {
        let of = self.of.get(&body.into_raw_parts());
        let list = of.into_iter().flat_map(|[contacts, _]| contacts);
        list.map(|&i| (i, &self.contacts[i]))
    }

    /// The joints of a body, by their numbers.
    pub fn joints_of(&self, body: RigidBodyHandle) -> impl Iterator<Item = (usize, &RigidJoint)> {
        let of = self.of.get(&body.into_raw_parts());
        let list = of.into_iter().flat_map(|[_, joints]| joints);
        list.map(|&i| (i, &self.joints[i]))
    }

    /// The bodies that a body presses on or hangs on, those that they do, and so forth, itself included; those that don't
    /// answer, and those that shadows can't follow, end a chain.
    pub fn heap(&self, body: RigidBodyHandle, around: &Surroundings) -> Vec<RigidBodyHandle> {
        let mut heap = vec![body];
        let mut known = BTreeSet::from([body.into_raw_parts()]);
        let mut next = 0;
        while let Some(&handle) = heap.get(next) {
            next += 1;
            let pressed = |b| observe::answer(handle, b, self, around).is_kept();
            if !around.bodies.get(handle).is_some_and(pressed) {
                continue;
            }
            let pressed = self
                .contacts_of(handle)
                .flat_map(|(_, c)| c.bodies)
                .flatten();
            let others = pressed.chain(self.joints_of(handle).flat_map(|(_, j)| j.bodies));
            let moves = |h: &RigidBodyHandle| around.bodies.get(*h).is_some_and(|b| b.is_dynamic());
            heap.extend(others.filter(|h| moves(h) && known.insert(h.into_raw_parts())));
        }
        heap
    }
}
