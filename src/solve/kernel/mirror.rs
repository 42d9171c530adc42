//! Positions, and velocities or swings, of all nodes column by column, as the nodes of a regular slice and those beside
//! them are read.
//!
//! Reading sixteen nodes from anywhere costs sixteen loads and a transposition. Where they follow each other it is three loads,
//! once every node has been transposed for all its neighbours.

use super::SLICES;
use super::table::{End, Table};
use super::vector::{Columns, Half, LANES, Pass, Run, Span, Starts, Three, Vector, columns};
use crate::solve::threads::Work;
use std::ops::Range;

/// The nodes by columns, with a margin that means nothing before the first and behind the last.
#[derive(Clone, Debug, Default)]
pub struct Mirror {
    margin: usize,
    pub columns: Columns,
}

impl Mirror {
    /// Of so many slices, of which none looks farther than `farthest` nodes. Each begins at a sixteenth place.
    pub fn new(slices: usize, farthest: usize) -> Self {
        let margin = farthest.next_multiple_of(LANES);
        Self {
            margin,
            columns: Columns::new(LANES * slices + 2 * margin),
        }
    }

    /// No places in it yet; `None` if it is too long.
    pub fn starts(&self) -> Option<Starts> {
        Starts::new(&self.columns)
    }

    /// Where the nodes so many behind those of a slice begin.
    pub fn start(&self, slice: usize, step: i32) -> usize {
        (self.margin + LANES * slice).wrapping_add_signed(step as isize)
    }

    /// What copies the places of all nodes, and what else is wanted.
    pub fn copying<'a>(&'a mut self, table: Table<'a>, copied: Copied) -> Copying<'a> {
        Copying {
            copied,
            slices: 0..table.slices(),
            margin: self.margin,
            columns: self.columns.span(),
            table,
        }
    }
}

/// What is copied besides places, to the three columns behind them.
#[derive(Clone, Copy)]
pub enum Copied {
    Nothing,
    Velocities,
    /// The same to each of the three.
    Swings,
}

/// Copies the nodes of some slices.
pub struct Copying<'a> {
    table: Table<'a>,
    slices: Range<usize>,
    margin: usize,
    columns: Span<'a>,
    copied: Copied,
}

impl Work for Copying<'_> {
    fn blocks(&self) -> usize {
        self.slices.len().div_ceil(SLICES)
    }

    fn cut(self, at: usize) -> [Self; 2] {
        let middle = self.slices.start + SLICES * at;
        let columns = self.columns.cut(self.margin + LANES * middle);
        let mut slices = [self.slices.start..middle, middle..self.slices.end].into_iter();
        columns.map(|columns| Self {
            slices: slices.next().unwrap_or_default(),
            columns,
            ..self
        })
    }
}

impl Pass for Copying<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector>(self) {
        match self.copied {
            Copied::Nothing => self.copy::<V, false, false>(),
            Copied::Velocities => self.copy::<V, true, false>(),
            Copied::Swings => self.copy::<V, false, true>(),
        }
    }
}

impl Copying<'_> {
    #[inline(always)]
    fn copy<V: Vector, const VELOCITIES: bool, const SWINGS: bool>(mut self) {
        let together = self.table.together();
        for slice in self.slices.clone() {
            for part in 0..LANES / V::LANES {
                let columns = match together.get(slice) {
                    Some(nodes) => columns::<V, _>(nodes, part),
                    None => {
                        let own = self.table.own(slice);
                        let first = own.columns::<V>(part, Half::First);
                        [first, own.columns::<V>(part, Half::Second)]
                    }
                };
                self.put::<V, VELOCITIES, SWINGS>((slice, part), columns);
            }
        }
    }

    #[inline(always)]
    fn put<V: Vector, const VELOCITIES: bool, const SWINGS: bool>(
        &mut self,
        (slice, part): (usize, usize),
        [[x, y, z, _], [u, v, w, swing]]: [[V; 4]; 2],
    ) {
        let first = self.margin + LANES * slice + part * V::LANES;
        self.columns.put(first, Three::First, [x, y, z]);
        if VELOCITIES {
            self.columns.put(first, Three::Second, [u, v, w]);
        }
        if SWINGS {
            self.columns.put(first, Three::Second, [swing; 3]);
        }
    }
}

impl<V: Vector> End<V> for Run<'_> {
    const STRAYS: bool = true;

    #[inline(always)]
    fn place(&self, part: usize) -> [V; 3] {
        self.three(Three::First, part)
    }

    #[inline(always)]
    fn velocity(&self, part: usize) -> [V; 3] {
        self.three(Three::Second, part)
    }

    #[inline(always)]
    fn swing(&self, part: usize) -> V {
        let [swing, ..] = self.three(Three::Second, part);
        swing
    }
}
