//! The points of a pair.

use super::pairs::{Pair, Side};
use super::{ContactSpring, RigidContact};
use crate::coupling::observe::Surroundings;
use crate::math::{DVec3, Pose, Vector, wide};
use rapier3d::dynamics::CoefficientCombineRule;
use rapier3d::geometry::{ContactData, ContactManifold, ContactManifoldData, SolverFlags};
use rapier3d::parry::query::{DefaultQueryDispatcher, PersistentQueryDispatcher};

/// Where the colliders of a pair touch now or nearly so. Where hooks have a say it is what the last step found.
pub fn of(pair: &Pair, around: &Surroundings, dt: f64) -> Vec<RigidContact> {
    if pair.hooked {
        return remembered(pair, around);
    }
    found_anew(pair, around, dt)
}

/// What Rapier has found, where it is now.
fn remembered(pair: &Pair, around: &Surroundings) -> Vec<RigidContact> {
    let last = pair.last.filter(|p| p.has_any_active_contact());
    let manifolds = last.map_or(&[][..], |p| p.solver_manifolds()).iter();
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
                ..contact(pair, around)
            }
        })
    });
    contacts.collect()
}

/// Points of a pair that are nearer to each other than this share of the prediction distance, on surfaces that face the same
/// way, are one: as Rapier merges those of composite shapes. Faces list their common corners twice, too.
const ONE_POINT: f32 = 0.25;
/// Cosine of the angle up to which surfaces face the same way; Rapier's.
const SAME_WAY: f64 = 0.996;

/// What Rapier is about to find. Of composite shapes it merges the parts' points by their normals before it solves
/// them; as constraints they are the same.
fn found_anew(pair: &Pair, around: &Surroundings, dt: f64) -> Vec<RigidContact> {
    let [first, second] = &pair.sides;
    let skins = [first, second].map(|s| s.collider.contact_skin());
    let near = around.parameters.prediction_distance();
    let relative = first.pose.inv_mul(&second.pose);
    // What Rapier remembers of simple shapes; of composite ones it makes sense with a private map alone.
    let is_simple = |s: &Side| s.collider.shape().as_composite_shape().is_none();
    let last = pair.last.filter(|_| pair.sides.iter().all(is_simple));
    let mut manifolds: Vec<ContactManifold> =
        last.map_or_else(Vec::new, |p| p.manifolds().to_vec());
    let found = PersistentQueryDispatcher::<ContactManifoldData, ContactData>::contact_manifolds(
        &DefaultQueryDispatcher,
        &relative,
        first.collider.shape(),
        second.collider.shape(),
        near + skins[0] + skins[1],
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
        let normal = poses[0].rotation * manifold.local_n1;
        for p in &manifold.points {
            let [a, b] = [poses[0] * p.local_p1, poses[1] * p.local_p2];
            let gap = p.dist - skins[0] - skins[1];
            // A corner that is farther but will be there within the step, as Rapier has it.
            let closing = (velocity_at(second, b) - velocity_at(first, a)).dot(normal);
            if gap.min(gap + closing * dt as f32) < near {
                let contact = RigidContact {
                    points: [
                        wide(a) + wide(normal) * f64::from(skins[0]),
                        wide(b) - wide(normal) * f64::from(skins[1]),
                    ],
                    normal: wide(normal),
                    impulse: p.data.impulse.into(),
                    ..contact(pair, around)
                };
                add(contact, f64::from(ONE_POINT * near), &mut contacts);
            }
        }
    }
    if contacts.iter().all(|c| c.impulse == 0.0) {
        recall_impulses(pair, near + skins[0], &mut contacts);
    }
    contacts
}

/// Adds a point, or puts it in the place of one nearer than `reach` m that is the same and not as deep.
fn add(contact: RigidContact, reach: f64, contacts: &mut Vec<RigidContact>) {
    let gap = |c: &RigidContact| (c.points[1] - c.points[0]).dot(c.normal);
    let same = contacts.iter_mut().find(|c| {
        c.points[0].distance_squared(contact.points[0]) < reach * reach
            && c.normal.dot(contact.normal) > SAME_WAY
    });
    let Some(same) = same else {
        contacts.push(contact);
        return;
    };
    let impulse = same.impulse + contact.impulse;
    if gap(&contact) < gap(same) {
        *same = contact;
    }
    same.impulse = impulse;
}

fn velocity_at(side: &Side, point: Vector) -> Vector {
    side.body
        .map_or(Vector::ZERO, |(_, b)| b.velocity_at_point(point))
}

/// Gives contacts of composite shapes the impulses of the points of Rapier's last step that are nearest to them, within
/// `reach`: each impulse to one contact.
fn recall_impulses(pair: &Pair, reach: f32, contacts: &mut [RigidContact]) {
    let solved = pair.last.map_or(&[][..], |p| p.solver_manifolds());
    for manifold in solved {
        for p in manifold.points.iter().filter(|p| p.data.impulse > 0.0) {
            let at = manifold
                .subshape_pos1()
                .map_or(p.local_p1, |part| part * p.local_p1);
            let at = wide(pair.sides[0].pose * at);
            let free = contacts.iter_mut().filter(|c| c.impulse == 0.0);
            let distance = |c: &RigidContact| c.points[0].distance_squared(at);
            let nearest = free.min_by(|a, b| distance(a).total_cmp(&distance(b)));
            if let Some(c) = nearest.filter(|c| distance(c) < f64::from(reach).powi(2)) {
                c.impulse = p.data.impulse.into();
            }
        }
    }
}

/// How deep loads may press Rapier's contacts, in length units; they are spared the rest.
const SAG: f64 = 1e-3;

/// What all points of a pair have in common.
fn contact(pair: &Pair, around: &Surroundings) -> RigidContact {
    let [first, second] = &pair.sides;
    let [a, b] = [first.collider, second.collider];
    let rank = |k: usize| {
        let body = pair.sides[k].body;
        body.map_or(i16::from(i8::MAX) + 1, |(_, b)| {
            b.effective_dominance_group()
        })
    };
    let dominance = rank(0) - rank(1);
    let unit = f64::from(around.parameters.length_unit);
    let gives_way = |side: &Side| {
        side.body
            .is_some_and(|(_, b)| b.is_dynamic() && !b.is_sleeping())
    };
    let softness = if dominance == 0 && pair.sides.iter().all(gives_way) {
        around.parameters.contact_softness
    } else {
        around.parameters.static_contact_softness
    };
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
        spring: ContactSpring::of(&softness, SAG * unit),
    }
}
