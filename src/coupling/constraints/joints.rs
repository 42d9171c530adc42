//! Joints that shadows can keep, as Rapier reads them: all but soft ones that have limits or hold links of multibodies, and those whose
//! turns about two axes count as one; and those of multibodies, but for kinematic ones and where there is more to these than
//! joints have: springs, friction, armature, couplings.

use crate::contact::target::wide_rotation;
use crate::coupling::observe::Surroundings;
use crate::law::joint::{Axes, Motor, Softness};
use crate::math::{DQuat, DVec3, wide};
use rapier3d::dynamics::{
    GenericJoint, JointAxesMask, MotorModel, Multibody, MultibodyLink, RigidBody, RigidBodyHandle,
};
use rapier3d::math::Pose;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

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

/// A joint of Rapier's, of one kind or the other.
#[derive(Clone, Copy)]
pub struct AnyJoint<'a> {
    bodies: [RigidBodyHandle; 2],
    data: &'a GenericJoint,
    /// Whether it is one of a multibody, whose motors Rapier solves exactly.
    reduced: bool,
    /// What a multibody damps along and about its axes \[N·s/m\], \[N·m·s\].
    drag: [f64; 6],
}

/// What tells joints apart: their kind, and a handle.
pub type JointKey = (bool, (u32, u32));

/// The joints of a body.
pub fn of<'a>(body: RigidBodyHandle, around: &Surroundings<'a>) -> Vec<(JointKey, AnyJoint<'a>)> {
    let joints = around.joints_of(body);
    let joints = joints.map(|(_, _, handle, joint)| {
        let any = AnyJoint {
            bodies: [joint.body1(), joint.body2()],
            data: &joint.data,
            reduced: false,
            drag: [0.0; 6],
        };
        ((false, handle.into_raw_parts()), any)
    });
    let multibody = multibody_of(body, around);
    let reduced = multibody.into_iter().flat_map(move |multibody| {
        let joined = multibody
            .links()
            .filter_map(|link| Some((link, parent(multibody, link)?)));
        let own = joined.filter(move |(link, parent)| {
            link.rigid_body_handle() == body || parent.rigid_body_handle() == body
        });
        own.map(|(link, parent)| {
            let handle = link.rigid_body_handle();
            let any = AnyJoint {
                bodies: [parent.rigid_body_handle(), handle],
                data: &link.joint.data,
                reduced: true,
                drag: drag(multibody, link),
            };
            ((true, handle.into_raw_parts()), any)
        })
    });
    joints.chain(reduced).collect()
}

/// The multibody that a body is a link of.
pub fn multibody_of<'a>(body: RigidBodyHandle, around: &Surroundings<'a>) -> Option<&'a Multibody> {
    let link = around.multibodies.rigid_body_link(body)?;
    around.multibodies.get_multibody(link.multibody)
}

fn parent<'a>(multibody: &'a Multibody, link: &MultibodyLink) -> Option<&'a MultibodyLink> {
    link.parent_id().and_then(|id| multibody.link(id))
}

fn drag(multibody: &Multibody, link: &MultibodyLink) -> [f64; 6] {
    let mut free = link.assembly_id()..;
    [0, 1, 2, 3, 4, 5].map(|i| {
        let is_locked = link.joint.data.locked_axes.bits() & (1 << i) != 0;
        let own = if is_locked { None } else { free.next() };
        own.and_then(|i| multibody.damping().get(i))
            .map_or(0.0, |&d| d.into())
    })
}

/// Whether shadows can keep all joints of a multibody.
fn can_keep(multibody: &Multibody) -> bool {
    let joints = multibody.links().filter(|link| !link.is_root());
    let mut joints = joints.map(|link| &link.joint);
    let zero = |values: &[f32]| values.iter().all(|x| *x == 0.0);
    multibody.couplings().is_empty()
        && zero(multibody.frictions().as_slice())
        && zero(multibody.armature().as_slice())
        && joints.all(|joint| {
            let has_springs = (0..6).any(|i| joint.spring(i).0 != 0.0);
            !joint.kinematic && !has_springs && joint.data.coupled_axes.is_empty()
        })
}

/// The bodies that joints hold together with `body`, itself included, if shadows can keep all of these joints.
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
        if multibody_of(current, around).is_some_and(|m| !can_keep(m)) {
            return None;
        }
        for (_, joint) in of(current, around) {
            if !joint.reduced && !is_kept(&joint, around, dt) {
                return None;
            }
            for other in joint.bodies {
                let moves = around.bodies.get(other).is_some_and(|b| b.is_dynamic());
                if moves && known.insert(other.into_raw_parts()) {
                    found.push(other);
                }
            }
        }
    }
    Some(found)
}

/// Whether shadows can keep a joint that is none of a multibody.
fn is_kept(joint: &AnyJoint, around: &Surroundings, dt: f64) -> bool {
    let on_link = holds_link(joint, around);
    let joint = joint.data;
    let coupled = joint.coupled_axes & JointAxesMask::ANG_AXES;
    let cone = coupled.intersects(joint.limit_axes);
    let clash = joint.coupled_axes.intersects(joint.locked_axes);
    let limited = !(joint.limit_axes & !joint.locked_axes).is_empty();
    !cone && !clash && !((limited || on_link) && is_soft(joint, dt))
}

/// Whether it holds a link of a multibody, which weighs what its own joints make of it.
fn holds_link(joint: &AnyJoint, around: &Surroundings) -> bool {
    let mut bodies = joint.bodies.iter();
    bodies.any(|body| multibody_of(*body, around).is_some())
}

/// Whether a joint gives way for longer than a step of `dt` s. By a frequency of 0, or endless damping, Rapier
/// holds velocities as hard as by none.
pub fn is_soft(joint: &GenericJoint, dt: f64) -> bool {
    let per_step = f64::from(joint.softness.natural_frequency) * dt;
    0.0 < per_step && per_step < 1.0 && joint.softness.damping_ratio.is_finite()
}

/// What the joint does to its bodies in a step of `dt` s.
pub fn held(joint: &AnyJoint, around: &Surroundings, dt: f64) -> Option<RigidJoint> {
    let AnyJoint {
        bodies: handles,
        data,
        reduced,
        drag,
    } = *joint;
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
    let solver_step = dt / iterations.max(1) as f64;
    let gives_way = !reduced && !holds_link(joint, around) && is_soft(data, solver_step);
    let softness = gives_way.then(|| {
        let spring = data.softness;
        let relaxes = around.parameters.num_internal_stabilization_iterations > 0;
        let omega = f64::from(spring.natural_frequency) * TAU;
        Softness::new(omega, spring.damping_ratio.into(), solver_step, relaxes)
    });
    let sweeps = around.parameters.num_internal_pgs_iterations
        + around.parameters.num_internal_stabilization_iterations;
    Some(RigidJoint {
        bodies: handles,
        anchors: [first, second],
        frames: [one, two],
        axes: Axes {
            locked: axes.map(|i| is_in(data.locked_axes, i)),
            softness,
            coupled: [0, 1, 2].map(|i| is_in(coupled, i)),
            limits,
            motors,
            solver_step,
            sweeps: if reduced { i32::MAX } else { sweeps as i32 },
            drag,
        },
        per_mass: axes.map(|i| data.motors[i].model == MotorModel::AccelerationBased),
    })
}
