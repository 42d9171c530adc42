//! Linear elasticity in the turned frame.

use super::polar::{polar, rotation, rotation_differential};
use super::tensor::{Mat, add_scaled, contract, det, mul, mul_transpose, scale, sub, trace, unit};
use super::{Elastic, Lame, Majorant};
use crate::math::Number;

/// W = μ‖S − I‖² + λ/2·tr²(S − I) with F = R·S (Müller & Gross 2004; here with the exact derivative, so that energy is
/// conserved). R is a proper rotation for inverted elements too, see [`polar`](super::polar), and what is inverted is
/// pushed back with a finite force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corotational<S>(pub Lame<S>);

impl<S: Number> Elastic<S> for Corotational<S> {
    #[inline(always)]
    fn energy(&self, f: &Mat<S>) -> S {
        let (_, s) = polar(f);
        let e = sub(&s, &unit());
        let t = trace(&e);
        self.0.mu * contract(&e, &e) + S::of(0.5) * self.0.lambda * t * t
    }

    #[inline(always)]
    fn stress(&self, f: &Mat<S>) -> Mat<S> {
        let r = rotation(f);
        let t = contract(&r, f) - S::of(3.0);
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

    #[inline(always)]
    fn majorant(&self, f: &Mat<S>) -> Majorant<S> {
        let r = rotation(f);
        let stretches = contract(&r, f);
        let square = contract(f, f);
        let two_mu = S::of(2.0) * self.0.mu;
        // The turning of R is (λ·tr(S − I) − 2μ) times a positive form of at most 2/min(σᵢ + σⱼ), and the product of the
        // three sums is half of t(t² − ‖F‖²) − 2J, none of them above √2·‖F‖. Where a sum is all but zero R is not unique
        // and the force jumps, which no substep resolves.
        let turn = (self.0.lambda * (stretches - S::of(3.0)) - two_mu).max(S::ZERO);
        let product = stretches * (stretches * stretches - square) - S::of(2.0) * det(f);
        let sum = product / (S::of(4.0) * square.max(S::of(1e-12)));
        let closest = sum.max(S::of(0.02) * square.sqrt()).max(S::of(1e-12));
        Majorant {
            iso: two_mu + S::of(2.0) * turn / closest,
            along: scale(&r, self.0.lambda.max(S::ZERO).sqrt()),
        }
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
