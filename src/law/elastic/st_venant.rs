//! The St. Venant–Kirchhoff solid.

use super::measure::green_strain;
use super::tensor::{
    Mat, add, add_scaled, contract, mul, scale, symmetric, trace, transpose_mul, unit,
};
use super::{Elastic, Lame};
use crate::math::Scalar;

/// W = μ‖E‖² + λ/2·tr²E of the Green strain E = ½(FᵀF − I). Exact under turns and stiffening in tension, but in uniaxial
/// compression it weakens below a stretch of 1/√3 and has no stress left at zero length; an inverted element is at
/// rest. Offered because other codes have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StVenantKirchhoff<S>(pub Lame<S>);

impl<S: Scalar> StVenantKirchhoff<S> {
    /// The second Piola–Kirchhoff stress of a Green strain \[Pa\].
    #[inline(always)]
    fn second(&self, e: &Mat<S>) -> Mat<S> {
        let shear = scale(e, S::of(2.0) * self.0.mu);
        add_scaled(&shear, self.0.lambda * trace(e), &unit())
    }
}

impl<S: Scalar> Elastic<S> for StVenantKirchhoff<S> {
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
}
