//! Which colliders a deformable can reach within a stretch of time, asked of Rapier's own BVH.
//!
//! The BVH is up to date after a step, not after the user's changes between steps: a new, enabled or reshaped collider,
//! or one whose body was teleported, enters it only within Rapier's next step. Such strays are found by one look over
//! all colliders and tested one by one.

use super::fast::Fast;
use super::hooks::{Gate, PairContext};
use super::known::Known;
use super::report::note;
use super::sense::Sensing;
use super::{AttachmentState, Deformable, DeformableHandle, RapierParts};
use crate::contact::form::Forms;
use crate::contact::target::{
    Target, admits, half_thickness, pushes, skin_of, target, wide_rotation,
};
use crate::math::{DVec3, Pose, narrow, wide};
use crate::solve::shadow::Shadow;
use rapier3d::data::arena::Arena;
use rapier3d::dynamics::RigidBodyHandle;
use rapier3d::geometry::{Aabb, Collider, ColliderHandle};
use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::parry::query::DefaultQueryDispatcher;
use rapier3d::pipeline::QueryFilter;

/// Distance a body may cover in `dt` s, and a margin \[m\].
pub(super) fn travel(speed: f64, dt: f64, parts: &RapierParts) -> f64 {
    let fall = f64::from(parts.gravity.length()) * dt * dt;
    (speed * dt + fall) * 1.5 + 0.05 * parts.length_unit()
}

/// A collider's pose by its body's, which is right even after a teleport.
pub(super) fn true_pose(collider: &Collider, parts: &RapierParts) -> Pose {
    let parent = collider.parent().and_then(|h| parts.bodies.get(h));
    match (parent, collider.position_wrt_parent()) {
        (Some(body), Some(relative)) => *body.position() * *relative,
        _ => *collider.position(),
    }
}

/// The box around a collider by its body's pose, with its skin.
pub(super) fn true_bounds(collider: &Collider, parts: &RapierParts) -> Aabb {
    let bounds = collider.shape().compute_aabb(&true_pose(collider, parts));
    bounds.loosened(skin_of(collider) as f32)
}

/// What every deformable of a step asks alike.
pub(super) struct Search<'a> {
    pub parts: &'a RapierParts<'a>,
    /// The awake rigid bodies.
    pub fast: Fast,
    pub strays: Vec<ColliderHandle>,
    /// The stretch of time \[s\].
    pub dt: f64,
    /// In how many seconds led nodes are led to their targets, before the first Rapier step has given them their velocities.
    pub lead: Option<f64>,
}

impl<'a> Search<'a> {
    /// A search over the next `dt` s, in which rigid bodies hold what they hold.
    pub fn new(
        known: &mut Known,
        holds: &Arena<AttachmentState>,
        parts: &'a RapierParts<'a>,
        dt: f64,
    ) -> Self {
        Self {
            parts,
            fast: Fast::find(parts, holds, dt),
            strays: known.strays(parts),
            dt,
            lead: None,
        }
    }

    /// A search at the beginning of a step of the world, over all of its `dt` s.
    pub fn ahead(
        known: &mut Known,
        holds: &Arena<AttachmentState>,
        parts: &'a RapierParts<'a>,
        dt: f64,
    ) -> Self {
        Self {
            lead: (dt > 0.0).then_some(dt),
            ..Self::new(known, holds, parts, dt)
        }
    }

    /// Speed of the fastest fast body that may meet what is within `bounds` and goes at `speed` m/s, and whatever else that one
    /// drives it to \[m/s\]; 0 without one.
    pub fn fast_speed(&self, bounds: &Aabb, speed: f64) -> f64 {
        let mut fastest = 0.0;
        if self.fast.is_empty() {
            return fastest;
        }
        let margin = 0.02 * self.parts.length_unit();
        loop {
            let speed = speed + self.fast.slow().max(fastest);
            let met = self
                .fast
                .within(&grown(bounds, travel(speed, self.dt, self.parts)));
            let much = (met - fastest) * self.dt > margin;
            fastest = met.max(fastest);
            if !much {
                return fastest;
            }
        }
    }

    /// The same of all rigid bodies. Nobody asks for the bounds while none is fast.
    pub fn rigid_speed(&self, bounds: impl FnOnce() -> Aabb, speed: f64) -> f64 {
        let slow = self.fast.slow();
        if self.fast.is_empty() {
            return slow;
        }
        slow.max(self.fast_speed(&bounds(), speed))
    }
}

/// A box with so much more on all sides \[m\].
pub(super) fn grown(bounds: &Aabb, by: f64) -> Aabb {
    let by = by as f32;
    Aabb::new(bounds.mins - by, bounds.maxs + by)
}

impl Deformable {
    /// The box around its nodes, grown by a margin \[m\].
    pub(super) fn box_within(&self, margin: f64) -> Aabb {
        let (lo, hi) = self.contact_bounds();
        // f32 corners far from the origin are coarse.
        let margin = margin + (lo.abs().max(hi.abs()) * 2e-7).max_element();
        Aabb::new(narrow(lo - margin), narrow(hi + margin))
    }

    /// The distance that its surface keeps \[m\].
    pub(super) fn half_thickness(&self) -> f64 {
        half_thickness(self.surface())
    }
}

/// Calls `found` for every collider the body may touch, moving at `speed` m/s at most, in the order of their handles, with
/// whether it pushes or only notices.
pub(super) fn for_each_in_reach(
    (own, body, speed): (DeformableHandle, &Deformable, f64),
    search: &Search,
    gate: &mut Gate,
    found: impl FnMut(ColliderHandle, &Collider, bool),
) {
    let half = body.half_thickness();
    let rigid_speed = search.rigid_speed(|| body.box_within(half), speed);
    let reach = half + travel(speed + rigid_speed, search.dt, search.parts);
    for_each_within((own, body), &body.box_within(reach), search, gate, found);
}

/// As [`for_each_in_reach`], for every collider within `bounds`.
pub(super) fn for_each_within(
    (own, body): (DeformableHandle, &Deformable),
    bounds: &Aabb,
    search: &Search,
    gate: &mut Gate,
    mut found: impl FnMut(ColliderHandle, &Collider, bool),
) {
    let parts = search.parts;
    let query = parts.broad_phase.as_query_pipeline(
        &DefaultQueryDispatcher,
        parts.bodies,
        parts.colliders,
        QueryFilter::default(),
    );
    let mut hits: Vec<_> = query
        .intersect_aabb_conservative(*bounds)
        .map(|(handle, _)| handle)
        .collect();
    hits.extend(search.strays.iter().filter(|h| {
        let stray = parts.colliders.get(**h);
        stray.is_some_and(|c| true_bounds(c, parts).intersects(bounds))
    }));
    hits.sort_by_key(|handle| handle.into_raw_parts());
    hits.dedup();
    for handle in hits {
        let Some(collider) = parts.colliders.get(handle) else {
            continue;
        };
        let rigid = collider
            .parent()
            .and_then(|h| Some((h, parts.bodies.get(h)?)));
        let pair = PairContext {
            deformable: (own, body),
            collider: (handle, collider),
            body: rigid,
        };
        let rigid = rigid.map(|(_, rigid)| rigid);
        if admits(collider, rigid, body.surface()) && gate.passes(&pair) {
            found(handle, collider, pushes(collider, body.surface()));
        }
    }
}

/// The targets of a body that moves at `speed` m/s at most. Colliders of other shapes are noted in `unsupported`, those that do not push in `sensing`.
pub(super) fn targets(
    (own, body, speed): (DeformableHandle, &Deformable, f64),
    search: &Search,
    gate: &mut Gate,
    forms: &mut Forms,
    unsupported: &mut Vec<ColliderHandle>,
    sensing: &mut Vec<Sensing>,
) -> Vec<Target> {
    let mut targets = Vec::new();
    for_each_in_reach(
        (own, body, speed),
        search,
        gate,
        |handle, collider, pushes| {
            if !pushes {
                sensing.push(Sensing {
                    deformable: own,
                    collider: handle,
                    sensor: collider.is_sensor(),
                    start: true_pose(collider, search.parts),
                });
                return;
            }
            match target(handle, collider, search.parts.bodies, body.surface(), forms) {
                Some(t) => targets.push(t),
                None => note(unsupported, handle),
            }
        },
    );
    targets
}

/// Bodies asleep that some node will run into within the stretch of time, faster than `threshold` \[m/s\], or a pinned one at
/// any speed. They must be awake by then: a sleeper is infinitely heavy, the blow would be lost on it, and what is pinned
/// would go through.
pub(super) fn sleepers_in_the_way(
    (own, body): (DeformableHandle, &Deformable),
    search: &Search,
    gate: &mut Gate,
    forms: &mut Forms,
    threshold: f64,
) -> Vec<RigidBodyHandle> {
    let mut found = Vec::new();
    let (mut unsupported, mut sensing) = (Vec::new(), Vec::new());
    let targets = targets(
        (own, body, body.coming_speed(search.lead)),
        search,
        gate,
        forms,
        &mut unsupported,
        &mut sensing,
    );
    let mut velocities = Vec::new();
    for target in targets {
        let Some((handle, rigid)) = target
            .body
            .and_then(|h| Some((h, search.parts.bodies.get(h)?)))
        else {
            continue;
        };
        if !rigid.is_dynamic() || !rigid.is_sleeping() || found.contains(&handle) {
            continue;
        }
        let pose = rigid.position();
        let rot = wide_rotation(pose.rotation);
        let shadow = Shadow {
            com: wide(pose.translation) + rot * wide(rigid.local_center_of_mass()),
            rot,
            ..Shadow::FIXED
        };
        let frame = target.frame(&shadow);
        let to_local = frame.axes.transpose();
        if velocities.is_empty() {
            velocities = body.coming_velocities(search.lead);
        }
        let point = |i: usize| {
            let place = frame.to_local(&body.state, i as u32);
            (place, to_local * velocities[i])
        };
        let particles = &body.state.particles;
        let pinned = |i: &usize| particles[*i].inv_mass == 0.0 && velocities[*i] != DVec3::ZERO;
        let (all, skin, time) = (0..body.node_count(), target.skin, 1.5 * search.dt);
        let form = &target.form;
        if form.is_hit(all.clone().map(point), skin, time, threshold)
            || form.is_hit(all.filter(pinned).map(point), skin, time, 0.0)
        {
            found.push(handle);
        }
    }
    found
}
