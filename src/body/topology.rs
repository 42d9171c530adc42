//! What of a body's surface can be touched besides its nodes: faces, their edges, and whether they close.

use super::Blueprint;
use crate::math::wide;
use std::collections::BTreeMap;

/// Faces and edges of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// Triangles over the nodes.
    pub faces: Vec<[u32; 3]>,
    /// Each edge of a face once; of a body without faces, its springs.
    pub edges: Vec<[u32; 2]>,
    /// Whether the faces enclose a volume: every edge belongs to two faces that agree on which side is outside. A surface
    /// that is open has no outside, and both sides count.
    pub closed: bool,
    /// Mean length of the edges at rest \[m\].
    pub spacing: f64,
}

impl Topology {
    /// The topology of a blueprint.
    pub fn of(blueprint: &Blueprint) -> Self {
        let mut uses = BTreeMap::<[u32; 2], (u32, u32)>::new();
        for &[a, b, c] in &blueprint.faces {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let count = uses.entry([p.min(q), p.max(q)]).or_default();
                *(if p < q { &mut count.0 } else { &mut count.1 }) += 1;
            }
        }
        let closed = !uses.is_empty() && uses.values().all(|count| *count == (1, 1));
        let edges: Vec<[u32; 2]> = if blueprint.faces.is_empty() {
            blueprint.springs.iter().map(|s| s.nodes).collect()
        } else {
            uses.into_keys().collect()
        };
        let at = |node: u32| wide(blueprint.nodes[node as usize].position);
        let total: f64 = edges.iter().map(|&[a, b]| at(a).distance(at(b))).sum();
        Self {
            faces: blueprint.faces.clone(),
            spacing: total / edges.len().max(1) as f64,
            edges,
            closed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Material;
    use crate::math::Vector;
    use crate::shape;

    fn topology(net: crate::body::Net) -> Topology {
        let material = Some(Material::rubber());
        Topology::of(&Blueprint::resolve(net, |_| material, None).unwrap())
    }

    #[test]
    fn a_block_is_closed_and_a_sheet_is_open() {
        let block = topology(shape::lattice(Vector::ONE, 0.5).unwrap());
        assert!(block.closed);
        // Euler: V − E + F = 2.
        assert_eq!(26 + block.faces.len(), 2 + block.edges.len());
        let rope = topology(shape::rope(Vector::ZERO, Vector::X, 4, 1e-4).unwrap());
        assert!(!rope.closed && rope.faces.is_empty());
        assert_eq!(rope.edges.len(), 4);
        assert!((rope.spacing - 0.25).abs() < 1e-6);
    }
}
