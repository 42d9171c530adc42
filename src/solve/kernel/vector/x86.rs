//! Vectors of eight and sixteen numbers by the intrinsics of x86-64.
//!
//! SAFETY of every block here that calls intrinsics: the types are private to the parent module, and `run` makes them a type
//! parameter only once the processor has said that it has AVX2, or AVX-512 F and DQ; see there.

use super::{Aside, Pass, Vector, Wide};
use crate::math::{Number, Packed};
use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Runs a pass with [`F8`].
#[target_feature(enable = "avx2")]
pub fn run256<P: Pass>(pass: P) -> P::Output {
    pass.run::<F8>()
}

/// Runs a pass with [`F16`].
#[target_feature(enable = "avx512f,avx512dq")]
pub fn run512<P: Pass>(pass: P) -> P::Output {
    pass.run::<F16>()
}

#[target_feature(enable = "avx2")]
#[inline(never)]
fn aside256<A: Aside<F8>>(aside: A) -> A::Output {
    aside.run()
}

#[target_feature(enable = "avx512f,avx512dq")]
#[inline(never)]
fn aside512<A: Aside<F16>>(aside: A) -> A::Output {
    aside.run()
}

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F8(__m256);

/// Sixteen numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F16(__m512);

macro_rules! operator {
    ($t:ty, $trait:ident, $name:ident, $intrinsic:ident) => {
        impl $trait for $t {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: see the top.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

/// Everything whose text does not depend on the width.
macro_rules! vector {
    ($t:ident, $lanes:expr, $raw:ty, $set:ident, $sqrt:ident, $xor:ident,
     [$add:ident, $sub:ident, $mul:ident, $div:ident]) => {
        operator!($t, Add, add, $add);
        operator!($t, Sub, sub, $sub);
        operator!($t, Mul, mul, $mul);
        operator!($t, Div, div, $div);

        impl Default for $t {
            fn default() -> Self {
                Self::ZERO
            }
        }

        impl Neg for $t {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: see the top.
                Self(unsafe { $xor(self.0, $set(-0.0)) })
            }
        }

        impl AddAssign for $t {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl SubAssign for $t {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }

        impl $t {
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

        impl Number for $t {
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
                self.larger(other)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                -(-self).larger(-other)
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

vector!(
    F8,
    8,
    __m256,
    _mm256_set1_ps,
    _mm256_sqrt_ps,
    _mm256_xor_ps,
    [_mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_div_ps]
);
vector!(
    F16,
    16,
    __m512,
    _mm512_set1_ps,
    _mm512_sqrt_ps,
    _mm512_xor_ps,
    [_mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps, _mm512_div_ps]
);

// SAFETY of the two blocks of functions below: see the top.
impl F8 {
    #[inline(always)]
    fn clear_sign(self) -> Self {
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }

    /// The instruction gives its second operand where one is NaN.
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        unsafe {
            let larger = _mm256_max_ps(other.0, self.0);
            let nan = _mm256_cmp_ps::<_CMP_UNORD_Q>(self.0, self.0);
            Self(_mm256_blendv_ps(larger, other.0, nan))
        }
    }

    #[inline(always)]
    fn bits(self, other: Self) -> u32 {
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0)) as u32 }
    }

    #[inline(always)]
    fn select_above(self, other: Self, this: Self, that: Self) -> Self {
        unsafe {
            let above = _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0);
            Self(_mm256_blendv_ps(that.0, this.0, above))
        }
    }
}

impl F16 {
    #[inline(always)]
    fn clear_sign(self) -> Self {
        Self(unsafe { _mm512_andnot_ps(_mm512_set1_ps(-0.0), self.0) })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        unsafe {
            let larger = _mm512_max_ps(other.0, self.0);
            let nan = _mm512_cmp_ps_mask::<_CMP_UNORD_Q>(self.0, self.0);
            Self(_mm512_mask_blend_ps(nan, larger, other.0))
        }
    }

    #[inline(always)]
    fn bits(self, other: Self) -> u32 {
        unsafe { _mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, other.0).into() }
    }

    #[inline(always)]
    fn select_above(self, other: Self, this: Self, that: Self) -> Self {
        unsafe {
            let above = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, other.0);
            Self(_mm512_mask_blend_ps(above, that.0, this.0))
        }
    }
}

/// Two rows of four numbers. Functions, because what closures do is not compiled for the processor at hand unless it happens
/// to be inlined.
///
/// # Safety
/// Each pointer must be good for reading four numbers, and the processor must have AVX2.
#[inline(always)]
unsafe fn two(rows: [*const f32; 2]) -> __m256 {
    // SAFETY: the caller's.
    unsafe {
        let first = _mm256_castps128_ps256(_mm_loadu_ps(rows[0]));
        _mm256_insertf128_ps::<1>(first, _mm_loadu_ps(rows[1]))
    }
}

/// Four rows of four numbers.
///
/// # Safety
/// Each pointer must be good for reading four numbers, and the processor must have AVX-512.
#[inline(always)]
unsafe fn four(rows: [*const f32; 4]) -> __m512 {
    // SAFETY: the caller's.
    unsafe {
        let some = _mm512_castps128_ps512(_mm_loadu_ps(rows[0]));
        let some = _mm512_insertf32x4::<1>(some, _mm_loadu_ps(rows[1]));
        let some = _mm512_insertf32x4::<2>(some, _mm_loadu_ps(rows[2]));
        _mm512_insertf32x4::<3>(some, _mm_loadu_ps(rows[3]))
    }
}

impl Packed<f32> for F8 {
    #[inline(always)]
    fn load(from: &Wide, part: usize) -> Self {
        let lanes = &from.0[8 * part..][..8];
        // SAFETY: there are eight numbers; see also the top.
        Self(unsafe { _mm256_loadu_ps(lanes.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, to: &mut Wide, part: usize) {
        let lanes = &mut to.0[8 * part..][..8];
        // SAFETY: as in `load`.
        unsafe { _mm256_storeu_ps(lanes.as_mut_ptr(), self.0) }
    }
}

impl Vector for F8 {
    #[inline(always)]
    fn aside<A: Aside<Self>>(aside: A) -> A::Output {
        // SAFETY: see the top.
        unsafe { aside256(aside) }
    }

    #[inline(always)]
    fn bits_above(self, other: Self) -> u32 {
        self.bits(other)
    }

    #[inline(always)]
    fn at_least(self, least: f32) -> Self {
        // SAFETY: see the top.
        Self(unsafe { _mm256_max_ps(self.0, _mm256_set1_ps(least)) })
    }

    #[inline(always)]
    unsafe fn columns(row: impl Fn(usize) -> *const f32) -> [Self; 4] {
        // SAFETY: the caller vouches for four numbers at each pointer; see also the top.
        unsafe {
            let a = two([row(0), row(4)]);
            let b = two([row(1), row(5)]);
            let c = two([row(2), row(6)]);
            let d = two([row(3), row(7)]);
            let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
            let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
            [
                Self(_mm256_shuffle_ps::<0x44>(ab, cd)),
                Self(_mm256_shuffle_ps::<0xee>(ab, cd)),
                Self(_mm256_shuffle_ps::<0x44>(ab_high, cd_high)),
                Self(_mm256_shuffle_ps::<0xee>(ab_high, cd_high)),
            ]
        }
    }

    #[inline(always)]
    unsafe fn put_columns([x, y, z, w]: [Self; 4], row: impl Fn(usize) -> *mut f32) {
        // SAFETY: as in `columns`.
        unsafe {
            let (xy, zw) = (_mm256_unpacklo_ps(x.0, y.0), _mm256_unpacklo_ps(z.0, w.0));
            let (xy_high, zw_high) = (_mm256_unpackhi_ps(x.0, y.0), _mm256_unpackhi_ps(z.0, w.0));
            let rows = [
                _mm256_shuffle_ps::<0x44>(xy, zw),
                _mm256_shuffle_ps::<0xee>(xy, zw),
                _mm256_shuffle_ps::<0x44>(xy_high, zw_high),
                _mm256_shuffle_ps::<0xee>(xy_high, zw_high),
            ];
            for (l, two) in rows.into_iter().enumerate() {
                _mm_storeu_ps(row(l), _mm256_castps256_ps128(two));
                _mm_storeu_ps(row(l + 4), _mm256_extractf128_ps::<1>(two));
            }
        }
    }
}

impl Packed<f32> for F16 {
    #[inline(always)]
    fn load(from: &Wide, part: usize) -> Self {
        let lanes = &from.0[16 * part..][..16];
        // SAFETY: there are sixteen numbers; see also the top.
        Self(unsafe { _mm512_loadu_ps(lanes.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, to: &mut Wide, part: usize) {
        let lanes = &mut to.0[16 * part..][..16];
        // SAFETY: as in `load`.
        unsafe { _mm512_storeu_ps(lanes.as_mut_ptr(), self.0) }
    }
}

impl Vector for F16 {
    #[inline(always)]
    fn aside<A: Aside<Self>>(aside: A) -> A::Output {
        // SAFETY: see the top.
        unsafe { aside512(aside) }
    }

    #[inline(always)]
    fn bits_above(self, other: Self) -> u32 {
        self.bits(other)
    }

    #[inline(always)]
    fn at_least(self, least: f32) -> Self {
        // SAFETY: see the top.
        Self(unsafe { _mm512_max_ps(self.0, _mm512_set1_ps(least)) })
    }

    #[inline(always)]
    unsafe fn columns(row: impl Fn(usize) -> *const f32) -> [Self; 4] {
        // SAFETY: the caller vouches for four numbers at each pointer; see also the top.
        unsafe {
            let a = four([row(0), row(4), row(8), row(12)]);
            let b = four([row(1), row(5), row(9), row(13)]);
            let c = four([row(2), row(6), row(10), row(14)]);
            let d = four([row(3), row(7), row(11), row(15)]);
            let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
            let (ab_high, cd_high) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
            [
                Self(_mm512_shuffle_ps::<0x44>(ab, cd)),
                Self(_mm512_shuffle_ps::<0xee>(ab, cd)),
                Self(_mm512_shuffle_ps::<0x44>(ab_high, cd_high)),
                Self(_mm512_shuffle_ps::<0xee>(ab_high, cd_high)),
            ]
        }
    }

    #[inline(always)]
    unsafe fn put_columns([x, y, z, w]: [Self; 4], row: impl Fn(usize) -> *mut f32) {
        // SAFETY: as in `columns`.
        unsafe {
            let (xy, zw) = (_mm512_unpacklo_ps(x.0, y.0), _mm512_unpacklo_ps(z.0, w.0));
            let (xy_high, zw_high) = (_mm512_unpackhi_ps(x.0, y.0), _mm512_unpackhi_ps(z.0, w.0));
            let rows = [
                _mm512_shuffle_ps::<0x44>(xy, zw),
                _mm512_shuffle_ps::<0xee>(xy, zw),
                _mm512_shuffle_ps::<0x44>(xy_high, zw_high),
                _mm512_shuffle_ps::<0xee>(xy_high, zw_high),
            ];
            for (l, four) in rows.into_iter().enumerate() {
                _mm_storeu_ps(row(l), _mm512_castps512_ps128(four));
                _mm_storeu_ps(row(l + 4), _mm512_extractf32x4_ps::<1>(four));
                _mm_storeu_ps(row(l + 8), _mm512_extractf32x4_ps::<2>(four));
                _mm_storeu_ps(row(l + 12), _mm512_extractf32x4_ps::<3>(four));
            }
        }
    }
}
