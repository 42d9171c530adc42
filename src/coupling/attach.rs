//! Attachments: nodes held at points of a rigid body, both ways, with a force one can read.

use crate::body::state::State;
use crate::contact::site::slot;
use crate::math::{DVec3, Real};
use crate::solve::rows::{Rows, Term, Tie};
use crate::solve::shadow::Shadow;
use rapier3d::dynamics::RigidBodyHandle;

/// Nodes of one deformable held at points of one rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Attachment<D> {
    /// The deformable.
    pub deformable: D,
    /// The rigid body.
    pub body: RigidBodyHandle,
    /// Each node and its anchor relative to the body's centre of mass, in the body's axes \[m\].
    pub anchors: Vec<(u32, DVec3)>,
    /// Mean force the deformable exerted on the body in the last step \[N\].
    pub force: DVec3,
    /// Its mean torque about the body's centre of mass \[N·m\].
    pub torque: DVec3,
}

impl<D> Attachment<D> {
    /// Adds a tie for every anchor.
    pub fn add_ties(
        &self,
        index: u32,
        body: u32,
        shadow: (u32, &Shadow),
        state: &State<Real>,
        slots: &mut [u32],
        rows: &mut Rows,
    ) {
        for &(node, anchor) in &self.anchors {
            let arm = shadow.1.rot * anchor;
            let error = state.position(node as usize) - (shadow.1.com + arm);
            let node = slot(body, node, state, slots, rows);
            let terms = rows.add_terms([Term {
                node,
                weight: 1.0,
                share: 1.0,
            }]);
            rows.ties.push(Tie {
                terms,
                between: false,
                bias: DVec3::ZERO,
                softness: 0.0,
                shadow: shadow.0,
                attachment: index,
                arm,
                error,
                impulse: DVec3::ZERO,
                mass: Default::default(),
            });
        }
    }
}
