//! Position-based kinematic bodies while a frame is cut into several Rapier steps.

use crate::math::Pose;
use rapier3d::dynamics::{RigidBodyHandle, RigidBodySet};

/// Where position-based kinematic bodies go in a frame of several Rapier steps: a part of the way in each, the last one
/// exactly to the user's target.
pub(super) struct KinematicTargets(Vec<(RigidBodyHandle, Pose, Pose)>);

impl KinematicTargets {
    pub fn read(bodies: &RigidBodySet, steps: usize) -> Self {
        if steps == 1 {
            return Self(Vec::new());
        }
        Self(
            bodies
                .iter()
                .filter(|(_, b)| {
                    b.body_type() == rapier3d::dynamics::RigidBodyType::KinematicPositionBased
                })
                .filter(|(_, b)| b.position() != b.next_position())
                .map(|(h, b)| (h, *b.position(), *b.next_position()))
                .collect(),
        )
    }

    pub fn set(&self, bodies: &mut RigidBodySet, step: usize, steps: usize) {
        for (handle, start, end) in &self.0 {
            let pose = if step == steps {
                *end
            } else {
                start.lerp(end, step as f32 / steps as f32)
            };
            if let Some(body) = bodies.get_mut(*handle) {
                body.set_next_kinematic_position(pose);
            }
        }
    }
}
