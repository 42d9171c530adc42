//! Forces from outside: gravity, drag, node forces and a user's force field.

use crate::body::NodeId;
use crate::math::Vector;

/// A force field on nodes. Wind is the example: `drag_area · (wind − velocity)`.
///
/// Called once per node and force evaluation, so keep it cheap. A trait because strangers plug in here.
pub trait ForceField: Send + Sync {
    /// Force on a node \[N\] at `position` \[m\] moving at `velocity` \[m/s\], `time` s into the simulation.
    fn force(&self, node: NodeId, position: Vector, velocity: Vector, time: f64) -> Vector;
}

impl<F> ForceField for F
where
    F: Fn(NodeId, Vector, Vector, f64) -> Vector + Send + Sync,
{
    fn force(&self, node: NodeId, position: Vector, velocity: Vector, time: f64) -> Vector {
        self(node, position, velocity, time)
    }
}

/// What acts on every node of a body besides its springs.
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct External<S> {
    /// Acceleration of gravity \[m/s²\].
    pub gravity: [S; 3],
    /// D in the force −D·v on every node \[N·s/m\].
    pub drag: S,
    /// Force on each node \[N\]; empty for none.
    pub node_forces: Vec<[S; 3]>,
}
