//! The St. Venant–Kirchhoff solid.

use super::majorant::{Majorant, largest_square, row_norm};
use super::measure::green_strain;
use super::tensor::{
    Mat, add, add_scaled, contract, mul, scale, symmetric, trace, transpose_mul, unit,
};
use super::{Elastic, Lame};
use crate::math::Number;

/// W = μ‖E‖² + λ/2·tr²E of the Green strain E = ½(FᵀF − I). Exact under turns and stiffening in tension, but in uniaxial
/// compression it weakens below a stretch of 1/√3 and has no stress left at zero length; an inverted element is at
/// rest. Offered because other codes have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StVenantKirchhoff<S>(pub Lame<S>);

impl<S: Number> StVenantKirchhoff<S> {
    /// The second Piola–Kirchhoff stress of a Green strain \[Pa\].
    #[inline(always)]
    fn second(&self, e: &Mat<S>) -> Mat<S> {
        let shear = scale(e, S::of(2.0) * self.0.mu);
        add_scaled(&shear, self.0.lambda * trace(e), &unit())
    }
}

impl<S: Number> Elastic<S> for StVenantKirchhoff<S> {
    #[inline(always)]
    fn energy(&self, f: &Mat<S>) -> S {
        let e = green_strain(f);
        let t = trace(&e);
        self.0.mu * contract(&e, &e) + S::of(0.5) * self.0.lambda * t * t
    }

    #[inline(always)]
    fn stress(&self, f: &Mat<S>) -> Mat<S> {
        mul(f, &self.second(&green_strain(f)))
    }

    #[inline(always)]
    fn differential(&self, f: &Mat<S>, d: &Mat<S>) -> Mat<S> {
        let change = symmetric(&transpose_mul(f, d));
        add(
            &mul(d, &self.second(&green_strain(f))),
            &mul(f, &self.second(&change)),
        )
    }

    #[inline(always)]
    fn majorant(&self, f: &Mat<S>) -> Majorant<S> {
        // S:DᵀD + 2μ‖sym FᵀD‖² + λ(F:D)².
        let pull = row_norm(&self.second(&green_strain(f)));
        Majorant {
            iso: pull + S::of(2.0) * self.0.mu * largest_square(f),
            along: scale(f, self.0.lambda.max(S::ZERO).sqrt()),
        }
    }
}
