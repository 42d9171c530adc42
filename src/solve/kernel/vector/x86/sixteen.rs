//! Sixteen numbers: AVX-512. SAFETY: see the parent module, which is "the top" here.

use super::super::{Aside, Pass, Vector, Wide};
use crate::math::{Number, Packed};
use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Runs a pass with [`F16`].
#[target_feature(enable = "avx512f,avx512dq")]
pub fn run512<P: Pass>(pass: P) -> P::Output {
    pass.run::<F16>()
}

#[target_feature(enable = "avx512f,avx512dq")]
#[inline(never)]
fn aside512<A: Aside<F16>>(aside: A) -> A::Output {
    aside.run()
}

/// Sixteen numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F16(__m512);

vector!(
    F16,
    16,
    __m512,
    _mm512_set1_ps,
    _mm512_sqrt_ps,
    _mm512_xor_ps,
    [_mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps, _mm512_div_ps]
);

// SAFETY of the functions of this block: see the top.
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
