//! Which colliders a deformable may touch, by Rapier's own rules, and how they are seen.

use super::encounter::outline;
use super::form::{Form, Forms};
use crate::body::error::{not_negative, positive};
use crate::body::state::State;
use crate::body::{Blueprint, BuildError};
use crate::law::row::{Lift, Turn, softness};
use crate::math::{DMat3, DQuat, DVec3, Real, Rotation};
use crate::solve::rows::{Row, Terms};
use crate::solve::shadow::Shadow;
use rapier3d::dynamics::{CoefficientCombineRule, RigidBody, RigidBodyHandle, RigidBodySet};
use rapier3d::geometry::{Collider, ColliderHandle, InteractionGroups, SharedShape};

/// How a deformable's surface behaves in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct SurfaceProperties {
    /// Coulomb's μ of this side.
    pub friction: Real,
    /// How it combines with the collider's; the stronger rule wins, as everywhere in Rapier.
    pub friction_combine_rule: CoefficientCombineRule,
    /// Which colliders and other deformables it meets; groups that don't agree switch contact off.
    pub collision_groups: InteractionGroups,
    /// Which colliders and other deformables push back; those of no agreement are only noticed.
    pub solver_groups: InteractionGroups,
    /// Distance kept between the middle of the surface and what touches it, doubled \[m\]: the thickness of a sheet, the
    /// diameter of a rope. Half the shortest edge at rest is the most that `build` takes. 0, the default, is no thickness
    /// against colliders and for solids. Two deformables that pass through each other's middle can't be told from two
    /// that do not, so against deformables sheets and ropes of thickness 0 have a tenth of their shortest edge. What is not
    /// positive and finite counts as 0.
    pub thickness: Real,
    /// Stiffness of its contacts \[N/m\] per node; `None`, the default, for contacts that do not give. What is not positive
    /// and finite counts as `None`.
    pub stiffness: Option<Real>,
    /// Bodies of a higher group push those of a lower one and feel nothing, as in Rapier; -127 to 127.
    pub dominance_group: i8,
    /// Mean force of a collider over a step above which an event tells of it \[N\]; `None`, the default, for no such
    /// events.
    pub contact_force_event_threshold: Option<Real>,
}

impl Default for SurfaceProperties {
    fn default() -> Self {
        Self {
            friction: 0.5,
            friction_combine_rule: CoefficientCombineRule::Average,
            collision_groups: InteractionGroups::all(),
            solver_groups: InteractionGroups::all(),
            thickness: 0.0,
            stiffness: None,
            dominance_group: 0,
            contact_force_event_threshold: None,
        }
    }
}

impl SurfaceProperties {
    /// Whether all values are what they may be.
    pub(crate) fn check(&self) -> Result<(), BuildError> {
        not_negative("the friction coefficient", self.friction.into())?;
        if let Some(threshold) = self.contact_force_event_threshold {
            not_negative("the threshold of force events", threshold.into())?;
        }
        not_negative("the thickness", self.thickness.into())?;
        if let Some(stiffness) = self.stiffness {
            positive("the contact stiffness", stiffness.into())?;
        }
        Ok(())
    }

    /// Whether it is thin enough for what touches: half of the spacing of its nodes at most.
    pub(crate) fn check_thickness(&self, touching: &Blueprint) -> Result<(), BuildError> {
        let thickness = f64::from(self.thickness);
        let limit = 0.5 * outline::spacing(touching);
        // Places of nodes are rounded.
        if thickness > limit * (1.0 + 1e-5) {
            return Err(BuildError::TooThick { thickness, limit });
        }
        Ok(())
    }
}

/// A collider that a deformable may touch in this step.
#[derive(Clone, Debug)]
pub struct Target {
    /// The collider.
    pub collider: ColliderHandle,
    /// Its rigid body, if it has one.
    pub body: Option<RigidBodyHandle>,
    /// Index of its shadow in the group.
    pub shadow: u32,
    /// Its shape.
    pub shape: SharedShape,
    /// Its shape as contact sees it.
    pub form: Form,
    /// Where its frame stands relative to the shadow: offset from the centre of mass, rotation.
    pub offset: DVec3,
    /// Rotation of the collider relative to its body.
    pub turn: DQuat,
    /// No point of it is farther from the shadow's centre of mass, or from its own origin \[m\]; huge for a half-space.
    pub extent: f64,
    /// Combined μ.
    pub friction: f64,
    /// Rapier's contact skin and half the deformable's thickness \[m\].
    pub skin: f64,
    /// What the deformable takes of an impulse: 1, or 0 if it dominates the collider's body.
    pub node_share: f64,
    /// What the collider's body takes of it: 1, or 0 if it dominates the deformable.
    pub rigid_share: f64,
    /// Stiffness of the contact \[N/m\] if it gives.
    pub stiffness: Option<f64>,
    /// Points of the deformable that the collider's body holds, in ascending order: nothing can move between the two.
    pub held: Vec<u32>,
}

/// A target's frame in the world at one instant.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Frame {
    /// Its origin \[m\].
    pub position: DVec3,
    /// From its axes to the world's.
    pub axes: DMat3,
}

impl Frame {
    /// Where a node stands in it \[m\].
    pub fn to_local(self, state: &State<Real>, node: u32) -> DVec3 {
        self.axes.transpose() * (state.local(node as usize) + (state.origin - self.position))
    }

    /// A bound on how far a point within `extent` m of the origin lies from where the other frame has it \[m\].
    pub fn distance(&self, other: &Self, extent: f64) -> f64 {
        let turned = (0..3)
            .map(|i| (self.axes.col(i) - other.axes.col(i)).length_squared())
            .sum::<f64>();
        // A fixed half-space has no extent to speak of, and 0·∞ is no distance.
        let turned = if turned > 0.0 {
            turned.sqrt() * extent
        } else {
            0.0
        };
        (self.position - other.position).length() + turned
    }
}

impl Target {
    /// Whether the collider's body holds all of these points of the deformable, which then do not touch it.
    pub fn holds(&self, points: impl IntoIterator<Item = u32>) -> bool {
        let is_held = |point: u32| self.held.binary_search(&point).is_ok();
        !self.held.is_empty() && points.into_iter().all(is_held)
    }

    /// Where the collider is while its shadow stands at `shadow`.
    pub fn frame(&self, shadow: &Shadow) -> Frame {
        Frame {
            position: shadow.com + shadow.rot * self.offset,
            axes: DMat3::from_quat(shadow.rot * self.turn),
        }
    }

    /// A bound on the speed of any of its points \[m/s\].
    pub fn speed(&self, shadow: &Shadow) -> f64 {
        let turning = shadow.w.length();
        // A fixed half-space has no extent to speak of, and 0·∞ is no speed.
        let turning = if turning > 0.0 {
            turning * self.extent
        } else {
            0.0
        };
        shadow.v.length() + turning
    }

    /// A row of this target in a substep of h s, its normal, depth and arm still to be filled in.
    pub fn row(&self, terms: Terms, pair: u32, h: f64) -> Row {
        Row {
            terms,
            shadow: self.shadow,
            pair,
            between: false,
            levers: None,
            normal: DVec3::ZERO,
            depth: 0.0,
            arm: DVec3::ZERO,
            turn: Turn::default(),
            rigid_share: self.rigid_share,
            friction: self.friction,
            softness: self.stiffness.map_or(0.0, |k| softness(k, h)),
            drift: DVec3::ZERO,
            carried: 0.0,
            normal_impulse: 0.0,
            friction_impulse: DVec3::ZERO,
            response: Default::default(),
            lift: Lift::default(),
            pinched: 0.0,
        }
    }
}

/// Rapier's rotation in `f64`.
pub fn wide_rotation(r: Rotation) -> DQuat {
    DQuat::from_xyzw(r.x.into(), r.y.into(), r.z.into(), r.w.into()).normalize()
}

/// Whether Rapier's rules let a deformable meet this collider: both enabled, none of Rapier's own soft bodies, collision
/// groups that agree. A deformable counts as a dynamic body
/// with the usual collision types, and Rapier asks for the agreement of one side only, so the collider's do not matter.
pub fn admits(collider: &Collider, body: Option<&RigidBody>, surface: &SurfaceProperties) -> bool {
    is_on(collider, body)
        && body.is_none_or(|b| !b.is_soft_frame())
        && collider.deformable_mesh_ref().is_none()
        && surface.collision_groups.test(collider.collision_groups())
}

/// Whether a collider, of a body if it has one, is switched on in the coming step of Rapier: only then are those marked whose body
/// has been switched on or off.
pub fn is_on(collider: &Collider, body: Option<&RigidBody>) -> bool {
    let is_off_by_body = || {
        // Only one that is switched off itself can be switched on.
        let mut copy = collider.clone();
        copy.set_enabled(true);
        !copy.is_enabled()
    };
    match body {
        Some(body) => body.is_enabled() && (collider.is_enabled() || is_off_by_body()),
        None => collider.is_enabled(),
    }
}

/// Whether an admitted collider pushes. Sensors, and those of solver groups that don't agree, only notice.
pub fn pushes(collider: &Collider, surface: &SurfaceProperties) -> bool {
    !collider.is_sensor() && surface.solver_groups.test(collider.solver_groups())
}

/// Half the thickness of a surface \[m\].
pub fn half_thickness(surface: &SurfaceProperties) -> f64 {
    0.5 * thickness(surface.thickness)
}

/// The skin of a collider \[m\].
pub fn skin_of(collider: &Collider) -> f64 {
    thickness(collider.contact_skin())
}

/// A thickness that can be one \[m\], else 0.
fn thickness(t: Real) -> f64 {
    if t.is_finite() {
        f64::from(t).max(0.0)
    } else {
        0.0
    }
}

/// Largest distance of any point of a collider from its own origin \[m\].
fn farthest(collider: &Collider) -> f64 {
    let ball = collider.shape().compute_local_bounding_sphere();
    f64::from(ball.center.length() + ball.radius)
}

/// The target for an admitted collider; `None` where its shape is not one that nodes can touch.
pub fn target(
    handle: ColliderHandle,
    collider: &Collider,
    bodies: &RigidBodySet,
    surface: &SurfaceProperties,
    forms: &mut Forms,
) -> Option<Target> {
    let form = forms.of(collider.shared_shape())?;
    let parent = collider.parent().and_then(|h| bodies.get(h));
    // A collider's own pose is stale after its body was teleported: its pose relative to the body is not.
    let (offset, turn) = match (parent, collider.position_wrt_parent()) {
        (Some(body), Some(pose)) => (
            pose.translation.as_dvec3() - body.local_center_of_mass().as_dvec3(),
            wide_rotation(pose.rotation),
        ),
        _ => (
            collider.position().translation.as_dvec3(),
            wide_rotation(collider.position().rotation),
        ),
    };
    let friction = CoefficientCombineRule::combine(
        surface.friction,
        collider.friction(),
        surface.friction_combine_rule,
        collider.friction_combine_rule(),
    );
    let dominance = parent.map_or(i16::from(i8::MAX) + 1, |b| b.effective_dominance_group())
        - i16::from(surface.dominance_group);
    Some(Target {
        collider: handle,
        body: parent.and(collider.parent()),
        shadow: 0,
        form,
        shape: collider.shared_shape().clone(),
        extent: offset.length() + farthest(collider),
        offset,
        turn,
        friction: f64::from(friction).max(0.0),
        skin: skin_of(collider) + half_thickness(surface),
        node_share: f64::from(dominance >= 0),
        rigid_share: f64::from(dominance <= 0),
        stiffness: surface
            .stiffness
            .map(f64::from)
            .filter(|k| k.is_finite() && *k > 0.0),
        held: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use rapier3d::dynamics::RigidBodyBuilder;
    use rapier3d::geometry::{ColliderBuilder, ColliderSet};

    /// The bound of a hull that lies far from the origin of its collider left that out, and was too small by as much.
    #[test]
    fn no_point_is_beyond_the_extent() {
        let corners = [Vector::ZERO, Vector::X, Vector::Y, Vector::Z];
        let corners = corners.map(|c| c + Vector::new(3.0, 0.0, 0.0));
        let (mut bodies, mut colliders) = (RigidBodySet::new(), ColliderSet::new());
        let body = bodies.insert(RigidBodyBuilder::dynamic().additional_mass(1.0));
        let hull = ColliderBuilder::convex_hull(&corners)
            .expect("a hull")
            .density(0.0);
        let hull = colliders.insert_with_parent(hull, body, &mut bodies);
        let surface = SurfaceProperties::default();
        let target = target(
            hull,
            &colliders[hull],
            &bodies,
            &surface,
            &mut Forms::default(),
        );
        let target = target.expect("hulls are touched");
        for corner in corners {
            let far = corner.as_dvec3().length();
            assert!(far <= target.extent, "{far} of {}", target.extent);
        }
    }
}
