//! The boundary of a tetrahedral mesh.

use super::Tets;
use crate::law::basis;

/// Triangles of the faces that belong to one tet, in the order of the tets.
pub(super) fn of_boundary(tets: &Tets) -> Vec<[u32; 3]> {
    let face = |tet: &[u32], f: usize| {
        let mut corners = basis::FACES[f].map(|c| tet[c]);
        corners.sort_unstable();
        corners
    };
    let mut all: Vec<([u32; 3], u32, u8)> = tets
        .iter()
        .enumerate()
        .flat_map(|(i, tet)| (0..4).map(move |f| (face(tet, f), i as u32, f as u8)))
        .collect();
    all.sort_unstable();
    let mut outer: Vec<(u32, u8)> = all
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|same| same.len() == 1)
        .map(|same| (same[0].1, same[0].2))
        .collect();
    outer.sort_unstable();
    let nodes: Vec<&[u32]> = tets.iter().collect();
    let mut triangles = Vec::new();
    for (tet, f) in outer {
        split(nodes[tet as usize], usize::from(f), &mut triangles);
    }
    triangles
}

/// One triangle of a linear face, four of a quadratic one.
fn split(tet: &[u32], face: usize, triangles: &mut Vec<[u32; 3]>) {
    let [a, b, c] = basis::FACES[face];
    if tet.len() == 4 {
        triangles.push([a, b, c].map(|i| tet[i]));
        return;
    }
    let middle = |p, q| 4 + basis::edge(p, q);
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    for triangle in [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]] {
        triangles.push(triangle.map(|i| tet[i]));
    }
}
