//! Stiffness-proportional damping that turns with the body.
//!
//! The β of Rayleigh's C = αM + βK is the time constant of a Kelvin–Voigt solid: viscous stress = β × elastic stiffness
//! × strain rate. Multiplying the current tangent by velocities would also damp by the geometric stiffness, which is
//! not positive in compression. Written with the rate of the Green strain it equals βK at small strains, is zero
//! in rigid motion of any size, and never gives energy.

use super::Lame;
use super::majorant::{Majorant, largest_square};
use super::tensor::{Mat, add_scaled, mul, scale, symmetric, trace, transpose_mul, unit};
use crate::math::Number;

/// P = F·(2μ_v·Ė + λ_v·tr Ė·I), Ė = sym(FᵀḞ).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Viscous<S>(
    /// λ_v and μ_v \[Pa·s\].
    pub Lame<S>,
);

impl<S: Number> Viscous<S> {
    /// β \[s\] times an elastic stiffness.
    pub fn proportional(beta: f64, elastic: Lame<f64>) -> Self {
        Self(Lame {
            lambda: S::of(beta * elastic.lambda),
            mu: S::of(beta * elastic.mu),
        })
    }

    /// First Piola–Kirchhoff stress \[Pa\] at F and its rate \[1/s\].
    #[inline(always)]
    pub fn stress(&self, f: &Mat<S>, rate: &Mat<S>) -> Mat<S> {
        let e = symmetric(&transpose_mul(f, rate));
        let shear = scale(&e, S::of(2.0) * self.0.mu);
        mul(f, &add_scaled(&shear, self.0.lambda * trace(&e), &unit()))
    }

    /// A bound of the stress per rate at F \[Pa·s\].
    #[inline(always)]
    pub fn majorant(&self, f: &Mat<S>) -> Majorant<S> {
        Majorant {
            iso: S::of(2.0) * self.0.mu * largest_square(f),
            along: scale(f, self.0.lambda.max(S::ZERO).sqrt()),
        }
    }
}
