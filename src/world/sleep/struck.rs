//! Rigid bodies asleep that another rigid body is about to strike.
//!
//! Rapier wakes them within its step, but in that step what they lie on or hold of a deformable would be neither their support
//! nor as stiff as it is: it would find them where one long step of Rapier's has driven them.

use crate::contact::target::is_on;
use crate::coupling::observe::velocity;
use crate::math::{DVec3, Pose, Vector, narrow, wide};
use crate::world::group::{BodyKey, handle_of};
use crate::world::reach::{grown, true_pose};
use crate::world::{DeformableWorld, RapierParts};
use rapier3d::dynamics::{RigidBody, RigidBodyHandle};
use rapier3d::geometry::{Aabb, Collider, ColliderHandle};
use rapier3d::parry::query::{DefaultQueryDispatcher, ShapeCastOptions, cast_shapes};
use rapier3d::pipeline::QueryFilter;
use std::collections::BTreeSet;

/// How much farther than it goes a body counts as going, in length units.
const MARGIN: f64 = 1e-3;

/// At which speed what is near already strikes, in length units per second.
const SLOW: f64 = 0.02;

impl DeformableWorld {
    /// Wakes bodies asleep beside deformables which a rigid body will strike in a step of the world of `dt` s, or that lie or
    /// hang together with one that will be struck.
    pub(in crate::world) fn wake_struck(&self, parts: &mut RapierParts, dt: f64) {
        let held = self.attachments.iter().filter_map(|(_, bond)| bond.body());
        let known = self.memory.keys();
        let known = known.copied().map(handle_of);
        let sleeps = |h: &RigidBodyHandle| parts.is_asleep(*h);
        let beside: BTreeSet<_> = held
            .chain(known)
            .filter(sleeps)
            .map(RigidBodyHandle::into_raw_parts)
            .collect();
        if beside.is_empty() {
            return;
        }
        let mut wake = BTreeSet::new();
        for struck in struck(parts, dt) {
            if wake.contains(&struck) {
                continue;
            }
            let heap = asleep_together(parts, struck);
            if heap.iter().any(|key| beside.contains(key)) {
                wake.extend(heap);
            }
        }
        for key in wake {
            parts.islands.wake_up(parts.bodies, handle_of(key), true);
        }
    }
}

/// The bodies asleep that awake ones come to within `dt` s.
fn struck(parts: &RapierParts, dt: f64) -> BTreeSet<BodyKey> {
    let query = parts.broad_phase.as_query_pipeline(
        &DefaultQueryDispatcher,
        parts.bodies,
        parts.colliders,
        QueryFilter::only_dynamic().exclude_sensors(),
    );
    let mut struck = BTreeSet::new();
    for (_, body) in parts.bodies.iter() {
        let Some(motion) = coming(body, parts, dt) else {
            continue;
        };
        for collider in colliders(body, parts) {
            let striker = Striker::new(collider, body, motion, parts, dt);
            let Some(bounds) = striker.bounds() else {
                continue;
            };
            for (other, _) in query.intersect_aabb_conservative(bounds) {
                if let Some((key, sleeper)) = asleep(parts, other)
                    && !struck.contains(&key)
                    && striker.strikes(sleeper, parts)
                {
                    struck.insert(key);
                }
            }
        }
    }
    struck
}

/// A collider on its way.
struct Striker<'a> {
    collider: &'a Collider,
    pose: Pose,
    /// Of its origin \[m/s\], \[rad/s\].
    v: DVec3,
    w: DVec3,
    /// For how long it goes \[s\].
    dt: f64,
    /// How near what it may turn into is, with a margin \[m\].
    near: f64,
}

impl<'a> Striker<'a> {
    fn new(
        collider: &'a Collider,
        body: &RigidBody,
        (v, w): (DVec3, DVec3),
        parts: &RapierParts,
        dt: f64,
    ) -> Self {
        let pose = true_pose(collider, parts);
        let arm = wide(pose.translation) - wide(body.center_of_mass());
        let radius = collider.shape().compute_local_bounding_sphere().radius;
        Self {
            collider,
            pose,
            v: v + w.cross(arm),
            w,
            dt,
            near: w.length() * f64::from(radius) * dt + MARGIN * parts.length_unit(),
        }
    }

    /// Where it may come to; `None` where numbers can't tell.
    fn bounds(&self) -> Option<Aabb> {
        let now = self.collider.shape().compute_aabb(&self.pose);
        let bounds = grown(&now, self.v.length() * self.dt + self.near);
        (bounds.mins.is_finite() && bounds.maxs.is_finite()).then_some(bounds)
    }

    /// Whether it comes to one that stays where it is, and pushes it if no hook says otherwise.
    fn strikes(&self, other: &Collider, parts: &RapierParts) -> bool {
        let one = self.collider;
        let pushes = one.collision_groups().test(other.collision_groups())
            && one.solver_groups().test(other.solver_groups())
            && one.parent() != other.parent();
        if !pushes {
            return false;
        }
        let there = true_pose(other, parts);
        let [comes, stays] = [narrow(self.v), Vector::ZERO];
        let options = ShapeCastOptions {
            target_distance: self.near as f32,
            ..ShapeCastOptions::with_max_time_of_impact(self.dt as f32)
        };
        let (shape, others) = (one.shape(), other.shape());
        let hit = cast_shapes(&self.pose, comes, shape, &there, stays, others, options);
        match hit {
            Ok(None) => false,
            // What is near already, and goes by, strikes nothing.
            Ok(Some(hit)) if hit.time_of_impact == 0.0 => {
                let arm = wide(self.pose.rotation * hit.witness1);
                let out = wide(self.pose.rotation * hit.normal1);
                (self.v + self.w.cross(arm)).dot(out) > SLOW * parts.length_unit()
            }
            // What can't be cast is in the way.
            Ok(Some(_)) | Err(_) => true,
        }
    }
}

/// The collider of a body asleep, if it is one.
fn asleep<'a>(parts: &'a RapierParts, collider: ColliderHandle) -> Option<(BodyKey, &'a Collider)> {
    let collider = parts.colliders.get(collider)?;
    let parent = collider.parent()?;
    let body = parts.moving(parent)?;
    body.is_sleeping()
        .then_some((parent.into_raw_parts(), collider))
}

/// How a body moves that is awake, if it does \[m/s\], \[rad/s\]; one that is at rest falls by its weight.
fn coming(body: &RigidBody, parts: &RapierParts, dt: f64) -> Option<(DVec3, DVec3)> {
    if !body.is_enabled() || body.is_sleeping() || body.is_fixed() {
        return None;
    }
    let (mut v, w) = velocity(body, dt);
    if body.is_dynamic() {
        v += wide(parts.gravity) * (f64::from(body.gravity_scale()) * dt);
    }
    let moves = v != DVec3::ZERO || w != DVec3::ZERO;
    (moves && v.is_finite() && w.is_finite()).then_some((v, w))
}

fn colliders<'a>(
    body: &'a RigidBody,
    parts: &'a RapierParts,
) -> impl Iterator<Item = &'a Collider> {
    let all = body.colliders().iter();
    let all = all.filter_map(|h| parts.colliders.get(*h));
    all.filter(|c| is_on(c, Some(body)) && !c.is_sensor())
}

/// A body asleep, and all that sleep with it: in contact or on joints.
fn asleep_together(parts: &RapierParts, body: BodyKey) -> BTreeSet<BodyKey> {
    let mut found = BTreeSet::from([body]);
    let mut next = vec![handle_of(body)];
    while let Some(handle) = next.pop() {
        for other in parts.bound_to(handle) {
            let asleep = parts.is_asleep(other);
            if asleep && found.insert(other.into_raw_parts()) {
                next.push(other);
            }
        }
    }
    found
}
