//! Position-based kinematic bodies: how they move within a frame, while it is cut into several Rapier steps.

use super::course::{Course, off_line};
use super::group::BodyKey;
use crate::contact::target::wide_rotation;
use crate::coupling::flight::rotation_vector;
use crate::math::{DQuat, DVec3, Pose, narrow, wide};
use rapier3d::dynamics::{RigidBody, RigidBodyHandle, RigidBodySet, RigidBodyType};
use std::collections::BTreeMap;

/// What is remembered of the courses of kinematic bodies.
pub(super) type Courses = BTreeMap<BodyKey, BodyCourse>;

/// What is remembered of one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(super) struct BodyCourse {
    /// Where it was to be at the end of the last frame: elsewhere something else has moved it.
    end: Pose,
    /// The rates at which its velocities change in the frame under way \[m/s², rad/s²\].
    pub bend: (DVec3, DVec3),
    linear: Course,
    angular: Course,
}

/// One body's way through a frame.
struct Way {
    body: RigidBodyHandle,
    start: Pose,
    end: Pose,
    /// Its centre of mass in its own frame \[m\].
    center: DVec3,
    /// Acceleration of the centre of mass \[m/s²\] and angular acceleration \[rad/s²\] on it.
    bend: (DVec3, DVec3),
}

/// Where position-based kinematic bodies go in a frame of `dt` s: a part of the way in each of several Rapier steps, the last one
/// exactly to the user's target.
pub(super) struct KinematicTargets {
    ways: Vec<Way>,
    dt: f64,
}

impl KinematicTargets {
    /// The ways of those that move, and what is remembered of them for the next frame.
    pub fn read(bodies: &RigidBodySet, courses: &mut Courses, dt: f64) -> Self {
        let mut followed = Courses::new();
        let is_led = |b: &RigidBody| b.body_type() == RigidBodyType::KinematicPositionBased;
        let led = bodies.iter().filter(|(_, b)| is_led(b) && b.is_enabled());
        let mut ways = Vec::new();
        for (body, b) in led {
            let (start, end) = (*b.position(), *b.next_position());
            let key = body.into_raw_parts();
            let known = courses.get(&key).filter(|c| c.end == start);
            if start == end && known.is_none() {
                continue;
            }
            let mut course = known.copied().unwrap_or(BodyCourse {
                end,
                bend: Default::default(),
                linear: Course::default(),
                angular: Course::default(),
            });
            course.end = end;
            let turn = wide_rotation(end.rotation) * wide_rotation(start.rotation).inverse();
            let center = wide(b.local_center_of_mass());
            let way = place(&end, center) - place(&start, center);
            course.bend = (
                course.linear.go_on(way / dt, dt),
                course.angular.go_on(rotation_vector(turn) / dt, dt),
            );
            if !(course.linear.is_over() && course.angular.is_over()) {
                followed.insert(key, course);
            }
            ways.push(Way {
                body,
                start,
                end,
                center,
                bend: course.bend,
            });
        }
        *courses = followed;
        Self { ways, dt }
    }

    /// Tells the bodies where to go in one of `steps` Rapier steps, counted from 1.
    pub fn set(&self, bodies: &mut RigidBodySet, step: usize, steps: usize) {
        if steps == 1 {
            return;
        }
        for way in self.ways.iter().filter(|w| w.start != w.end) {
            let share = step as f64 / steps as f64;
            let pose = if step == steps {
                way.end
            } else {
                way.at(share, self.dt)
            };
            if let Some(body) = bodies.get_mut(way.body) {
                body.set_next_kinematic_position(pose);
            }
        }
    }
}

impl Way {
    /// Where the body is after a share of a frame of `dt` s: its centre of mass goes straight but for the bend, as in Rapier's step.
    fn at(&self, share: f64, dt: f64) -> Pose {
        let mut pose = self.start.lerp(&self.end, share as f32);
        let turned = DQuat::from_scaled_axis(off_line(self.bend.1, dt, share));
        let rotation = turned * wide_rotation(pose.rotation);
        let ends = [&self.start, &self.end].map(|end| place(end, self.center));
        let center = ends[0].lerp(ends[1], share) + off_line(self.bend.0, dt, share);
        pose.translation = narrow(center - rotation * self.center);
        pose.rotation = rotation.as_quat();
        pose
    }
}

/// Where a point of a body is \[m\].
fn place(pose: &Pose, local: DVec3) -> DVec3 {
    wide(pose.translation) + wide_rotation(pose.rotation) * local
}
