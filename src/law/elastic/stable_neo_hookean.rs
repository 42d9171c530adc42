//! The neo-Hookean solid of Smith, de Goes & Kim, *Stable Neo-Hookean Flesh Simulation* (ACM TOG 37, 2018).

use super::majorant::{Majorant, of_volume};
use super::tensor::{Mat, add_scaled, cofactor, cofactor_differential, contract, det, scale};
use super::{Elastic, Lame};
use crate::math::Number;
use std::f64::consts::LN_2;

/// W = m/2(I₁ − 3) + l/2(J − α)² − m/2·ln(I₁ + 1) less its value at rest, with m = 4μ/3, l = λ + 5μ/6 and
/// α = 1 + 3m/(4l) (their equations 13 to 16): stable at rest, finite for every F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableNeoHookean<S> {
    /// m \[Pa\].
    shear: S,
    /// l \[Pa\].
    volume: S,
    /// α − 1.
    shift: S,
    /// l/2(1 − α)² − m/2·ln 4 \[Pa\].
    at_rest: S,
}

impl<S: Number> StableNeoHookean<S> {
    /// With the Lamé constants of the linear solid it is at small strains.
    #[inline(always)]
    pub fn new(lame: Lame<S>) -> Self {
        let shear = S::of(4.0 / 3.0) * lame.mu;
        let volume = lame.lambda + S::of(5.0 / 6.0) * lame.mu;
        let shift = S::of(0.75) * shear / volume;
        let half = S::of(0.5);
        Self {
            shear,
            volume,
            shift,
            at_rest: half * volume * shift * shift - half * shear * S::of(2.0 * LN_2),
        }
    }
}

impl<S: Number> Elastic<S> for StableNeoHookean<S> {
    #[inline(always)]
    fn energy(&self, f: &Mat<S>) -> S {
        let half = S::of(0.5);
        let square = contract(f, f);
        let over = det(f) - S::ONE - self.shift;
        half * self.shear * (square - S::of(3.0) - (square + S::ONE).ln())
            + half * self.volume * over * over
            - self.at_rest
    }

    #[inline(always)]
    fn stress(&self, f: &Mat<S>) -> Mat<S> {
        let over = det(f) - S::ONE - self.shift;
        let shear = self.shear * (S::ONE - S::ONE / (contract(f, f) + S::ONE));
        add_scaled(&scale(f, shear), self.volume * over, &cofactor(f))
    }

    #[inline(always)]
    fn differential(&self, f: &Mat<S>, d: &Mat<S>) -> Mat<S> {
        let over = det(f) - S::ONE - self.shift;
        let inverse = S::ONE / (contract(f, f) + S::ONE);
        let c = cofactor(f);
        let shear = scale(d, self.shear * (S::ONE - inverse));
        let bend = S::of(2.0) * self.shear * inverse * inverse * contract(f, d);
        let sum = add_scaled(&shear, bend, f);
        let sum = add_scaled(&sum, self.volume * contract(&c, d), &c);
        add_scaled(&sum, self.volume * over, &cofactor_differential(f, d))
    }

    #[inline(always)]
    fn majorant(&self, f: &Mat<S>) -> Majorant<S> {
        let c = cofactor(f);
        let j = det(f);
        let over = j - S::ONE - self.shift;
        let square = contract(f, f);
        let inverse = S::ONE / (square + S::ONE);
        // (F:D)² ≤ ‖F‖²‖D‖².
        let bend = S::of(2.0) * inverse * inverse * square;
        let iso = self.shear * (S::ONE - inverse + bend);
        of_volume(f, &c, j, [iso, self.volume * over, self.volume])
    }
}
