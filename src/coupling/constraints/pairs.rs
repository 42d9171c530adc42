//! Which colliders may press on each other, by Rapier's rules.

use crate::contact::target::is_on;
use crate::coupling::observe::Surroundings;
use crate::math::Pose;
use rapier3d::dynamics::{RigidBody, RigidBodyHandle, RigidBodyType};
use rapier3d::geometry::{Collider, ColliderHandle, ContactPair};
use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::parry::query::DefaultQueryDispatcher;
use rapier3d::pipeline::{ActiveHooks, QueryFilter};

/// A collider with its body and where it is.
#[derive(Clone, Copy)]
pub struct Side<'a> {
    pub handle: ColliderHandle,
    pub collider: &'a Collider,
    pub body: Option<(RigidBodyHandle, &'a RigidBody)>,
    pub pose: Pose,
}

/// Two colliders that may press on each other.
pub struct Pair<'a> {
    pub sides: [Side<'a>; 2],
    /// What Rapier's last step found.
    pub last: Option<&'a ContactPair>,
    /// Whether only Rapier can tell what comes of it, because the user's hooks have a say in it.
    pub hooked: bool,
}

impl Pair<'_> {
    /// The same for both orders.
    pub fn key(&self) -> [(u32, u32); 2] {
        let mut key = [&self.sides[0], &self.sides[1]].map(|s| s.handle.into_raw_parts());
        key.sort();
        key
    }

    pub fn bodies(&self) -> [Option<RigidBodyHandle>; 2] {
        [&self.sides[0], &self.sides[1]].map(|s| s.body.map(|(h, _)| h))
    }
}

/// The pairs of a body's colliders, in the order of handles.
pub fn of<'a>(body: &RigidBody, around: &Surroundings<'a>) -> Vec<Pair<'a>> {
    let query = around.broad_phase.as_query_pipeline(
        &DefaultQueryDispatcher,
        around.bodies,
        around.colliders,
        QueryFilter::default(),
    );
    let mut pairs = Vec::new();
    for &handle in body.colliders() {
        let Some(own) = side(handle, around).filter(|s| is_on(s.collider, Some(body))) else {
            continue;
        };
        let reach = around.parameters.prediction_distance() + own.collider.contact_skin();
        let mut bounds = own.collider.shape().compute_aabb(&own.pose);
        bounds.mins -= reach;
        bounds.maxs += reach;
        let near = query.intersect_aabb_conservative(bounds).map(|(h, _)| h);
        let known = around.narrow_phase.contact_pairs_with(handle);
        let known = known.map(|p| {
            if p.collider1 == handle {
                p.collider2
            } else {
                p.collider1
            }
        });
        let mut others: Vec<ColliderHandle> = near.chain(known).collect();
        others.sort_by_key(|h| h.into_raw_parts());
        others.dedup();
        let others = others.into_iter().filter_map(|h| side(h, around));
        pairs.extend(others.filter_map(|other| pair(own, other, around)));
    }
    pairs
}

fn side<'a>(handle: ColliderHandle, around: &Surroundings<'a>) -> Option<Side<'a>> {
    let collider = around.colliders.get(handle)?;
    let parent = collider.parent();
    let body = parent.and_then(|h| Some((h, around.bodies.get(h)?)));
    let pose = match (body, collider.position_wrt_parent()) {
        // Right even after a teleport.
        (Some((_, body)), Some(relative)) => *body.position() * *relative,
        _ => *collider.position(),
    };
    Some(Side {
        handle,
        collider,
        body,
        pose,
    })
}

/// The pair, if Rapier lets these two press on each other.
fn pair<'a>(own: Side<'a>, other: Side<'a>, around: &Surroundings<'a>) -> Option<Pair<'a>> {
    let last = around.narrow_phase.contact_pair(own.handle, other.handle);
    let first_is_own = last.is_none_or(|p| p.collider1 == own.handle);
    let sides = if first_is_own {
        [own, other]
    } else {
        [other, own]
    };
    let [a, b] = [own.collider, other.collider];
    let hooks = a.active_hooks() | b.active_hooks();
    let hooked =
        hooks.intersects(ActiveHooks::FILTER_CONTACT_PAIRS | ActiveHooks::MODIFY_SOLVER_CONTACTS);
    let kind = |s: &Side| s.body.map_or(RigidBodyType::Fixed, |(_, b)| b.body_type());
    let kinds = [kind(&own), kind(&other)];
    let meets = |c: &Collider| c.active_collision_types().test(kinds[0], kinds[1]);
    // Rapier looks at the pairs that it has, and takes up those whose boxes meet.
    let margin = 0.5 * around.parameters.prediction_distance();
    let bounds = |s: &Side| {
        let bounds = s.collider.shape().compute_aabb(&s.pose);
        bounds.loosened(margin + s.collider.contact_skin())
    };
    let near = || last.is_some() || bounds(&own).intersects(&bounds(&other));
    let allowed = is_on(other.collider, other.body.map(|(_, b)| b))
        && !(a.is_sensor() || b.is_sensor())
        && other.body.is_none_or(|(_, b)| !b.is_soft_frame())
        && b.deformable_mesh_ref().is_none()
        && own.body.map(|(h, _)| h) != other.body.map(|(h, _)| h)
        && (meets(a) || meets(b))
        && a.collision_groups().test(b.collision_groups())
        && a.solver_groups().test(b.solver_groups())
        && joints_allow(&own, &other, around)
        && near();
    allowed.then_some(Pair {
        sides,
        last,
        hooked,
    })
}

/// Whether no joint keeps the bodies' colliders from touching.
fn joints_allow(own: &Side, other: &Side, around: &Surroundings) -> bool {
    let (Some((a, _)), Some((b, _))) = (own.body, other.body) else {
        return true;
    };
    let mut joints = around.joints.joints_between(a, b);
    if joints.any(|(_, joint)| !joint.data.contacts_enabled) {
        return false;
    }
    let links = [a, b].map(|h| around.multibodies.rigid_body_link(h));
    let [Some(one), Some(two)] = links else {
        return true;
    };
    let own = one.multibody == two.multibody;
    let multibody = around.multibodies.get_multibody(one.multibody);
    let between = around.multibodies.joint_between(a, b);
    !own || multibody.is_none_or(|m| m.self_contacts_enabled())
        && between.is_none_or(|(_, _, link)| link.joint.data.contacts_enabled)
}
