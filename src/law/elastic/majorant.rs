//! How stiff a law can be at a deformation, in a form whose fastest motion of an element is found at once.

#[cfg(test)]
use super::tensor::contract;
use super::tensor::{Mat, scale, transpose_mul};
use crate::math::Number;

/// A bound of the second variation of the energy: D : ∂P/∂F : D ≤ iso·‖D‖² + (along : D)² for every D.
#[derive(Clone, Copy, Debug)]
pub struct Majorant<S> {
    /// In every direction \[Pa\].
    pub iso: S,
    /// The stiff direction, a change of volume \[√Pa\].
    pub along: Mat<S>,
}

/// A bound of the square of the largest stretch: the row-sum norm of FᵀF, which is exact for a rotation.
#[inline(always)]
pub(super) fn largest_square<S: Number>(f: &Mat<S>) -> S {
    row_norm(&transpose_mul(f, f))
}

#[inline(always)]
pub(super) fn row_norm<S: Number>(m: &Mat<S>) -> S {
    let first = m[0][0].abs() + m[0][1].abs() + m[0][2].abs();
    let second = m[1][0].abs() + m[1][1].abs() + m[1][2].abs();
    first
        .max(second)
        .max(m[2][0].abs() + m[2][1].abs() + m[2][2].abs())
}

/// Of a law whose second variation is iso·‖D‖² + curvature·(C:D)² + slope·Q(D), with C = cof F, J = det F and Q the second
/// variation of J. In the frame of the stretches σ, Q = 2Σσₖ(DᵢᵢDⱼⱼ − DᵢⱼDⱼᵢ), and also (C:D)²/J − J·tr (F⁻¹D)², which
/// is the closer form, exact at rest, unless the element is nearly flat.
#[inline(always)]
pub(super) fn of_volume<S: Number>(
    f: &Mat<S>,
    c: &Mat<S>,
    j: S,
    [iso, slope, curvature]: [S; 3],
) -> Majorant<S> {
    let stretch = largest_square(f).sqrt();
    let flat = S::of(0.1);
    let safe = j.max(flat);
    // −slope·J·tr (F⁻¹D)² has the eigenvalues ±slope·σₖ, and −slope·J/σₖ² ≤ |slope|·‖CᵀC‖/J where the slope is negative.
    let least = largest_square(c) / safe;
    let turned = S::ZERO.above(slope, stretch.max(least), stretch);
    let near = (curvature + slope / safe).max(S::ZERO);
    let pick = |this: S, that: S| j.above(flat, this, that);
    Majorant {
        iso: iso + slope.abs() * pick(turned, stretch + stretch),
        along: scale(c, pick(near, curvature.max(S::ZERO)).sqrt()),
    }
}

/// The value of the bound along `d`.
#[cfg(test)]
pub(super) fn value(m: &Majorant<f64>, d: &Mat<f64>) -> f64 {
    m.iso * contract(d, d) + contract(&m.along, d).powi(2)
}
