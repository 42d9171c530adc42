//! Sixteen numbers: AVX-512. SAFETY: see the parent module, which is "the top" here.

use super::super::{Aside, Pass, Vector, Wide};
use crate::math::{Number, Packed};
use std::arch::x86_64::*;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Runs a pass with [`F16`] on a processor that takes roots fast.
#[target_feature(enable = "avx512f,avx512dq")]
pub fn run512<P: Pass>(pass: P) -> P::Output {
    pass.run::<F16<false>>()
}

/// Runs a pass with [`F16`] on one that does not.
#[target_feature(enable = "avx512f,avx512dq")]
pub fn run512_without_divider<P: Pass>(pass: P) -> P::Output {
    pass.run::<F16<true>>()
}

#[target_feature(enable = "avx512f,avx512dq")]
#[inline(never)]
fn aside512<A: Aside<F16<NEWTON>>, const NEWTON: bool>(aside: A) -> A::Output {
    aside.run()
}

/// Sixteen numbers, whose roots with their reciprocals are found by Newton's method or by the processor.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F16<const NEWTON: bool>(__m512);

vector!(
    [const NEWTON: bool] F16<NEWTON>,
    16,
    __m512,
    _mm512_set1_ps,
    _mm512_sqrt_ps,
    _mm512_xor_ps,
    [
        _mm512_add_ps,
        _mm512_sub_ps,
        _mm512_mul_ps,
        _mm512_div_ps,
        _mm512_max_ps,
        _mm512_min_ps
    ]
);

// SAFETY of the functions of this block: see the top.
impl<const NEWTON: bool> F16<NEWTON> {
    #[inline(always)]
    fn clear_sign(self) -> Self {
        Self(unsafe { _mm512_andnot_ps(_mm512_set1_ps(-0.0), self.0) })
    }

    /// Of each four numbers of one vector, then of the other, the sums of the first two and of the last two.
    #[inline(always)]
    fn sums_of_pairs(self, other: Self) -> Self {
        unsafe {
            let first = Self(_mm512_shuffle_ps::<0x88>(self.0, other.0));
            first + Self(_mm512_shuffle_ps::<0xdd>(self.0, other.0))
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

impl<const NEWTON: bool> Packed<f32> for F16<NEWTON> {
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

impl<const NEWTON: bool> Vector for F16<NEWTON> {
    type Mask = __mmask16;
    const EVERYWHERE: Self::Mask = __mmask16::MAX;
    const BY_TWOS: bool = NEWTON;

    #[inline(always)]
    fn also_above(self, other: Self, mask: Self::Mask) -> Self::Mask {
        // SAFETY: see the top.
        unsafe { _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(mask, self.0, other.0) }
    }

    #[inline(always)]
    fn is_everywhere(mask: Self::Mask) -> bool {
        mask == Self::EVERYWHERE
    }

    #[inline(always)]
    fn aside<A: Aside<Self>>(aside: A) -> A::Output {
        // SAFETY: see the top.
        unsafe { aside512(aside) }
    }

    /// By Newton's method from 14 bits: a square root and a division take a Xeon 24 cycles, this takes it 10. Fused products leave
    /// remainders exact, so that the last corrections round as they should (Markstein 1990); what the processor estimates makes
    /// no difference. A test compares all mantissas.
    #[inline(always)]
    fn root(self) -> [Self; 2] {
        const UP: i32 = _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC;
        if !NEWTON {
            let root = self.sqrt();
            return [root, Self::ONE / root];
        }
        // SAFETY: see the top.
        unsafe {
            let (square, half) = (self.0, _mm512_set1_ps(0.5));
            let rough = _mm512_rsqrt14_ps(square);
            let root = _mm512_mul_ps(square, rough);
            let half_rough = _mm512_mul_ps(half, rough);
            let error = _mm512_fnmadd_ps(root, half_rough, half);
            let root = _mm512_fmadd_ps(root, error, root);
            let half_inverse = _mm512_fmadd_ps(half_rough, error, half_rough);
            let remainder = _mm512_fnmadd_ps(root, root, square);
            let root = _mm512_fmadd_ps(remainder, half_inverse, root);
            let inverse = _mm512_add_ps(half_inverse, half_inverse);
            let error = _mm512_fnmadd_ps(root, inverse, _mm512_set1_ps(1.0));
            // Of a root whose mantissa is full the reciprocal is just above the middle between two numbers.
            let error = _mm512_fmadd_round_ps::<UP>(error, error, error);
            [Self(root), Self(_mm512_fmadd_ps(inverse, error, inverse))]
        }
    }

    #[inline(always)]
    fn bits_above(self, other: Self) -> u32 {
        self.bits(other)
    }

    #[inline(always)]
    fn load_from(from: &[f32]) -> Self {
        let lanes = &from[..16];
        // SAFETY: as in `load`.
        Self(unsafe { _mm512_loadu_ps(lanes.as_ptr()) })
    }

    #[inline(always)]
    fn store_to(self, to: &mut [f32]) {
        let lanes = &mut to[..16];
        // SAFETY: as in `load`.
        unsafe { _mm512_storeu_ps(lanes.as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn multiply_and_add(self, factor: Self, more: Self) -> Self {
        // SAFETY: see the top.
        Self(unsafe { _mm512_fmadd_ps(self.0, factor.0, more.0) })
    }

    #[inline(always)]
    fn halves([a, b]: [Self; 2]) -> [Self; 2] {
        // SAFETY: see the top.
        unsafe {
            [
                Self(_mm512_shuffle_f32x4::<0x88>(a.0, b.0)),
                Self(_mm512_shuffle_f32x4::<0xdd>(a.0, b.0)),
            ]
        }
    }

    #[inline(always)]
    fn rows([first, second]: [Self; 2]) -> [Self; 2] {
        // SAFETY: see the top.
        unsafe {
            let (a, b) = (_mm512_castps_pd(first.0), _mm512_castps_pd(second.0));
            let few = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
            let more = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
            [
                Self(_mm512_castpd_ps(_mm512_permutex2var_pd(a, few, b))),
                Self(_mm512_castpd_ps(_mm512_permutex2var_pd(a, more, b))),
            ]
        }
    }

    #[inline(always)]
    fn zero_below(self, least: Self) -> Self {
        // SAFETY: see the top.
        unsafe {
            let not_below = _mm512_cmp_ps_mask::<_CMP_NLT_UQ>(self.abs().0, least.0);
            Self(_mm512_maskz_mov_ps(not_below, self.0))
        }
    }

    #[inline(always)]
    fn last_of_four(self) -> Self {
        // SAFETY: see the top.
        Self(unsafe { _mm512_permute_ps::<0xff>(self.0) })
    }

    #[inline(always)]
    fn sums_of_fours([a, b, c, d]: [Self; 4]) -> Self {
        Self::sums_of_pairs(Self::sums_of_pairs(a, b), Self::sums_of_pairs(c, d))
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

    #[inline(always)]
    unsafe fn put_four([x, y, z, w]: [Self; 4], rows: *mut f32) {
        // SAFETY: the caller vouches for 64 numbers; see also the top.
        unsafe {
            let xy = _mm512_shuffle_f32x4::<0x44>(x.0, y.0);
            let xy_behind = _mm512_shuffle_f32x4::<0xee>(x.0, y.0);
            let zw = _mm512_shuffle_f32x4::<0x44>(z.0, w.0);
            let zw_behind = _mm512_shuffle_f32x4::<0xee>(z.0, w.0);
            let (first, last) = (every_eighth(0), every_eighth(4));
            _mm512_storeu_ps(rows, _mm512_permutex2var_ps(xy, first, zw));
            _mm512_storeu_ps(rows.add(16), _mm512_permutex2var_ps(xy, last, zw));
            let (xy, zw) = (xy_behind, zw_behind);
            _mm512_storeu_ps(rows.add(32), _mm512_permutex2var_ps(xy, first, zw));
            _mm512_storeu_ps(rows.add(48), _mm512_permutex2var_ps(xy, last, zw));
        }
    }

    #[inline(always)]
    unsafe fn columns_of_eight(rows: *const f32) -> [[Self; 4]; 2] {
        let (first, last) = (every_eighth(0), every_eighth(4));
        // SAFETY: the caller vouches for 128 numbers; see also the top.
        unsafe {
            let (a, b) = (_mm512_loadu_ps(rows), _mm512_loadu_ps(rows.add(16)));
            let (c, d) = (_mm512_loadu_ps(rows.add(32)), _mm512_loadu_ps(rows.add(48)));
            let (e, f) = (_mm512_loadu_ps(rows.add(64)), _mm512_loadu_ps(rows.add(80)));
            let (g, h) = (
                _mm512_loadu_ps(rows.add(96)),
                _mm512_loadu_ps(rows.add(112)),
            );
            // Of four rows each, the columns of a half.
            [
                four_by_four([
                    _mm512_permutex2var_ps(a, first, b),
                    _mm512_permutex2var_ps(c, first, d),
                    _mm512_permutex2var_ps(e, first, f),
                    _mm512_permutex2var_ps(g, first, h),
                ])
                .map(Self),
                four_by_four([
                    _mm512_permutex2var_ps(a, last, b),
                    _mm512_permutex2var_ps(c, last, d),
                    _mm512_permutex2var_ps(e, last, f),
                    _mm512_permutex2var_ps(g, last, h),
                ])
                .map(Self),
            ]
        }
    }
}

/// Every eighth of 32 numbers from one on, then every eighth from each of the next three on.
#[inline(always)]
fn every_eighth(from: i32) -> __m512i {
    let k = from;
    // SAFETY: see the top.
    unsafe {
        _mm512_setr_epi32(
            k,
            k + 8,
            k + 16,
            k + 24,
            k + 1,
            k + 9,
            k + 17,
            k + 25,
            k + 2,
            k + 10,
            k + 18,
            k + 26,
            k + 3,
            k + 11,
            k + 19,
            k + 27,
        )
    }
}

/// The transpose of four times four quarters.
#[inline(always)]
fn four_by_four([a, b, c, d]: [__m512; 4]) -> [__m512; 4] {
    // SAFETY: see the top.
    unsafe {
        let (low, low_behind) = (
            _mm512_shuffle_f32x4::<0x44>(a, b),
            _mm512_shuffle_f32x4::<0x44>(c, d),
        );
        let (high, high_behind) = (
            _mm512_shuffle_f32x4::<0xee>(a, b),
            _mm512_shuffle_f32x4::<0xee>(c, d),
        );
        [
            _mm512_shuffle_f32x4::<0x88>(low, low_behind),
            _mm512_shuffle_f32x4::<0xdd>(low, low_behind),
            _mm512_shuffle_f32x4::<0x88>(high, high_behind),
            _mm512_shuffle_f32x4::<0xdd>(high, high_behind),
        ]
    }
}
