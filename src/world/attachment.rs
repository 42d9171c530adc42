//! Attachments of nodes to rigid bodies, as the world keeps them.

use super::{AttachmentHandle, DeformableHandle, DeformableWorld, RapierParts};
use crate::body::NodeId;
use crate::contact::target::wide_rotation;
use crate::coupling::attach::Attachment;
use crate::math::{DVec3, wide};
use rapier3d::dynamics::{RigidBodyHandle, RigidBodySet};

/// Why nodes can't be attached.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AttachError {
    /// The deformable is not in this world.
    #[error("there is no deformable {0:?} in this world")]
    UnknownDeformable(DeformableHandle),
    /// The rigid body is not in Rapier's set.
    #[error("there is no rigid body {0:?} in the set")]
    UnknownBody(RigidBodyHandle),
    /// A node does not exist.
    #[error("node {node} does not exist, the body has {count} nodes")]
    UnknownNode {
        /// Its index.
        node: u32,
        /// How many there are.
        count: usize,
    },
    /// No nodes were given.
    #[error("no nodes to attach")]
    NoNodes,
}

impl DeformableWorld {
    /// Holds nodes of a deformable where they are now relative to a rigid body, both ways.
    ///
    /// # Errors
    /// An unknown deformable, body or node, or no nodes at all.
    pub fn attach(
        &mut self,
        deformable: DeformableHandle,
        nodes: &[NodeId],
        body: RigidBodyHandle,
        bodies: &RigidBodySet,
    ) -> Result<AttachmentHandle, AttachError> {
        let soft = self
            .get(deformable)
            .ok_or(AttachError::UnknownDeformable(deformable))?;
        let rigid = bodies.get(body).ok_or(AttachError::UnknownBody(body))?;
        if nodes.is_empty() {
            return Err(AttachError::NoNodes);
        }
        let turn = wide_rotation(rigid.position().rotation);
        let com = wide(rigid.position().translation) + turn * wide(rigid.local_center_of_mass());
        let mut anchors = Vec::with_capacity(nodes.len());
        for &node in nodes {
            let position = soft.position(node).ok_or(AttachError::UnknownNode {
                node: node.0,
                count: soft.node_count(),
            })?;
            anchors.push((node.0, turn.inverse() * (position - com)));
        }
        anchors.sort_by_key(|(node, _)| *node);
        anchors.dedup_by_key(|(node, _)| *node);
        Ok(AttachmentHandle(self.attachments.insert(Attachment {
            deformable,
            body,
            anchors,
            force: DVec3::ZERO,
            torque: DVec3::ZERO,
        })))
    }

    /// Lets attached nodes go.
    pub fn detach(&mut self, handle: AttachmentHandle) -> bool {
        self.attachments.remove(handle.0).is_some()
    }

    /// Whether the handle is that of an attachment in this world.
    pub fn contains_attachment(&self, handle: AttachmentHandle) -> bool {
        self.attachments.contains(handle.0)
    }

    /// An attachment: what it holds, and where.
    pub fn attachment(&self, handle: AttachmentHandle) -> Option<&Attachment<DeformableHandle>> {
        self.attachments.get(handle.0)
    }

    /// All attachments, in the order of their slots.
    pub fn attachments(
        &self,
    ) -> impl Iterator<Item = (AttachmentHandle, &Attachment<DeformableHandle>)> {
        self.attachments
            .iter()
            .map(|(i, a)| (AttachmentHandle(i), a))
    }

    /// Mean force \[N\] and torque about the centre of mass \[N·m\] that an attachment exerted on its rigid body in the
    /// last rigid step.
    pub fn attachment_force(&self, handle: AttachmentHandle) -> Option<(DVec3, DVec3)> {
        self.attachments.get(handle.0).map(|a| (a.force, a.torque))
    }

    /// Attachments to bodies that are gone, go.
    pub(super) fn drop_stale_attachments(&mut self, parts: &RapierParts) {
        self.attachments
            .retain(|_, a| parts.bodies.contains(a.body));
    }
}
