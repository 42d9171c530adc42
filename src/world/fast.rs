//! Rigid bodies that come from afar in one stretch of time.
//!
//! Deformables look around themselves as far as their own speed takes them and slower bodies may come, which is about as
//! far as they look anyway. What is faster is met only where its own way leads: by the speed of the fastest body of all a
//! thousand blocks would look for each other within metres, for one bullet that flies a kilometre off.

use super::reach::{grown, travel, true_bounds};
use super::{AttachmentState, RapierParts};
use crate::contact::target::{is_on, wide_rotation};
use crate::coupling::attach::Point;
use crate::coupling::observe::velocity;
use crate::math::{Vector, narrow, wide};
use rapier3d::data::arena::Arena;
use rapier3d::dynamics::RigidBody;
use rapier3d::geometry::Aabb;
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};

/// How far a body goes at least that is fast, in length units: as far as the margin around everything that moves.
const FAR: f64 = 0.05;

/// Beyond what no way and no box counts \[m\].
const FARTHEST: f32 = 1e9;

/// The awake rigid bodies and how fast they are in a stretch of time.
#[derive(Default)]
pub(super) struct Fast {
    /// Speed of the fastest body that is not fast \[m/s\].
    slow: f64,
    /// Of each collider of fast bodies, and of what they hold of a deformable \[m/s\].
    speeds: Vec<f64>,
    /// Where they may come to, each in all directions: it may be thrown back.
    tree: Bvh,
}

impl Fast {
    /// Those of the coming `dt` s, with what they hold. Rapier's set of active bodies lacks those that have not made a step yet,
    /// and the velocity of a kinematic body is that of the last one.
    pub fn find(parts: &RapierParts, holds: &Arena<AttachmentState>, dt: f64) -> Self {
        let mut fast = Self::default();
        let mut boxes = Vec::new();
        for body in parts.bodies.iter().map(|(_, b)| b).filter(is_awake) {
            let (v, w) = velocity(body, dt);
            let extent = f64::from(body.mass_properties().max_extent());
            let speed = v.length() + w.length() * extent;
            if !is_far(speed, dt, parts) {
                fast.slow = fast.slow.max(speed);
                continue;
            }
            for &handle in body.colliders() {
                if let Some(collider) = parts.colliders.get(handle).filter(|c| is_on(c, Some(body)))
                {
                    let bounds = true_bounds(collider, parts);
                    boxes.extend(swept(&bounds, travel(speed, dt, parts)));
                    fast.speeds.resize(boxes.len(), speed);
                }
            }
        }
        for (_, bond) in holds.iter().filter(|(_, bond)| !bond.is_broken()) {
            let body = bond.body().and_then(|b| parts.bodies.get(b));
            let Some(body) = body.filter(is_awake) else {
                continue;
            };
            let (v, w) = velocity(body, dt);
            let (bounds, arm) = held(&bond.points, body);
            let speed = v.length() + w.length() * arm;
            if is_far(speed, dt, parts) {
                boxes.extend(swept(&bounds, travel(speed, dt, parts)));
                fast.speeds.resize(boxes.len(), speed);
            }
        }
        fast.tree = Bvh::from_leaves(BvhBuildStrategy::default(), &boxes);
        fast
    }

    /// Speed of the fastest body that is not fast \[m/s\].
    pub fn slow(&self) -> f64 {
        self.slow
    }

    pub fn is_empty(&self) -> bool {
        self.speeds.is_empty()
    }

    /// Speed of the fastest body whose way leads into a box \[m/s\]; 0 without one.
    pub fn within(&self, bounds: &Aabb) -> f64 {
        let met = self.tree.intersect_aabb(bounds);
        met.map(|i| self.speeds[i as usize]).fold(0.0, f64::max)
    }
}

fn is_awake(body: &&RigidBody) -> bool {
    body.is_enabled() && !body.is_fixed() && !body.is_sleeping()
}

fn is_far(speed: f64, dt: f64, parts: &RapierParts) -> bool {
    1.5 * speed * dt > FAR * parts.length_unit()
}

/// A box with so much more on all sides \[m\], if it is one that numbers can tell. That of a half-space has no volume that
/// they hold.
fn swept(bounds: &Aabb, way: f64) -> Option<Aabb> {
    let most = Vector::splat(FARTHEST);
    let grown = grown(bounds, way.min(FARTHEST.into()));
    let [mins, maxs] = [grown.mins, grown.maxs].map(|v| v.clamp(-most, most));
    (mins.is_finite() && maxs.is_finite()).then(|| Aabb::new(mins, maxs))
}

/// The box around points that a body holds, which no collider of it need be near, and how far they are from its centre of
/// mass at most \[m\].
fn held(points: &[Point], body: &RigidBody) -> (Aabb, f64) {
    let pose = body.position();
    let rot = wide_rotation(pose.rotation);
    let mut bounds = Aabb::new_invalid();
    let mut arm = 0.0_f64;
    for point in points {
        bounds.take_point(narrow(wide(pose.translation) + rot * point.anchor));
        arm = arm.max(point.anchor.distance(wide(body.local_center_of_mass())));
    }
    (bounds, arm)
}
