//! Rigid bodies asleep that lose or change what holds them: a joint, or a collider that they touch.
//!
//! Rapier wakes them within its step and moves them at once, and what of a deformable is in their way would see that too late. Whom
//! it has been told to wake is its own secret until then. So they are found by what is not there any more as it was.

use crate::world::RapierParts;
use crate::world::group::{BodyKey, handle_of};
use crate::world::{DeformableWorld, known::Known};
use rapier3d::dynamics::{GenericJoint, RigidBodyHandle};
use rapier3d::geometry::ColliderHandle;
use std::collections::{BTreeMap, BTreeSet};

/// Whether a joint is one of a multibody, and its handle.
type JointKey = (bool, (u32, u32));

/// The joints of a world as they were at the end of its last step; `None` before that.
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize),
    serde(transparent)
)]
pub(in crate::world) struct Moorings(Option<BTreeMap<JointKey, Mooring>>);

/// A joint.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
struct Mooring {
    bodies: [BodyKey; 2],
    /// All but the impulses of one that holds a body asleep; joints of multibodies wake nobody by what they are.
    joint: Option<Box<GenericJoint>>,
}

impl Moorings {
    fn now(parts: &RapierParts) -> BTreeMap<JointKey, Mooring> {
        let sleeps = |h: &RigidBodyHandle| is_asleep(*h, parts);
        let impulse = parts.impulse_joints.iter().map(|(handle, joint)| {
            let bodies = [joint.body1(), joint.body2()];
            let mooring = Mooring {
                bodies: bodies.map(RigidBodyHandle::into_raw_parts),
                joint: bodies
                    .iter()
                    .any(sleeps)
                    .then(|| Box::new(at_rest(joint.data))),
            };
            ((false, handle.into_raw_parts()), mooring)
        });
        let links = parts.multibody_joints.iter();
        let reduced = links.filter_map(|(handle, _, multibody, link)| {
            let parent = multibody.link(link.parent_id()?)?;
            let bodies = [parent, link].map(|l| l.rigid_body_handle().into_raw_parts());
            let mooring = Mooring {
                bodies,
                joint: None,
            };
            let (index, generation) = handle.into_raw_parts();
            Some(((true, (index, generation)), mooring))
        });
        impulse.chain(reduced).collect()
    }

    /// Notes what there is at the end of a step.
    pub fn note(&mut self, parts: &RapierParts) {
        self.0 = Some(Self::now(parts));
    }

    /// The bodies at the ends of joints that have come, gone or been changed since.
    fn changed(&self, parts: &RapierParts) -> Vec<BodyKey> {
        let Some(last) = &self.0 else {
            return Vec::new();
        };
        let now = Self::now(parts);
        let gone = last.iter().filter(|(key, _)| !now.contains_key(key));
        let others = now.iter().filter(|(key, mooring)| {
            // What fell asleep by hand has been told to.
            last.get(key).is_none_or(|last| {
                last.bodies != mooring.bodies || last.joint.is_some() && last.joint != mooring.joint
            })
        });
        let bodies = gone.chain(others).flat_map(|(_, mooring)| mooring.bodies);
        bodies.collect()
    }
}

/// A joint without its impulses, which are of the last step.
fn at_rest(mut joint: GenericJoint) -> GenericJoint {
    joint.limits.iter_mut().for_each(|l| l.impulse = 0.0);
    joint.motors.iter_mut().for_each(|m| m.impulse = 0.0);
    joint
}

fn is_asleep(body: RigidBodyHandle, parts: &RapierParts) -> bool {
    parts.moving(body).is_some_and(|body| body.is_sleeping())
}

impl Known {
    /// The colliders that have gone or are not as they were known, those that are new left out.
    fn changed(&mut self, parts: &RapierParts) -> Vec<ColliderHandle> {
        let mut changed = self.strays(parts);
        changed.retain(|handle| self.knows(*handle));
        changed.extend(self.gone(parts));
        changed
    }
}

impl DeformableWorld {
    /// Wakes the bodies asleep that Rapier will wake in its coming step, as what held them has changed.
    pub(in crate::world) fn wake_unmoored(&mut self, parts: &mut RapierParts) {
        let mut wake: BTreeSet<BodyKey> = self.moorings.changed(parts).into_iter().collect();
        for handle in self.known.changed(parts) {
            let pairs = parts.narrow_phase.contact_pairs_with(handle);
            let beside = pairs.flat_map(|pair| [pair.collider1, pair.collider2]);
            let all = beside.chain([handle]);
            let bodies = all.filter_map(|c| parts.colliders.get(c)?.parent());
            wake.extend(bodies.map(RigidBodyHandle::into_raw_parts));
        }
        for body in wake.into_iter().map(handle_of) {
            if is_asleep(body, parts) {
                parts.islands.wake_up(parts.bodies, body, true);
            }
        }
    }
}
