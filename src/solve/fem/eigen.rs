//! Eigenvalues of small symmetric matrices.

use crate::law::elastic::tensor::{Mat, mul, mul_transpose, unit};

/// How often a matrix is squared for its largest eigenvalue.
const SQUARINGS: u32 = 5;

/// The eigenvectors of a positive matrix, row by row, as long as the roots of their eigenvalues: Jacobi's rotations.
pub(super) fn axes(matrix: &Mat<f64>) -> Mat<f64> {
    let (mut m, mut v) = (*matrix, unit());
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q] == 0.0 {
                continue;
            }
            let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let mut turn = unit();
            (turn[p][p], turn[q][q]) = (c, c);
            (turn[p][q], turn[q][p]) = (-t * c, t * c);
            m = mul_transpose(&mul(&turn, &m), &turn);
            v = mul(&turn, &v);
        }
    }
    std::array::from_fn(|i| v[i].map(|x| x * m[i][i].max(0.0).sqrt()))
}

/// An upper bound of the largest size of an eigenvalue of a symmetric matrix A, which is overwritten: (tr A^2p)^(1/2p) with
/// p = 32, by squarings. Never too low and at most 5 % too high; a power iteration would be a little too low, which is
/// the wrong side.
pub(super) fn largest_eigenvalue(matrix: &mut [f64], size: usize) -> f64 {
    let mut square = vec![0.0; size * size];
    let mut bound = 1.0;
    let mut power = 1.0;
    for step in 0..=SQUARINGS {
        let norm = matrix.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm == 0.0 {
            return 0.0;
        }
        if !norm.is_finite() {
            return f64::INFINITY;
        }
        // ‖A‖ ≥ |λ|, and λ of A is ‖A‖ times the root of λ of (A/‖A‖)².
        bound *= norm.powf(power);
        if step == SQUARINGS {
            break;
        }
        power *= 0.5;
        let scale = 1.0 / norm;
        matrix.iter_mut().for_each(|x| *x *= scale);
        for (i, out) in square.chunks_exact_mut(size).enumerate() {
            out.fill(0.0);
            for (k, row) in matrix.chunks_exact(size).enumerate() {
                let factor = matrix[i * size + k];
                for (o, r) in out.iter_mut().zip(row) {
                    *o += factor * r;
                }
            }
        }
        matrix.copy_from_slice(&square);
    }
    bound
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_make_up_their_matrix() {
        let m = [[4.0, 1.0, -2.0], [1.0, 3.0, 0.5], [-2.0, 0.5, 5.0]];
        let a = axes(&m);
        for i in 0..3 {
            for j in 0..3 {
                let sum: f64 = (0..3).map(|k| a[k][i] * a[k][j]).sum();
                assert!((sum - m[i][j]).abs() < 1e-12);
                let across: f64 = (0..3).map(|k| a[i][k] * a[j][k]).sum();
                assert!(i == j || across.abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_bound_is_above_and_close() {
        // Eigenvalues 1, 2, 3 and −2.9 in a turned frame.
        let q = [
            [0.5, 0.5, 0.5, 0.5],
            [0.5, -0.5, 0.5, -0.5],
            [0.5, 0.5, -0.5, -0.5],
            [0.5, -0.5, -0.5, 0.5],
        ];
        let values = [1.0, 2.0, 3.0, -2.9];
        let mut m: Vec<f64> = (0..16)
            .map(|n| (0..4).map(|e| q[n / 4][e] * values[e] * q[n % 4][e]).sum())
            .collect();
        let found = largest_eigenvalue(&mut m, 4);
        assert!((3.0..3.0 * 1.01).contains(&found), "{found}");
        let mut one = vec![1e-200, 0.0, 0.0, 0.0];
        assert!(largest_eigenvalue(&mut one, 2) < 1e-100);
        assert!(largest_eigenvalue(&mut [f64::NAN; 4], 2) > 1e300);
    }
}
