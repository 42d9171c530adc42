//! The stiffness of one element, for static solves.

use super::elements::{Basis, Element};
use crate::law::elastic::tensor::{Mat, from_fn, mul, zero};

/// Row by row, 3N×3N \[N/m\]: `differential` is the change of P along a change of F.
pub(crate) fn element_matrix<B: Basis<N, G>, const N: usize, const G: usize>(
    element: &Element<N, G>,
    differential: impl Fn(&Mat<f64>, &Mat<f64>) -> Mat<f64>,
    position: impl Fn(usize) -> [f64; 3],
    matrix: &mut [f64],
) {
    matrix.fill(0.0);
    let x = B::gradients(&element.gather(position));
    for (g, point) in element.points.iter().enumerate() {
        let f = mul(&x[g], &point.inverse);
        let gradients = element.gradients::<B>(g);
        // The change of P per change of each entry of F.
        let tangent: [[Mat<f64>; 3]; 3] = std::array::from_fn(|j| {
            std::array::from_fn(|l| {
                let mut d = zero();
                d[j][l] = point.volume;
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
