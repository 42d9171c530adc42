//! What the springs of a tetrahedral mesh amount to as a solid.

use super::{TetMesh, volume};
use crate::law::basis;

/// Elastic constants of the springs [`TetMesh::springs`] makes, for a Young's modulus of 1. A solid would have
/// `young` = \[1, 1, 1\] and `zener` = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringModuli {
    /// Young's modulus along x, y and z, the mesh being free to shear as it stretches.
    pub young: [f64; 3],
    /// Mean Poisson's ratio of a pull along x, y and z.
    pub poisson: [f64; 3],
    /// The same two with all shear held back, for a pull along x: they differ where stretch and shear are coupled.
    pub held: [f64; 2],
    /// Zener's ratio 2C₄₄/(C₁₁ − C₁₂) of the mean constants of the three axes: 1 when isotropic.
    pub zener: f64,
}

impl SpringModuli {
    /// The largest of how far E of an axis is from 1 and Zener's ratio from 1: below .05 a mesh may pass for isotropic.
    pub fn anisotropy(&self) -> f64 {
        let off = self.young.map(|e| (e - 1.0).abs());
        off.into_iter().fold((self.zener - 1.0).abs(), f64::max)
    }
}

/// The places of xx, yy, zz, yz, xz, xy.
const VOIGT: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [1, 2], [0, 2], [0, 1]];

impl TetMesh {
    /// The constants of the mesh's springs in uniform strain, C = Σ V·Σ n⊗n⊗n⊗n / ΣV over tets and their edges. Exact inside a
    /// regular grid, where nodes follow a uniform strain; in an irregular mesh they give way a little, and the springs
    /// are softer than this. `None` when the springs can't resist every strain.
    pub fn spring_moduli(&self) -> Option<SpringModuli> {
        let mut c = [[0.0; 6]; 6];
        let mut total = 0.0;
        for tet in self.tets.iter() {
            let p = self.corners(tet);
            let v = volume(p);
            total += v;
            for [a, b] in basis::EDGES {
                let n = (p[b] - p[a]).normalize().to_array();
                let pair = VOIGT.map(|[i, j]| n[i] * n[j]);
                for (row, &r) in c.iter_mut().zip(&pair) {
                    for (entry, &s) in row.iter_mut().zip(&pair) {
                        *entry += v * r * s;
                    }
                }
            }
        }
        let c = c.map(|row| row.map(|x| x / total));
        let free = inverse(c)?;
        let straight: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| c[i][j]));
        let held = inverse(straight)?;
        let across = |s: &dyn Fn(usize, usize) -> f64, i: usize| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            -0.5 * (s(i, j) + s(i, k)) / s(i, i)
        };
        let mean = |entries: [f64; 3]| entries.iter().sum::<f64>() / 3.0;
        let c11 = mean([c[0][0], c[1][1], c[2][2]]);
        let c12 = mean([c[0][1], c[1][2], c[0][2]]);
        let c44 = mean([c[3][3], c[4][4], c[5][5]]);
        Some(SpringModuli {
            young: std::array::from_fn(|i| 1.0 / free[i][i]),
            poisson: std::array::from_fn(|i| across(&|a, b| free[a][b], i)),
            held: [1.0 / held[0][0], across(&|a, b| held[a][b], 0)],
            zener: 2.0 * c44 / (c11 - c12),
        })
    }
}

/// The inverse by Gauss–Jordan elimination; `None` for a matrix that is singular or nearly so.
fn inverse<const N: usize>(mut m: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
    let mut out: [[f64; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    for k in 0..N {
        let pivot = (k..N).max_by(|&a, &b| m[a][k].abs().total_cmp(&m[b][k].abs()))?;
        m.swap(k, pivot);
        out.swap(k, pivot);
        let p = m[k][k];
        if p.is_nan() || p.abs() <= 1e-9 {
            return None;
        }
        for j in 0..N {
            m[k][j] /= p;
            out[k][j] /= p;
        }
        for i in (0..N).filter(|i| *i != k) {
            let f = m[i][k];
            for j in 0..N {
                m[i][j] -= f * m[k][j];
                out[i][j] -= f * out[k][j];
            }
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {

    use crate::math::Vector;
    use crate::shape::{TetSplit, tet_box};

    /// V13.
    #[test]
    fn v13_van_gelders_springs_on_grids() {
        let grid = |split| tet_box(Vector::splat(0.4), 0.1, split).unwrap();
        let close = |found: f64, expected: f64| {
            assert!(
                (found - expected).abs() < 1e-3,
                "{found}, expected {expected}"
            );
        };
        let five = grid(TetSplit::Five).spring_moduli().unwrap();
        for axis in 0..3 {
            close(five.young[axis], 1.2);
            close(five.poisson[axis], 0.2);
        }
        close(five.zener, 0.667);
        assert!(five.anisotropy() > 0.3);
        let six = grid(TetSplit::Six).spring_moduli().unwrap();
        for axis in 0..3 {
            close(six.young[axis], 1.0345);
            close(six.poisson[axis], 0.0345);
        }
        close(six.held[0], 1.35484);
        close(six.held[1], 0.1613);
        close(six.zener, 0.476);
    }
}
