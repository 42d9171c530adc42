//! Quadratic meshes from linear ones, and middle nodes in their order.

use super::{TetMesh, Tets, faces};
use crate::law::basis;
#[cfg(any(feature = "import", test))]
use crate::math::DVec3;

impl TetMesh {
    /// The same mesh with a node in the middle of every edge, shared by the tets around it; a quadratic mesh is returned as
    /// it is. New nodes follow the old ones, in the order of their edges' nodes.
    pub fn quadratic(self) -> Self {
        let Tets::Linear(linear) = &self.tets else {
            return self;
        };
        let ends = |tet: &[u32; 4], e: usize| {
            let [a, b] = basis::EDGES[e].map(|c| tet[c]);
            (a.min(b), a.max(b))
        };
        let mut edges: Vec<(u32, u32)> = linear
            .iter()
            .flat_map(|tet| (0..6).map(move |e| ends(tet, e)))
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let corners = self.nodes.len();
        let mut nodes = self.nodes;
        nodes.reserve(edges.len());
        for &(a, b) in &edges {
            nodes.push(0.5 * (nodes[a as usize] + nodes[b as usize]));
        }
        let middle = |tet: &[u32; 4], e: usize| {
            let place = edges.binary_search(&ends(tet, e));
            (corners + place.unwrap_or_else(|i| i)) as u32
        };
        let tets = Tets::Quadratic(
            linear
                .iter()
                .map(|tet| std::array::from_fn(|i| if i < 4 { tet[i] } else { middle(tet, i - 4) }))
                .collect(),
        );
        Self {
            faces: faces::of_boundary(&tets),
            nodes,
            tets,
        }
    }
}

/// The six middle nodes of a tet, given in any order, put in the order of [`basis::EDGES`]: each goes to the edge whose
/// middle it is nearest to. `None` when two claim the same edge.
#[cfg(any(feature = "import", test))]
pub(crate) fn sort_by_edge(nodes: &[DVec3], tet: [u32; 10]) -> Option<[u32; 10]> {
    let at = |i: usize| nodes.get(tet[i] as usize).copied();
    let mut sorted = tet;
    let mut taken = [false; 6];
    for (i, node) in tet.iter().enumerate().skip(4) {
        let place = at(i)?;
        let mut best = (f64::INFINITY, 6);
        for (e, [a, b]) in basis::EDGES.into_iter().enumerate() {
            let distance = place.distance_squared(0.5 * (at(a)? + at(b)?));
            if distance < best.0 {
                best = (distance, e);
            }
        }
        let taken = taken.get_mut(best.1)?;
        if std::mem::replace(taken, true) {
            return None;
        }
        sorted[4 + best.1] = *node;
    }
    Some(sorted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_edges_get_one_node_and_any_order_is_sorted() {
        let nodes = vec![
            DVec3::ZERO,
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            DVec3::new(1.0, 1.0, 1.0),
        ];
        let tets = Tets::Linear(vec![[0, 1, 2, 3], [1, 2, 3, 4]]);
        let mesh = TetMesh::new(nodes, tets).unwrap().quadratic();
        assert_eq!(mesh.nodes.len(), 5 + 9);
        assert_eq!(mesh.faces.len(), 6 * 4);
        mesh.check().unwrap();
        let Tets::Quadratic(tets) = &mesh.tets else {
            panic!("quadratic");
        };
        for tet in tets {
            let mut shuffled = *tet;
            shuffled[4..].rotate_left(2);
            shuffled.swap(5, 8);
            assert_eq!(sort_by_edge(&mesh.nodes, shuffled), Some(*tet));
            shuffled[4] = shuffled[5];
            assert_eq!(sort_by_edge(&mesh.nodes, shuffled), None);
        }
    }
}
