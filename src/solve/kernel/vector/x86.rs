//! Vectors of eight and sixteen numbers by the intrinsics of x86-64.
//!
//! SAFETY of every block here that calls intrinsics: the types are private to the parent module, and `run` makes them a type
//! parameter only once the processor has said that it has AVX2 and FMA, or AVX-512 F and DQ; see there.

macro_rules! operator {
    ([$($kind:tt)*] $t:ty, $trait:ident, $name:ident, $intrinsic:ident) => {
        impl<$($kind)*> $trait for $t {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: see the top.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

/// Everything whose text does not depend on the width; in brackets what the type is generic over.
macro_rules! vector {
    ([$($kind:tt)*] $t:ty, $lanes:expr, $raw:ty, $set:ident, $sqrt:ident, $xor:ident,
     [$add:ident, $sub:ident, $mul:ident, $div:ident, $max:ident, $min:ident]) => {
        operator!([$($kind)*] $t, Add, add, $add);
        operator!([$($kind)*] $t, Sub, sub, $sub);
        operator!([$($kind)*] $t, Mul, mul, $mul);
        operator!([$($kind)*] $t, Div, div, $div);

        impl<$($kind)*> Default for $t {
            fn default() -> Self {
                Self::ZERO
            }
        }

        impl<$($kind)*> Neg for $t {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: see the top.
                Self(unsafe { $xor(self.0, $set(-0.0)) })
            }
        }

        impl<$($kind)*> AddAssign for $t {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl<$($kind)*> SubAssign for $t {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }

        impl<$($kind)*> $t {
            #[inline(always)]
            fn lanes(self) -> [f32; $lanes] {
                // SAFETY: both are so many numbers without padding, and every pattern is a number.
                unsafe { std::mem::transmute::<$raw, [f32; $lanes]>(self.0) }
            }

            #[inline(always)]
            const fn from_lanes(lanes: [f32; $lanes]) -> Self {
                // SAFETY: as in `lanes`.
                Self(unsafe { std::mem::transmute::<[f32; $lanes], $raw>(lanes) })
            }
        }

        impl<$($kind)*> Number for $t {
            const ZERO: Self = Self::from_lanes([0.0; $lanes]);
            const ONE: Self = Self::from_lanes([1.0; $lanes]);
            const COARSE: f64 = <f32 as Number>::COARSE;
            const LANES: usize = $lanes;
            #[inline(always)]
            fn of(x: f64) -> Self {
                // SAFETY: see the top.
                Self(unsafe { $set(x as f32) })
            }
            #[inline(always)]
            fn lane(self, lane: usize) -> f64 {
                self.lanes()[lane].into()
            }
            #[inline(always)]
            fn of_lanes(value: impl FnMut(usize) -> f64) -> Self {
                Self::from_lanes(std::array::from_fn(value).map(|x: f64| x as f32))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: see the top.
                Self(unsafe { $sqrt(self.0) })
            }
            #[inline(always)]
            fn ln(self) -> Self {
                Self::from_lanes(self.lanes().map(f32::ln))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.clear_sign()
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: see the top.
                Self(unsafe { $max(self.0, other.0) })
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                // SAFETY: see the top.
                Self(unsafe { $min(self.0, other.0) })
            }
            #[inline(always)]
            fn all_above(self, other: Self) -> bool {
                self.bits(other) == (1 << $lanes) - 1
            }
            #[inline(always)]
            fn above(self, other: Self, this: Self, that: Self) -> Self {
                self.select_above(other, this, that)
            }
        }
    };
}

mod eight;
mod sixteen;

pub use eight::run256;
pub use sixteen::{run512, run512_without_divider};
