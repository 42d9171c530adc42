//! Linear elasticity in the turned frame.

use super::polar::{polar, rotation_differential};
use super::tensor::{Mat, add_scaled, contract, mul, mul_transpose, scale, sub, trace, unit};
use super::{Elastic, Lame};
use crate::math::Scalar;

/// W = μ‖S − I‖² + λ/2·tr²(S − I) with F = R·S (Müller & Gross 2004; here with the exact derivative, so that energy is
/// conserved). R is a proper rotation for inverted elements too, see [`polar`](super::polar), and what is inverted is
/// pushed back with a finite force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corotational<S>(pub Lame<S>);

impl<S: Scalar> Elastic<S> for Corotational<S> {
    #[inline(always)]
    fn energy(&self, f: &Mat<S>) -> S {
        let (_, s) = polar(f);
        let e = sub(&s, &unit());
        let t = trace(&e);
        self.0.mu * contract(&e, &e) + S::of(0.5) * self.0.lambda * t * t
    }

    #[inline(always)]
    fn stress(&self, f: &Mat<S>) -> Mat<S> {
        let (r, s) = polar(f);
        let t = trace(&sub(&s, &unit()));
        let shear = scale(&sub(f, &r), S::of(2.0) * self.0.mu);
        add_scaled(&shear, self.0.lambda * t, &r)
    }

    #[inline(always)]
    fn differential(&self, f: &Mat<S>, d: &Mat<S>) -> Mat<S> {
        let (r, s) = polar(f);
        let t = trace(&sub(&s, &unit()));
        let turn = rotation_differential(&r, &s, d);
        let two_mu = S::of(2.0) * self.0.mu;
        let straight = add_scaled(&scale(d, two_mu), self.0.lambda * contract(&r, d), &r);
        add_scaled(&straight, self.0.lambda * t - two_mu, &turn)
    }

    /// R·(2μ(S − I) + λ·tr(S − I)·I)·Rᵀ, the stress of the linear solid in the turned frame. The law takes strains as small,
    /// so areas at rest and now are one; P·Fᵀ/J differs from it by a part as large as the strain.
    #[inline(always)]
    fn cauchy(&self, f: &Mat<S>) -> Mat<S> {
        let (r, s) = polar(f);
        let e = sub(&s, &unit());
        let shear = scale(&mul_transpose(&mul(&r, &e), &r), S::of(2.0) * self.0.mu);
        add_scaled(&shear, self.0.lambda * trace(&e), &unit())
    }
}
