//! Joints that shadows can keep, as Rapier reads them: all but soft ones, and those whose turns about two axes count as one.

use crate::contact::target::wide_rotation;
use crate::coupling::observe::Surroundings;
use crate::law::joint::{Axes, Motor};
use crate::math::{DQuat, DVec3, wide};
use rapier3d::dynamics::{
    GenericJoint, ImpulseJoint, ImpulseJointHandle, JointAxesMask, MotorModel, RigidBody,
    RigidBodyHandle,
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
    /// The joint's axes on each.
    pub frames: [DQuat; 2],
    /// What it does along and about those of the first.
    pub axes: Axes,
    /// Whether stiffness and damping of its motors are per mass or moment of inertia.
    pub per_mass: [bool; 6],
}

/// The joints of a body.
pub fn of<'a>(
    body: RigidBodyHandle,
    around: &Surroundings<'a>,
) -> impl Iterator<Item = (ImpulseJointHandle, &'a ImpulseJoint)> {
    let joints = around.joints.attached_enabled_joints(body);
    joints.map(|(_, _, handle, joint)| (handle, joint))
}

/// The bodies that joints hold together with `body`, itself included, if shadows can keep all of these joints and
/// none of the bodies is a link of a multibody.
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
            if !is_kept(&joint.data, dt) {
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

/// Whether shadows can keep a joint.
fn is_kept(joint: &GenericJoint, dt: f64) -> bool {
    let coupled = joint.coupled_axes & JointAxesMask::ANG_AXES;
    let cone = coupled.intersects(joint.limit_axes);
    let clash = joint.coupled_axes.intersects(joint.locked_axes);
    !cone && !clash && !is_soft(joint, dt)
}

/// Whether a joint gives way for longer than a step of `dt` s.
pub fn is_soft(joint: &GenericJoint, dt: f64) -> bool {
    f64::from(joint.softness.natural_frequency) * dt < 1.0
}

/// What the joint does to its bodies in a step of `dt` s.
pub fn held(joint: &ImpulseJoint, around: &Surroundings, dt: f64) -> Option<RigidJoint> {
    let handles = [joint.body1(), joint.body2()];
    let data = &joint.data;
    let bodies = [
        around.bodies.get(handles[0])?,
        around.bodies.get(handles[1])?,
    ];
    let frame = |body: &RigidBody, local: &Pose| -> (DVec3, DQuat) {
        let pose = body.position();
        let rot = wide_rotation(pose.rotation);
        let at = wide(pose.translation) + rot * wide(local.translation);
        (at, rot * wide_rotation(local.rotation))
    };
    let (first, one) = frame(bodies[0], &data.local_frame1);
    let (second, two) = frame(bodies[1], &data.local_frame2);
    let is_in = |mask: JointAxesMask, i: usize| mask.bits() & (1 << i) != 0;
    let axes = [0, 1, 2, 3, 4, 5];
    // Of what is coupled the first counts; Rapier couples no motors of turns.
    let coupled = data.coupled_axes;
    let distance = (0..3).find(|i| is_in(coupled, *i));
    let counts = |i: usize| {
        let alone = !is_in(coupled, i) || distance == Some(i);
        alone && !is_in(data.locked_axes, i)
    };
    let limits = axes.map(|i| {
        let limits = [data.limits[i].min, data.limits[i].max].map(f64::from);
        // A distance has no lower limit in Rapier.
        let limits = if distance == Some(i) {
            [f64::NEG_INFINITY, limits[1]]
        } else {
            limits
        };
        (counts(i) && is_in(data.limit_axes, i)).then_some(limits)
    });
    let motors = axes.map(|i| {
        let of_distance = distance == Some(i)
            && data
                .motor_axes
                .intersects(coupled & JointAxesMask::LIN_AXES);
        let motor = &data.motors[i];
        (counts(i) && (is_in(data.motor_axes, i) || of_distance)).then(|| Motor {
            place: motor.target_pos.into(),
            velocity: motor.target_vel.into(),
            stiffness: motor.stiffness.into(),
            damping: motor.damping.into(),
            max_force: motor.max_force.into(),
        })
    });
    let iterations = bodies.map(|b| b.additional_solver_iterations());
    let iterations = around.parameters.num_solver_iterations + iterations[0].max(iterations[1]);
    let sweeps = around.parameters.num_internal_pgs_iterations
        + around.parameters.num_internal_stabilization_iterations;
    Some(RigidJoint {
        bodies: handles,
        anchors: [first, second],
        frames: [one, two],
        axes: Axes {
            locked: axes.map(|i| is_in(data.locked_axes, i)),
            coupled: [0, 1, 2].map(|i| is_in(coupled, i)),
            limits,
            motors,
            solver_step: dt / iterations.max(1) as f64,
            sweeps: sweeps as i32,
        },
        per_mass: axes.map(|i| data.motors[i].model == MotorModel::AccelerationBased),
    })
}
