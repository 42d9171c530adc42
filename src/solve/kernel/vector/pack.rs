//! Vectors of four numbers without anything that depends on the processor.

use super::{Aside, Vector};
use crate::math::{Number, Pack};

impl Vector for Pack<f32> {
    type Mask = [bool; 4];
    const EVERYWHERE: Self::Mask = [true; 4];

    #[inline(always)]
    fn also_above(self, other: Self, mask: Self::Mask) -> Self::Mask {
        std::array::from_fn(|l| mask[l] & (self.0[l] > other.0[l]))
    }

    #[inline(always)]
    fn is_everywhere(mask: Self::Mask) -> bool {
        mask == Self::EVERYWHERE
    }

    #[inline(always)]
    fn multiply_and_add(self, factor: Self, more: Self) -> Self {
        self * factor + more
    }

    #[inline(always)]
    fn load_from(from: &[f32]) -> Self {
        Self([from[0], from[1], from[2], from[3]])
    }

    #[inline(always)]
    fn store_to(self, to: &mut [f32]) {
        to[..4].copy_from_slice(&self.0);
    }

    #[inline(never)]
    fn aside<A: Aside<Self>>(aside: A) -> A::Output {
        aside.run()
    }

    #[inline(always)]
    fn bits_above(self, other: Self) -> u32 {
        let bit = |l: usize| u32::from(self.0[l] > other.0[l]) << l;
        bit(0) | bit(1) | bit(2) | bit(3)
    }

    #[inline(always)]
    fn halves(rows: [Self; 2]) -> [Self; 2] {
        // A vector is half a row.
        rows
    }

    #[inline(always)]
    fn rows(halves: [Self; 2]) -> [Self; 2] {
        halves
    }

    #[inline(always)]
    fn zero_below(self, least: Self) -> Self {
        Self::above(least, self.abs(), Self::ZERO, self)
    }

    #[inline(always)]
    fn last_of_four(self) -> Self {
        Self([self.0[3]; 4])
    }

    #[inline(always)]
    fn sums_of_fours([a, b, c, d]: [Self; 4]) -> Self {
        let sum = |[a, b, c, d]: [f32; 4]| (a + b) + (c + d);
        Self([sum(a.0), sum(b.0), sum(c.0), sum(d.0)])
    }

    #[inline(always)]
    unsafe fn columns(row: impl Fn(usize) -> *const f32) -> [Self; 4] {
        // SAFETY: the caller vouches for four numbers at each pointer.
        let row = |l| unsafe { *row(l).cast::<[f32; 4]>() };
        let [a, b, c, d] = [row(0), row(1), row(2), row(3)];
        [0, 1, 2, 3].map(|k| Self([a[k], b[k], c[k], d[k]]))
    }

    #[inline(always)]
    unsafe fn put_columns([x, y, z, w]: [Self; 4], row: impl Fn(usize) -> *mut f32) {
        for l in 0..4 {
            // SAFETY: the caller vouches for four numbers at each pointer.
            unsafe { *row(l).cast::<[f32; 4]>() = [x.0[l], y.0[l], z.0[l], w.0[l]] };
        }
    }
}
