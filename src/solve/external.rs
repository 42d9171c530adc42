//! Forces from outside: gravity, drag, node forces and a user's force field.

use crate::body::NodeId;
use crate::math::Vector;

/// A force field on nodes. Wind is the example: `drag_area · (wind − velocity)`.
///
/// Called once per node and force evaluation, so keep it cheap. A trait because strangers plug in here.
///
/// The stable substep h knows nothing of it. By symplectic Euler, the default scheme, it is given the velocity of the substep before: a
/// drag of c N·s/m is stable on nodes of m kg while c·h < 2m, and a force across the velocity, as Coriolis' and Lorentz's, makes
/// (F·h/(m·v))² of the kinetic energy in every substep. A stiffness of k N/m wants k·h² < 4m. Velocity Verlet and RK4 are as
/// good as exact across the velocity; drag is stable in any substep where the builder's
/// [`drag`](crate::world::DeformableBuilder::drag) is it.
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
