//! What rigid bodies press on, or may press on within the coming step.
//!
//! Rapier finds contacts at the start of its step and answers them within it. What it found in the last step is a step
//! old: a body that flies at 5 m/s is 2 cm farther by now, and may be stopped in this step by something that was not near
//! in the last. So the contacts are found here as Rapier is about to find them, at the poses and by the functions that
//! it will use.

mod partners;
mod points;

use super::observe::{self, Answer, Surroundings};
use crate::math::DVec3;
use rapier3d::dynamics::RigidBodyHandle;
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
}

/// The contacts of bodies that deformables can touch, of what these press on, and so forth.
#[derive(Debug, Default)]
pub struct Presses {
    contacts: Vec<RigidContact>,
    /// By the key of a body: the contacts it is part of.
    of: BTreeMap<(u32, u32), Vec<usize>>,
}

impl Presses {
    /// Those of `seeds` and of all that these lead to. What does not answer, and what hangs on joints, ends a chain.
    pub fn gather(seeds: impl IntoIterator<Item = RigidBodyHandle>, around: &Surroundings) -> Self {
        let mut found = Self::default();
        let mut next: Vec<RigidBodyHandle> = seeds.into_iter().collect();
        let mut seen = BTreeSet::new();
        let mut known: BTreeSet<_> = next.iter().map(|b| b.into_raw_parts()).collect();
        while let Some(handle) = next.pop() {
            let Some(body) = around.bodies.get(handle) else {
                continue;
            };
            if !observe::is_single(handle, body, around) {
                continue;
            }
            for pair in partners::of(body, around) {
                if !seen.insert(pair.key()) {
                    continue;
                }
                for contact in points::of(&pair, around) {
                    found.add(contact);
                }
                let others = pair.bodies().into_iter().flatten();
                next.extend(others.filter(|b| known.insert(b.into_raw_parts())));
            }
        }
        found
    }

    fn add(&mut self, contact: RigidContact) {
        for body in contact.bodies.into_iter().flatten() {
            let list = self.of.entry(body.into_raw_parts()).or_default();
            list.push(self.contacts.len());
        }
        self.contacts.push(contact);
    }

    /// Whether a body may press on anything.
    pub fn has(&self, body: RigidBodyHandle) -> bool {
        self.of.contains_key(&body.into_raw_parts())
    }

    /// The contacts of a body, by their numbers.
    pub fn of(&self, body: RigidBodyHandle) -> impl Iterator<Item = (usize, &RigidContact)> {
        let list = self.of.get(&body.into_raw_parts()).into_iter().flatten();
        list.map(|&i| (i, &self.contacts[i]))
    }

    /// The bodies that a body presses on, those that they press on, and so forth, itself included; those that don't answer,
    /// and those that hang on joints, end a chain.
    pub fn heap(&self, body: RigidBodyHandle, around: &Surroundings) -> Vec<RigidBodyHandle> {
        let mut heap = vec![body];
        let mut known = BTreeSet::from([body.into_raw_parts()]);
        let mut next = 0;
        while let Some(&handle) = heap.get(next) {
            next += 1;
            let pressed = |b| observe::answer(handle, b, self, around) == Answer::Pressed;
            if !around.bodies.get(handle).is_some_and(pressed) {
                continue;
            }
            let others = self.of(handle).flat_map(|(_, c)| c.bodies).flatten();
            let moves = |h: &RigidBodyHandle| around.bodies.get(*h).is_some_and(|b| b.is_dynamic());
            heap.extend(others.filter(|h| moves(h) && known.insert(h.into_raw_parts())));
        }
        heap
    }
}
