//! Rapier's sets by reference, for those who own the loop themselves.

use crate::coupling::observe::{AttachedJoint, Surroundings, joints_of};
use crate::math::Vector;
use rapier3d::dynamics::{
    ImpulseJointSet, IntegrationParameters, IslandManager, MultibodyJointSet, RigidBody,
    RigidBodyHandle, RigidBodySet,
};
use rapier3d::geometry::{BroadPhaseBvh, ColliderSet, NarrowPhase};
use rapier3d::pipeline::PhysicsWorld;

/// The parts of a Rapier world that deformables look at and act on.
pub struct RapierParts<'a> {
    /// Gravity \[m/s²\].
    pub gravity: Vector,
    /// Read for dt, solver iterations and the length unit; never written.
    pub integration_parameters: &'a IntegrationParameters,
    /// To wake bodies.
    pub islands: &'a mut IslandManager,
    /// To find colliders.
    pub broad_phase: &'a BroadPhaseBvh,
    /// To see which bodies touch others.
    pub narrow_phase: &'a NarrowPhase,
    /// The bodies that get impulses.
    pub bodies: &'a mut RigidBodySet,
    /// The colliders.
    pub colliders: &'a ColliderSet,
    /// To see which bodies are jointed.
    pub impulse_joints: &'a ImpulseJointSet,
    /// To see which bodies are links.
    pub multibody_joints: &'a MultibodyJointSet,
}

impl<'a> From<&'a mut PhysicsWorld> for RapierParts<'a> {
    fn from(world: &'a mut PhysicsWorld) -> Self {
        Self {
            gravity: world.gravity,
            integration_parameters: &world.integration_parameters,
            islands: &mut world.islands,
            broad_phase: &world.broad_phase,
            narrow_phase: &world.narrow_phase,
            bodies: &mut world.bodies,
            colliders: &world.colliders,
            impulse_joints: &world.impulse_joints,
            multibody_joints: &world.multibody_joints,
        }
    }
}

impl RapierParts<'_> {
    /// A body, if it is one that moves.
    pub(super) fn moving(&self, handle: RigidBodyHandle) -> Option<&RigidBody> {
        let body = self.bodies.get(handle);
        body.filter(|b| b.is_dynamic() && b.is_enabled())
    }

    pub(super) fn is_asleep(&self, handle: RigidBodyHandle) -> bool {
        self.moving(handle).is_some_and(RigidBody::is_sleeping)
    }

    /// The joints of a body, with the bodies at their ends.
    pub(super) fn joints_of(
        &self,
        body: RigidBodyHandle,
    ) -> impl Iterator<Item = AttachedJoint<'_>> {
        joints_of(body, (self.impulse_joints, self.bodies))
    }

    /// The bodies that a body is jointed to, linked to in a multibody, or presses on. It may be among them itself.
    pub(super) fn bound_to(&self, body: RigidBodyHandle) -> impl Iterator<Item = RigidBodyHandle> {
        let joints = self.joints_of(body);
        let joined = joints.flat_map(|(first, second, ..)| [first, second]);
        let links = self.multibody_joints.attached_joints(body);
        let linked = links.flat_map(|(first, second, ..)| [first, second]);
        let colliders = self.bodies.get(body).map_or(&[][..], RigidBody::colliders);
        let pairs = colliders.iter();
        let pairs = pairs.flat_map(|c| self.narrow_phase.contact_pairs_with(*c));
        let pairs = pairs.filter(|pair| pair.has_any_active_contact());
        let pressed = pairs.flat_map(|pair| [pair.collider1, pair.collider2]);
        let pressed = pressed.filter_map(|c| self.colliders.get(c)?.parent());
        joined.chain(linked).chain(pressed)
    }

    pub(super) fn surroundings(&self) -> Surroundings<'_> {
        Surroundings {
            gravity: self.gravity,
            parameters: self.integration_parameters,
            bodies: self.bodies,
            colliders: self.colliders,
            broad_phase: self.broad_phase,
            narrow_phase: self.narrow_phase,
            joints: self.impulse_joints,
            multibodies: self.multibody_joints,
        }
    }

    /// The world's length unit.
    pub(super) fn length_unit(&self) -> f64 {
        self.integration_parameters.length_unit.into()
    }
}
