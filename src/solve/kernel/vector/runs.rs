//! Numbers of nodes column by column, read sixteen at a time from places that are known to be inside.

use super::{LANES, Vector, Wide};
use std::ops::Range;

/// Six columns of as many numbers: places, and velocities or swings.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// In lines of the cache: what begins at a sixteenth place is read from one of them.
    numbers: Vec<Wide>,
    /// Of a column, a multiple of sixteen.
    length: usize,
}

/// Which three columns.
#[derive(Clone, Copy)]
pub enum Three {
    /// Places.
    First = 0,
    /// Velocities, or what else was copied.
    Second = 3,
}

impl Columns {
    /// Zeros, at least so many in a column.
    pub fn new(length: usize) -> Self {
        let lines = length.div_ceil(LANES);
        Self {
            numbers: vec![Wide([0.0; LANES]); 6 * lines],
            length: LANES * lines,
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.numbers[..])
    }

    /// All of it, to be written.
    pub fn span(&mut self) -> Span<'_> {
        let lines = (self.length / LANES).max(1);
        let mut columns = self.numbers.chunks_exact_mut(lines);
        Span {
            columns: std::array::from_fn(|_| numbers_of(columns.next().unwrap_or_default())),
            first: 0,
        }
    }
}

/// The numbers of lines, one behind the other.
fn numbers_of(lines: &mut [Wide]) -> &mut [f32] {
    // SAFETY: a line is sixteen numbers without padding (`repr(C)`), all of them borrowed for writing.
    unsafe { std::slice::from_raw_parts_mut(lines.as_mut_ptr().cast(), LANES * lines.len()) }
}

/// Columns to be written, from a place on.
pub struct Span<'a> {
    columns: [&'a mut [f32]; 6],
    first: usize,
}

impl Span<'_> {
    /// What lies before a place, and the rest.
    pub fn cut(self, at: usize) -> [Self; 2] {
        let mut rest: [&mut [f32]; 6] = Default::default();
        let mut columns = self.columns;
        for (column, rest) in columns.iter_mut().zip(&mut rest) {
            (*column, *rest) = std::mem::take(column).split_at_mut(at - self.first);
        }
        let before = Self {
            columns,
            first: self.first,
        };
        let rest = Self {
            columns: rest,
            first: at,
        };
        [before, rest]
    }

    /// Writes three columns from a place on.
    #[inline(always)]
    pub fn put<V: Vector>(&mut self, from: usize, which: Three, values: [V; 3]) {
        for (k, value) in values.into_iter().enumerate() {
            value.store_to(&mut self.columns[which as usize + k][from - self.first..]);
        }
    }
}

/// Places in columns from which on sixteen numbers are read.
#[derive(Clone, Debug, Default)]
pub struct Starts {
    starts: Vec<u32>,
    /// All sixteen are inside columns of this length.
    length: usize,
}

impl Starts {
    /// No places in such columns yet; `None` if they are too long for numbers of 32 bits.
    pub fn new(columns: &Columns) -> Option<Self> {
        (columns.length <= u32::MAX as usize).then_some(Self {
            starts: Vec::new(),
            length: columns.length,
        })
    }

    /// Adds a place, which must be there.
    pub fn push(&mut self, start: usize) {
        assert!(start + LANES <= self.length);
        self.starts.push(start as u32);
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..])
    }

    /// These places in columns; `None` if those are not of the length.
    pub fn of<'a>(&'a self, columns: &'a Columns) -> Option<Runs<'a>> {
        (columns.length == self.length).then_some(Runs {
            starts: &self.starts,
            columns,
        })
    }
}

/// Columns to read by [`Starts`] that are all inside.
#[derive(Clone, Copy)]
pub struct Runs<'a> {
    starts: &'a [u32],
    columns: &'a Columns,
}

impl<'a> Runs<'a> {
    /// What one slot has, if there is one.
    #[inline(always)]
    pub fn slot(&self, slot: usize) -> Option<Run<'a>> {
        let columns = self.columns;
        let start = self.starts.get(slot)?;
        Some(Run {
            start: *start,
            columns,
        })
    }

    /// What some slots have.
    #[inline(always)]
    pub fn slots(&self, slots: Range<usize>) -> impl Iterator<Item = Run<'a>> + use<'a> {
        let columns = self.columns;
        let starts = self.starts[slots].iter();
        starts.map(move |&start| Run { start, columns })
    }
}

/// Sixteen numbers of each column.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    start: u32,
    columns: &'a Columns,
}

impl Run<'_> {
    /// A part of three columns.
    #[inline(always)]
    pub fn three<V: Vector>(&self, which: Three, part: usize) -> [V; 3] {
        assert!(part < LANES / V::LANES);
        let length = self.columns.length;
        let first = which as usize * length + self.start as usize + part * V::LANES;
        // SAFETY: only `Starts::push` writes starts, each with sixteen numbers behind it in columns of `Starts::length`, and
        // `Starts::of` found these to be of that length. So are the numbers of this part in every one of the six columns that
        // there are, and `which` and the two behind it are below six.
        unsafe {
            [
                self.load(first),
                self.load(first + length),
                self.load(first + 2 * length),
            ]
        }
    }

    /// # Safety
    /// There must be as many numbers as the vector has lanes from this place on.
    #[inline(always)]
    unsafe fn load<V: Vector>(&self, from: usize) -> V {
        // SAFETY: the caller's.
        unsafe {
            let from = self.columns.numbers.as_ptr().cast::<f32>().add(from);
            V::load_from(std::slice::from_raw_parts(from, V::LANES))
        }
    }
}
