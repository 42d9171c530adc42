//! Snapshots: a world in mid-run as bytes, and back.
//!
//! What is saved is blueprints, states and all that is remembered between steps, so that a restored world goes on bit for
//! bit as the saved one. Tables, trees and the forms of shapes follow from these and are made anew. Shapes are not saved
//! with contacts: Rapier's colliders have them.
//!
//! Bytes carry the version, the layout, their length and a checksum, so that what is damaged or foreign is told from what is
//! whole before any of it is read. This guards against mishap, not against forgery.

mod body;
mod envelope;
mod error;

pub use error::SnapshotError;

use super::group::BodyKey;
use super::known::Known;
use super::sleep::{HeldShape, Island, Moorings, Neighbour};
use super::touch::{Touch, TouchKey};
use super::{AttachmentState, Deformable, DeformableParameters, DeformableWorld, kinematic, meet};
use crate::contact::candidates::{self, Candidates};
use crate::contact::encounter::Encounter;
use crate::contact::target::target;
use crate::coupling::memory::BodyMemory;
use crate::math::Vector;
use envelope::{Kind, open, wrap};
use rapier3d::data::arena::Arena;
use rapier3d::dynamics::RigidBodySet;
use rapier3d::geometry::{ColliderHandle, ColliderSet, SharedShape};
use rapier3d::pipeline::PhysicsWorld;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Deformable and collider.
type ContactKey = ((u32, u32), BodyKey);

/// What is written; [`Incoming`] is what is read.
#[derive(Serialize)]
struct Outgoing<'a> {
    params: &'a DeformableParameters,
    bodies: &'a Arena<Box<Deformable>>,
    attachments: &'a Arena<AttachmentState>,
    memory: &'a BTreeMap<BodyKey, BodyMemory>,
    contacts: Vec<(ContactKey, candidates::Saved)>,
    encounters: &'a BTreeMap<(BodyKey, BodyKey), Encounter>,
    meetings: &'a meet::Meetings,
    courses: &'a kinematic::Courses,
    known: &'a Known,
    moorings: &'a Moorings,
    touches: &'a BTreeMap<TouchKey, Touch>,
    islands: &'a [Island],
    /// Hashes of the shapes beside the islands, in their order; `None` for those that are others by now.
    shapes: Vec<Option<u64>>,
    time: f64,
    steps: u64,
    fine_until: f64,
    gravity: Option<Vector>,
    parity: bool,
}

#[derive(Deserialize)]
struct Incoming {
    params: DeformableParameters,
    bodies: Arena<Box<Deformable>>,
    attachments: Arena<AttachmentState>,
    memory: BTreeMap<BodyKey, BodyMemory>,
    contacts: Vec<(ContactKey, candidates::Saved)>,
    encounters: BTreeMap<(BodyKey, BodyKey), Encounter>,
    meetings: meet::Meetings,
    courses: kinematic::Courses,
    known: Known,
    moorings: Moorings,
    touches: BTreeMap<TouchKey, Touch>,
    islands: Vec<Island>,
    shapes: Vec<Option<u64>>,
    time: f64,
    steps: u64,
    fine_until: f64,
    gravity: Option<Vector>,
    parity: bool,
}

impl DeformableWorld {
    /// The deformables and Rapier's world as bytes, to go on from with [`Self::load`].
    ///
    /// Hooks and force fields are code and are left out: set them again with [`Self::set_hooks`] and
    /// [`Deformable::set_force_field`]. So are Rapier's workspaces, which hold nothing between steps, and the
    /// [report](Self::report). A restored world goes on bit for bit as the saved one, with any
    /// [`Kernel`](crate::solve::Kernel). To go back by some steps within a program, clone the worlds' parts, which is faster.
    ///
    /// # Errors
    /// [`SnapshotError::MidStep`] between `before_step` and `after_step`, [`SnapshotError::Unsaveable`] for what Rapier
    /// can't save, such as custom shapes.
    ///
    /// ```
    /// use crumple::prelude::*;
    /// use crumple::rapier3d::prelude::*;
    /// let mut world = PhysicsWorld::default();
    /// world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::cuboid(5.0, 0.1, 5.0));
    /// let mut deformables = DeformableWorld::default();
    /// deformables.insert(
    ///     DeformableBuilder::new(lattice(Vector::splat(0.4), 0.1))
    ///         .material(Material::rubber())
    ///         .translation(Vector::new(0.0, 0.4, 0.0)),
    /// )?;
    /// for _ in 0..20 {
    ///     deformables.step(&mut world);
    /// }
    /// let bytes = deformables.save(&world)?;
    /// let (mut again, mut world_again) = DeformableWorld::load(&bytes)?;
    /// for _ in 0..20 {
    ///     deformables.step(&mut world);
    ///     again.step(&mut world_again);
    /// }
    /// assert_eq!(again.state_hash(), deformables.state_hash());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn save(&self, world: &PhysicsWorld) -> Result<Vec<u8>, SnapshotError> {
        let content = (self.outgoing(&world.colliders)?, world);
        encode(Kind::Whole, &content)
    }

    /// Both worlds as they were saved by [`Self::save`].
    ///
    /// # Errors
    /// [`SnapshotError`] for bytes that are no snapshot, of another version or layout, cut short or damaged.
    pub fn load(bytes: &[u8]) -> Result<(Self, PhysicsWorld), SnapshotError> {
        let (deformables, world): (Incoming, PhysicsWorld) = decode(Kind::Whole, bytes)?;
        let deformables = deformables.restore(&world.bodies, &world.colliders);
        Ok((deformables, world))
    }

    /// The deformables alone as bytes, for those who save Rapier's sets themselves; to go on from with
    /// [`Self::load_beside`].
    ///
    /// # Errors
    /// As [`Self::save`].
    pub fn save_beside(&self, colliders: &ColliderSet) -> Result<Vec<u8>, SnapshotError> {
        encode(Kind::Beside, &self.outgoing(colliders)?)
    }

    /// The deformables as they were saved by [`Self::save_beside`]. Rapier's sets must be those of the same time: bodies,
    /// colliders and joints are known by their handles, and contacts with what is not there any more, or has another
    /// shape, are forgotten.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn load_beside(
        bytes: &[u8],
        bodies: &RigidBodySet,
        colliders: &ColliderSet,
    ) -> Result<Self, SnapshotError> {
        let saved: Incoming = decode(Kind::Beside, bytes)?;
        Ok(saved.restore(bodies, colliders))
    }

    fn outgoing(&self, colliders: &ColliderSet) -> Result<Outgoing<'_>, SnapshotError> {
        if self.half_done.is_some() || !self.waiting.is_empty() {
            return Err(SnapshotError::MidStep);
        }
        // What is remembered of a collider that has gone is of no use.
        let contacts = self.contacts.iter().filter_map(|(key, contact)| {
            let (index, generation) = key.1;
            colliders.get(ColliderHandle::from_raw_parts(index, generation))?;
            Some((*key, contact.save()?))
        });
        let shape = |beside: &Neighbour| {
            let shape = colliders.get(beside.collider)?.shared_shape();
            let same = beside.shape.as_ref() == Some(&HeldShape(shape.clone()));
            same.then(|| candidates::fingerprint(shape))?
        };
        let beside = self.islands.iter().flat_map(Island::neighbours);
        Ok(Outgoing {
            params: &self.params,
            bodies: &self.bodies,
            attachments: &self.attachments,
            memory: &self.memory,
            contacts: contacts.collect(),
            encounters: &self.encounters,
            meetings: &self.meetings,
            courses: &self.courses,
            known: &self.known,
            moorings: &self.moorings,
            touches: &self.touches,
            islands: &self.islands,
            shapes: beside.map(shape).collect(),
            time: self.time,
            steps: self.steps,
            fine_until: self.fine_until,
            gravity: self.gravity,
            parity: self.parity,
        })
    }
}

impl Incoming {
    fn restore(self, bodies: &RigidBodySet, colliders: &ColliderSet) -> DeformableWorld {
        let mut world = DeformableWorld {
            params: self.params,
            bodies: self.bodies,
            attachments: self.attachments,
            memory: self.memory,
            encounters: self.encounters,
            meetings: self.meetings,
            courses: self.courses,
            known: self.known,
            moorings: self.moorings,
            touches: self.touches,
            islands: self.islands,
            time: self.time,
            steps: self.steps,
            fine_until: self.fine_until,
            gravity: self.gravity,
            parity: self.parity,
            ..DeformableWorld::default()
        };
        let beside = world.islands.iter_mut().flat_map(Island::neighbours_mut);
        for (neighbour, saved) in beside.zip(self.shapes) {
            let shape = colliders.get(neighbour.collider);
            let shape = shape.map(|c| c.shared_shape().clone());
            let same = |s: &SharedShape| saved.is_some() && candidates::fingerprint(s) == saved;
            neighbour.shape = shape.filter(same).map(HeldShape);
        }
        for (key, saved) in self.contacts {
            let contact = world.contact(key, saved, bodies, colliders);
            world.contacts.extend(contact.map(|c| (key, c)));
        }
        world
    }
}

impl DeformableWorld {
    /// A saved contact with the shape that the collider has.
    fn contact(
        &mut self,
        ((slot, generation), collider): ContactKey,
        saved: candidates::Saved,
        bodies: &RigidBodySet,
        colliders: &ColliderSet,
    ) -> Option<Candidates> {
        let index = rapier3d::data::arena::Index::from_raw_parts(slot, generation);
        let body = self.bodies.get(index)?;
        let handle = ColliderHandle::from_raw_parts(collider.0, collider.1);
        let collider = colliders.get(handle)?;
        let target = target(handle, collider, bodies, &body.surface, &mut self.forms)?;
        Candidates::restore(saved, target, body.contact_topology().spacing)
    }
}

fn encode(kind: Kind, content: &impl Serialize) -> Result<Vec<u8>, SnapshotError> {
    let content = postcard::to_stdvec(content).map_err(|e| SnapshotError::Unsaveable {
        reason: e.to_string(),
    })?;
    Ok(wrap(kind, &content))
}

fn decode<'a, T: Deserialize<'a>>(kind: Kind, bytes: &'a [u8]) -> Result<T, SnapshotError> {
    let content = open(bytes, kind)?;
    let (value, rest) = postcard::take_from_bytes(content).map_err(|e| {
        let reason = e.to_string();
        SnapshotError::Unreadable { reason }
    })?;
    match rest {
        [] => Ok(value),
        _ => Err(SnapshotError::Unreadable {
            reason: format!("{} bytes are left over", rest.len()),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Behind a checksum that is right, content that is not is still an error, found before memory is taken.
    #[test]
    fn content_of_wrong_counts_is_no_world() {
        let mut world = PhysicsWorld::default();
        world.insert(
            rapier3d::dynamics::RigidBodyBuilder::fixed(),
            rapier3d::geometry::ColliderBuilder::cuboid(1.0, 0.5, 1.0),
        );
        let mut deformables = DeformableWorld::default();
        let net = crate::shape::lattice(Vector::splat(0.4), 0.2);
        let block = crate::world::DeformableBuilder::new(net)
            .material(crate::body::Material::rubber())
            .translation(Vector::Y * 0.7);
        deformables.insert(block).unwrap();
        deformables.step(&mut world);
        let bytes = deformables.save(&world).unwrap();
        let content = open(&bytes, Kind::Whole).unwrap();
        let load = |content: &[u8]| DeformableWorld::load(&wrap(Kind::Whole, content)).err();
        assert_eq!(load(content), None);
        for length in (0..content.len()).step_by(97) {
            let error = load(&content[..length]);
            assert!(
                matches!(error, Some(SnapshotError::Unreadable { .. })),
                "{length}: {error:?}"
            );
        }
        let error = load(&[content, &[0]].concat());
        assert!(matches!(error, Some(SnapshotError::Unreadable { .. })));
        // Anywhere a count of 2⁶³: what follows is too short for it.
        let huge = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f];
        for at in (0..content.len()).step_by(97) {
            let error = load(&[&content[..at], &huge, &content[at..]].concat());
            let is_told = matches!(error, Some(SnapshotError::Unreadable { .. }));
            assert!(is_told, "a count at {at}: {error:?}");
        }
    }
}
