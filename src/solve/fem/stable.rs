//! A proven bound on the fastest modes of a body of elements, as it is now.
//!
//! For every way of dividing the masses among elements, λ(M⁻¹K) ≤ max over elements of λ(Mₑ⁻¹Kₑ): the energy of any motion is
//! the sum of the elements', each at most its λ times its own kinetic form (Irons & Treharne 1971). A share may differ by
//! direction: any positive 3×3 matrices that sum to m·I at a node will do. Here they follow the elements' own
//! stiffness at the node, m·L⁻¹·Kₐₐ·L⁻ᵀ with L·Lᵀ the sum of the Kₐₐ, so that stiff elements lean on the mass soft
//! neighbours don't need, in the direction they need it; elements that come out fastest are given more in a few rounds,
//! and the best round counts. Shares by volume would cost up to a third of the step on uneven meshes.
//!
//! An element's λ is bounded by (tr A^2p)^(1/2p) of its matrix A = Mₑ^-½·Kₑ·Mₑ^-½, with p = 32 by five squarings: never too
//! low, at most 5 % too high and mostly under 2 %, with no iteration that could stop early. A power iteration would be
//! a little too low, which is the wrong side. The tangent at the current F is used, so that squeezing,
//! stiffening and geometric stiffness count.

use super::elements::{Basis, Element, Elements, jacobian};
use crate::law::elastic::tensor::{
    Mat, add, add_scaled, from_fn, inverse, mul, mul_transpose, scale, trace, unit, zero,
};
use crate::law::elastic::{Elastic, Viscous};
use crate::math::Scalar;

/// How often an element's matrix is squared.
const SQUARINGS: u32 = 5;

/// What of the trace of an element's stiffness at a node is added in all directions to its claim on the node's mass. Without
/// it nearly incompressible elements, stiff in one direction only, would leave the fast motions across without mass; at
/// .1 to .3 the bound is closest for all ν.
const BLEND: f64 = 0.2;

/// How often the masses are divided anew.
const ROUNDS: usize = 2;

/// A bound on the fastest mode.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// Bound of λ(M⁻¹K) \[1/s²\], or of λ(M⁻¹C) \[1/s\].
    pub largest: f64,
    /// The element that has it; none when nothing moves.
    pub element: Option<u32>,
}

/// Bounds λ(M⁻¹K) \[1/s²\] of the tangent at positions \[m\]; `inv_mass` is 1/m of a node \[1/kg\], 0 when pinned.
pub fn elastic_rates<S, B, L, const N: usize, const G: usize>(
    elements: &Elements<S, B, N, G>,
    law: &L,
    position: impl Fn(usize) -> [f64; 3],
    inv_mass: impl Fn(usize) -> f64,
) -> Rates
where
    S: Scalar,
    B: Basis<N, G>,
    L: Elastic<f64>,
{
    bound(elements, |f, d| law.differential(f, d), position, inv_mass)
}

/// Bounds λ(M⁻¹C) \[1/s\] of stiffness-proportional damping at positions \[m\].
pub fn damping_rates<S, B, const N: usize, const G: usize>(
    elements: &Elements<S, B, N, G>,
    law: &Viscous<f64>,
    position: impl Fn(usize) -> [f64; 3],
    inv_mass: impl Fn(usize) -> f64,
) -> Rates
where
    S: Scalar,
    B: Basis<N, G>,
{
    bound(elements, |f, d| law.stress(f, d), position, inv_mass)
}

/// The stiffness of one element, row by row, 3N×3N: `differential` is the change of P along a change of F.
pub(crate) fn element_matrix<S: Scalar, B: Basis<N, G>, const N: usize, const G: usize>(
    element: &Element<S, N, G>,
    differential: impl Fn(&Mat<f64>, &Mat<f64>) -> Mat<f64>,
    position: impl Fn(usize) -> [f64; 3],
    matrix: &mut [f64],
) {
    matrix.fill(0.0);
    let x = element.gather(position);
    for (g, point) in element.points.iter().enumerate() {
        let inverse = point.inverse.map(|row| row.map(S::f64));
        let volume = point.volume.f64();
        let f = mul(&jacobian::<f64, B, N, G>(&x, g), &inverse);
        // ∇N at rest.
        let gradients: [[f64; 3]; N] = std::array::from_fn(|a| {
            let d = B::GRADIENTS[g][a];
            std::array::from_fn(|k| (0..3).map(|l| d[l] * inverse[l][k]).sum())
        });
        // The change of P per change of each entry of F.
        let tangent: [[Mat<f64>; 3]; 3] = std::array::from_fn(|j| {
            std::array::from_fn(|l| {
                let mut d = zero();
                d[j][l] = volume;
                differential(&f, &d)
            })
        });
        for (b, gb) in gradients.iter().enumerate() {
            for (j, by_row) in tangent.iter().enumerate() {
                let change = from_fn(|i, k| (0..3).map(|l| by_row[l][i][k] * gb[l]).sum::<f64>());
                for (a, ga) in gradients.iter().enumerate() {
                    for (i, row) in change.iter().enumerate() {
                        matrix[(3 * a + i) * 3 * N + 3 * b + j] +=
                            row[0] * ga[0] + row[1] * ga[1] + row[2] * ga[2];
                    }
                }
            }
        }
    }
}

fn bound<S: Scalar, B: Basis<N, G>, const N: usize, const G: usize>(
    elements: &Elements<S, B, N, G>,
    differential: impl Fn(&Mat<f64>, &Mat<f64>) -> Mat<f64>,
    position: impl Fn(usize) -> [f64; 3],
    inv_mass: impl Fn(usize) -> f64,
) -> Rates {
    let size = 3 * N;
    let mut matrix = vec![0.0; size * size];
    let mut square = vec![0.0; size * size];
    let fill = |element: &Element<S, N, G>, matrix: &mut [f64]| {
        element_matrix::<S, B, N, G>(element, &differential, &position, matrix);
    };
    let mut weights: Vec<[Mat<f64>; N]> = Vec::with_capacity(elements.list.len());
    for element in &elements.list {
        fill(element, &mut matrix);
        weights.push(std::array::from_fn(|a| {
            let own = from_fn(|i, j| matrix[(3 * a + i) * size + 3 * a + j]);
            let whole = trace(&own).abs().max(1e-290);
            let blended = add_scaled(&own, BLEND * whole, &unit());
            if cholesky(&blended).is_some() {
                blended
            } else {
                // A softened element still takes part in the motion of its nodes.
                scale(&unit(), whole)
            }
        }));
    }
    let mut sums = vec![zero(); elements.node_count];
    let mut best = Rates {
        largest: f64::INFINITY,
        element: None,
    };
    for round in 0..=ROUNDS {
        sums.fill(zero());
        for (element, own) in elements.list.iter().zip(&weights) {
            for (node, weight) in element.nodes.iter().zip(own) {
                sums[*node as usize] = add(&sums[*node as usize], weight);
            }
        }
        let mut rates = Rates::default();
        for (i, (element, own)) in elements.list.iter().zip(&mut weights).enumerate() {
            fill(element, &mut matrix);
            let roots: [Mat<f64>; N] = std::array::from_fn(|a| {
                let node = element.nodes[a] as usize;
                scale(&factor(&own[a], &sums[node]), inv_mass(node).sqrt())
            });
            for a in 0..N {
                for b in 0..N {
                    let at = |i: usize, j: usize| (3 * a + i) * size + 3 * b + j;
                    let block = from_fn(|i, j| matrix[at(i, j)]);
                    let scaled = mul_transpose(&mul(&roots[a], &block), &roots[b]);
                    for (i, row) in scaled.iter().enumerate() {
                        for (j, entry) in row.iter().enumerate() {
                            matrix[at(i, j)] = *entry;
                        }
                    }
                }
            }
            let largest = largest_eigenvalue(&mut matrix, &mut square, size, 0.5 * rates.largest);
            if largest > rates.largest {
                rates = Rates {
                    largest,
                    element: Some(i as u32),
                };
            }
            if round < ROUNDS && largest.is_normal() {
                own.iter_mut().for_each(|w| *w = scale(w, largest));
            }
        }
        if rates.largest < best.largest {
            best = rates;
        }
    }
    best
}

/// The lower triangular L of m = L·Lᵀ; `None` unless m is positive definite.
fn cholesky(m: &Mat<f64>) -> Option<Mat<f64>> {
    let mut l = zero();
    for i in 0..3 {
        for j in 0..=i {
            let rest = m[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            if i != j {
                l[i][j] = rest / l[j][j];
            } else if rest > 0.0 {
                l[i][i] = rest.sqrt();
            } else {
                return None;
            }
        }
    }
    Some(l)
}

/// T with TᵀT the inverse of a node's share in one element, L⁻¹·own·L⁻ᵀ where sum = L·Lᵀ. The shares sum to the unit matrix.
fn factor(own: &Mat<f64>, sum: &Mat<f64>) -> Mat<f64> {
    match (cholesky(own), cholesky(sum)) {
        (Some(own), Some(sum)) => mul(&inverse(&own), &sum),
        _ => scale(&unit(), f64::INFINITY),
    }
}

/// An upper bound of the largest size of an eigenvalue of a symmetric matrix, which is overwritten. Where it is sure not to
/// exceed `enough` it may stop with any bound below that.
fn largest_eigenvalue(matrix: &mut [f64], square: &mut [f64], size: usize, enough: f64) -> f64 {
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
        if bound <= enough || step == SQUARINGS {
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
        matrix.copy_from_slice(square);
    }
    bound
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let found = largest_eigenvalue(&mut m, &mut [0.0; 16], 4, 0.0);
        assert!((3.0..3.0 * 1.01).contains(&found), "{found}");
        let mut one = vec![1e-200, 0.0, 0.0, 0.0];
        assert!(largest_eigenvalue(&mut one, &mut [0.0; 4], 2, 0.0) < 1e-100);
        assert!(largest_eigenvalue(&mut [f64::NAN; 4], &mut [0.0; 4], 2, 0.0) > 1e300);
    }
}
