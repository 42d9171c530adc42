//! Rigid bodies asleep that lose or change what holds them: a joint, or a collider that they touch.
//!
//! Rapier wakes them within its step and moves them at once, and what of a deformable is in their way would see that too late. Whom
//! it has been told to wake is its own secret until then. So they are found by what is not there any more as it was: of colliders all
//! that Rapier wakes, of joints what may reach a deformable, as these can be changed without waking anybody.

use crate::coupling::constraints::JointKey;
use crate::math::Pose;
use crate::world::group::{BodyKey, handle_of};
use crate::world::reach::grown;
use crate::world::{DeformableWorld, RapierParts};
use rapier3d::dynamics::{
    GenericJoint, ImpulseJoint, ImpulseJointHandle, Multibody, MultibodyJointHandle, MultibodyLink,
    RigidBodyHandle, RigidBodyType,
};
use rapier3d::geometry::Aabb;
use rapier3d::parry::bounding_volume::BoundingVolume;
use std::cell::LazyCell;
use std::collections::{BTreeMap, BTreeSet};

/// How fast a body may be driven from rest and meet a deformable within a step, in length units per second.
const DRIVEN: f64 = 20.0;

/// The joints of a world as they were at the end of its last step.
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(in crate::world) struct Moorings {
    /// The generations of all, by slot, those of multibodies apart; `None` before the first step.
    known: Option<[Vec<Option<u32>>; 2]>,
    /// Those that hold a body asleep near a deformable.
    held: BTreeMap<JointKey, Mooring>,
}

/// A joint.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
struct Mooring {
    bodies: [BodyKey; 2],
    /// What counts of it; joints of multibodies wake nobody by what they are.
    joint: Option<Box<GenericJoint>>,
    /// What the bodies are, and where fixed ones stand.
    ends: [Option<(RigidBodyType, Option<Pose>)>; 2],
}

/// A joint, the bodies that it joins, and what it is if it is none of a multibody.
type Joined<'a> = (JointKey, [RigidBodyHandle; 2], Option<&'a ImpulseJoint>);

fn all<'a>(parts: &'a RapierParts) -> impl Iterator<Item = Joined<'a>> {
    let joints = parts.impulse_joints.iter().map(|(handle, joint)| {
        let bodies = [joint.body1(), joint.body2()];
        ((false, handle.into_raw_parts()), bodies, Some(joint))
    });
    let links = parts.multibody_joints.iter();
    let links = links.filter_map(|(handle, _, multibody, link)| {
        let bodies = ends_of(multibody, link)?;
        Some(((true, handle.into_raw_parts()), bodies, None))
    });
    joints.chain(links)
}

fn ends_of(multibody: &Multibody, link: &MultibodyLink) -> Option<[RigidBodyHandle; 2]> {
    let parent = multibody.link(link.parent_id()?)?;
    Some([parent, link].map(|l| l.rigid_body_handle()))
}

impl Mooring {
    fn of(bodies: [RigidBodyHandle; 2], joint: Option<&ImpulseJoint>, parts: &RapierParts) -> Self {
        let end = |body: RigidBodyHandle| {
            let body = parts.bodies.get(body)?;
            let place = body.is_fixed().then(|| *body.position());
            Some((body.body_type(), place))
        };
        Self {
            bodies: bodies.map(RigidBodyHandle::into_raw_parts),
            joint: joint.map(|joint| Box::new(at_rest(joint.data))),
            ends: bodies.map(end),
        }
    }

    /// What is now in the place of a joint.
    fn now((reduced, handle): JointKey, parts: &RapierParts) -> Option<Self> {
        let (index, generation) = handle;
        if reduced {
            let handle = MultibodyJointHandle::from_raw_parts(index, generation);
            let (multibody, link) = parts.multibody_joints.get(handle)?;
            let bodies = ends_of(multibody, multibody.link(link)?)?;
            return Some(Self::of(bodies, None, parts));
        }
        let handle = ImpulseJointHandle::from_raw_parts(index, generation);
        let joint = parts.impulse_joints.get(handle)?;
        Some(Self::of([joint.body1(), joint.body2()], Some(joint), parts))
    }
}

/// A joint without what is the user's alone, and without its impulses, which are of the last step.
fn at_rest(mut joint: GenericJoint) -> GenericJoint {
    joint.limits.iter_mut().for_each(|l| l.impulse = 0.0);
    joint.motors.iter_mut().for_each(|m| m.impulse = 0.0);
    joint.user_data = 0;
    joint
}

impl Moorings {
    /// The bodies at the ends of joints that have come, gone or been changed since.
    fn changed(
        &self,
        parts: &RapierParts,
        is_near: impl Fn(RigidBodyHandle) -> bool,
    ) -> Vec<BodyKey> {
        let Some(known) = &self.known else {
            return Vec::new();
        };
        let others = self.held.iter().filter(|(key, mooring)| {
            let now = Mooring::now(**key, parts);
            now.as_ref() != Some(mooring)
        });
        let others = others.flat_map(|(_, mooring)| mooring.bodies);
        let is_new = |(reduced, (index, generation)): JointKey| {
            let last = known[usize::from(reduced)].get(index as usize);
            last != Some(&Some(generation))
        };
        let new = all(parts).filter(|(key, bodies, _)| {
            is_new(*key) && bodies.iter().any(|b| parts.is_asleep(*b) && is_near(*b))
        });
        let new = new.flat_map(|(_, bodies, _)| bodies.map(RigidBodyHandle::into_raw_parts));
        others.chain(new).collect()
    }

    /// Notes what there is.
    fn note(&mut self, parts: &RapierParts, is_near: impl Fn(RigidBodyHandle) -> bool) {
        let mut known = self.known.take().unwrap_or_default();
        known.iter_mut().for_each(Vec::clear);
        self.held.clear();
        for (key, bodies, joint) in all(parts) {
            let (reduced, (index, generation)) = key;
            let (slots, index) = (&mut known[usize::from(reduced)], index as usize);
            slots.resize(slots.len().max(index + 1), None);
            slots[index] = Some(generation);
            if bodies.iter().any(|b| parts.is_asleep(*b) && is_near(*b)) {
                self.held.insert(key, Mooring::of(bodies, joint, parts));
            }
        }
        self.known = Some(known);
    }
}

impl DeformableWorld {
    /// Wakes the bodies asleep that Rapier will wake in its coming step of `dt` s, as what held them has changed.
    pub(in crate::world) fn wake_unmoored(&mut self, parts: &mut RapierParts, dt: f64) {
        if !self.iter().any(|(_, body)| body.is_enabled()) {
            return;
        }
        let around = LazyCell::new(|| self.around(parts, dt));
        let wake = self
            .moorings
            .changed(parts, |body| is_near(body, *around, parts));
        let mut wake: BTreeSet<BodyKey> = wake.into_iter().collect();
        for handle in self.known.changed(parts) {
            let pairs = parts.narrow_phase.contact_pairs_with(handle);
            let beside = pairs.flat_map(|pair| [pair.collider1, pair.collider2]);
            let all = beside.chain([handle]);
            let bodies = all.filter_map(|c| parts.colliders.get(c)?.parent());
            wake.extend(bodies.map(RigidBodyHandle::into_raw_parts));
        }
        for body in wake.into_iter().map(handle_of) {
            if parts.is_asleep(body) {
                parts.islands.wake_up(parts.bodies, body, true);
            }
        }
    }

    /// Notes what holds bodies asleep, at the end of a step of `dt` s.
    pub(in crate::world) fn note_moorings(&mut self, parts: &RapierParts, dt: f64) {
        let mut moorings = std::mem::take(&mut self.moorings);
        if self.iter().any(|(_, body)| body.is_enabled()) {
            let around = LazyCell::new(|| self.around(parts, dt));
            moorings.note(parts, |body| is_near(body, *around, parts));
            self.moorings = moorings;
        }
    }

    /// What of the world may meet a deformable within `dt` s.
    fn around(&self, parts: &RapierParts, dt: f64) -> Aabb {
        let bodies = self.iter().filter(|(_, body)| body.is_enabled());
        let boxes = bodies.map(|(_, body)| body.box_within(body.half_thickness()));
        let all = boxes.fold(Aabb::new_invalid(), |all, own| all.merged(&own));
        grown(&all, DRIVEN * parts.length_unit() * dt)
    }
}

/// Whether a body may be within these bounds.
fn is_near(body: RigidBodyHandle, bounds: Aabb, parts: &RapierParts) -> bool {
    let body = parts.bodies.get(body);
    body.is_some_and(|body| {
        let extent = body.mass_properties().max_extent();
        let nearest = body.center_of_mass().clamp(bounds.mins, bounds.maxs);
        nearest.distance(body.center_of_mass()) <= extent
    })
}
