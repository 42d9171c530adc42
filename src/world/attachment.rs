//! What a user says of an attachment, and what can be wrong with it.

use super::DeformableHandle;
use crate::body::NodeId;
use crate::coupling::attach::{Hold, To};
use crate::math::{Real, Vector};
use rapier3d::dynamics::RigidBodyHandle;

/// What nodes are attached to: a rigid body, another deformable, or the world.
pub type AttachTo = To<DeformableHandle>;

impl From<DeformableHandle> for AttachTo {
    fn from(deformable: DeformableHandle) -> Self {
        Self::Deformable(deformable)
    }
}

/// Nodes to be attached, how, and how strongly.
///
/// A tow rope that breaks at 500 N:
///
/// ```
/// use crumple::prelude::*;
/// use crumple::rapier3d::prelude::*;
/// let mut world = PhysicsWorld::default();
/// let load = world.insert_body(
///     RigidBodyBuilder::dynamic().additional_mass(100.0).translation(Vector::new(0.0, -1.0, 0.0)),
/// );
/// let mut deformables = DeformableWorld::default();
/// let line = deformables.insert(
///     DeformableBuilder::new(rope(Vector::ZERO, Vector::new(0.0, -1.0, 0.0), 4, 1e-4)?)
///         .material(Material::elastic(1.0e8, 1000.0).viscosity(1.0e5)),
/// )?;
/// let hook = Attachment::pin([NodeId(0)]);
/// deformables.attach(line, hook, AttachTo::World, &world.bodies)?;
/// let eye = Attachment::pin([NodeId(4)]).strength(500.0); // half of the load's weight
/// let eye = deformables.attach(line, eye, load, &world.bodies)?;
/// for _ in 0..60 {
///     deformables.step(&mut world);
/// }
/// let broken = deformables.attachment(eye).and_then(|a| a.broken).expect("981 N hang on it");
/// println!("broke at {:.0} N after {:.4} s", broken.force.length(), broken.time);
/// assert!(broken.force.length() >= 500.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Attachment {
    pub(super) nodes: Vec<NodeId>,
    pub(super) hold: Hold,
    pub(super) at: Option<Vector>,
    pub(super) damping: Option<Real>,
    pub(super) strength: Real,
    pub(super) moment_strength: Real,
}

impl Attachment {
    fn new(nodes: impl IntoIterator<Item = NodeId>, hold: Hold) -> Self {
        Self {
            nodes: nodes.into_iter().collect(),
            hold,
            at: None,
            damping: None,
            strength: Real::INFINITY,
            moment_strength: Real::INFINITY,
        }
    }

    /// Holds every node at its own point, where it is when it is attached. Three nodes or more that are not in line hold the
    /// rotation as well.
    pub fn weld(nodes: impl IntoIterator<Item = NodeId>) -> Self {
        Self::new(nodes, Hold::Weld)
    }

    /// Holds the centre of mass of the nodes, or the point given by [`Self::at`], and leaves rotation free: a ball joint.
    pub fn pin(nodes: impl IntoIterator<Item = NodeId>) -> Self {
        Self::new(nodes, Hold::Pin)
    }

    /// Holds every node where it is when it is attached, by a spring of `stiffness` N/m and zero rest length, which must be
    /// positive: a damper alone is no link. It is stable at any stiffness, and its energy counts as the deformable's.
    pub fn link(nodes: impl IntoIterator<Item = NodeId>, stiffness: Real) -> Self {
        let hold = Hold::Link {
            stiffness: stiffness.into(),
            damping: 0.0,
        };
        Self::new(nodes, hold)
    }

    /// Damping of each node of a link \[N·s/m\].
    pub fn damping(mut self, damping: Real) -> Self {
        self.damping = Some(damping);
        self
    }

    /// A point of the world \[m\]: what a pin turns about, which must be within reach of its nodes (in their plane, or on
    /// their line, if they lie in one); for the others, what the moment is taken about.
    pub fn at(mut self, point: Vector) -> Self {
        self.at = Some(point);
        self
    }

    /// Resultant force at which it breaks \[N\]. The force is an average over 0.1 ms, or over a substep if that is longer: a
    /// single hard blow has an impulse and no force that would not depend on the substep. Nodes that are attached to the surface of
    /// another deformable are drawn up to it first, at up to [`push_out_speed`](super::DeformableParameters::push_out_speed), and the force
    /// of that counts: across a gap of half a millimetre it broke an attachment of 50 N.
    pub fn strength(mut self, force: Real) -> Self {
        self.strength = force;
        self
    }

    /// Resultant moment at which it breaks \[N·m\], about the point given by [`Self::at`], or else the mean of the nodes.
    pub fn moment_strength(mut self, moment: Real) -> Self {
        self.moment_strength = moment;
        self
    }
}

impl From<&[NodeId]> for Attachment {
    fn from(nodes: &[NodeId]) -> Self {
        Self::weld(nodes.iter().copied())
    }
}

impl From<&Vec<NodeId>> for Attachment {
    fn from(nodes: &Vec<NodeId>) -> Self {
        Self::weld(nodes.iter().copied())
    }
}

impl<const N: usize> From<&[NodeId; N]> for Attachment {
    fn from(nodes: &[NodeId; N]) -> Self {
        Self::weld(nodes.iter().copied())
    }
}

impl From<&Self> for Attachment {
    fn from(attachment: &Self) -> Self {
        attachment.clone()
    }
}

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
    /// A number is out of range.
    #[error("{what} is {value}, it must be {must}")]
    Value {
        /// Name of the value.
        what: &'static str,
        /// The value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A deformable can't be attached to itself.
    #[error("deformable {0:?} can't be attached to itself")]
    ToItself(DeformableHandle),
    /// A node is too far from the surface of the deformable it is to be attached to.
    #[error(
        "node {node} is {distance} m from the other deformable's surface, at most {limit} m can be bridged"
    )]
    TooFar {
        /// Its index; of a pin, that of its first node.
        node: u32,
        /// How far it is \[m\].
        distance: f64,
        /// How far it may be \[m\]: a twentieth of the nearest face's longest edge.
        limit: f64,
    },
    /// The nodes of a pin can't make its pivot.
    #[error("the pivot is {distance} m away from anything its nodes can make; pin more nodes")]
    Pivot {
        /// How far \[m\].
        distance: f64,
    },
}
