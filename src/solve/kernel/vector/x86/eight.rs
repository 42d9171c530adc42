//! Eight numbers: AVX2. SAFETY: see the parent module, which is "the top" here.

use super::super::{Aside, Pass, Vector, Wide};
use crate::math::{Number, Packed};
use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Runs a pass with [`F8`].
#[target_feature(enable = "avx2,fma")]
pub fn run256<P: Pass>(pass: P) -> P::Output {
    pass.run::<F8>()
}

#[target_feature(enable = "avx2,fma")]
#[inline(never)]
fn aside256<A: Aside<F8>>(aside: A) -> A::Output {
    aside.run()
}

/// Eight numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F8(__m256);

vector!(
    [] F8,
    8,
    __m256,
    _mm256_set1_ps,
    _mm256_sqrt_ps,
    _mm256_xor_ps,
    [
        _mm256_add_ps,
        _mm256_sub_ps,
        _mm256_mul_ps,
        _mm256_div_ps,
        _mm256_max_ps,
        _mm256_min_ps
    ]
);

// SAFETY of the functions of this block: see the top.
impl F8 {
    #[inline(always)]
    fn clear_sign(self) -> Self {
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }

    /// Of each four numbers of one vector, then of the other, the sums of the first two and of the last two.
    #[inline(always)]
    fn sums_of_pairs(self, other: Self) -> Self {
        unsafe {
            let first = Self(_mm256_shuffle_ps::<0x88>(self.0, other.0));
            first + Self(_mm256_shuffle_ps::<0xdd>(self.0, other.0))
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
    /// All bits of a lane, or none.
    type Mask = Self;
    const EVERYWHERE: Self = Self::from_lanes([f32::from_bits(u32::MAX); 8]);

    #[inline(always)]
    fn also_above(self, other: Self, mask: Self) -> Self {
        // SAFETY: see the top.
        Self(unsafe { _mm256_and_ps(mask.0, _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0)) })
    }

    #[inline(always)]
    fn is_everywhere(mask: Self) -> bool {
        // SAFETY: see the top.
        unsafe { _mm256_movemask_ps(mask.0) == 0xff }
    }

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
    fn load_from(from: &[f32]) -> Self {
        let lanes = &from[..8];
        // SAFETY: as in `load`.
        Self(unsafe { _mm256_loadu_ps(lanes.as_ptr()) })
    }

    #[inline(always)]
    fn store_to(self, to: &mut [f32]) {
        let lanes = &mut to[..8];
        // SAFETY: as in `load`.
        unsafe { _mm256_storeu_ps(lanes.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn multiply_and_add(self, factor: Self, more: Self) -> Self {
        // SAFETY: see the top.
        Self(unsafe { _mm256_fmadd_ps(self.0, factor.0, more.0) })
    }

    #[inline(always)]
    fn halves([a, b]: [Self; 2]) -> [Self; 2] {
        // SAFETY: see the top.
        unsafe {
            [
                Self(_mm256_permute2f128_ps::<0x20>(a.0, b.0)),
                Self(_mm256_permute2f128_ps::<0x31>(a.0, b.0)),
            ]
        }
    }

    #[inline(always)]
    fn rows(halves: [Self; 2]) -> [Self; 2] {
        // Two by two, so that it is its own reverse.
        Self::halves(halves)
    }

    #[inline(always)]
    fn zero_below(self, least: Self) -> Self {
        // Bits of positive numbers are in their order, NaN above all: a comparison would wait longer, and for a mask.
        // SAFETY: see the top.
        unsafe {
            let bits = _mm256_castps_si256(self.0);
            let size = _mm256_and_si256(bits, _mm256_set1_epi32(i32::MAX));
            let beyond = _mm256_sub_epi32(size, _mm256_castps_si256(least.0));
            let below = _mm256_srai_epi32::<31>(beyond);
            Self(_mm256_castsi256_ps(_mm256_andnot_si256(below, bits)))
        }
    }

    #[inline(always)]
    fn last_of_four(self) -> Self {
        // SAFETY: see the top.
        Self(unsafe { _mm256_permute_ps::<0xff>(self.0) })
    }

    #[inline(always)]
    fn sums_of_fours([a, b, c, d]: [Self; 4]) -> Self {
        Self::sums_of_pairs(Self::sums_of_pairs(a, b), Self::sums_of_pairs(c, d))
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
