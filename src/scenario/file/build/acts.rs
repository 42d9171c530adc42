//! What acts over time: forces, led motions, motors.
//!
//! Rapier's forces and motors hold for a whole step, so a force that changes is taken in the middle of the step; a place
//! that is led to is that at its end.

use super::super::super::Run;
use super::super::model::{self, Region, Scenario, Signal};
use super::{RunError, joints, selected};
use crate::body::NodeId;
use crate::math::{DVec3, Pose, Real, Rotation, Vector, narrow};
use crate::world::DeformableHandle;
use rapier3d::dynamics::{ImpulseJointHandle, JointAxis, RigidBodyHandle, RigidBodyType};
use std::collections::HashSet;

/// An actuator with its handles.
pub(super) enum Act {
    PushRigid {
        body: RigidBodyHandle,
        force: [Signal; 3],
        torque: [Signal; 3],
    },
    PushNodes {
        body: DeformableHandle,
        /// Nodes and their shares of the force.
        nodes: Vec<(NodeId, f64)>,
        force: [Signal; 3],
    },
    LeadRigid {
        body: RigidBodyHandle,
        from: Pose,
        by: [Signal; 3],
        turn: [Signal; 3],
    },
    LeadNodes {
        body: DeformableHandle,
        /// Nodes and where they began \[m\].
        nodes: Vec<(NodeId, DVec3)>,
        by: [Signal; 3],
    },
    Drive {
        joint: ImpulseJointHandle,
        axis: JointAxis,
        position: Option<Signal>,
        velocity: Option<Signal>,
    },
}

/// The acts of a scene, and which actuator each is of.
type Acts = Vec<(usize, Act)>;

/// Finds what the actuators of a scene act on.
pub(super) fn prepare(
    scene: &Scenario,
    run: &Run,
    joints: &[(String, ImpulseJointHandle)],
) -> Result<Acts, RunError> {
    let mut acts = Vec::new();
    for (i, act) in scene.actuators.iter().enumerate() {
        let act = match act {
            model::Act::Force {
                on,
                nodes,
                force,
                torque,
            } => push(run, on, nodes.as_ref(), force, torque)?,
            model::Act::Move {
                of,
                nodes,
                by,
                turn,
            } => lead(run, of, nodes.as_ref(), by, turn)?,
            model::Act::Drive {
                joint: name,
                position,
                velocity,
            } => {
                let made = joints.iter().find(|(n, _)| n == name).map(|(_, h)| *h);
                let said = scene.joints.iter().find(|j| j.name == *name);
                let axis = said
                    .filter(|j| j.motor.is_some())
                    .and_then(|j| joints::axis(&j.kind));
                let (Some(joint), Some(axis)) = (made, axis) else {
                    let what = "only a joint with a motor can be driven";
                    return unfit(name, what);
                };
                Some(Act::Drive {
                    joint,
                    axis,
                    position: position.clone(),
                    velocity: velocity.clone(),
                })
            }
        };
        acts.extend(act.map(|act| (i, act)));
    }
    alone(run, &acts)?;
    Ok(acts)
}

/// A node can't be led by two.
fn alone(run: &Run, acts: &Acts) -> Result<(), RunError> {
    let mut led = HashSet::new();
    for (_, act) in acts {
        let Act::LeadNodes { body, nodes, .. } = act else {
            continue;
        };
        if !nodes.iter().all(|(node, _)| led.insert((*body, *node))) {
            let mut all = run.cast.deformables.iter();
            let name = all.find(|(_, handle)| handle == body);
            let name = name.map_or("", |(name, _)| name);
            return unfit(name, "two motions lead the same nodes");
        }
    }
    Ok(())
}

fn unfit<T>(name: &str, what: &'static str) -> Result<T, RunError> {
    Err(RunError::Unfit {
        name: name.into(),
        what,
    })
}

fn push(
    run: &Run,
    on: &str,
    region: Option<&Region>,
    force: &[Signal; 3],
    torque: &[Signal; 3],
) -> Result<Option<Act>, RunError> {
    if let Some(body) = run.cast.body(on) {
        let kind = run.world.bodies.get(body).map(|b| b.body_type());
        if kind != Some(RigidBodyType::Dynamic) || region.is_some() {
            return unfit(on, "forces act on dynamic rigid bodies, as a whole");
        }
        let (force, torque) = (force.clone(), torque.clone());
        return Ok(Some(Act::PushRigid {
            body,
            force,
            torque,
        }));
    }
    let Some((body, soft)) = deformable(run, on) else {
        return Ok(None);
    };
    if *torque != Signal::none() {
        return unfit(on, "torques act on rigid bodies only");
    }
    let nodes = selected(soft, region, "a force", on)?;
    let mass = |n: &NodeId| f64::from(soft.node_mass(*n).unwrap_or(0.0));
    let whole: f64 = nodes.iter().map(mass).sum();
    let nodes = nodes.iter().map(|n| (*n, mass(n) / whole)).collect();
    let force = force.clone();
    Ok(Some(Act::PushNodes { body, nodes, force }))
}

fn lead(
    run: &Run,
    of: &str,
    region: Option<&Region>,
    by: &[Signal; 3],
    turn: &[Signal; 3],
) -> Result<Option<Act>, RunError> {
    let by = by.clone();
    if let Some(body) = run.cast.body(of) {
        let rigid = run.world.bodies.get(body);
        let rigid = rigid.filter(|b| b.body_type() == RigidBodyType::KinematicPositionBased);
        let (Some(rigid), None) = (rigid, region) else {
            return unfit(
                of,
                "only bodies of kind KinematicPosition can be led, as a whole",
            );
        };
        return Ok(Some(Act::LeadRigid {
            body,
            from: *rigid.position(),
            by,
            turn: turn.clone(),
        }));
    }
    let Some((body, soft)) = deformable(run, of) else {
        return Ok(None);
    };
    if *turn != Signal::none() {
        return unfit(of, "only rigid bodies can be turned");
    }
    let nodes = selected(soft, region, "a motion", of)?;
    let pinned = |n: &&NodeId| soft.blueprint().nodes[n.index()].pinned;
    let nodes: Vec<_> = nodes
        .iter()
        .filter(pinned)
        .filter_map(|n| Some((*n, soft.position(*n)?)))
        .collect();
    match nodes.is_empty() {
        true => unfit(of, "only pinned nodes can be led, and none is pinned there"),
        false => Ok(Some(Act::LeadNodes { body, nodes, by })),
    }
}

fn deformable<'a>(
    run: &'a Run,
    name: &str,
) -> Option<(DeformableHandle, &'a crate::world::Deformable)> {
    let handle = run.cast.deformable(name)?;
    Some((handle, run.deformables.get(handle)?))
}

impl Act {
    /// Takes back what it did to the last step. All acts do so before the first acts: forces on one body add up.
    pub fn end(&self, run: &mut Run) {
        if let Self::PushRigid { body, .. } = self
            && let Some(body) = run.world.bodies.get_mut(*body)
        {
            body.reset_forces(false);
            body.reset_torques(false);
        }
    }

    /// Acts on the coming step; does nothing, and says so by `false`, where a signal is not finite.
    pub fn apply(&self, run: &mut Run) -> bool {
        // Whole steps: the sum of Rapier's, which are `f32`, drifts by 1e-8.
        let steps = run.steps as f64;
        let when = |share: f64| ((steps + share) * run.options.dt).min(run.options.duration);
        // The last step may go on a little longer than what a formula was written for.
        let [middle, end] = [0.5, 1.0].map(when);
        let exact = |signals: &[Signal; 3], time| {
            let v = DVec3::from_array(std::array::from_fn(|i| signals[i].at(time)));
            narrow(v).is_finite().then_some(v)
        };
        let vector = |signals: &[Signal; 3], time| exact(signals, time).map(narrow);
        let number = |signal: &Option<Signal>, time| {
            let value = signal.as_ref().map(|s| s.at(time) as Real);
            value.is_none_or(Real::is_finite).then_some(value)
        };
        match self {
            Self::PushRigid {
                body,
                force,
                torque,
            } => {
                let (Some(force), Some(torque)) = (vector(force, middle), vector(torque, middle))
                else {
                    return false;
                };
                if let Some(body) = run.world.bodies.get_mut(*body) {
                    // A force of nothing must not keep a body awake.
                    body.add_force(force, force != Vector::ZERO);
                    body.add_torque(torque, torque != Vector::ZERO);
                }
            }
            Self::PushNodes { body, nodes, force } => {
                let Some(force) = exact(force, middle) else {
                    return false;
                };
                if let Some(body) = run.deformables.get_mut(*body) {
                    for (node, share) in nodes {
                        body.add_step_force(*node, narrow(force * *share));
                    }
                }
            }
            Self::LeadRigid {
                body,
                from,
                by,
                turn,
            } => {
                let (Some(by), Some(turn)) = (vector(by, end), vector(turn, end)) else {
                    return false;
                };
                let turn = Rotation::from_scaled_axis(turn) * from.rotation;
                let place = from.translation + by;
                if let Some(body) = run.world.bodies.get_mut(*body) {
                    body.set_next_kinematic_position(Pose::from_parts(place, turn));
                }
            }
            Self::LeadNodes { body, nodes, by } => {
                let Some(by) = exact(by, end) else {
                    return false;
                };
                if let Some(body) = run.deformables.get_mut(*body) {
                    for (node, from) in nodes {
                        body.set_kinematic_target(*node, narrow(*from + by));
                    }
                }
            }
            Self::Drive {
                joint,
                axis,
                position,
                velocity,
            } => {
                let (Some(position), Some(velocity)) =
                    (number(position, end), number(velocity, middle))
                else {
                    return false;
                };
                if let Some(joint) = run.world.impulse_joints.get_mut(*joint, true) {
                    let motor = &mut joint.data.motors[*axis as usize];
                    motor.target_pos = position.unwrap_or(motor.target_pos);
                    motor.target_vel = velocity.unwrap_or(motor.target_vel);
                }
            }
        }
        true
    }
}
