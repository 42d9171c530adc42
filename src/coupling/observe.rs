//! Reading a rigid body: its shadow, and whether something rigid holds it.

use super::constraints::RigidConstraints;
use super::flight::fastest_spin;
use super::linkage::{self, Mobility};
use super::memory::{BodyMemory, Response};
use crate::contact::target::wide_rotation;
use crate::math::{DMat3, DVec3, Vector, wide};
use crate::solve::shadow::Shadow;
use rapier3d::dynamics::{
    ImpulseJoint, ImpulseJointHandle, ImpulseJointSet, IntegrationParameters, JointEnabled,
    MultibodyJointSet, RigidBody, RigidBodyHandle, RigidBodyPosition, RigidBodySet, RigidBodyType,
};
use rapier3d::geometry::{BroadPhaseBvh, ColliderSet, NarrowPhase};

/// What surrounds a body in Rapier's world.
#[derive(Clone, Copy)]
pub struct Surroundings<'a> {
    /// Gravity \[m/s²\].
    pub gravity: Vector,
    /// Rapier's parameters.
    pub parameters: &'a IntegrationParameters,
    /// All bodies.
    pub bodies: &'a RigidBodySet,
    /// All colliders.
    pub colliders: &'a ColliderSet,
    /// Where colliders are.
    pub broad_phase: &'a BroadPhaseBvh,
    /// Contacts between colliders.
    pub narrow_phase: &'a NarrowPhase,
    /// Joints.
    pub joints: &'a ImpulseJointSet,
    /// Joints in reduced coordinates.
    pub multibodies: &'a MultibodyJointSet,
}

#[cfg(test)]
impl<'a> From<&'a rapier3d::pipeline::PhysicsWorld> for Surroundings<'a> {
    fn from(world: &'a rapier3d::pipeline::PhysicsWorld) -> Self {
        Self {
            gravity: world.gravity,
            parameters: &world.integration_parameters,
            bodies: &world.bodies,
            colliders: &world.colliders,
            broad_phase: &world.broad_phase,
            narrow_phase: &world.narrow_phase,
            joints: &world.impulse_joints,
            multibodies: &world.multibody_joints,
        }
    }
}

impl<'a> Surroundings<'a> {
    /// The joints of a body, with the bodies at their ends.
    pub fn joints_of(&self, body: RigidBodyHandle) -> impl Iterator<Item = AttachedJoint<'a>> {
        joints_of(body, (self.joints, self.bodies))
    }
}

/// The bodies that a joint joins, its handle, and the joint.
pub type AttachedJoint<'a> = (
    RigidBodyHandle,
    RigidBodyHandle,
    ImpulseJointHandle,
    &'a ImpulseJoint,
);

/// The joints of a body that are switched on in the coming step of Rapier: only then are those marked again that were switched off
/// with a body.
pub fn joints_of<'a>(
    body: RigidBodyHandle,
    (joints, bodies): (&'a ImpulseJointSet, &'a RigidBodySet),
) -> impl Iterator<Item = AttachedJoint<'a>> {
    let is_on = |body| bodies.get(body).is_some_and(RigidBody::is_enabled);
    let all = joints.attached_joints(body);
    all.filter(move |&(a, b, _, joint)| match joint.data.enabled {
        JointEnabled::Enabled => true,
        JointEnabled::DisabledByAttachedBody => is_on(a) && is_on(b),
        JointEnabled::Disabled => false,
    })
}

/// How a rigid body answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Not at all: fixed, kinematic or asleep.
    None,
    /// Like a free body.
    Free,
    /// Pressed against other rigid bodies or joined to them: its shadow keeps these contacts and joints.
    Constrained,
    /// The same of a link of a multibody. Rapier rewrites its velocity from joint coordinates: impulses are lost on it, forces are not.
    Linked,
    /// Held by joints that shadows can't keep, and perhaps by rigid contacts too.
    Jointed,
    /// A link of a multibody that shadows can't keep.
    Link,
}

impl Answer {
    /// Whether its shadow keeps its contacts and joints.
    pub fn is_kept(self) -> bool {
        matches!(self, Self::Constrained | Self::Linked)
    }
}

/// The share of an acceleration held over a Rapier step of n solver iterations that shows as displacement:
/// s = (n + 1)/(2n), because Rapier integrates symplectically in n small steps.
pub fn displacement_share(body: &RigidBody, parameters: &IntegrationParameters) -> f64 {
    let n = substeps(body, parameters) as f64;
    (n + 1.0) / (2.0 * n)
}

/// How many substeps Rapier takes a body through in a step.
pub fn substeps(body: &RigidBody, parameters: &IntegrationParameters) -> usize {
    (parameters.num_solver_iterations + body.additional_solver_iterations()).max(1)
}

/// Acceleration and angular acceleration of a body by gravity and the user's forces.
pub fn free_acceleration(body: &RigidBody, gravity: Vector) -> (DVec3, DVec3) {
    let props = body.mass_properties();
    let inv_mass = wide(props.effective_inv_mass);
    let weight = wide(gravity) * f64::from(body.gravity_scale());
    let allowed = DVec3::new(
        f64::from(inv_mass.x > 0.0),
        f64::from(inv_mass.y > 0.0),
        f64::from(inv_mass.z > 0.0),
    );
    (
        weight * allowed + wide(body.user_force()) * inv_mass,
        inv_inertia(body) * wide(body.user_torque()),
    )
}

/// I⁻¹ in world axes \[1/(kg·m²)\], 0 about locked axes.
pub fn inv_inertia(body: &RigidBody) -> DMat3 {
    let m = body.mass_properties().effective_world_inv_inertia;
    let (xx, yy, zz) = (m.m11.into(), m.m22.into(), m.m33.into());
    let (xy, xz, yz) = (m.m12.into(), m.m13.into(), m.m23.into());
    DMat3::from_cols(
        DVec3::new(xx, xy, xz),
        DVec3::new(xy, yy, yz),
        DVec3::new(xz, yz, zz),
    )
}

/// The shadow of a body for a rigid step of `dt` s.
pub fn shadow(
    body: &RigidBody,
    answer: Answer,
    mobility: &Mobility,
    response: Response,
    around: &Surroundings,
    dt: f64,
) -> Shadow {
    let pose = body.position();
    let rot = wide_rotation(pose.rotation);
    let com = wide(pose.translation) + rot * wide(body.local_center_of_mass());
    let (v, mut w) = velocity(body, dt);
    if body.body_type() == RigidBodyType::KinematicVelocityBased {
        w = w.clamp_length_max(fastest_spin(body, dt));
    }
    let mut shadow = Shadow {
        com,
        rot,
        v,
        w,
        before: (v, w),
        ..Shadow::FIXED
    };
    if answer == Answer::None {
        return shadow;
    }
    let (along, about) = (response.along, response.about);
    shadow.inv_mass = scaled(along, mobility.inv_mass, along);
    let cross = scaled(along, mobility.cross, about);
    shadow.cross = (cross != DMat3::ZERO).then_some(cross);
    shadow.inv_inertia = scaled(about, mobility.inv_inertia, about);
    shadow.acceleration = mobility.acceleration * along;
    shadow.spin_up = mobility.spin_up * about;
    let own = answer == Answer::Free || answer.is_kept();
    // What a link gets is spread over the whole step, and holds it up in every iteration of that.
    if own && answer != Answer::Linked {
        shadow.lead = Some((displacement_share(body, around.parameters) - 0.5) * dt);
    }
    // Rapier damps no links of multibodies, and always turns them as free bodies turn.
    let is_link = matches!(answer, Answer::Linked | Answer::Link);
    if !is_link {
        shadow.damping = (body.linear_damping().into(), body.angular_damping().into());
    }
    if own && (is_link || body.gyroscopic_forces_enabled()) {
        // Of what can't turn about every axis it is not finite.
        let inertia = inv_inertia(body).inverse();
        if inertia.is_finite() {
            shadow.inertia = inertia;
            let props = &body.mass_properties().local_mprops;
            shadow.principal = (
                wide_rotation(props.principal_inertia_local_frame),
                wide(props.principal_inertia()),
            );
        }
    }
    shadow
}

/// A block of a symmetric matrix, scaled along each axis.
fn scaled(rows: DVec3, m: DMat3, columns: DVec3) -> DMat3 {
    let root = |by: DVec3| DMat3::from_diagonal(DVec3::new(by.x.sqrt(), by.y.sqrt(), by.z.sqrt()));
    root(rows) * m * root(columns)
}

/// Velocity of the centre of mass and angular velocity over a rigid step of `dt` s.
pub fn velocity(body: &RigidBody, dt: f64) -> (DVec3, DVec3) {
    use rapier3d::dynamics::RigidBodyType::*;
    match body.body_type() {
        // Its linvel is that of the last step; the target tells where it goes in this one.
        KinematicPositionBased => {
            let (position, mut next_position) = (*body.position(), *body.next_position());
            if next_position.rotation.dot(position.rotation) < 0.0 {
                // The same orientation, but Rapier takes it for the long way round.
                next_position.rotation = -next_position.rotation;
            }
            if next_position == position {
                // Where the body is turned the products below are not quite 0.
                return Default::default();
            }
            let motion = RigidBodyPosition {
                position,
                next_position,
            }
            .interpolate_velocity((1.0 / dt) as f32, body.local_center_of_mass());
            (wide(motion.linvel), wide(motion.angvel))
        }
        // Rapier does not move what was told a velocity without being woken.
        Dynamic | KinematicVelocityBased if body.is_sleeping() => (DVec3::ZERO, DVec3::ZERO),
        Dynamic | KinematicVelocityBased => (wide(body.linvel()), wide(body.angvel())),
        _ => (DVec3::ZERO, DVec3::ZERO),
    }
}

/// How a body will answer in this step.
pub fn answer(
    handle: RigidBodyHandle,
    body: &RigidBody,
    constraints: &RigidConstraints,
    around: &Surroundings,
) -> Answer {
    if !body.is_dynamic() || body.is_sleeping() {
        Answer::None
    } else if is_link(handle, around) {
        if constraints.follows(handle) {
            Answer::Linked
        } else {
            Answer::Link
        }
    } else if has_joint(handle, around) && !constraints.follows(handle) {
        Answer::Jointed
    } else if constraints.has(handle) {
        Answer::Constrained
    } else {
        Answer::Free
    }
}

fn has_joint(handle: RigidBodyHandle, around: &Surroundings) -> bool {
    around.joints_of(handle).next().is_some()
}

fn is_link(handle: RigidBodyHandle, around: &Surroundings) -> bool {
    around.multibodies.rigid_body_link(handle).is_some()
}

/// How a body answers before ρ, and its ρ: remembered, or at first guessed from what holds it.
pub fn response(
    handle: RigidBodyHandle,
    body: &RigidBody,
    answer: Answer,
    memory: &mut BodyMemory,
    around: &Surroundings,
    dt: f64,
) -> (Mobility, Response) {
    let mobility = match answer {
        Answer::Jointed => linkage::mobility(handle, around, dt),
        _ => Mobility::free(body, around.gravity),
    };
    if !matches!(answer, Answer::Jointed | Answer::Link) {
        memory.response = None;
        return (mobility, Response::all(1.0));
    }
    // What contacts do to joined bodies is in their mobility.
    let guess = if answer == Answer::Link { 0.5 } else { 1.0 };
    let known = memory.response.get_or_insert_with(|| Response::all(guess));
    (mobility, *known)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::dynamics::{FixedJointBuilder, RigidBodyBuilder};
    use rapier3d::pipeline::PhysicsWorld;

    /// Symptom: what was joined to a body that was switched on again counted as free in the step that followed. One that is made at a body
    /// that is switched off holds in Rapier.
    #[test]
    fn joints_are_switched_on_with_their_bodies() {
        let mut world = PhysicsWorld::default();
        let bodies = [0.0, 1.0].map(|x| {
            let body = RigidBodyBuilder::dynamic().translation(Vector::X * x);
            world.insert_body(body.additional_mass(1.0))
        });
        let joint = FixedJointBuilder::new();
        world
            .impulse_joints
            .insert(bodies[0], bodies[1], joint, true);
        let count = |world: &_| Surroundings::from(world).joints_of(bodies[1]).count();
        for enabled in [true, false, true, false] {
            world.bodies[bodies[0]].set_enabled(enabled);
            assert!(!enabled || count(&world) == 1);
            world.step();
            assert_eq!(count(&world), usize::from(enabled));
        }
        world
            .impulse_joints
            .insert(bodies[0], bodies[1], joint, true);
        assert_eq!(count(&world), 1);
    }

    /// Symptom: nothing fell asleep on a tilted lift at rest. Cause: Rapier's difference of two equal poses is rounded.
    #[test]
    fn a_tilted_body_that_is_led_to_where_it_is_has_no_velocity() {
        let (mut rounded, places) = (0, 100);
        for i in 0..places {
            let i = i as f32;
            let place = Vector::new(1.0 + i, 0.3 * i, 2.0);
            let body = RigidBodyBuilder::kinematic_position_based().translation(place);
            let body = body.rotation(Vector::new(0.1, 0.01 * i, 0.2)).build();
            let (position, next_position) = (*body.position(), *body.next_position());
            let both = RigidBodyPosition {
                position,
                next_position,
            };
            let rates = both.interpolate_velocity(240.0, body.local_center_of_mass());
            rounded += usize::from(rates.linvel != Vector::ZERO);
            assert_eq!(velocity(&body, 1.0 / 240.0), Default::default());
        }
        assert!(rounded > places / 2, "{rounded}");
    }
}
