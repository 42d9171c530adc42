//! Whether the supports hold every part of a body.
//!
//! A part (nodes joined by elements) is held when no rigid motion of it leaves all its fixed coordinates at rest. That is
//! a question of six numbers per part, answered exactly before the first factorisation, where a pivot near zero would
//! only say that something is wrong.

use super::error::{Motion, StaticError};
use super::structure::Structure;
use crate::math::DVec3;
use faer::{Mat, Side};

/// Below this part of the largest, an eigenvalue is zero.
const ZERO: f64 = 1e-9;

type Six = [[f64; 6]; 6];

/// Checks every part of a structure.
pub(super) fn check(
    structure: &impl Structure,
    positions: &[DVec3],
    fixed: &[[bool; 3]],
) -> Result<(), StaticError> {
    let parts = parts(structure, positions);
    let mut members: Vec<(u32, u32)> = parts.iter().copied().zip(0..).collect();
    members.sort_unstable();
    for part in members.chunk_by(|a, b| a.0 == b.0) {
        let nodes = || part.iter().map(|m| m.1 as usize);
        if nodes().all(|n| fixed[n] == [true; 3]) {
            continue;
        }
        let free = free_motions(nodes, positions, fixed);
        if !free.is_empty() {
            return Err(StaticError::Supports {
                node: part[0].1,
                nodes: part.len(),
                free,
            });
        }
    }
    Ok(())
}

/// The first node of the part each node belongs to.
fn parts(structure: &impl Structure, positions: &[DVec3]) -> Vec<u32> {
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut parent: Vec<u32> = (0..positions.len() as u32).collect();
    structure.stiffness(positions, &mut |a, b, _| {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b) as usize] = a.min(b);
    });
    (0..parent.len() as u32)
        .map(|i| root(&mut parent, i))
        .collect()
}

/// The rigid motions that leave the fixed coordinates of some nodes at rest.
fn free_motions<I: Iterator<Item = usize>>(
    nodes: impl Fn() -> I,
    positions: &[DVec3],
    fixed: &[[bool; 3]],
) -> Vec<Motion> {
    let count = nodes().count() as f64;
    let centre = nodes().map(|n| positions[n]).sum::<DVec3>() / count;
    let size = nodes()
        .map(|n| positions[n].distance(centre))
        .fold(0.0, f64::max)
        .max(f64::MIN_POSITIVE);
    let (mut held, mut moves) = ([[0.0; 6]; 6], [[0.0; 6]; 6]);
    for n in nodes() {
        let r = (positions[n] - centre) / size;
        for (axis, held_here) in fixed[n].into_iter().enumerate() {
            // How coordinate `axis` of the node moves per unit of each rigid motion: e_axis and r × e_axis.
            let e = DVec3::AXES[axis];
            let turn = r.cross(e);
            let row = [e.x, e.y, e.z, turn.x, turn.y, turn.z];
            add(&mut moves, &row);
            if held_here {
                add(&mut held, &row);
            }
        }
    }
    // A motion that moves no node (a straight bar turning about itself) is none.
    let scale = (0..6).map(|i| moves[i][i]).sum::<f64>();
    for (value, v) in eigen(&moves) {
        if value <= ZERO * scale {
            add(&mut held, &v.map(|x| x * scale.sqrt()));
        }
    }
    eigen(&held)
        .into_iter()
        .filter(|(value, _)| *value <= ZERO * scale)
        .map(|(_, v)| Motion {
            translation: DVec3::new(v[0], v[1], v[2]),
            rotation: clean(DVec3::new(v[3], v[4], v[5])) / size,
            centre,
        })
        .collect()
}

/// Without what is rounding noise of a unit vector.
fn clean(v: DVec3) -> DVec3 {
    if v.length() < 1e-6 { DVec3::ZERO } else { v }
}

fn add(m: &mut Six, row: &[f64; 6]) {
    for i in 0..6 {
        for j in 0..6 {
            m[i][j] += row[i] * row[j];
        }
    }
}

/// Eigenvalues and vectors; none if the numbers are not finite.
fn eigen(m: &Six) -> Vec<(f64, [f64; 6])> {
    let matrix = Mat::from_fn(6, 6, |i, j| m[i][j]);
    let Ok(found) = matrix.self_adjoint_eigen(Side::Lower) else {
        return Vec::new();
    };
    (0..6)
        .map(|e| (found.S()[e], std::array::from_fn(|i| found.U()[(i, e)])))
        .collect()
}
