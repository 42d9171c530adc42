//! Rigid bodies and colliders.

use super::super::super::Cast;
use super::super::model::{Collider, Groups, Rigid, RigidKind, Rule};
use super::{RunError, shapes, vector};
use crate::math::{Pose, Real, Rotation};
use rapier3d::dynamics::{CoefficientCombineRule, RigidBodyBuilder};
use rapier3d::geometry::{ColliderBuilder, Group, InteractionGroups, InteractionTestMode};
use rapier3d::pipeline::PhysicsWorld;

pub(super) fn insert(
    rigid: &Rigid,
    frame: Pose,
    world: &mut PhysicsWorld,
    cast: &mut Cast,
) -> Result<(), RunError> {
    let handle = world.insert_body(body(rigid, frame));
    for (i, c) in rigid.colliders.iter().enumerate() {
        let made = collider(c, &rigid.name)?;
        let made = world.insert_collider(made, Some(handle));
        let name = match (c.name.as_str(), i) {
            ("", 0) => rigid.name.clone(),
            ("", i) => format!("{}-{}", rigid.name, i + 1),
            (name, _) => name.into(),
        };
        let movable = (!matches!(rigid.kind, RigidKind::Fixed)).then_some(handle);
        cast.rigid.push((name, movable, made));
    }
    cast.bodies.push((rigid.name.clone(), handle));
    Ok(())
}

fn body(rigid: &Rigid, frame: Pose) -> RigidBodyBuilder {
    let builder = match rigid.kind {
        RigidKind::Fixed => RigidBodyBuilder::fixed(),
        RigidKind::Dynamic => RigidBodyBuilder::dynamic(),
        RigidKind::KinematicPosition => RigidBodyBuilder::kinematic_position_based(),
        RigidKind::KinematicVelocity => RigidBodyBuilder::kinematic_velocity_based(),
    };
    let turn = Rotation::from_scaled_axis(vector(rigid.rotation));
    let own = Pose::from_parts(vector(rigid.translation), turn);
    // A product with nothing would round the turn anew.
    let pose = match rigid.frame {
        Some(_) => frame * own,
        None => own,
    };
    let mut builder = builder
        .pose(pose)
        .linvel(vector(rigid.linvel))
        .angvel(vector(rigid.angvel))
        .gravity_scale(rigid.gravity_scale as Real)
        .additional_mass(rigid.additional_mass as Real)
        .linear_damping(rigid.linear_damping as Real)
        .angular_damping(rigid.angular_damping as Real)
        .can_sleep(rigid.can_sleep)
        .ccd_enabled(rigid.ccd)
        .dominance_group(rigid.dominance);
    if rigid.lock_rotations {
        builder = builder.lock_rotations();
    }
    builder
}

fn collider(c: &Collider, body: &str) -> Result<ColliderBuilder, RunError> {
    let builder = ColliderBuilder::new(shapes::shape(&c.shape, body)?)
        .translation(vector(c.translation))
        .rotation(vector(c.rotation))
        .friction(c.friction as Real)
        .friction_combine_rule(rule(&c.friction_rule))
        .restitution(c.restitution as Real)
        .restitution_combine_rule(rule(&c.restitution_rule))
        .sensor(c.sensor)
        .collision_groups(groups(&c.groups))
        .solver_groups(groups(&c.solver_groups))
        .contact_skin(c.contact_skin as Real);
    Ok(match c.mass {
        Some(mass) => builder.mass(mass as Real),
        None => builder.density(c.density as Real),
    })
}

pub(super) fn rule(rule: &Rule) -> CoefficientCombineRule {
    match rule {
        Rule::Average => CoefficientCombineRule::Average,
        Rule::Min => CoefficientCombineRule::Min,
        Rule::Multiply => CoefficientCombineRule::Multiply,
        Rule::Max => CoefficientCombineRule::Max,
        Rule::ClampedSum => CoefficientCombineRule::ClampedSum,
    }
}

pub(super) fn groups(groups: &Groups) -> InteractionGroups {
    let bits = |list: &[u32]| {
        let all = list.iter().map(|g| 1_u32 << (g - 1));
        Group::from_bits_truncate(all.fold(0, |sum, bit| sum | bit))
    };
    let some = |list: &[u32]| match list {
        [] => Group::ALL,
        list => bits(list),
    };
    let with = some(&groups.with) & !bits(&groups.not_with);
    InteractionGroups::new(some(&groups.member), with, InteractionTestMode::And)
}
