//! 3×3 matrices over a [`Scalar`](crate::math::Scalar), as plain arrays of rows: what the laws of solids are written in.
//!
//! Rapier's matrices have one scalar each; the laws have two. Plain arrays also leave a vector kernel free to put lanes in
//! the place of the scalar.

use crate::math::Number;

/// A 3×3 matrix, row by row: `m[i][j]` is row i, column j.
pub type Mat<S> = [[S; 3]; 3];

/// The matrix of an expression of row and column. A macro, because closures would be called and not inlined in the long
/// functions that laws become.
macro_rules! matrix {
    ($i:ident, $j:ident => $value:expr) => {{
        let mut m = [[S::ZERO; 3]; 3];
        let mut $i = 0;
        while $i < 3 {
            let mut $j = 0;
            while $j < 3 {
                m[$i][$j] = $value;
                $j += 1;
            }
            $i += 1;
        }
        m
    }};
}
pub(crate) use matrix;

/// The matrix with `entry(i, j)` in row i, column j.
#[inline(always)]
pub fn from_fn<S: Number>(mut entry: impl FnMut(usize, usize) -> S) -> Mat<S> {
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// The matrix of zeros.
#[inline(always)]
pub fn zero<S: Number>() -> Mat<S> {
    [[S::ZERO; 3]; 3]
}

/// The unit matrix.
#[inline(always)]
pub fn unit<S: Number>() -> Mat<S> {
    matrix!(i, j => if i == j { S::ONE } else { S::ZERO })
}

/// a + b.
#[inline(always)]
pub fn add<S: Number>(a: &Mat<S>, b: &Mat<S>) -> Mat<S> {
    matrix!(i, j => a[i][j] + b[i][j])
}

/// a − b.
#[inline(always)]
pub fn sub<S: Number>(a: &Mat<S>, b: &Mat<S>) -> Mat<S> {
    matrix!(i, j => a[i][j] - b[i][j])
}

/// s·a.
#[inline(always)]
pub fn scale<S: Number>(a: &Mat<S>, s: S) -> Mat<S> {
    matrix!(i, j => a[i][j] * s)
}

/// a + s·b.
#[inline(always)]
pub fn add_scaled<S: Number>(a: &Mat<S>, s: S, b: &Mat<S>) -> Mat<S> {
    matrix!(i, j => a[i][j] + s * b[i][j])
}

/// a·b.
#[inline(always)]
pub fn mul<S: Number>(a: &Mat<S>, b: &Mat<S>) -> Mat<S> {
    matrix!(i, j => a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j])
}

/// aᵀ·b.
#[inline(always)]
pub fn transpose_mul<S: Number>(a: &Mat<S>, b: &Mat<S>) -> Mat<S> {
    matrix!(i, j => a[0][i] * b[0][j] + a[1][i] * b[1][j] + a[2][i] * b[2][j])
}

/// a·bᵀ.
#[inline(always)]
pub fn mul_transpose<S: Number>(a: &Mat<S>, b: &Mat<S>) -> Mat<S> {
    matrix!(i, j => a[i][0] * b[j][0] + a[i][1] * b[j][1] + a[i][2] * b[j][2])
}

/// a·v.
#[inline(always)]
pub fn apply<S: Number>(a: &Mat<S>, v: [S; 3]) -> [S; 3] {
    [
        a[0][0] * v[0] + a[0][1] * v[1] + a[0][2] * v[2],
        a[1][0] * v[0] + a[1][1] * v[1] + a[1][2] * v[2],
        a[2][0] * v[0] + a[2][1] * v[1] + a[2][2] * v[2],
    ]
}

/// a:b, the sum of the products of the entries.
#[inline(always)]
pub fn contract<S: Number>(a: &Mat<S>, b: &Mat<S>) -> S {
    (a[0][0] * b[0][0] + a[0][1] * b[0][1] + a[0][2] * b[0][2])
        + (a[1][0] * b[1][0] + a[1][1] * b[1][1] + a[1][2] * b[1][2])
        + (a[2][0] * b[2][0] + a[2][1] * b[2][1] + a[2][2] * b[2][2])
}

/// The sum of the diagonal.
#[inline(always)]
pub fn trace<S: Number>(a: &Mat<S>) -> S {
    a[0][0] + a[1][1] + a[2][2]
}

/// The symmetric part, ½(a + aᵀ).
#[inline(always)]
pub fn symmetric<S: Number>(a: &Mat<S>) -> Mat<S> {
    matrix!(i, j => S::of(0.5) * (a[i][j] + a[j][i]))
}

/// The cofactors, ∂(det a)/∂a = det(a)·a⁻ᵀ; defined for a singular matrix too.
#[inline(always)]
pub fn cofactor<S: Number>(a: &Mat<S>) -> Mat<S> {
    matrix!(i, j => {
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1]
    })
}

/// The change of [`cofactor`]`(a)` along `d`.
#[inline(always)]
pub fn cofactor_differential<S: Number>(a: &Mat<S>, d: &Mat<S>) -> Mat<S> {
    matrix!(i, j => {
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        d[i1][j1] * a[i2][j2] + a[i1][j1] * d[i2][j2]
            - d[i1][j2] * a[i2][j1]
            - a[i1][j2] * d[i2][j1]
    })
}

/// The determinant.
#[inline(always)]
pub fn det<S: Number>(a: &Mat<S>) -> S {
    let c = cofactor(a);
    a[0][0] * c[0][0] + a[0][1] * c[0][1] + a[0][2] * c[0][2]
}

/// The inverse; not finite for a singular matrix.
#[inline(always)]
pub fn inverse<S: Number>(a: &Mat<S>) -> Mat<S> {
    let c = cofactor(a);
    let d = S::ONE / (a[0][0] * c[0][0] + a[0][1] * c[0][1] + a[0][2] * c[0][2]);
    matrix!(i, j => c[j][i] * d)
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Mat<f64> = [[1.2, 0.3, -0.4], [0.1, 0.8, 0.5], [-0.7, 0.2, 1.5]];

    #[test]
    fn inverse_cofactor_and_determinant_agree() {
        let i = mul(&A, &inverse(&A));
        assert!(contract(&sub(&i, &unit()), &sub(&i, &unit())).sqrt() < 1e-14);
        let scaled = scale(&from_fn(|i, j| inverse(&A)[j][i]), det(&A));
        let off = sub(&scaled, &cofactor(&A));
        assert!(contract(&off, &off).sqrt() < 1e-14);
    }

    #[test]
    fn the_differential_of_the_cofactor_is_its_slope() {
        let d = [[0.3, -0.1, 0.7], [0.2, 0.9, -0.3], [0.1, 0.4, -0.6]];
        let e = 1e-6;
        let slope = scale(
            &sub(
                &cofactor(&add_scaled(&A, e, &d)),
                &cofactor(&add_scaled(&A, -e, &d)),
            ),
            0.5 / e,
        );
        let off = sub(&slope, &cofactor_differential(&A, &d));
        assert!(contract(&off, &off).sqrt() < 1e-9);
    }
}
