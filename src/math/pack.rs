//! Several scalars side by side, so that a law is computed for several elements at once.
//!
//! Plain arrays and plain loops: at a width of four the compiler keeps a pack of `f32` in one vector register of any
//! x86-64 or ARM64 processor, without a line of code that depends on it, so results are the same on all of them.

use super::{Number, Scalar};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// How many scalars a pack has.
pub const WIDTH: usize = 4;

/// How many scalars tables have side by side, whatever the width they are computed in.
pub const LANES: usize = 16;

/// [`LANES`] scalars of a table, read in parts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Wide<S = f32>(pub [S; LANES]);

/// Some scalars side by side.
pub trait Packed<S>: Number {
    /// The scalars from lane `part`·[`Number::LANES`] on.
    fn load(from: &Wide<S>, part: usize) -> Self;
    /// Writes to those lanes.
    fn store(self, to: &mut Wide<S>, part: usize);
}

/// [`WIDTH`] scalars.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub struct Pack<S>(pub [S; WIDTH]);

impl<S: Scalar> Default for Pack<S> {
    fn default() -> Self {
        Self::ZERO
    }
}

/// A pack of an expression of the lane. A macro, because closures would be called and not inlined in the long functions that
/// laws become.
macro_rules! lanes {
    ($lane:ident => $value:expr) => {{
        let mut lanes = [S::ZERO; WIDTH];
        let mut $lane = 0;
        while $lane < WIDTH {
            lanes[$lane] = $value;
            $lane += 1;
        }
        Self(lanes)
    }};
}

macro_rules! operator {
    ($trait:ident, $name:ident, $op:tt) => {
        impl<S: Scalar> $trait for Pack<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                lanes!(i => self.0[i] $op other.0[i])
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<S: Scalar> Neg for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        lanes!(i => -self.0[i])
    }
}

impl<S: Scalar> AddAssign for Pack<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Scalar> SubAssign for Pack<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<S: Scalar> Number for Pack<S> {
    const ZERO: Self = Self([S::ZERO; WIDTH]);
    const ONE: Self = Self([S::ONE; WIDTH]);
    const COARSE: f64 = S::COARSE;
    const LANES: usize = WIDTH;
    #[inline(always)]
    fn of(x: f64) -> Self {
        Self([S::of(x); WIDTH])
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane].f64()
    }
    #[inline(always)]
    fn of_lanes(mut value: impl FnMut(usize) -> f64) -> Self {
        lanes!(i => S::of(value(i)))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        lanes!(i => self.0[i].sqrt())
    }
    #[inline(always)]
    fn ln(self) -> Self {
        lanes!(i => self.0[i].ln())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        lanes!(i => self.0[i].abs())
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        lanes!(i => Number::max(self.0[i], other.0[i]))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        lanes!(i => Number::min(self.0[i], other.0[i]))
    }
    #[inline(always)]
    fn all_above(self, other: Self) -> bool {
        // No short cut: a chain of branches would cost more than the comparisons.
        let mut all = true;
        for i in 0..WIDTH {
            all &= self.0[i] > other.0[i];
        }
        all
    }
    #[inline(always)]
    fn above(self, other: Self, this: Self, that: Self) -> Self {
        lanes!(i => if self.0[i] > other.0[i] { this.0[i] } else { that.0[i] })
    }
}

impl<S: Scalar> Packed<S> for Pack<S> {
    #[inline(always)]
    fn load(from: &Wide<S>, part: usize) -> Self {
        let from = &from.0[WIDTH * part..][..WIDTH];
        lanes!(i => from[i])
    }

    #[inline(always)]
    fn store(self, to: &mut Wide<S>, part: usize) {
        to.0[WIDTH * part..][..WIDTH].copy_from_slice(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_computed_as_scalars() {
        let a = [1.5_f32, -2.0, 0.25, 3.0];
        let b = [0.5_f32, 4.0, -1.0, 3.0];
        let (p, q) = (Pack(a), Pack(b));
        let sum = (p + q) * p - q / p;
        for i in 0..WIDTH {
            assert_eq!(sum.0[i], (a[i] + b[i]) * a[i] - b[i] / a[i]);
        }
        assert_eq!(p.max(q).0, [1.5, 4.0, 0.25, 3.0]);
        assert_eq!(p.above(q, Pack::ONE, Pack::ZERO).0, [1.0, 0.0, 1.0, 0.0]);
        assert!(!p.all_above(q) && (p + Pack::of(9.0)).all_above(q));
        assert!(!Pack([f32::NAN, 1.0, 1.0, 1.0]).all_above(Pack::ZERO));
    }
}
