//! Joints that shadows can keep: all but those with limits, motors or springs.

use crate::contact::target::wide_rotation;
use crate::coupling::observe::Surroundings;
use crate::math::{DQuat, DVec3, wide};
use rapier3d::dynamics::{
    GenericJoint, ImpulseJoint, ImpulseJointHandle, RigidBody, RigidBodyHandle,
};
use rapier3d::math::Pose;
use std::collections::BTreeSet;

/// A joint of two bodies as it stands now.
#[derive(Clone, Copy, Debug)]
pub struct RigidJoint {
    /// The bodies.
    pub bodies: [RigidBodyHandle; 2],
    /// The anchor on each \[m\].
    pub anchors: [DVec3; 2],
    /// Its axes on the first.
    pub axes: [DVec3; 3],
    /// Which displacements along these axes, and turns about them, are locked.
    pub locked: [bool; 6],
}

/// The joints of a body.
pub fn of<'a>(
    body: RigidBodyHandle,
    around: &Surroundings<'a>,
) -> impl Iterator<Item = (ImpulseJointHandle, &'a ImpulseJoint)> {
    let joints = around.joints.attached_enabled_joints(body);
    joints.map(|(_, _, handle, joint)| (handle, joint))
}

/// The bodies that joints hold together with `body`, itself included, if all of these joints are plain and none of the
/// bodies is a link of a multibody.
pub fn linkage(
    body: RigidBodyHandle,
    around: &Surroundings,
    dt: f64,
) -> Option<Vec<RigidBodyHandle>> {
    let mut found = vec![body];
    let mut known = BTreeSet::from([body.into_raw_parts()]);
    let mut next = 0;
    while let Some(&current) = found.get(next) {
        next += 1;
        if around.multibodies.rigid_body_link(current).is_some() {
            return None;
        }
        for (_, joint) in of(current, around) {
            if !is_plain(&joint.data, dt) {
                return None;
            }
            for other in [joint.body1(), joint.body2()] {
                let moves = around.bodies.get(other).is_some_and(|b| b.is_dynamic());
                if moves && known.insert(other.into_raw_parts()) {
                    found.push(other);
                }
            }
        }
    }
    Some(found)
}

fn is_plain(joint: &GenericJoint, dt: f64) -> bool {
    let free = !joint.locked_axes.bits();
    (joint.limit_axes | joint.motor_axes).bits() & free == 0
        && joint.coupled_axes.is_empty()
        && !is_soft(joint, dt)
}

/// Whether a joint gives way for longer than a step of `dt` s.
pub fn is_soft(joint: &GenericJoint, dt: f64) -> bool {
    f64::from(joint.softness.natural_frequency) * dt < 1.0
}

/// Where the joint holds its bodies.
pub fn held(joint: &ImpulseJoint, around: &Surroundings) -> Option<RigidJoint> {
    let bodies = [joint.body1(), joint.body2()];
    let data = &joint.data;
    let frame = |handle: RigidBodyHandle, local: &Pose| -> Option<(DVec3, DQuat)> {
        let body: &RigidBody = around.bodies.get(handle)?;
        let pose = body.position();
        let rot = wide_rotation(pose.rotation);
        let at = wide(pose.translation) + rot * wide(local.translation);
        Some((at, rot * wide_rotation(local.rotation)))
    };
    let (first, turn) = frame(bodies[0], &data.local_frame1)?;
    let (second, _) = frame(bodies[1], &data.local_frame2)?;
    let locked = data.locked_axes.bits();
    Some(RigidJoint {
        bodies,
        anchors: [first, second],
        axes: [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turn * axis),
        locked: [0, 1, 2, 3, 4, 5].map(|i| locked & (1 << i) != 0),
    })
}
