//! The compressible neo-Hookean solid of the textbooks.

use super::majorant::{Majorant, of_volume};
use super::tensor::{Mat, add_scaled, cofactor, cofactor_differential, contract, det, scale};
use super::{Elastic, Lame};
use crate::math::Number;

/// W = μ/2(I₁ − 3) + g(J), g = −μ ln J + λ/2 ln²J, with I₁ = ‖F‖² and J = det F.
///
/// Below [`NeoHookean::FLOOR`] g goes on as the parabola with the same value, slope and curvature: an element pressed flat or
/// turned inside out has a finite energy and a force that opens it, some hundred times as stiff as at rest. A continuum
/// never reaches J ≤ 0, but a mesh thrown about by an explicit step does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeoHookean<S>(pub Lame<S>);

impl<S: Number> NeoHookean<S> {
    /// The J below which the energy is the parabola.
    pub const FLOOR: f64 = 0.1;

    /// g, g′ and g″ at `j`.
    #[inline(always)]
    fn volume(&self, j: S) -> [S; 3] {
        let Lame { lambda, mu } = self.0;
        let at = j.max(S::of(Self::FLOOR));
        let ln = at.ln();
        let inverse = S::ONE / at;
        let half = S::of(0.5);
        let value = (half * lambda * ln - mu) * ln;
        let slope = (lambda * ln - mu) * inverse;
        let curvature = (lambda + mu - lambda * ln) * inverse * inverse;
        let below = j - at;
        [
            value + (slope + half * curvature * below) * below,
            slope + curvature * below,
            curvature,
        ]
    }
}

impl<S: Number> Elastic<S> for NeoHookean<S> {
    #[inline(always)]
    fn energy(&self, f: &Mat<S>) -> S {
        let [value, ..] = self.volume(det(f));
        S::of(0.5) * self.0.mu * (contract(f, f) - S::of(3.0)) + value
    }

    #[inline(always)]
    fn stress(&self, f: &Mat<S>) -> Mat<S> {
        let [_, slope, _] = self.volume(det(f));
        add_scaled(&scale(f, self.0.mu), slope, &cofactor(f))
    }

    #[inline(always)]
    fn differential(&self, f: &Mat<S>, d: &Mat<S>) -> Mat<S> {
        let [_, slope, curvature] = self.volume(det(f));
        let c = cofactor(f);
        let along = add_scaled(&scale(d, self.0.mu), curvature * contract(&c, d), &c);
        add_scaled(&along, slope, &cofactor_differential(f, d))
    }

    #[inline(always)]
    fn majorant(&self, f: &Mat<S>) -> Majorant<S> {
        let c = cofactor(f);
        let j = det(f);
        let [_, slope, curvature] = self.volume(j);
        of_volume(f, &c, j, [self.0.mu, slope, curvature])
    }
}
