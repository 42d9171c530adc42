//! Rows of eight or four numbers, fetched and written column by column at places that are known to be inside.

use super::{LANES, Vector};
use crate::body::state::Particle;
use crate::solve::forces::Lanes;
use crate::solve::stable::Rates;
use std::marker::PhantomData;
use std::ops::Range;

/// A row of `f32` and nothing else.
///
/// # Safety
/// The type must be 32 >> [`Self::HALVED`] bytes of initialised `f32`, and any `f32` must be allowed in each place.
pub unsafe trait Row: Copy {
    /// 0 for eight numbers, 1 for four.
    const HALVED: u32;
}

/// Eight numbers, read as two rows of four.
///
/// # Safety
/// As for a [`Row`] that is not halved.
pub unsafe trait Whole: Row {}

/// Checked by the compiler: the size. The types are `repr(C)` and have eight `f32` and nothing else.
macro_rules! whole {
    ($t:ty) => {
        // SAFETY: as said above.
        unsafe impl Row for $t {
            const HALVED: u32 = 0;
        }
        // SAFETY: as said above.
        unsafe impl Whole for $t {}
        const _: () = assert!(size_of::<$t>() == 32);
    };
}
whole!(Particle<f32>);
whole!(Rates<f32>);

// SAFETY: four `f32`.
unsafe impl Row for Lanes<f32> {
    const HALVED: u32 = 1;
}

/// Which four numbers of a row.
#[derive(Clone, Copy)]
pub enum Half {
    /// The first four.
    First = 0,
    /// The last four.
    Second = 4,
}

/// Indices of rows, [`LANES`] side by side, as offsets in bytes of rows of eight numbers.
#[derive(Clone, Debug, Default)]
pub struct Places {
    offsets: Vec<Offsets>,
    /// Every offset is that of one of so many rows.
    rows: usize,
    /// Of places to write to, per row whether a slot has it. No two slots have the same then.
    taken: Option<Vec<bool>>,
}

#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Offsets([u32; LANES]);

/// Bytes of a row of eight numbers.
const BYTES: u32 = 32;

impl Places {
    /// Places in tables of at least `rows` rows; `None` if there are more than offsets of 32 bits reach.
    pub fn new(rows: usize) -> Option<Self> {
        (rows <= u32::MAX as usize / BYTES as usize).then_some(Self {
            offsets: Vec::new(),
            rows,
            taken: None,
        })
    }

    /// The same of which no two slots have the same row, so that slots can be written at once.
    pub fn distinct(rows: usize) -> Option<Self> {
        let places = Self::new(rows)?;
        let taken = Some(vec![false; rows]);
        Some(Self { taken, ..places })
    }

    /// Adds rows, which must be there, and not in another slot where those are distinct.
    pub fn push(&mut self, rows: [u32; LANES]) {
        assert!(rows.iter().all(|&r| (r as usize) < self.rows));
        if let Some(taken) = &mut self.taken {
            assert!(rows.iter().all(|&r| !taken[r as usize]));
            rows.iter().for_each(|&r| taken[r as usize] = true);
        }
        self.offsets.push(Offsets(rows.map(|r| r * BYTES)));
    }

    /// Puts another row, which must be there, in a lane of slots that are not distinct.
    pub fn set(&mut self, slot: usize, lane: usize, row: usize) {
        assert!(row < self.rows && self.taken.is_none());
        self.offsets[slot].0[lane] = row as u32 * BYTES;
    }

    /// The row in a lane.
    #[inline(always)]
    pub fn row(&self, slot: usize, lane: usize) -> usize {
        (self.offsets[slot].0[lane] / BYTES) as usize
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let taken = self.taken.as_deref().unwrap_or_default();
        size_of_val(&self.offsets[..]) + size_of_val(taken)
    }

    /// These places in a table; `None` if it has too few rows.
    pub fn of<'a, R: Row>(&'a self, rows: &'a [R]) -> Option<Reader<'a, R>> {
        (rows.len() >= self.rows).then_some(Reader {
            offsets: &self.offsets,
            rows,
        })
    }

    /// The same to write to; `None` as well if slots are not distinct.
    pub fn of_mut<'a, R: Row>(&'a self, rows: &'a mut [R]) -> Option<Writer<'a, R>> {
        (rows.len() >= self.rows && self.taken.is_some()).then_some(Writer {
            offsets: &self.offsets,
            rows: rows.as_mut_ptr(),
            borrowed: PhantomData,
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

impl<R: Whole> Slot<'_, R> {
    /// Half of the rows of a part, column by column.
    #[inline(always)]
    pub fn columns<V: Vector>(&self, part: usize, half: Half) -> [V; 4] {
        let base = self.rows.as_ptr().cast::<u8>();
        let offsets = &self.offsets.0[part * V::LANES..][..V::LANES];
        // SAFETY: only `Places::push` and `set` write offsets, each that of one of `Places::rows` rows, and the reader
        // was made for at least so many. So the row is inside `rows`; half of it is four numbers (`Whole`).
        unsafe {
            V::columns(|l| {
                base.add(offsets[l] as usize)
                    .cast::<f32>()
                    .add(half as usize)
            })
        }
    }
}

/// Rows to write by [`Places`] that are all inside, no two slots the same ones.
pub struct Writer<'a, R> {
    offsets: &'a [Offsets],
    /// Of the places' table, as long as they ask for.
    rows: *mut R,
    borrowed: PhantomData<&'a mut [R]>,
}

// SAFETY: it writes rows that are borrowed for it, those of its own slots, which no other writer has (`Writer::cut`).
unsafe impl<R: Row + Send> Send for Writer<'_, R> {}

impl<R: Row> Writer<'_, R> {
    /// The first so many slots, and the others.
    pub fn cut(self, at: usize) -> [Self; 2] {
        // Each slot goes to one of the two, and no two slots have the same row (`Places::distinct`).
        let (first, rest) = self.offsets.split_at(at.min(self.offsets.len()));
        [first, rest].map(|offsets| Self { offsets, ..self })
    }

    /// Writes the first four numbers of the rows of a part of a slot. Where two lanes have one row the last counts.
    #[inline(always)]
    pub fn put<V: Vector>(&mut self, slot: usize, part: usize, columns: [V; 4]) {
        let base = self.rows.cast::<u8>();
        let offsets = &self.offsets[slot].0[part * V::LANES..][..V::LANES];
        // SAFETY: as in `Slot::columns`, with rows of half as many bytes where they are halved (`Row`); they are borrowed for
        // writing, by nobody else (see `cut`), and may hold any numbers.
        unsafe {
            V::put_columns(columns, |l| {
                base.add((offsets[l] >> R::HALVED) as usize).cast::<f32>()
            });
        }
    }
}

/// Both halves of a part of sixteen rows that lie together, column by column.
#[inline(always)]
pub fn columns<V: Vector, R: Whole>(rows: &[R; LANES], part: usize) -> [[V; 4]; 2] {
    let rows = &rows[part * V::LANES..][..V::LANES];
    // SAFETY: there is a row for each lane, and each is eight numbers (`Whole`).
    unsafe { V::columns_of_eight(rows.as_ptr().cast()) }
}

/// The numbers of sixteen rows that lie together.
#[inline(always)]
pub fn numbers<R: Whole>(rows: &[R; LANES]) -> &[f32; 8 * LANES] {
    // SAFETY: each row is eight numbers (`Whole`).
    unsafe { &*std::ptr::from_ref(rows).cast() }
}

/// The same to write to.
#[inline(always)]
pub fn numbers_mut<R: Whole>(rows: &mut [R; LANES]) -> &mut [f32; 8 * LANES] {
    // SAFETY: as in `numbers`, borrowed for writing; any numbers are allowed in them.
    unsafe { &mut *std::ptr::from_mut(rows).cast() }
}

/// Writes part of sixteen times four numbers that lie together.
#[inline(always)]
pub fn put_four<V: Vector>(rows: &mut [[f32; 4]; LANES], part: usize, columns: [V; 4]) {
    let rows = &mut rows[part * V::LANES..][..V::LANES];
    // SAFETY: there are four numbers for each lane, borrowed for writing.
    unsafe { V::put_four(columns, rows.as_mut_ptr().cast()) }
}
