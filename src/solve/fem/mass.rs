//! Lumped masses.

use super::elements::{Basis, Elements};

/// The volume each node stands for \[m³\]: a quarter of a linear tet per corner; of a quadratic one 1/36 per corner and 4/27
/// per middle node (Hinton, Rock & Zienkiewicz 1976). Times a density they are the lumped masses.
pub fn lumped_volumes<B: Basis<N, G>, const N: usize, const G: usize>(
    elements: &Elements<B, N, G>,
) -> Vec<f64> {
    let mut volumes = vec![0.0; elements.node_count];
    for (element, volume) in elements.list.iter().zip(elements.volumes()) {
        for (node, share) in element.nodes.iter().zip(B::MASS) {
            volumes[*node as usize] += share * volume;
        }
    }
    volumes
}
