//! Vectors of `f32` of the width the processor has, and the fetching of rows of numbers into them. **Unsafe code** is here, and for
//! threads in `solve::threads::team`.
//!
//! What is computed is written once, as a [`Pass`] generic over [`Vector`], and compiled for every width; [`run`] picks one at
//! run time, so a build for the baseline processor uses what it finds. The types of the wide vectors are private: code gets at
//! one as the type parameter of `Pass::run` alone, which [`run`] calls after it has asked the processor. Nothing else
//! makes their operations sound, and nothing else is needed, because a processor does not lose an extension.
//!
//! Products are never fused with sums, but within [`Vector::root`], which rounds as if it were exact. So every width gives the same bits.

#![allow(unsafe_code)]

mod pack;
mod rows;
mod runs;
#[cfg(target_arch = "x86_64")]
mod x86;

use super::Kernel;
use crate::math::{Pack, Packed};
#[cfg(target_arch = "x86_64")]
use std::sync::LazyLock;

#[cfg(all(test, target_arch = "x86_64"))]
mod tests;

pub use crate::math::{LANES, Wide};
pub use rows::{Half, Places, Reader, Slot, Writer, columns, numbers, numbers_mut, put_four};
pub use runs::{Columns, Run, Runs, Span, Starts, Three};

/// One, four, eight or sixteen `f32`.
pub trait Vector: Packed<f32> {
    /// Of each lane, whether something holds there.
    type Mask: Copy;
    /// It holds in every lane.
    const EVERYWHERE: Self::Mask;
    /// Whether springs are taken up two at a time, the second while the root of the first is awaited: where there are the registers
    /// for it, and roots are long chains of products.
    const BY_TWOS: bool = false;
    /// Where it held and this is above the other; not where one is NaN.
    fn also_above(self, other: Self, mask: Self::Mask) -> Self::Mask;
    /// Whether it holds in every lane.
    fn is_everywhere(mask: Self::Mask) -> bool;
    /// One bit for each lane that is above the other's; not where one is NaN.
    fn bits_above(self, other: Self) -> u32;
    /// The square root and its reciprocal, each rounded as if it were exact. Of what is less than
    /// [`LEAST_SQUARE`](crate::law::spring::LEAST_SQUARE), infinite or not a number neither means anything.
    #[inline(always)]
    fn root(self) -> [Self; 2] {
        let root = self.sqrt();
        [root, Self::ONE / root]
    }
    /// The product with a factor and a sum, fused where the processor can: for roofs, not for results.
    fn multiply_and_add(self, factor: Self, more: Self) -> Self;
    /// The first numbers of a slice, which must have so many.
    fn load_from(from: &[f32]) -> Self;
    /// Writes to the first places of a slice, which must have so many.
    fn store_to(self, to: &mut [f32]);
    /// The four columns of as many rows of four numbers as there are lanes.
    ///
    /// # Safety
    /// Each pointer must be good for reading four numbers.
    unsafe fn columns(row: impl Fn(usize) -> *const f32) -> [Self; 4];
    /// Computes something rare in a function of its own, compiled for the same processor, so that it costs the loop around it no
    /// register.
    fn aside<A: Aside<Self>>(aside: A) -> A::Output;
    /// Writes columns as rows.
    ///
    /// # Safety
    /// Each pointer must be good for writing four numbers.
    unsafe fn put_columns(columns: [Self; 4], row: impl Fn(usize) -> *mut f32);
    /// Of two vectors full of rows of eight numbers, one behind the other, the first halves of all rows and the second halves.
    fn halves(rows: [Self; 2]) -> [Self; 2];
    /// The rows of such halves.
    fn rows(halves: [Self; 2]) -> [Self; 2];
    /// 0 where it is nearer to 0 than another number, which must be positive; what is not a number stays so.
    fn zero_below(self, least: Self) -> Self;
    /// Of each four numbers the last, four times.
    fn last_of_four(self) -> Self;
    /// The sums of each four numbers of four vectors, (a + b) + (c + d), in an order that depends on the width.
    fn sums_of_fours(rows: [Self; 4]) -> Self;
    /// Writes columns as rows of four numbers, one behind the other.
    ///
    /// # Safety
    /// The pointer must be good for writing as many of them as there are lanes.
    #[inline(always)]
    unsafe fn put_four(columns: [Self; 4], rows: *mut f32) {
        // SAFETY: the caller's.
        unsafe { Self::put_columns(columns, |l| rows.add(4 * l)) }
    }
    /// The eight columns of as many rows of eight numbers as there are lanes, one behind the other.
    ///
    /// # Safety
    /// The pointer must be good for reading them.
    #[inline(always)]
    unsafe fn columns_of_eight(rows: *const f32) -> [[Self; 4]; 2] {
        // SAFETY: the caller's.
        unsafe {
            let first = Self::columns(|l| rows.add(8 * l));
            [first, Self::columns(|l| rows.add(8 * l + 4))]
        }
    }
}

/// Something computed by vectors of any width. `run` is to be `#[inline(always)]`, and so is all it calls for each vector:
/// what is not inlined is not compiled for the processor at hand.
pub trait Pass {
    /// What comes of it.
    type Output;
    /// The computation.
    fn run<V: Vector>(self) -> Self::Output;
}

/// Something rare, see [`Vector::aside`].
pub trait Aside<V> {
    /// What comes of it.
    type Output;
    /// The computation.
    fn run(self) -> Self::Output;
}

/// What the processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Width {
    /// Nothing that every processor does not have.
    Portable,
    /// Eight lanes: AVX2 and FMA.
    Avx2,
    /// Sixteen lanes: AVX-512.
    Avx512,
}

impl Width {
    /// The widest that this processor has and the setting allows.
    pub fn of(kernel: Kernel) -> Self {
        let wanted = match kernel {
            Kernel::Portable => return Self::Portable,
            Kernel::Avx2 => Self::Avx2,
            Kernel::Auto | Kernel::Avx512 => Self::Avx512,
        };
        wanted.min(Self::widest())
    }

    #[cfg(target_arch = "x86_64")]
    fn widest() -> Self {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            Self::Avx512
        } else if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            Self::Avx2
        } else {
            Self::Portable
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn widest() -> Self {
        Self::Portable
    }
}

/// Whether Newton's method is faster than the divider, as on Intel's processors: those need 24 cycles for the roots and reciprocals
/// of sixteen numbers, on Zen 5 the divider does not hold a pass up.
#[cfg(target_arch = "x86_64")]
fn has_slow_divider() -> bool {
    static IS_INTEL: LazyLock<bool> = LazyLock::new(|| {
        // SAFETY: every processor of 64 bits has it. (Rust has it as safe from 1.94 on.)
        #[allow(unused_unsafe)]
        let of = unsafe { std::arch::x86_64::__cpuid(0) };
        [of.ebx, of.edx, of.ecx] == [*b"Genu", *b"ineI", *b"ntel"].map(u32::from_le_bytes)
    });
    *IS_INTEL
}

/// Runs a pass with the widest vectors that this processor has and the setting allows.
pub fn run<P: Pass>(kernel: Kernel, pass: P) -> P::Output {
    match Width::of(kernel) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `Width::of` has asked the processor for these features.
        Width::Avx512 if has_slow_divider() => unsafe { x86::run512_without_divider(pass) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        Width::Avx512 => unsafe { x86::run512(pass) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        Width::Avx2 => unsafe { x86::run256(pass) },
        _ => pass.run::<Pack<f32>>(),
    }
}
