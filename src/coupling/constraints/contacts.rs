//! The points of a pair.

use super::RigidContact;
use super::pairs::Pair;
use crate::coupling::observe::Surroundings;
use crate::math::{DVec3, Pose, wide};
use rapier3d::dynamics::CoefficientCombineRule;
use rapier3d::geometry::{ContactData, ContactManifold, ContactManifoldData, SolverFlags};
use rapier3d::parry::query::{DefaultQueryDispatcher, PersistentQueryDispatcher};

/// Where the colliders of a pair touch now or nearly so. Where hooks have a say, and where many parts of a composite shape
/// touch, which Rapier sums up in its own way, it is what the last step found.
pub fn of(pair: &Pair, around: &Surroundings) -> Vec<RigidContact> {
    let last = pair.last.filter(|p| p.has_any_active_contact());
    let many = last.is_some_and(|p| p.manifolds().len() > 1);
    if pair.hooked || many {
        return last.map_or_else(Vec::new, |_| remembered(pair, around));
    }
    found_anew(pair, around)
}

/// What Rapier has found, where it is now.
fn remembered(pair: &Pair, around: &Surroundings) -> Vec<RigidContact> {
    let manifolds = pair.last.map_or(&[][..], |p| p.solver_manifolds()).iter();
    let answered = manifolds.filter(|m| {
        let flags = m.data.solver_flags;
        flags.contains(SolverFlags::COMPUTE_RIGID_IMPULSES)
    });
    let contacts = answered.flat_map(|m| {
        m.data.solver_contacts.iter().map(move |c| {
            let (first, second) = m.data.solver_contact_world_points(c, around.bodies);
            let id = (c.contact_id[0] & !rapier3d::geometry::NEW_CONTACT_BIT) as usize;
            RigidContact {
                points: [wide(first), wide(second)],
                normal: wide(m.data.normal),
                friction: m.data.friction.into(),
                belt: wide(c.tangent_velocity),
                impulse: m.points.get(id).map_or(0.0, |p| p.data.impulse).into(),
                ..contact(pair)
            }
        })
    });
    contacts.collect()
}

/// What Rapier is about to find.
fn found_anew(pair: &Pair, around: &Surroundings) -> Vec<RigidContact> {
    let [first, second] = &pair.sides;
    // What it remembers of the points tells how hard they were pressed.
    let mut manifolds: Vec<ContactManifold> =
        pair.last.map_or_else(Vec::new, |p| p.manifolds().to_vec());
    let skins = [first, second].map(|s| s.collider.contact_skin());
    let prediction = around.parameters.prediction_distance() + skins[0] + skins[1];
    let relative = first.pose.inv_mul(&second.pose);
    let found = PersistentQueryDispatcher::<ContactManifoldData, ContactData>::contact_manifolds(
        &DefaultQueryDispatcher,
        &relative,
        first.collider.shape(),
        second.collider.shape(),
        prediction,
        &mut manifolds,
        &mut None,
    );
    if found.is_err() {
        return Vec::new();
    }
    let mut contacts = Vec::new();
    for manifold in &manifolds {
        let at = |part: Option<&Pose>, pose: &Pose| part.map_or(*pose, |part| *pose * *part);
        let poses = [
            at(manifold.subshape_pos1(), &first.pose),
            at(manifold.subshape_pos2(), &second.pose),
        ];
        let normal = wide(poses[0].rotation * manifold.local_n1);
        let near = manifold.points.iter().filter(|p| p.dist < prediction);
        contacts.extend(near.map(|p| RigidContact {
            points: [
                wide(poses[0] * p.local_p1) + normal * f64::from(skins[0]),
                wide(poses[1] * p.local_p2) - normal * f64::from(skins[1]),
            ],
            normal,
            impulse: p.data.impulse.into(),
            ..contact(pair)
        }));
    }
    contacts
}

/// What all points of a pair have in common.
fn contact(pair: &Pair) -> RigidContact {
    let [first, second] = &pair.sides;
    let [a, b] = [first.collider, second.collider];
    let rank = |k: usize| {
        let body = pair.sides[k].body;
        body.map_or(i16::from(i8::MAX) + 1, |(_, b)| {
            b.effective_dominance_group()
        })
    };
    let dominance = rank(0) - rank(1);
    RigidContact {
        bodies: pair.bodies(),
        points: [DVec3::ZERO; 2],
        normal: DVec3::ZERO,
        shares: [f64::from(dominance <= 0), f64::from(dominance >= 0)],
        friction: CoefficientCombineRule::combine(
            a.friction(),
            b.friction(),
            a.friction_combine_rule(),
            b.friction_combine_rule(),
        )
        .into(),
        belt: DVec3::ZERO,
        impulse: 0.0,
    }
}
