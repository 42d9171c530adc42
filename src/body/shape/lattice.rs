//! A solid box of equal cells.
//!
//! A cubic lattice with springs on the edges and on both diagonals of every face is the simplest one that is isotropic:
//! with k = 2Ea/5 on both kinds it has Young's modulus E in every direction and Poisson's ratio ¼, the only ratio central
//! forces allow. The cells are stretched to fit the box exactly rather than the box rounded to the cells, because a
//! crash is read in millimetres of the box.

use super::cells::{CellGrid, Kind};
use crate::body::error::positive;
use crate::body::{BuildError, Net};
use crate::math::{DVec3, Real, Vector, wide};

/// The largest squared aspect of a face whose diagonals stay at the isotropic stiffness in a cell too flat for exact
/// constants; beyond it they are softened, so that what is left for the edges is at the least 1/20 of the whole.
const MAX_ASPECT: f64 = 1.425;

/// A box of `size` \[m\] centred on the origin, cut into cells of about `cell` \[m\]: max(1, round(size/cell)) along each
/// axis, stretched to fit. Nodes are numbered with x fastest, then y, then z.
///
/// E and ν = ¼ are exact while the sides of a cell satisfy a²(1/b² + 1/c²) < 3 each way round, which covers sides that
/// differ by 22 % and so every box at least six cells thick. Flatter cells (a plate of one thin layer) keep the exact
/// axial stiffness C₁₁ = 6E/5 but are softer in shear and couple less across, down to ν = 0; their E is then up to 20 %
/// high.
///
/// # Errors
/// [`BuildError::Value`] if a size or the cell is not positive and finite, or if there would be more than fifty million
/// nodes.
pub fn lattice(size: Vector, cell: Real) -> Result<Net, BuildError> {
    for (what, value) in [
        ("the x size of the lattice", size.x),
        ("the y size of the lattice", size.y),
        ("the z size of the lattice", size.z),
        ("the cell size of the lattice", cell),
    ] {
        positive(what, value.into())?;
    }
    let size = wide(size);
    let counts = (size / f64::from(cell)).round().max(DVec3::ONE);
    let grid = CellGrid::new(counts.to_array(), true)?;
    let sides = size / counts;
    let origin = -0.5 * size;
    let sections = CellSections::of_box(sides);
    let share = sides.x * sides.y * sides.z / 8.0;
    let position = |at: [usize; 3]| origin + DVec3::from_array(at.map(|v| v as f64)) * sides;
    let (net, _) = grid.net(
        position,
        |_, _| share,
        |_, kind, length| sections.section(kind, length),
    );
    Ok(net)
}

/// k/E of the springs of one cell \[m\]: what it adds to a spring's stiffness, per unit of Young's modulus.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellSections {
    edge: [f64; 3],
    diagonal: [f64; 3],
}

impl CellSections {
    /// Of a box with `sides` \[m\].
    ///
    /// With λ = μ = 2E/5, the diagonals of the face of sides a and b must give C₁₁₂₂ = μ and the edges what is missing to
    /// C₁₁₁₁ = 3μ. For a cube that is a quarter of 2Ea/5 per edge and half of it per diagonal.
    pub fn of_box(sides: DVec3) -> Self {
        let exact = Self::with_aspect(sides, f64::INFINITY);
        if exact.edge.iter().all(|&e| e > 0.0) {
            exact
        } else {
            Self::with_aspect(sides, MAX_ASPECT)
        }
    }

    fn with_aspect(sides: DVec3, max_aspect: f64) -> Self {
        const MU: f64 = 0.4;
        let s = sides.to_array();
        let volume = s[0] * s[1] * s[2];
        let mut left = [3.0 * MU; 3];
        let mut diagonal = [0.0; 3];
        for (axis, diagonal) in diagonal.iter_mut().enumerate() {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let (u2, v2) = (s[u] * s[u], s[v] * s[v]);
            let mu = MU * (max_aspect * u2.min(v2) / u2.max(v2)).min(1.0);
            *diagonal = mu * volume * (u2 + v2) / (4.0 * u2 * v2);
            left[u] -= mu * u2 / v2;
            left[v] -= mu * v2 / u2;
        }
        Self {
            edge: std::array::from_fn(|d| left[d] * volume / (4.0 * s[d] * s[d])),
            diagonal,
        }
    }

    /// k/E \[m\] of a kind of spring.
    pub fn per_young(&self, kind: Kind) -> f64 {
        match kind {
            Kind::Edge(d) => self.edge[d],
            Kind::Diagonal(d) => self.diagonal[d],
        }
    }

    /// Σ k·L²/E over the springs of one cell with these corners \[m³\]: 6 times the volume for a cube, because the sum
    /// over the axes of an isotropic solid's C with λ = μ = 2E/5 is 15μ.
    pub fn modulus_sum(&self, corners: &[DVec3; 8]) -> f64 {
        let mut sum = 0.0;
        for a in 0..8_usize {
            for axis in 0..3 {
                // Edges from their near end; diagonals once, from the corner that is low along the face's first axis.
                let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
                if a & (1 << axis) == 0 {
                    let l2 = corners[a].distance_squared(corners[a | 1 << axis]);
                    sum += self.edge[axis] * l2;
                }
                if a & u == 0 {
                    let l2 = corners[a].distance_squared(corners[(a | u) ^ v]);
                    sum += self.diagonal[axis] * l2;
                }
            }
        }
        sum
    }

    /// Section of a kind of spring of a length \[m²\].
    pub fn section(&self, kind: Kind, length: f64) -> f64 {
        self.per_young(kind) * length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const YOUNG: f64 = 1.0e6;

    /// Forces on the nodes under the homogeneous strain `e`, linearised, in f64.
    fn forces(net: &Net, e: DVec3) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; net.nodes.len()];
        for s in &net.springs {
            let [a, b] = s.nodes.map(|n| n as usize);
            let d = wide(net.nodes[b].position) - wide(net.nodes[a].position);
            let k = YOUNG * f64::from(s.section) / d.length();
            let n = d.normalize();
            let f = n * (k * n.dot(d * e));
            out[a] += f;
            out[b] -= f;
        }
        out
    }

    fn check_uniaxial(size: Vector, cell: Real, tolerance: f64) {
        let net = lattice(size, cell).unwrap();
        net.check().unwrap();
        let strain = 1.0e-5;
        for axis in 0..3 {
            let mut e = DVec3::splat(-0.25 * strain);
            e[axis] = strain;
            let f = forces(&net, e);
            let half = 0.5 * wide(size);
            let area = 8.0 * half.x * half.y * half.z / (2.0 * half[axis]);
            let axial = YOUNG * strain * area;
            let mut end = DVec3::ZERO;
            for (node, f) in net.nodes.iter().zip(&f) {
                let x = f64::from(node.position[axis]);
                let mut free = *f;
                if (x.abs() - half[axis]).abs() < 1e-6 {
                    free[axis] = 0.0;
                    if x > 0.0 {
                        end += *f;
                    }
                }
                assert!(
                    free.length() < tolerance * axial,
                    "axis {axis}: {free} at {}",
                    node.position
                );
            }
            assert!(
                (-end[axis] / axial - 1.0).abs() < tolerance,
                "axis {axis}: {end} for {axial}"
            );
        }
    }

    /// V11: a bar of 1, 2 and 4 cells across has exactly E and ν = ¼, surfaces included.
    #[test]
    fn uniaxial_tension_is_exact_on_any_section() {
        for n in [1.0, 2.0, 4.0] {
            check_uniaxial(Vector::new(0.8, 0.1 * n, 0.1 * n), 0.1, 1e-4);
        }
        check_uniaxial(Vector::new(0.1, 0.1, 0.1), 0.1, 1e-4);
    }

    #[test]
    fn cells_that_are_nearly_cubes_are_exact_too() {
        check_uniaxial(Vector::new(0.33, 0.36, 0.39), 0.1, 1e-4);
    }

    #[test]
    fn flat_cells_keep_positive_springs() {
        for size in [[1.0, 0.01, 1.0], [2.0, 0.01, 0.01], [0.149, 0.075, 0.3]] {
            let net = lattice(Vector::from_array(size), 0.1).unwrap();
            assert!(net.springs.iter().all(|s| s.section > 0.0));
            net.check().unwrap();
        }
    }

    #[test]
    fn counts_volume_and_order() {
        let size = Vector::new(0.4, 0.3, 0.2);
        let net = lattice(size, 0.1).unwrap();
        assert_eq!(net.nodes.len(), 5 * 4 * 3);
        // Edges 4·4·3 + 5·3·3 + 5·4·2, diagonals twice the faces 5·3·2 + 4·4·2 + 4·3·3.
        assert_eq!(net.springs.len(), 133 + 2 * 98);
        assert_eq!(net.faces.len(), 2 * 2 * (12 + 8 + 6));
        let volume: f64 = net.nodes.iter().map(|n| f64::from(n.volume)).sum();
        assert!((volume / 0.024 - 1.0).abs() < 1e-6);
        assert_eq!(net.bounds(), (-0.5 * size, 0.5 * size));
        assert!(net.springs.is_sorted_by_key(|s| s.nodes));
        assert!(net.springs.iter().all(|s| s.nodes[0] < s.nodes[1]));
        let mut hull = 0.0;
        for f in &net.faces {
            let [a, b, c] = f.map(|n| wide(net.nodes[n as usize].position));
            hull += a.dot(b.cross(c)) / 6.0;
        }
        assert!((hull / 0.024 - 1.0).abs() < 1e-6, "outward: {hull}");
    }

    #[test]
    fn bad_sizes_are_errors() {
        let bad = |size: [Real; 3], cell| lattice(Vector::from_array(size), cell).unwrap_err();
        for error in [
            bad([Real::NAN, 1.0, 1.0], 0.1),
            bad([1.0, -1.0, 1.0], 0.1),
            bad([1.0, 1.0, Real::INFINITY], 0.1),
            bad([1.0, 1.0, 1.0], 0.0),
            bad([1.0, 1.0, 1.0], 1e-4),
            bad([1.0, 1.0, 1.0], 1e-30),
        ] {
            assert!(matches!(error, BuildError::Value { .. }), "{error}");
        }
    }
}
