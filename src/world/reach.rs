//! Which colliders a deformable can reach within a stretch of time, asked of Rapier's own BVH.

use super::report::note;
use super::{Deformable, RapierParts};
use crate::contact::target::{Target, admits, target};
use crate::math::narrow;
use rapier3d::dynamics::RigidBody;
use rapier3d::geometry::{Aabb, Collider, ColliderHandle};
use rapier3d::parry::query::DefaultQueryDispatcher;
use rapier3d::pipeline::QueryFilter;

/// Distance a body may cover in `dt` s, and a margin \[m\].
fn travel(speed: f64, dt: f64, parts: &RapierParts) -> f64 {
    let fall = f64::from(parts.gravity.length()) * dt * dt;
    (speed * dt + fall) * 1.5 + 0.05 * parts.length_unit()
}

/// The fastest that any point of an awake body can move \[m/s\].
pub(super) fn fastest_rigid(parts: &RapierParts) -> f64 {
    parts
        .islands
        .active_bodies()
        .filter_map(|h| parts.bodies.get(h))
        .map(point_speed)
        .fold(0.0, f64::max)
}

fn point_speed(body: &RigidBody) -> f64 {
    let extent = f64::from(body.mass_properties().max_extent());
    f64::from(body.linvel().length()) + f64::from(body.angvel().length()) * extent
}

/// Calls `found` for every collider the body may touch within `dt` s, in the order of their handles. `rigid_speed` is
/// that of the fastest rigid body.
pub(super) fn for_each_in_reach(
    body: &Deformable,
    parts: &RapierParts,
    rigid_speed: f64,
    dt: f64,
    mut found: impl FnMut(ColliderHandle, &Collider, Option<&RigidBody>),
) {
    let speed = f64::from(body.max_speed_squared()).sqrt();
    let reach = travel(speed + rigid_speed, dt, parts);
    let (lo, hi) = body.bounds();
    // f32 corners far from the origin are coarse: a relative margin covers it.
    let coarse = (lo.abs().max(hi.abs()) * 2e-7).max_element();
    let aabb = Aabb::new(narrow(lo - reach - coarse), narrow(hi + reach + coarse));
    let query = parts.broad_phase.as_query_pipeline(
        &DefaultQueryDispatcher,
        parts.bodies,
        parts.colliders,
        QueryFilter::default(),
    );
    let mut hits: Vec<_> = query.intersect_aabb_conservative(aabb).collect();
    hits.sort_by_key(|(handle, _)| handle.into_raw_parts());
    for (handle, collider) in hits {
        let rigid = collider.parent().and_then(|h| parts.bodies.get(h));
        if admits(collider, rigid, body.surface()) {
            found(handle, collider, rigid);
        }
    }
}

/// The targets of a body for a rigid step of `dt` s. Colliders of other shapes are noted in `unsupported`.
pub(super) fn targets(
    body: &Deformable,
    parts: &RapierParts,
    rigid_speed: f64,
    dt: f64,
    unsupported: &mut Vec<ColliderHandle>,
) -> Vec<Target> {
    let mut targets = Vec::new();
    for_each_in_reach(body, parts, rigid_speed, dt, |handle, collider, _| {
        match target(handle, collider, parts.bodies, body.surface()) {
            Some(t) => targets.push(t),
            None => note(unsupported, handle),
        }
    });
    targets
}
