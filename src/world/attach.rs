//! Attachments in the world: made, read, let go.

use super::attachment::{AttachError, AttachTo, Attachment};
use super::group::BodyKey;
use super::{AttachmentHandle, Deformable, DeformableHandle, DeformableWorld, RapierParts};
use crate::contact::target::wide_rotation;
use crate::coupling::attach::{Bond, Hold, Load, Part, Point};
use crate::coupling::memory::BodyMemory;
use crate::coupling::pivot::pivot;
use crate::math::{DQuat, DVec3, wide};
use rapier3d::dynamics::{RigidBody, RigidBodyHandle, RigidBodySet};
use std::collections::BTreeMap;

/// An attachment as it is read: its nodes, target, force, moment, energy, and whether it broke.
pub type AttachmentState = Bond<DeformableHandle>;

/// How far from a lone node another may be to be attached to it \[m\], and how far a pivot from what its nodes make.
const CLOSE: f64 = 1e-3;
/// By how much two sides of an attachment are apart that something from outside has moved, in length units.
const LOOSE: f64 = 1e-5;
/// How far a face may be from a node that is attached to it, in its longest edges.
const FACE_GAP: f64 = 0.05;

impl DeformableWorld {
    /// Attaches nodes of a deformable to a rigid body, another deformable or the world ([`AttachTo::World`]), both ways. A
    /// slice of nodes is a weld. To a deformable, each node is held at the nearest point of its faces, of its springs where
    /// it has none, or of its nodes that no spring holds; torn faces and broken springs are passed by.
    ///
    /// While either side is disabled nothing is held; a node that has been moved meanwhile, or teleported, or whose body
    /// was, is led back at [`push_out_speed`](super::DeformableParameters::push_out_speed). Removing either side removes the
    /// attachment. A node that is welded, or pinned alone, does not touch what holds it; others do, and all that lies beside
    /// them: keep those apart by collision groups.
    ///
    /// # Errors
    /// Unknown handles and nodes, no nodes, numbers that are negative or not finite, a deformable attached to itself, and
    /// points that are too far apart.
    pub fn attach(
        &mut self,
        deformable: DeformableHandle,
        attachment: impl Into<Attachment>,
        to: impl Into<AttachTo>,
        bodies: &RigidBodySet,
    ) -> Result<AttachmentHandle, AttachError> {
        let (attachment, target) = (attachment.into(), to.into());
        let soft = self
            .get(deformable)
            .ok_or(AttachError::UnknownDeformable(deformable))?;
        let hold = checked(&attachment)?;
        let nodes = nodes_of(&attachment, soft)?;
        let (origin, rot) = match target {
            AttachTo::Body(handle) => {
                let body = bodies.get(handle).ok_or(AttachError::UnknownBody(handle))?;
                if self.holds_nodes(handle) {
                    held_frame(&self.memory, (handle, body))
                } else {
                    frame(body)
                }
            }
            _ => (DVec3::ZERO, DQuat::IDENTITY),
        };
        let mut points = held_points(&attachment, soft, &nodes)?;
        let mean = {
            let at = points.iter().map(|p| p.anchor);
            at.sum::<DVec3>() / points.len() as f64
        };
        if let AttachTo::Deformable(other) = target {
            if other == deformable {
                return Err(AttachError::ToItself(other));
            }
            let other = self
                .get(other)
                .ok_or(AttachError::UnknownDeformable(other))?;
            for point in &mut points {
                stick(point, other)?;
            }
        } else {
            for point in &mut points {
                point.anchor = rot.inverse() * (point.anchor - origin);
            }
        }
        let about = attachment.at.map_or(mean, wide);
        let com = match target {
            AttachTo::Body(body) => bodies.get(body).map(|b| wide(b.local_center_of_mass())),
            _ => None,
        };
        let com = com.unwrap_or_default();
        self.wake_attached(deformable, target);
        // What holds nodes for the first time holds them where it is, not where its shadow was.
        if let AttachTo::Body(body) = target
            && !self.holds_nodes(body)
            && let Some(memory) = self.memory.get_mut(&body.into_raw_parts())
        {
            memory.offset = Default::default();
        }
        Ok(AttachmentHandle(self.attachments.insert(Bond {
            deformable,
            target,
            hold,
            nodes: nodes.into(),
            points: points.into(),
            pivot: rot.inverse() * (about - origin),
            com,
            strength: attachment.strength.into(),
            moment_strength: attachment.moment_strength.into(),
            force: DVec3::ZERO,
            moment: DVec3::ZERO,
            torque: DVec3::ZERO,
            by_pins: Load::default(),
            energy: 0.0,
            moved: Vec::new(),
            moved_in: 0.0,
            average: Default::default(),
            broken: None,
            loose: false,
            apart_asleep: None,
        })))
    }

    /// Lets attached nodes go. The energy of a link goes as well, as external work.
    pub fn detach(&mut self, handle: AttachmentHandle) -> bool {
        let bond = self.attachments.remove(handle.0);
        bond.map(|bond| self.release(&bond)).is_some()
    }

    fn holds_nodes(&self, body: RigidBodyHandle) -> bool {
        let mut bonds = self.attachments.iter().map(|(_, bond)| bond);
        bonds.any(|bond| bond.body() == Some(body) && !bond.is_broken())
    }

    fn wake_attached(&mut self, deformable: DeformableHandle, target: AttachTo) {
        let other = match target {
            AttachTo::Deformable(other) => Some(other),
            _ => None,
        };
        for handle in [Some(deformable), other].into_iter().flatten() {
            if let Some(body) = self.get_mut(handle) {
                body.wake_up();
            }
        }
    }

    fn release(&mut self, bond: &AttachmentState) {
        self.wake_attached(bond.deformable, bond.target);
        if let Some(owner) = self.get_mut(bond.deformable) {
            owner.links -= bond.energy;
            owner.solver.work.external -= bond.energy;
        }
    }

    /// An attachment.
    pub fn attachment(&self, handle: AttachmentHandle) -> Option<&AttachmentState> {
        self.attachments.get(handle.0)
    }

    /// All attachments, broken ones included, in the order of their slots.
    pub fn attachments(&self) -> impl Iterator<Item = (AttachmentHandle, &AttachmentState)> {
        self.attachments
            .iter()
            .map(|(i, a)| (AttachmentHandle(i), a))
    }

    /// Whether the handle is that of an attachment in this world.
    pub fn contains_attachment(&self, handle: AttachmentHandle) -> bool {
        self.attachments.contains(handle.0)
    }

    /// Mean force \[N\] that an attachment exerted on its target in the last rigid step, and its torque about the rigid
    /// body's centre of mass, or about the world's origin \[N·m\]. (A [`contact_force`](Self::contact_force) is the other way
    /// round, on the deformable, and the mean over all rigid steps of the world's.) [`AttachmentState::moment`] is about the
    /// pivot. What pinned
    /// nodes bear of a body goes on being told while that sleeps; of one that slept when it was attached, or of one that is
    /// fixed or kinematic, they bear nothing.
    pub fn attachment_force(&self, handle: AttachmentHandle) -> Option<(DVec3, DVec3)> {
        self.attachments.get(handle.0).map(|a| (a.force, a.torque))
    }

    /// How far the farthest held point is from where it is held, now \[m\]. A rigid body that rests on others or hangs on
    /// joints, and is light for the springs behind the nodes, can be half a millimetre and 5 mrad off the place at which it holds them, see
    /// `docs/limits.md`.
    pub fn attachment_stretch(
        &self,
        handle: AttachmentHandle,
        bodies: &RigidBodySet,
    ) -> Option<f64> {
        let bond = self.attachments.get(handle.0)?;
        let frame = match bond.target {
            AttachTo::Body(body) => frame(bodies.get(body)?),
            _ => (DVec3::ZERO, DQuat::IDENTITY),
        };
        self.stretch(bond, frame)
    }

    /// The same from where it is held in truth.
    fn own_stretch(&self, bond: &AttachmentState, bodies: &RigidBodySet) -> Option<f64> {
        let frame = match bond.target {
            AttachTo::Body(body) => held_frame(&self.memory, (body, bodies.get(body)?)),
            _ => (DVec3::ZERO, DQuat::IDENTITY),
        };
        self.stretch(bond, frame)
    }

    fn stretch(&self, bond: &AttachmentState, (origin, rot): (DVec3, DQuat)) -> Option<f64> {
        let other = match bond.target {
            AttachTo::Deformable(other) => Some(&self.get(other)?.state),
            _ => None,
        };
        let own = &self.get(bond.deformable)?.state;
        let errors = bond.errors(origin, rot, own, other);
        Some(errors.map(|e| e.length()).fold(0.0, f64::max))
    }

    /// Removes the attachments of what is gone.
    pub(super) fn drop_stale_attachments(&mut self, bodies: Option<&RigidBodySet>) {
        let stale = |bond: &AttachmentState, world: &Self| {
            !world.contains(bond.deformable)
                || match bond.target {
                    AttachTo::Body(body) => bodies.is_some_and(|b| !b.contains(body)),
                    AttachTo::Deformable(other) => !world.contains(other),
                    _ => false,
                }
        };
        let all = self.attachments.iter();
        let found: Vec<_> = all
            .filter(|(_, a)| stale(a, self))
            .map(|(i, _)| i)
            .collect();
        for i in found {
            self.detach(AttachmentHandle(i));
        }
    }

    /// Finds out which attachments were pulled apart from outside since the last step.
    pub(super) fn find_loose_attachments(&mut self, parts: &RapierParts) {
        let limit = LOOSE * parts.length_unit();
        let look = |(i, bond): (_, &AttachmentState)| {
            let apart = self.own_stretch(bond, parts.bodies);
            let body = bond.body().and_then(|b| parts.bodies.get(b));
            let asleep = body.is_some_and(|b| b.is_sleeping());
            let loose = !bond.is_link() && apart.is_some_and(|s| s > limit);
            (i, loose, apart.filter(|_| asleep))
        };
        let found: Vec<_> = self.attachments.iter().map(look).collect();
        for (i, loose, apart) in found {
            let bond = &mut self.attachments[i];
            (bond.loose, bond.apart_asleep) = (loose, apart);
        }
    }

    /// Whether it was pulled apart, or together, since the last step, in which its rigid body slept.
    pub(super) fn is_moved_asleep(&self, bond: &AttachmentState, parts: &RapierParts) -> bool {
        let apart = self.own_stretch(bond, parts.bodies);
        let by = apart.zip(bond.apart_asleep).map(|(now, last)| now - last);
        by.is_some_and(|by| by.abs() > LOOSE * parts.length_unit())
    }
}

/// Where a rigid body's frame is, and its axes.
pub(super) fn frame(body: &RigidBody) -> (DVec3, DQuat) {
    let at = body.position();
    (wide(at.translation), wide_rotation(at.rotation))
}

/// The same where it holds nodes, which is that of its shadow.
pub(super) fn held_frame(
    memory: &BTreeMap<BodyKey, BodyMemory>,
    (handle, body): (RigidBodyHandle, &RigidBody),
) -> (DVec3, DQuat) {
    let (origin, rot) = frame(body);
    let Some(memory) = memory.get(&handle.into_raw_parts()) else {
        return (origin, rot);
    };
    let com = wide(body.center_of_mass());
    let (at, turned) = memory.apart(com, rot);
    if (at, turned) == (com, rot) {
        return (origin, rot);
    }
    (at + turned * (rot.inverse() * (origin - com)), turned)
}

/// How the nodes are held, once its numbers are in range.
fn checked(a: &Attachment) -> Result<Hold, AttachError> {
    let value = |what, value: f32, must| AttachError::Value {
        what,
        value: value.into(),
        must,
    };
    for (what, x) in [
        ("the strength", a.strength),
        ("the moment strength", a.moment_strength),
    ] {
        if x.is_nan() || x < 0.0 {
            return Err(value(what, x, "positive, 0 or infinite"));
        }
    }
    let mut pivot = a.at.iter().flat_map(|at| at.to_array());
    if let Some(x) = pivot.find(|x| !x.is_finite()) {
        return Err(value("a coordinate of the pivot", x, "finite"));
    }
    let Hold::Link { stiffness, .. } = a.hold else {
        return match a.damping {
            Some(c) => Err(value("the damping", c, "left out but for links")),
            None => Ok(a.hold),
        };
    };
    let damping = a.damping.unwrap_or(0.0);
    if !(stiffness as f32).is_normal() || stiffness < 0.0 {
        let must = "positive and finite";
        return Err(value("the stiffness of the link", stiffness as f32, must));
    }
    if !(damping.is_finite() && damping >= 0.0) {
        let must = "0 or positive, and finite";
        return Err(value("the damping of the link", damping, must));
    }
    Ok(Hold::Link {
        stiffness,
        damping: damping.into(),
    })
}

/// The nodes in ascending order, each once.
fn nodes_of(a: &Attachment, soft: &Deformable) -> Result<Vec<u32>, AttachError> {
    let mut nodes: Vec<u32> = a.nodes.iter().map(|n| n.0).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let count = soft.node_count();
    match nodes.last() {
        None => Err(AttachError::NoNodes),
        Some(&node) if node as usize >= count => Err(AttachError::UnknownNode { node, count }),
        _ => Ok(nodes),
    }
}

/// The points to be held; their anchors are still where they are in the world.
fn held_points(
    a: &Attachment,
    soft: &Deformable,
    nodes: &[u32],
) -> Result<Vec<Point>, AttachError> {
    let own = |node: u32, weight: f64| Part {
        other: false,
        node,
        weight,
    };
    let position = |node: u32| soft.state.position(node as usize);
    if a.hold != Hold::Pin {
        let single = |&node: &u32| Point {
            parts: vec![own(node, 1.0)],
            anchor: position(node),
        };
        return Ok(nodes.iter().map(single).collect());
    }
    let mass = |node: u32| f64::from(soft.blueprint.nodes[node as usize].mass);
    let masses: Vec<_> = nodes.iter().map(|&n| (position(n), mass(n))).collect();
    let (weights, distance, extent) = pivot(&masses, a.at.map(wide));
    if distance > CLOSE * extent.max(0.01) || !distance.is_finite() {
        return Err(AttachError::Pivot { distance });
    }
    let parts: Vec<Part> = nodes.iter().zip(weights).map(|(&n, w)| own(n, w)).collect();
    let anchor = parts.iter().map(|p| position(p.node) * p.weight).sum();
    Ok(vec![Point { parts, anchor }])
}

/// Holds a point at the nearest one of another deformable.
fn stick(point: &mut Point, other: &Deformable) -> Result<(), AttachError> {
    let node = point.parts[0].node;
    let too_far = |distance, limit| AttachError::TooFar {
        node,
        distance,
        limit,
    };
    let search = other.search(0.0);
    let found = search.nearest(point.anchor - other.state.origin, f64::INFINITY);
    let found = found.filter(|f| f.distance.is_finite());
    let found = found.ok_or(too_far(f64::INFINITY, CLOSE))?;
    let [a, b, c] = search.corners(found.at.feature);
    let edge = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let limit = if edge > 0.0 { FACE_GAP * edge } else { CLOSE };
    if found.distance > limit {
        return Err(too_far(found.distance, limit));
    }
    let weighted = found.at.nodes.into_iter().zip(found.weights);
    let weighted = weighted.filter(|(_, weight)| *weight != 0.0);
    point.parts.extend(weighted.map(|(node, weight)| Part {
        other: true,
        node: node.0,
        weight: -weight,
    }));
    point.anchor = DVec3::ZERO;
    Ok(())
}
