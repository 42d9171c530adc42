//! The observer: called after every substep with what happened in it. A trait because strangers plug in here; whatever it
//! does, it can't change a result.

use super::touch::TouchEvent;
use super::{AttachmentHandle, Deformable, DeformableHandle};
use crate::body::{NodeId, SpringId};
use crate::math::DVec3;
use rapier3d::geometry::ColliderHandle;

/// Sees every substep of every group of deformables. `Send`, because bodies may be advanced by the threads of a pool.
pub trait Observer: Send {
    /// Called after a substep.
    fn substep(&mut self, substep: &Substep);
    /// Called when a spring yields for the first time or breaks.
    fn event(&mut self, _event: &SpringEvent) {}
    /// Called when an attachment breaks.
    fn attachment_event(&mut self, _event: &AttachmentBroke) {}
    /// Called at the end of a step for every contact that began, was strong or ended in it.
    fn touch_event(&mut self, _event: &TouchEvent) {}
    /// Whether [`Self::substep`], [`Self::event`] and [`Self::attachment_event`] are to be called; asked in every rigid step. They
    /// are called in the order of groups, one group after the other. Without them groups are advanced at once where there are
    /// threads (feature `parallel`).
    fn wants_substeps(&self) -> bool {
        true
    }
    /// Whether [`Self::substep`] is to find in the bodies what their springs have flowed by `time`, the end of the substep \[s\]: for
    /// energies, tensions and lengths at rest. Bringing these up to date costs time; without it they are those of an earlier
    /// substep, while positions and velocities are always those of `time`. Asked before every call, with the group's bodies.
    fn wants_springs(
        &self,
        _time: f64,
        _deformables: &[(DeformableHandle, Box<Deformable>)],
    ) -> bool {
        self.wants_substeps()
    }
    /// Whether [`Substep::node_impulses`] are wanted, which costs time; asked in every substep.
    fn wants_node_impulses(&self) -> bool {
        false
    }
}

/// Observes nothing.
impl Observer for () {
    fn substep(&mut self, _: &Substep) {}
    fn wants_substeps(&self) -> bool {
        false
    }
    fn wants_springs(&self, _: f64, _: &[(DeformableHandle, Box<Deformable>)]) -> bool {
        false
    }
}

/// What happened in a substep of one group.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct Substep<'a> {
    /// Simulated time at its end \[s\].
    pub time: f64,
    /// Its length \[s\].
    pub h: f64,
    /// The deformables of the group.
    pub deformables: &'a [(DeformableHandle, Box<Deformable>)],
    /// Every pair of deformable and partner that is near, touching or not. Two deformables are two pairs, one seen from
    /// each.
    pub contacts: &'a [PairImpulse],
    /// What each attachment transmitted.
    pub attachments: &'a [AttachmentImpulse],
    /// What nodes got from contacts; empty unless [`Observer::wants_node_impulses`].
    pub node_impulses: &'a [NodeImpulse],
}

/// What a deformable is in contact with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub enum Partner {
    /// A collider.
    Collider(ColliderHandle),
    /// Another deformable.
    Deformable(DeformableHandle),
}

impl Partner {
    /// What partners are sorted by: colliders come first.
    pub(super) fn key(self) -> (bool, (u32, u32)) {
        match self {
            Self::Collider(c) => (false, c.into_raw_parts()),
            Self::Deformable(d) => (true, d.key()),
        }
    }
}

impl From<ColliderHandle> for Partner {
    fn from(collider: ColliderHandle) -> Self {
        Self::Collider(collider)
    }
}

impl From<DeformableHandle> for Partner {
    fn from(deformable: DeformableHandle) -> Self {
        Self::Deformable(deformable)
    }
}

/// What a node got from one point of contact in a substep. A point within a face or an edge gives to each of its nodes; a
/// node may get from several points, which add up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeImpulse {
    /// The deformable.
    pub deformable: DeformableHandle,
    /// The node.
    pub node: NodeId,
    /// What pushed it.
    pub partner: Partner,
    /// Impulse on the node \[N·s\]; none for a deformable that dominates the partner.
    pub impulse: DVec3,
}

/// What one partner did to one deformable in a substep.
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairImpulse {
    /// The deformable.
    pub deformable: DeformableHandle,
    /// What it touches.
    pub partner: Partner,
    /// Impulse on the deformable \[N·s\].
    pub impulse: DVec3,
    /// Deepest point \[m\], 0 when none is inside.
    pub depth: f64,
    /// Points that received an impulse.
    pub touching: u32,
}

/// What one attachment did in a substep to a deformable: that which is attached, or the one that it is attached to.
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttachmentImpulse {
    /// The attachment.
    pub attachment: AttachmentHandle,
    /// The deformable.
    pub deformable: DeformableHandle,
    /// Impulse on the deformable \[N·s\].
    pub impulse: DVec3,
    /// Angular impulse on the deformable about the attachment's pivot \[N·m·s\].
    pub moment: DVec3,
}

/// An attachment broke: under what, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttachmentBroke {
    /// The attachment.
    pub attachment: AttachmentHandle,
    /// The deformable.
    pub deformable: DeformableHandle,
    /// Force on what it was attached to \[N\].
    pub force: DVec3,
    /// Moment on it about the pivot \[N·m\].
    pub moment: DVec3,
    /// Simulated time at the end of the substep \[s\].
    pub time: f64,
}

/// What happened to a spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SpringEventKind {
    /// It flowed for the first time.
    YieldBegan,
    /// It broke.
    Broke,
}

/// A spring yielded or broke: which, where, when, at what force and energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringEvent {
    /// What happened.
    pub kind: SpringEventKind,
    /// The body.
    pub deformable: DeformableHandle,
    /// The spring.
    pub spring: SpringId,
    /// Middle of the spring in the world \[m\].
    pub position: DVec3,
    /// Simulated time at the end of the substep \[s\].
    pub time: f64,
    /// Tension when it happened \[N\], negative in compression.
    pub force: f64,
    /// Elastic energy it held when it happened \[J\].
    pub energy: f64,
}
