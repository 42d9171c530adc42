//! Which cells of a grid are inside a closed surface, and which of them make one sound body.
//!
//! A cell counts by its centre, so that the filled volume is right on average without a bias. Insideness is the parity
//! of the triangles a ray crosses; a ray through an edge or a vertex, which is the rule rather than the exception for
//! surfaces drawn on a grid, is decided by moving it by an infinitesimal (δ, δ²), so that each crossing is counted in
//! exactly one of the triangles that meet there.

use super::cells::CellGrid;
use crate::body::Surface;
use crate::math::DVec3;
use std::collections::VecDeque;

/// Marks the cells whose centre is inside. `origin` is the grid's low corner and `cell` the side of a cell \[m\].
pub(super) fn fill(grid: &mut CellGrid, surface: &Surface, origin: DVec3, cell: f64) {
    let [nx, ny, nz] = grid.counts;
    // Per column of cells along x: where the ray through their centres crosses the surface.
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); ny * nz];
    for t in 0..surface.triangles.len() {
        let corners = surface.corners(t);
        let ids = surface.triangles[t];
        let range = |v: [f64; 3], low: f64, n: usize| {
            let lo = v[0].min(v[1]).min(v[2]);
            let hi = v[0].max(v[1]).max(v[2]);
            // Centres are at low + (i + ½)·cell; one more on either side costs nothing and forgives rounding.
            let first = ((lo - low) / cell - 0.5).floor().max(0.0) as usize;
            let last = ((hi - low) / cell - 0.5).ceil().max(0.0) as usize;
            first..(last + 1).min(n)
        };
        for k in range(corners.map(|c| c.z), origin.z, nz) {
            for j in range(corners.map(|c| c.y), origin.y, ny) {
                let y = origin.y + (j as f64 + 0.5) * cell;
                let z = origin.z + (k as f64 + 0.5) * cell;
                if let Some(x) = crossing(corners, ids, y, z) {
                    crossings[j + ny * k].push(x);
                }
            }
        }
    }
    for (column, xs) in crossings.iter_mut().enumerate() {
        xs.sort_by(f64::total_cmp);
        let mut next = 0;
        for i in 0..nx {
            let x = origin.x + (i as f64 + 0.5) * cell;
            while next < xs.len() && xs[next] <= x {
                next += 1;
            }
            grid.occupied[i + nx * column] = next % 2 == 1;
        }
    }
}

/// Where the line along x through (y, z) crosses a triangle.
fn crossing(corners: [DVec3; 3], ids: [u32; 3], y: f64, z: f64) -> Option<f64> {
    let side = |a: usize, b: usize| {
        // Both triangles at an edge must compute the same number, hence in the order of the vertices.
        let (lo, hi, sign) = if ids[a] < ids[b] {
            (a, b, 1.0)
        } else {
            (b, a, -1.0)
        };
        let (p, q) = (corners[lo], corners[hi]);
        let (ey, ez) = (q.y - p.y, q.z - p.z);
        let e = ey * (z - p.z) - ez * (y - p.y);
        let moved = [e, -ez, ey].into_iter().find(|v| *v != 0.0).unwrap_or(0.0);
        (sign * e, sign * moved.signum())
    };
    let [(w2, s2), (w0, s0), (w1, s1)] = [side(0, 1), side(1, 2), side(2, 0)];
    if s0 != s1 || s1 != s2 {
        return None;
    }
    let sum = w0 + w1 + w2;
    (sum != 0.0).then(|| (w0 * corners[0].x + w1 * corners[1].x + w2 * corners[2].x) / sum)
}

/// Keeps only the largest set of cells connected through faces: a body in two pieces would be two bodies.
pub(super) fn keep_largest(grid: &mut CellGrid) {
    let mut piece = vec![u32::MAX; grid.occupied.len()];
    let mut sizes: Vec<usize> = Vec::new();
    let mut queue = VecDeque::new();
    for start in 0..grid.occupied.len() {
        if !grid.occupied[start] || piece[start] != u32::MAX {
            continue;
        }
        let id = sizes.len() as u32;
        sizes.push(0);
        piece[start] = id;
        queue.push_back(start);
        while let Some(cell) = queue.pop_front() {
            sizes[id as usize] += 1;
            let at = grid.cell_at(cell).map(|v| v as i64);
            for axis in 0..3 {
                for step in [-1, 1] {
                    let mut next = at;
                    next[axis] += step;
                    if let Some(next) = grid.solid(next).filter(|&n| piece[n] == u32::MAX) {
                        piece[next] = id;
                        queue.push_back(next);
                    }
                }
            }
        }
    }
    let mut largest = 0;
    for (id, &size) in sizes.iter().enumerate() {
        if size > sizes[largest] {
            largest = id;
        }
    }
    for (solid, piece) in grid.occupied.iter_mut().zip(&piece) {
        *solid = *piece == largest as u32;
    }
}

/// Fills a cell wherever two cells touch along an edge only, until none do: such an edge would belong to four boundary
/// triangles, and the surface of the net would not be one.
pub(super) fn close_hinges(grid: &mut CellGrid) {
    let mut changed = true;
    while changed {
        changed = false;
        for cell in 0..grid.occupied.len() {
            let at = grid.cell_at(cell);
            for axis in 0..3 {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                if at[u] + 1 >= grid.counts[u] || at[v] + 1 >= grid.counts[v] {
                    continue;
                }
                let [mut right, mut up, mut both] = [at; 3];
                right[u] += 1;
                up[v] += 1;
                both[u] += 1;
                both[v] += 1;
                let [right, up, both] = [right, up, both].map(|c| grid.cell(c));
                let o = &mut grid.occupied;
                if o[cell] && o[both] && !o[right] && !o[up] {
                    o[right] = true;
                    changed = true;
                } else if o[right] && o[up] && !o[cell] && !o[both] {
                    o[cell] = true;
                    changed = true;
                }
            }
        }
    }
}
