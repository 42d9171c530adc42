//! Rapier's own math types, their `f64` twins, and the scalar the laws are generic over.
//!
//! State is `f32` because Rapier's is; sums, rigid shadows and rows are `f64`. Laws and integrators are generic over
//! [`Scalar`] so that their orders and growth factors can be tested in `f64`, where rounding does not hide them. Laws of
//! solids are generic over [`Number`], so that one text serves a single element and a [`Pack`] of them.

pub use rapier3d::math::glamx::{DMat3, DQuat, DVec3};
pub use rapier3d::math::{Pose, Real, Rotation, Vector};
pub(crate) use rapier3d::na;

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

mod disjoint;
mod fnv;
mod pack;

pub(crate) use disjoint::Disjoint;
pub(crate) use fnv::Fnv;
pub use pack::{LANES, Pack, Packed, WIDTH, Wide};

/// What laws compute with: a [`Scalar`], or several of them side by side, see [`Pack`].
pub trait Number:
    Copy
    + Debug
    + Default
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// A relative error that one step of Newton's method takes to the rounding: the square root of that, and for `f64`, where a
    /// near-double root costs a digit or two, a tenth of it.
    const COARSE: f64;
    /// How many there are side by side.
    const LANES: usize;
    /// The nearest value to `x`, in every lane.
    fn of(x: f64) -> Self;
    /// The value in a lane.
    fn lane(self, lane: usize) -> f64;
    /// The nearest value to what `value` gives for each lane.
    fn of_lanes(value: impl FnMut(usize) -> f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The larger of two; the other where they are equal or one is NaN, which is one instruction of x86.
    fn max(self, other: Self) -> Self;
    /// The smaller of two, likewise.
    fn min(self, other: Self) -> Self;
    /// Whether every lane is above the other's; not where one is NaN.
    fn all_above(self, other: Self) -> bool;
    /// `this` in the lanes that are above the other's, else `that`.
    fn above(self, other: Self, this: Self, that: Self) -> Self;
}

/// The floating-point type of a state, an integrator or a solver: `f32` or `f64`.
pub trait Scalar: Number + PartialOrd {
    /// Positive infinity: the yield or break force of a spring that never yields or breaks.
    const INFINITY: Self;
    /// The same value as `f64`.
    fn f64(self) -> f64;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;
}

macro_rules! scalar {
    ($t:ty, $coarse:expr) => {
        impl Number for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const COARSE: f64 = $coarse;
            const LANES: usize = 1;
            #[inline(always)]
            fn of(x: f64) -> Self {
                x as $t
            }
            #[inline(always)]
            fn lane(self, _: usize) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn of_lanes(mut value: impl FnMut(usize) -> f64) -> Self {
                value(0) as $t
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn ln(self) -> Self {
                self.ln()
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn all_above(self, other: Self) -> bool {
                self > other
            }
            #[inline(always)]
            fn above(self, other: Self, this: Self, that: Self) -> Self {
                if self > other { this } else { that }
            }
        }

        impl Scalar for $t {
            const INFINITY: Self = <$t>::INFINITY;
            #[inline(always)]
            fn f64(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                <$t>::is_finite(self)
            }
        }
    };
}
scalar!(f32, 1e-4);
scalar!(f64, 1e-9);

/// `a + b` and what rounding took from it (Knuth's two-sum): `a + b == sum + error` exactly.
#[inline(always)]
pub fn two_sum<S: Number>(a: S, b: S) -> (S, S) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// The squares of a matrix's elements, summed.
#[inline(always)]
pub fn sum_of_squares(m: &DMat3) -> f64 {
    m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()
}

/// A Rapier vector in `f64`.
#[inline(always)]
pub fn wide(v: Vector) -> DVec3 {
    v.as_dvec3()
}

/// An `f64` vector rounded to Rapier's scalar.
#[inline(always)]
pub fn narrow(v: DVec3) -> Vector {
    v.as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sum_loses_nothing() {
        let (sum, error) = two_sum(1.0e8_f32, 1.25);
        assert_eq!(sum as f64 + error as f64, 1.0e8 + 1.25);
        assert_ne!(error, 0.0, "the example must be one that rounds");
    }
}
