//! What the importers of tetrahedra share: leaving out unused nodes and checking the shape.

use super::ImportError;
use crate::body::{TetMesh, Tets};
use crate::math::DVec3;
use std::path::Path;

/// The mesh of the nodes that tets use, in their order.
pub(super) fn finish(
    nodes: Vec<DVec3>,
    mut tets: Tets,
    name: &Path,
) -> Result<TetMesh, ImportError> {
    if tets.is_empty() {
        return Err(ImportError::Empty { path: name.into() });
    }
    let mut used = vec![u32::MAX; nodes.len()];
    each_node(&mut tets, |n| {
        if let Some(mark) = used.get_mut(*n as usize) {
            *mark = 0;
        }
    });
    let mut kept = Vec::new();
    for (mark, place) in used.iter_mut().zip(nodes) {
        if *mark == 0 {
            *mark = kept.len() as u32;
            kept.push(place);
        }
    }
    each_node(&mut tets, |n| {
        *n = used.get(*n as usize).copied().unwrap_or(u32::MAX)
    });
    TetMesh::new(kept, tets).map_err(|source| ImportError::Shape {
        path: name.into(),
        source,
    })
}

fn each_node(tets: &mut Tets, mut change: impl FnMut(&mut u32)) {
    match tets {
        Tets::Linear(tets) => tets.iter_mut().flatten().for_each(&mut change),
        Tets::Quadratic(tets) => tets.iter_mut().flatten().for_each(&mut change),
    }
}
