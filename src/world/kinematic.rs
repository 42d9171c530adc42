//! Kinematic bodies: how they move within a frame, while it is cut into several Rapier steps.

use super::course::{Course, off_line};
use super::group::BodyKey;
use crate::contact::target::wide_rotation;
use crate::coupling::flight::rotation_vector;
use crate::math::{DQuat, DVec3, Pose, Vector, narrow, wide};
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
    /// Where a position-based one was to be at the end of the last frame: elsewhere something else has moved it.
    end: Pose,
    /// The rates at which its velocities change in the frame under way \[m/s², rad/s²\].
    pub bend: (DVec3, DVec3),
    linear: Course,
    angular: Course,
}

impl BodyCourse {
    /// Of a body that has stood.
    fn at(end: &Pose) -> Self {
        Self {
            end: *end,
            bend: Default::default(),
            linear: Course::default(),
            angular: Course::default(),
        }
    }

    /// Goes on with a frame of `dt` s at these velocities in the mean \[m/s, rad/s\].
    fn go_on(&mut self, (linear, angular): (DVec3, DVec3), dt: f64) {
        self.bend = (
            self.linear.go_on(linear, dt),
            self.angular.go_on(angular, dt),
        );
    }

    /// Whether it has stood still for two frames: nothing is to be remembered.
    fn is_over(&self) -> bool {
        self.linear.is_over() && self.angular.is_over()
    }
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

/// A velocity-based body with the velocities that it has from its user \[m/s, rad/s\], and the rates at which they change.
struct Drive {
    body: RigidBodyHandle,
    velocities: (Vector, Vector),
    bend: (DVec3, DVec3),
}

/// Where kinematic bodies go in a frame of `dt` s: a part of the way in each of several Rapier steps, the last one of
/// position-based ones exactly to the user's target.
pub(super) struct KinematicTargets {
    ways: Vec<Way>,
    drives: Vec<Drive>,
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
            let mut course = known.copied().unwrap_or_else(|| BodyCourse::at(&end));
            course.end = end;
            let turn = wide_rotation(end.rotation) * wide_rotation(start.rotation).inverse();
            let center = wide(b.local_center_of_mass());
            let way = place(&end, center) - place(&start, center);
            course.go_on((way / dt, rotation_vector(turn) / dt), dt);
            if !course.is_over() {
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
        let drives = read_drives(bodies, courses, &mut followed, dt);
        *courses = followed;
        Self { ways, drives, dt }
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
        let since_middle = ((step as f64 - 0.5) / steps as f64 - 0.5) * self.dt;
        self.drive(bodies, since_middle);
    }

    /// Gives velocity-based bodies what their users gave them.
    pub fn restore(&self, bodies: &mut RigidBodySet) {
        self.drive(bodies, 0.0);
    }

    /// Gives velocity-based bodies the velocities of a time since the middle of the frame \[s\].
    fn drive(&self, bodies: &mut RigidBodySet, since_middle: f64) {
        for drive in &self.drives {
            if let Some(body) = bodies.get_mut(drive.body) {
                let ((linvel, angvel), bend) = (drive.velocities, drive.bend);
                body.set_linvel(linvel + narrow(bend.0 * since_middle), false);
                body.set_angvel(angvel + narrow(bend.1 * since_middle), false);
            }
        }
    }
}

/// The velocity-based bodies whose velocities change within the frame, and what is remembered of all that move.
fn read_drives(
    bodies: &RigidBodySet,
    courses: &Courses,
    followed: &mut Courses,
    dt: f64,
) -> Vec<Drive> {
    let is_driven = |b: &RigidBody| b.body_type() == RigidBodyType::KinematicVelocityBased;
    let driven = bodies
        .iter()
        .filter(|(_, b)| is_driven(b) && b.is_enabled() && !b.is_sleeping());
    let mut drives = Vec::new();
    for (body, b) in driven {
        let velocities = (b.linvel(), b.angvel());
        let key = body.into_raw_parts();
        let known = courses.get(&key);
        if velocities == Default::default() && known.is_none() {
            continue;
        }
        let mut course = known
            .copied()
            .unwrap_or_else(|| BodyCourse::at(b.position()));
        course.go_on((wide(velocities.0), wide(velocities.1)), dt);
        if !course.is_over() {
            followed.insert(key, course);
        }
        if course.bend != Default::default() {
            drives.push(Drive {
                body,
                velocities,
                bend: course.bend,
            });
        }
    }
    drives
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
