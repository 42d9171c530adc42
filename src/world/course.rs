//! The course of what is led from target to target, frame by frame: kinematic bodies and nodes.
//!
//! Targets tell where something is at the ends of frames, not how it gets there. In a straight line its velocity would jump by a·dt
//! at every target, which throws what lies on it: at 60 frames a second a block on a platform that swings by 5 cm at 8/s lifts
//! off, where mechanics presses it by half its weight at least. So velocity is taken to change within a frame at the rate at
//! which it has changed from frame to frame, by which a steadily accelerated course is exact; where that rate comes suddenly, as when
//! something sets out or stops, a frame is left straight (a slope limiter; van Leer 1977).

use crate::math::DVec3;
use std::collections::BTreeMap;

/// What is remembered of a course, of a point \[m\] or a rotation \[rad\]: all zero for what has stood still, which is what is thought of
/// the time before the first frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(super) struct Course {
    /// Mean velocity in the last frame \[m/s, rad/s\].
    velocity: DVec3,
    /// By how much the mean velocity had changed from the frame before, per time \[m/s², rad/s²\].
    slope: DVec3,
    /// Length of the last frame \[s\]; 0 before the first.
    dt: f64,
}

/// A change of velocity in a frame of less is none \[m/s, rad/s\]: positions of `f32` are not more exact.
const SMOOTH: f64 = 1e-3;

impl Course {
    /// Goes on with a frame of `dt` s at `velocity` in the mean, and says at which rate the velocity changes within it.
    pub fn go_on(&mut self, velocity: DVec3, dt: f64) -> DVec3 {
        let last = if self.dt > 0.0 { self.dt } else { dt };
        let slope = (velocity - self.velocity) / (0.5 * (dt + last));
        let before = std::mem::replace(
            self,
            Self {
                velocity,
                slope,
                dt,
            },
        );
        // From between the two frames to the middle of this one.
        let rate = slope * 1.5 - before.slope * 0.5;
        let agree = slope.dot(before.slope) > 0.0 && slope.dot(rate) > 0.0;
        if !(slope.is_finite() && agree) || velocity == DVec3::ZERO {
            return DVec3::ZERO;
        }
        let most = 2.0 * before.slope.length().min(slope.length());
        let rate = rate.clamp_length_max(most);
        if rate.length() * dt > SMOOTH {
            rate
        } else {
            DVec3::ZERO
        }
    }

    /// Whether it has stood still for two frames: nothing is to be remembered.
    pub fn is_over(&self) -> bool {
        self.velocity == DVec3::ZERO && self.slope == DVec3::ZERO
    }
}

/// The courses of the nodes of a body that are led.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(super) struct NodeCourses {
    of: BTreeMap<u32, NodeCourse>,
    /// Length of the rigid step under way, and how much of it is over \[s\].
    step: (f64, f64),
}

/// The course of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
struct NodeCourse {
    /// Where the node is to be at the end of the frame \[m\].
    end: DVec3,
    /// The rate at which its velocity changes in it \[m/s²\].
    bend: DVec3,
    /// Its mean velocity in the rigid step under way \[m/s\].
    mean: DVec3,
    /// Its velocity, and by how much it changed for the substep under way \[m/s\].
    velocity: DVec3,
    change: DVec3,
    course: Course,
}

/// How far from the last target a node is taken to have been led on from there \[m\].
const SAME_PLACE: f64 = 1e-6;

impl NodeCourses {
    /// Goes on with the courses of nodes that are led, each from where it is to its target, in a frame of `dt` s; those of others
    /// are forgotten.
    pub fn go_on(&mut self, led: impl Iterator<Item = (u32, [DVec3; 2])>, dt: f64) {
        let followed = led.map(|(node, [at, target])| {
            let known = self.of.get(&node);
            // Elsewhere something else has moved it.
            let known = known.filter(|c| c.end.distance(at) <= SAME_PLACE);
            let mut followed = known.copied().unwrap_or_default();
            followed.end = target;
            // Told to stand, it stands.
            let way = if target.distance(at) <= SAME_PLACE {
                DVec3::ZERO
            } else {
                target - at
            };
            followed.bend = followed.course.go_on(way / dt, dt);
            (node, followed)
        });
        self.of = followed.collect();
    }

    /// The mean velocity of a node in the next `dt` s, of which it has this one till the end of the frame, in `remaining` s.
    pub fn mean(&self, node: u32, velocity: DVec3, (remaining, dt): (f64, f64)) -> DVec3 {
        let bend = self.of.get(&node).map_or(DVec3::ZERO, |c| c.bend);
        velocity - bend * (0.5 * (remaining - dt))
    }

    /// Begins a rigid step of `dt` s with these mean velocities.
    pub fn begin(&mut self, means: &[(usize, DVec3)], dt: f64) {
        self.step = (dt, 0.0);
        for (node, mean) in means {
            if let Some(course) = self.of.get_mut(&(*node as u32)) {
                (course.mean, course.velocity) = (*mean, *mean);
            }
        }
    }

    /// Begins a substep of h s: the nodes whose velocities change, and to what.
    pub fn substep(&mut self, h: f64) -> impl Iterator<Item = (usize, DVec3)> + '_ {
        let (dt, over) = self.step;
        self.step.1 = over + h;
        let bent = self.bent();
        bent.map(move |(node, course)| {
            let now = course.mean + course.bend * (over + 0.5 * (h - dt));
            course.change = now - course.velocity;
            course.velocity = now;
            (node, now)
        })
    }

    /// The nodes whose velocities have changed for this substep, and by how much.
    pub fn changes(&self) -> impl Iterator<Item = (usize, DVec3)> + '_ {
        let bent = self.of.iter().filter(|(_, c)| c.bend != DVec3::ZERO);
        bent.map(|(node, course)| (*node as usize, course.change))
    }

    fn bent(&mut self) -> impl Iterator<Item = (usize, &mut NodeCourse)> {
        let bent = self.of.iter_mut().filter(|(_, c)| c.bend != DVec3::ZERO);
        bent.map(|(node, course)| (*node as usize, course))
    }

    /// Nodes with a course.
    #[cfg(feature = "serde-serialize")]
    pub fn nodes(&self) -> impl Iterator<Item = &u32> {
        self.of.keys()
    }

    /// Forgets them all.
    pub fn clear(&mut self) {
        self.of.clear();
    }
}

/// How far a course of the rate `bend` is from the straight one after a share of a frame of `dt` s.
pub(super) fn off_line(bend: DVec3, dt: f64, share: f64) -> DVec3 {
    bend * (0.5 * dt * dt * share * (share - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1.0 / 60.0;

    fn bends(course: &mut Course, at: impl Fn(f64) -> f64, frames: usize) -> Vec<f64> {
        let mean = |i: usize| (at((i + 1) as f64 * DT) - at(i as f64 * DT)) / DT;
        let bend = |i: usize| course.go_on(DVec3::X * mean(i), DT).x;
        (0..frames).map(bend).collect()
    }

    #[test]
    fn a_steady_acceleration_is_found() {
        let found = bends(&mut Course::default(), |t| 1.5 * t * t, 5);
        assert_eq!(found[0], 0.0, "it might stay that fast");
        assert!(
            found[1..].iter().all(|a| (a - 3.0).abs() < 1e-9),
            "{found:?}"
        );
    }

    #[test]
    fn what_sets_out_or_stops_at_once_goes_straight() {
        let mut course = Course::default();
        let found = bends(&mut course, |t| 2.0 * t, 5);
        assert!(found.iter().all(|a| a.abs() < 1e-9), "{found:?}");
        let found = bends(&mut course, |_| 0.0, 5);
        assert!(found.iter().all(|a| a.abs() < 1e-9), "{found:?}");
    }

    /// Its velocity jumps by ω·dt, 0.13, of what it would on straight lines.
    #[test]
    fn a_swing_is_nearly_smooth() {
        let (w, amplitude) = (8.0, 0.05);
        let at = |t: f64| amplitude * (1.0 - (w * t).cos());
        let found = bends(&mut Course::default(), at, 200);
        let mean = |i: usize| (at((i + 1) as f64 * DT) - at(i as f64 * DT)) / DT;
        let jump = |i: usize| {
            let end = mean(i - 1) + 0.5 * DT * found[i - 1];
            (mean(i) - 0.5 * DT * found[i] - end).abs()
        };
        let most = (3..200).map(jump).fold(0.0, f64::max);
        assert!(most < 0.15 * amplitude * w * w * DT, "{most}");
    }

    #[test]
    fn a_course_ends_at_its_target() {
        let bend = DVec3::new(1.0, -2.0, 3.0);
        assert_eq!(off_line(bend, DT, 0.0), DVec3::ZERO);
        assert_eq!(off_line(bend, DT, 1.0), DVec3::ZERO);
        // Halfway it is behind by a·dt²/8.
        let behind = off_line(bend, DT, 0.5) + bend * (DT * DT / 8.0);
        assert!(behind.length() < 1e-12);
    }
}
