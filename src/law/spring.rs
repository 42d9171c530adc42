//! The axial spring: Hooke tension, axial damping and stored energy.

use crate::math::Number;

/// The least square of a length that counts \[m²\]: 2⁻⁹⁸, whose root is exact.
pub const LEAST_SQUARE: f64 = 1.0 / (1_u128 << 98) as f64;

/// Tension k·e \[N\] of stiffness k \[N/m\] at elongation e \[m\]; negative in compression.
#[inline(always)]
pub fn tension<S: Number>(stiffness: S, elongation: S) -> S {
    stiffness * elongation
}

/// Damping tension c·ė \[N\] at damping c \[N·s/m\] and rate of elongation ė \[m/s\].
#[inline(always)]
pub fn damping<S: Number>(damping: S, rate: S) -> S {
    damping * rate
}

/// Stored energy ½·k·e² \[J\].
#[inline(always)]
pub fn energy<S: Number>(stiffness: S, elongation: S) -> S {
    S::of(0.5) * stiffness * elongation * elongation
}

/// What a section \[m²\] and a length \[m\] make of a modulus \[Pa\] or a viscosity \[Pa·s\]: k = E·A/L, c = η·A/L.
#[inline(always)]
pub fn of_section<S: Number>(modulus: S, section: S, length: S) -> S {
    modulus * section / length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tension_is_the_derivative_of_the_energy() {
        let (k, e, d) = (1234.5_f64, 0.0173, 1e-6);
        let slope = (energy(k, e + d) - energy(k, e - d)) / (2.0 * d);
        assert!((slope - tension(k, e)).abs() < 1e-6 * tension(k, e));
    }
}
