//! Vectors of `f32` of the width the processor has, and the fetching of 32-byte rows into them. **The only unsafe code of the
//! crate.**
//!
//! What is computed is written once, as a [`Pass`] generic over [`Vector`], and compiled for every width; [`run`] picks one at
//! run time, so a build for the baseline processor uses what it finds. The types of the wide vectors are private: code gets at
//! one as the type parameter of `Pass::run` alone, which [`run`] calls after it has asked the processor. Nothing else
//! makes their operations sound, and nothing else is needed, because a processor does not lose an extension.
//!
//! Products are never fused with sums, so every width gives the same bits.

#![allow(unsafe_code)]

use super::Kernel;
use crate::body::state::Particle;
use crate::math::{Number, Pack, Packed};
use crate::solve::forces::Force;
use crate::solve::springs::Limit;
use std::ops::Range;

pub use crate::math::{LANES, Wide};

/// One, four, eight or sixteen `f32`.
pub trait Vector: Packed<f32> {
    /// The larger of it and a number; the number where it is NaN.
    fn at_least(self, least: f32) -> Self;
    /// One bit for each lane that is above the other's; not where one is NaN.
    fn bits_above(self, other: Self) -> u32;
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
    /// Four lanes, without anything that depends on the processor.
    Portable,
    /// Eight lanes: AVX2.
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
        } else if is_x86_feature_detected!("avx2") {
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

/// Runs a pass with the widest vectors that this processor has and the setting allows.
pub fn run<P: Pass>(kernel: Kernel, pass: P) -> P::Output {
    match Width::of(kernel) {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: `Width::of` has asked the processor for these features.
        Width::Avx512 => unsafe { x86::run512(pass) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        Width::Avx2 => unsafe { x86::run256(pass) },
        _ => pass.run::<Pack<f32>>(),
    }
}

impl Vector for Pack<f32> {
    #[inline(always)]
    fn at_least(self, least: f32) -> Self {
        self.max(Self::of(least.into()))
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

/// Eight numbers in 32 aligned bytes, read as two rows of four.
///
/// # Safety
/// The type must be 32 bytes of initialised `f32`, aligned to 32 bytes, and any `f32` must be allowed in each place.
pub unsafe trait Row: Copy {}

/// Checked by the compiler: size and alignment. The types are `repr(C)` and have eight `f32` and nothing else.
macro_rules! row {
    ($t:ty) => {
        // SAFETY: as said above.
        unsafe impl Row for $t {}
        const _: () = assert!(size_of::<$t>() == 32 && align_of::<$t>() == 32);
    };
}
row!(Particle<f32>);
row!(Force<f32>);
row!(Limit<f32>);

/// Which four numbers of a row.
#[derive(Clone, Copy)]
pub enum Half {
    /// The first four.
    First = 0,
    /// The last four.
    Second = 4,
}

/// Indices of rows, [`LANES`] side by side, as offsets in bytes.
#[derive(Clone, Debug, Default)]
pub struct Places {
    offsets: Vec<Offsets>,
    /// Every offset is that of one of so many rows.
    rows: usize,
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Offsets([u32; LANES]);

/// Bytes of a row.
const BYTES: u32 = 32;

impl Places {
    /// Places in tables of at least `rows` rows; `None` if there are more than offsets of 32 bits reach.
    pub fn new(rows: usize) -> Option<Self> {
        (rows <= u32::MAX as usize / BYTES as usize).then_some(Self {
            offsets: Vec::new(),
            rows,
        })
    }

    /// Adds rows, which must be there.
    pub fn push(&mut self, rows: [u32; LANES]) {
        assert!(rows.iter().all(|&r| (r as usize) < self.rows));
        self.offsets.push(Offsets(rows.map(|r| r * BYTES)));
    }

    /// Puts another row, which must be there, in a lane.
    pub fn set(&mut self, slot: usize, lane: usize, row: usize) {
        assert!(row < self.rows);
        self.offsets[slot].0[lane] = row as u32 * BYTES;
    }

    /// The row in a lane.
    #[inline(always)]
    pub fn row(&self, slot: usize, lane: usize) -> usize {
        (self.offsets[slot].0[lane] / BYTES) as usize
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.offsets[..])
    }

    /// These places in a table; `None` if it has too few rows.
    pub fn of<'a, R: Row>(&'a self, rows: &'a [R]) -> Option<Reader<'a, R>> {
        (rows.len() >= self.rows).then_some(Reader {
            offsets: &self.offsets,
            rows,
        })
    }

    /// The same to write to.
    pub fn of_mut<'a, R: Row>(&'a self, rows: &'a mut [R]) -> Option<Writer<'a, R>> {
        (rows.len() >= self.rows).then_some(Writer {
            offsets: &self.offsets,
            rows,
        })
    }
}

/// Rows to read by [`Places`] that are all inside.
#[derive(Clone, Copy)]
pub struct Reader<'a, R> {
    offsets: &'a [Offsets],
    rows: &'a [R],
}

impl<'a, R: Row> Reader<'a, R> {
    /// What a slot has in its lanes.
    #[inline(always)]
    pub fn slot(&self, slot: usize) -> Slot<'a, R> {
        Slot {
            offsets: &self.offsets[slot],
            rows: self.rows,
        }
    }

    /// What some slots have.
    #[inline(always)]
    pub fn slots(&self, slots: Range<usize>) -> impl Iterator<Item = Slot<'a, R>> {
        let rows = self.rows;
        let slots = self.offsets[slots].iter();
        slots.map(move |offsets| Slot { offsets, rows })
    }
}

/// One slot of a [`Reader`].
#[derive(Clone, Copy)]
pub struct Slot<'a, R> {
    offsets: &'a Offsets,
    rows: &'a [R],
}

impl<R: Row> Slot<'_, R> {
    /// Half of the rows of a part, column by column.
    #[inline(always)]
    pub fn columns<V: Vector>(&self, part: usize, half: Half) -> [V; 4] {
        let base = self.rows.as_ptr().cast::<u8>();
        let offsets = &self.offsets.0[part * V::LANES..][..V::LANES];
        // SAFETY: only `Places::push` and `set` write offsets, each that of one of `Places::rows` rows, and the reader
        // was made for at least so many. So the row is inside `rows`; half of it is four numbers (`Row`).
        unsafe {
            V::columns(|l| {
                base.add(offsets[l] as usize)
                    .cast::<f32>()
                    .add(half as usize)
            })
        }
    }

    /// Which row is in a lane.
    #[inline(always)]
    pub fn row(&self, lane: usize) -> usize {
        (self.offsets.0[lane] / BYTES) as usize
    }
}

/// Rows to write by [`Places`] that are all inside.
pub struct Writer<'a, R> {
    offsets: &'a [Offsets],
    rows: &'a mut [R],
}

impl<R: Row> Writer<'_, R> {
    /// Writes half of the rows of a part of a slot. Where two lanes have one row the last counts.
    #[inline(always)]
    pub fn put<V: Vector>(&mut self, slot: usize, part: usize, half: Half, columns: [V; 4]) {
        let base = self.rows.as_mut_ptr().cast::<u8>();
        let offsets = &self.offsets[slot].0[part * V::LANES..][..V::LANES];
        // SAFETY: as in `Slot::columns`; the rows are borrowed for writing, and may hold any numbers (`Row`).
        unsafe {
            V::put_columns(columns, |l| {
                base.add(offsets[l] as usize)
                    .cast::<f32>()
                    .add(half as usize)
            });
        }
    }
}

/// Half of a part of sixteen rows that lie together, column by column.
#[inline(always)]
pub fn columns<V: Vector, R: Row>(rows: &[R; LANES], part: usize, half: Half) -> [V; 4] {
    let rows = &rows[part * V::LANES..][..V::LANES];
    // SAFETY: there is a row for each lane; half of it is four numbers (`Row`).
    unsafe { V::columns(|l| rows.as_ptr().add(l).cast::<f32>().add(half as usize)) }
}

/// Writes half of a part of sixteen rows that lie together.
#[inline(always)]
pub fn put<V: Vector, R: Row>(rows: &mut [R; LANES], part: usize, half: Half, columns: [V; 4]) {
    let rows = rows[part * V::LANES..][..V::LANES].as_mut_ptr();
    // SAFETY: as in `columns`, borrowed for writing.
    unsafe { V::put_columns(columns, |l| rows.add(l).cast::<f32>().add(half as usize)) }
}

/// Part of sixteen times four numbers that lie together, column by column.
#[inline(always)]
pub fn columns_of_four<V: Vector>(rows: &[[f32; 4]; LANES], part: usize) -> [V; 4] {
    let rows = &rows[part * V::LANES..][..V::LANES];
    // SAFETY: there are four numbers for each lane.
    unsafe { V::columns(|l| rows.as_ptr().add(l).cast::<f32>()) }
}

/// Writes part of sixteen times four numbers that lie together.
#[inline(always)]
pub fn put_four<V: Vector>(rows: &mut [[f32; 4]; LANES], part: usize, columns: [V; 4]) {
    let rows = rows[part * V::LANES..][..V::LANES].as_mut_ptr();
    // SAFETY: as in `columns_of_four`, borrowed for writing.
    unsafe { V::put_columns(columns, |l| rows.add(l).cast::<f32>()) }
}

#[cfg(target_arch = "x86_64")]
mod x86;
