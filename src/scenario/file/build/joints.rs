//! Joints and their motors.

use super::super::super::Cast;
use super::super::model::{Joint, JointKind, Scenario};
use super::vector;
use crate::math::Real;
use rapier3d::dynamics::{
    FixedJoint, GenericJoint, ImpulseJointHandle, JointAxis, MotorModel, PrismaticJoint,
    RevoluteJoint, RopeJoint, SphericalJoint, SpringJoint,
};
use rapier3d::pipeline::PhysicsWorld;

/// Puts in all joints of a scene. Their bodies are known: the loader has looked.
pub(super) fn insert(
    scene: &Scenario,
    world: &mut PhysicsWorld,
    cast: &Cast,
) -> Vec<(String, ImpulseJointHandle)> {
    let mut handles = Vec::new();
    for joint in &scene.joints {
        if let (Some(a), Some(b)) = (cast.body(&joint.a), cast.body(&joint.b)) {
            let handle = world.insert_impulse_joint(a, b, made(joint));
            handles.push((joint.name.clone(), handle));
        }
    }
    handles
}

fn made(joint: &Joint) -> GenericJoint {
    let mut made: GenericJoint = match &joint.kind {
        JointKind::Fixed => FixedJoint::new().into(),
        JointKind::Spherical => SphericalJoint::new().into(),
        JointKind::Revolute(axis) => RevoluteJoint::new(vector(*axis).normalize()).into(),
        JointKind::Prismatic(axis) => PrismaticJoint::new(vector(*axis).normalize()).into(),
        JointKind::Rope(length) => RopeJoint::new(*length as Real).into(),
        JointKind::Spring {
            rest_length,
            stiffness,
            damping,
        } => {
            let [l, k, c] = [rest_length, stiffness, damping].map(|x| *x as Real);
            SpringJoint::new(l, k, c).into()
        }
    };
    made.set_local_anchor1(vector(joint.anchor_a));
    made.set_local_anchor2(vector(joint.anchor_b));
    made.set_contacts_enabled(joint.contacts);
    let Some(axis) = axis(&joint.kind) else {
        return made;
    };
    if let Some(limits) = joint.limits {
        made.set_limits(axis, limits.map(|x| x as Real));
    }
    if let Some(motor) = &joint.motor {
        made.set_motor_model(
            axis,
            match motor.per_mass {
                true => MotorModel::AccelerationBased,
                false => MotorModel::ForceBased,
            },
        );
        let [x, v, k, c] = [
            motor.position,
            motor.velocity,
            motor.stiffness,
            motor.damping,
        ];
        made.set_motor(axis, x as Real, v as Real, k as Real, c as Real);
        made.set_motor_max_force(axis, motor.max_force as Real);
    }
    made
}

/// The axis along or about which a joint is free.
pub(crate) fn axis(kind: &JointKind) -> Option<JointAxis> {
    match kind {
        JointKind::Revolute(_) => Some(JointAxis::AngX),
        JointKind::Prismatic(_) => Some(JointAxis::LinX),
        _ => None,
    }
}
