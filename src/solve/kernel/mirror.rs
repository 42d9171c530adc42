//! Positions and velocities of all nodes column by column, as the nodes beside those of a regular slice are read.
//!
//! Reading sixteen nodes from anywhere costs sixteen loads and a transposition. Where they follow each other it is three loads,
//! once every node has been transposed for all its neighbours.

use super::table::{End, Table};
use super::vector::{Columns, Half, LANES, Run, Starts, Three, Vector, columns};

/// The nodes by columns, with a margin that means nothing before the first and behind the last.
#[derive(Clone, Debug, Default)]
pub struct Mirror {
    margin: usize,
    pub columns: Columns,
}

impl Mirror {
    /// Of so many slices, of which none looks farther than `farthest` nodes.
    pub fn new(slices: usize, farthest: usize) -> Self {
        Self {
            margin: farthest,
            columns: Columns::new(LANES * slices + 2 * farthest),
        }
    }

    /// No places in it yet; `None` if it is too long.
    pub fn starts(&self, slices: usize) -> Option<Starts> {
        Starts::new(LANES * slices + 2 * self.margin)
    }

    /// Where the nodes so many behind those of a slice begin.
    pub fn start(&self, slice: usize, step: i32) -> usize {
        (self.margin + LANES * slice).wrapping_add_signed(step as isize)
    }

    /// Copies all nodes.
    #[inline(always)]
    pub fn fill<V: Vector, const DAMPED: bool>(&mut self, table: &Table) {
        let together = table.together();
        for (slice, nodes) in together.iter().enumerate() {
            for part in 0..LANES / V::LANES {
                let columns = columns::<V, _>(nodes, part);
                self.put::<V, DAMPED>((slice, part), columns);
            }
        }
        for slice in together.len()..table.slices() {
            let own = table.own(slice);
            for part in 0..LANES / V::LANES {
                let places = own.columns::<V>(part, Half::First);
                let velocities = own.columns::<V>(part, Half::Second);
                self.put::<V, DAMPED>((slice, part), [places, velocities]);
            }
        }
    }

    #[inline(always)]
    fn put<V: Vector, const DAMPED: bool>(
        &mut self,
        (slice, part): (usize, usize),
        [[x, y, z, _], [u, v, w, _]]: [[V; 4]; 2],
    ) {
        let first = self.start(slice, 0) + part * V::LANES;
        self.columns.put(first, Three::First, [x, y, z]);
        if DAMPED {
            self.columns.put(first, Three::Second, [u, v, w]);
        }
    }
}

impl<V: Vector> End<V> for Run<'_> {
    #[inline(always)]
    fn place(&self, part: usize) -> [V; 3] {
        self.three(Three::First, part)
    }

    #[inline(always)]
    fn velocity(&self, part: usize) -> [V; 3] {
        self.three(Three::Second, part)
    }
}
