//! What of a body touches others: its nodes and faces, or those of an embedded skin.

use super::Deformable;
use super::substep::Group;
use crate::body::{Blueprint, Embedded, State, Topology};
use crate::contact::site::{Carrier, Side};
use crate::math::{DVec3, Real};
use crate::solve::kernel;

impl Deformable {
    /// The points and faces that touch, at rest.
    pub(super) fn contact_blueprint(&self) -> &Blueprint {
        let skin = self.embedded.as_deref();
        skin.map_or(&self.blueprint, |e| &e.blueprint)
    }

    /// Where these points are: of a skin, where they were when it last [followed](Self::follow).
    pub(super) fn contact_state(&self) -> &State<Real> {
        let skin = self.embedded.as_deref();
        skin.map_or(&self.state, |e| &e.state)
    }

    /// Their faces and edges.
    pub(super) fn contact_topology(&self) -> &Topology {
        let skin = self.embedded.as_deref();
        skin.map_or(&self.topology, |e| &e.topology)
    }

    /// Takes the skin along.
    pub(super) fn follow(&mut self) {
        if let Some(embedded) = &mut self.embedded {
            embedded.follow(&self.state);
        }
    }

    /// How much farther than its nodes what touches may go \[1\].
    pub(super) fn gain(&self) -> f64 {
        self.embedded.as_ref().map_or(1.0, |e| e.gain)
    }

    /// The corners of the box around all that can touch, and around the nodes \[m\].
    pub(super) fn contact_bounds(&self) -> (DVec3, DVec3) {
        let (lo, hi) = kernel::box_around(self.solver.kernel, &self.state);
        let Some(embedded) = &self.embedded else {
            return (lo, hi);
        };
        let points = embedded.bindings.iter().map(|binding| {
            let parts = binding.parts();
            parts
                .map(|(node, w)| self.state.local(node) * w)
                .sum::<DVec3>()
                + self.state.origin
        });
        points.fold((lo, hi), |(lo, hi), x| (lo.min(x), hi.max(x)))
    }

    /// It in a substep, as member `body` of its group, and the map of its nodes to row nodes.
    pub(super) fn side(&mut self, body: u32) -> (Side<'_>, &mut [u32]) {
        let Self {
            state,
            topology,
            embedded,
            slots,
            solver,
            ..
        } = self;
        let forces = &solver.forces;
        let carrier = |bindings| Carrier {
            body,
            nodes: state,
            bindings,
        };
        let side = match embedded {
            None => Side {
                state,
                topology,
                carrier: carrier(None),
                forces,
            },
            Some(e) => {
                let Embedded {
                    state, topology, ..
                } = &**e;
                Side {
                    state,
                    topology,
                    carrier: carrier(Some(&e.bindings)),
                    forces,
                }
            }
        };
        (side, slots)
    }

    /// The points that touch and are carried by some of these nodes alone; both are in ascending order.
    pub(super) fn points_of(&self, nodes: &[u32]) -> Vec<u32> {
        let Some(embedded) = &self.embedded else {
            return nodes.to_vec();
        };
        let known = |node: usize| nodes.binary_search(&(node as u32)).is_ok();
        let points = (0..).zip(&embedded.bindings);
        let held = points.filter(|(_, b)| b.parts().all(|(node, _)| known(node)));
        held.map(|(point, _)| point).collect()
    }
}

impl Group {
    /// Takes the skins of all members along.
    pub(super) fn follow(&mut self) {
        self.members.iter_mut().for_each(|(_, body)| body.follow());
    }
}
