//! Stress and strain as engineers read them.

use super::tensor::{
    Mat, contract, det, from_fn, mul_transpose, scale, sub, trace, transpose_mul, unit,
};
use crate::math::Number;

/// The Green strain ½(FᵀF − I).
#[inline(always)]
pub fn green_strain<S: Number>(f: &Mat<S>) -> Mat<S> {
    scale(&sub(&transpose_mul(f, f), &unit()), S::of(0.5))
}

/// The Cauchy stress P·Fᵀ/J \[Pa\], force per current area; not finite for a flat element.
#[inline(always)]
pub fn cauchy<S: Number>(stress: &Mat<S>, f: &Mat<S>) -> Mat<S> {
    scale(&mul_transpose(stress, f), S::ONE / det(f))
}

/// −⅓ tr σ \[Pa\], positive in compression.
#[inline(always)]
pub fn mean_pressure<S: Number>(cauchy: &Mat<S>) -> S {
    -trace(cauchy) / S::of(3.0)
}

/// The von Mises stress √(3/2·s:s) \[Pa\], s the deviator of a Cauchy stress.
#[inline(always)]
pub fn von_mises<S: Number>(cauchy: &Mat<S>) -> S {
    let p = mean_pressure(cauchy);
    let s = from_fn(|i, j| cauchy[i][j] + if i == j { p } else { S::ZERO });
    (S::of(1.5) * contract(&s, &s)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn von_mises_of_tension_and_shear() {
        let tension: Mat<f64> = [[300.0, 0.0, 0.0], [0.0; 3], [0.0; 3]];
        assert!((von_mises(&tension) - 300.0).abs() < 1e-12);
        assert!((mean_pressure(&tension) + 100.0).abs() < 1e-12);
        let shear: Mat<f64> = [[0.0, 200.0, 0.0], [200.0, 0.0, 0.0], [0.0; 3]];
        assert!((von_mises(&shear) - 200.0 * 3.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn cauchy_stress_is_force_per_current_area() {
        // Twice as long, half as wide both ways: 100 Pa at rest are 400 Pa now.
        let f: Mat<f64> = [[2.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]];
        let p: Mat<f64> = [[100.0, 0.0, 0.0], [0.0; 3], [0.0; 3]];
        assert!((cauchy(&p, &f)[0][0] - 400.0).abs() < 1e-12);
        assert!((green_strain(&f)[0][0] - 1.5).abs() < 1e-15);
    }
}
