//! A tetrahedral mesh as springs along its edges.

use super::{TetMesh, Tets};
use crate::body::{Net, Node, Spring};
use crate::law::basis;
use crate::math::narrow;

impl TetMesh {
    /// A net of springs with the constants of Van Gelder (1998), k = Σ E·V/L² over the tets around an edge: as sections,
    /// Σ V/L, so that any [`Material`](crate::body::Material) applies. A quarter of each tet's volume goes to each of its
    /// corners. Middle nodes are left out.
    ///
    /// Springs along edges can't have the E and ν of a solid on every mesh: on cubes cut into five tets the net has
    /// E₁₀₀ = 1.2·E, ν = .2 and Zener's ratio .667, on cubes cut into six 1.0345·E, .0345 and .476. What
    /// a net really has is measured by a static solve.
    pub fn springs(&self) -> Net {
        let mut node_of = vec![u32::MAX; self.nodes.len()];
        for corner in self.tets.corners().flatten() {
            node_of[corner as usize] = 0;
        }
        let mut net = Net::default();
        for (node, place) in node_of.iter_mut().zip(&self.nodes) {
            if *node == 0 {
                *node = net.nodes.len() as u32;
                net.nodes.push(Node::of_volume(narrow(*place), 0.0));
            }
        }
        let mut volumes = vec![0.0; net.nodes.len()];
        let mut shares: Vec<([u32; 2], f64)> = Vec::with_capacity(6 * self.tets.len());
        for (tet, volume) in self.tets.iter().zip(self.corner_volumes()) {
            let at = self.corners(tet);
            for corner in &tet[..4] {
                volumes[node_of[*corner as usize] as usize] += 0.25 * volume;
            }
            for [a, b] in basis::EDGES {
                let mut ends = [a, b].map(|c| node_of[tet[c] as usize]);
                ends.sort_unstable();
                shares.push((ends, volume / at[a].distance(at[b])));
            }
        }
        // Stable: shares of one edge stay in the order of the tets, so the sums are the same on every run.
        shares.sort_by_key(|s| s.0);
        for same in shares.chunk_by(|a, b| a.0 == b.0) {
            let section: f64 = same.iter().map(|s| s.1).sum();
            let [a, b] = same[0].0;
            net.springs.push(Spring::of_section(a, b, section as f32));
        }
        for (node, volume) in net.nodes.iter_mut().zip(volumes) {
            node.volume = volume as f32;
        }
        net.faces = match &self.tets {
            Tets::Linear(_) => self.faces.clone(),
            Tets::Quadratic(tets) => {
                let corners = tets.iter().map(|t| [t[0], t[1], t[2], t[3]]).collect();
                super::faces::of_boundary(&Tets::Linear(corners))
            }
        };
        for node in net.faces.iter_mut().flatten() {
            *node = node_of[*node as usize];
        }
        net
    }
}
