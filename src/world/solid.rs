//! What can be read of a body's tets.

use super::Deformable;
use crate::body::{Solid, SolidMesh, TetId, TetMesh};
use crate::law::basis;
use crate::math::Real;
use crate::solve::fem::{Part, Stress};

impl Deformable {
    fn part(&self) -> Option<(&SolidMesh, &Part<Real>)> {
        Some((self.blueprint.solid.as_deref()?, self.solver.part.as_ref()?))
    }

    /// How many tets it has.
    pub fn tet_count(&self) -> usize {
        self.tet_mesh().map_or(0, |mesh| mesh.tets.len())
    }

    /// Its tets at rest, in its own frame; `None` for a body of springs.
    pub fn tet_mesh(&self) -> Option<&TetMesh> {
        self.blueprint.solid.as_deref().map(|s| &s.mesh)
    }

    /// What its tets are made of; `None` for a body of springs.
    pub fn solid(&self) -> Option<&Solid> {
        self.blueprint.solid.as_deref().map(|s| &s.solid)
    }

    /// Elastic stress and strain of a tet now, the mean over its volume; `None` for an unknown id.
    pub fn stress(&self, tet: TetId) -> Option<Stress> {
        let at = |n: usize| self.state.local(n).to_array();
        self.part()?.1.model.stress(tet.index(), at)
    }

    /// Elastic stress and strain of every tet now; empty for a body of springs.
    pub fn stresses(&self) -> Vec<Stress> {
        let at = |n: usize| self.state.local(n).to_array();
        self.part()
            .map_or_else(Vec::new, |(_, part)| part.model.stresses(at))
    }

    /// Von Mises stress at each node \[Pa\]: the mean over its tets by their volume. 0 where it has none.
    pub fn node_von_mises(&self) -> Vec<Real> {
        let mut sums = vec![(0.0, 0.0); self.node_count()];
        if let Some(mesh) = self.tet_mesh() {
            let each = mesh.tets.iter().zip(mesh.corner_volumes());
            for ((nodes, volume), stress) in each.zip(self.stresses()) {
                for &node in nodes {
                    sums[node as usize].0 += volume * stress.von_mises;
                    sums[node as usize].1 += volume;
                }
            }
        }
        let mean = |(sum, volume): &(f64, f64)| if *volume > 0.0 { sum / volume } else { 0.0 };
        sums.iter().map(|s| mean(s) as Real).collect()
    }

    /// Largest strain of any edge of a tet, as its length over that at rest minus 1.
    pub(super) fn max_edge_strain(&self) -> f64 {
        let Some(mesh) = self.tet_mesh() else {
            return 0.0;
        };
        let strain = |corners: [u32; 4], [a, b]: [usize; 2]| {
            let [a, b] = [corners[a] as usize, corners[b] as usize];
            let rest = mesh.nodes[a].distance(mesh.nodes[b]);
            (self.state.local(a).distance(self.state.local(b)) / rest - 1.0).abs()
        };
        let corners = mesh.tets.corners();
        corners
            .flat_map(|c| basis::EDGES.map(|edge| strain(c, edge)))
            .fold(0.0, f64::max)
    }
}
