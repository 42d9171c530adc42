//! The shortest way from a point in a cell of a grid to other cells.

use super::primitive;
use crate::math::DVec3;
use rapier3d::math::IVector;

/// The bit of the cell itself.
pub const SELF: u32 = 1 << 13;
/// The neighbours across faces.
const FACES: u32 = 1 << 4 | 1 << 10 | 1 << 12 | 1 << 14 | 1 << 16 | 1 << 22;
/// The seven neighbours around each corner of a cell: bits 0 to 2 of the index say whether the corner is the upper one.
const OCTANTS: [u32; 8] = {
    let mut masks = [0; 8];
    let mut i = 0;
    while i < 64 {
        let (corner, step) = (i / 8, i % 8);
        let mut bit = 13;
        let mut axis = 0;
        let mut weight = 1;
        while axis < 3 {
            if step >> axis & 1 == 1 {
                bit = if corner >> axis & 1 == 1 {
                    bit + weight
                } else {
                    bit - weight
                };
            }
            axis += 1;
            weight *= 3;
        }
        if step != 0 {
            masks[corner] |= 1 << bit;
        }
        i += 1;
    }
    masks
};

/// The chunk of a cell and the cell's place in it.
#[inline]
pub fn place(cell: IVector) -> (IVector, usize) {
    let key = IVector::new(cell.x >> 3, cell.y >> 3, cell.z >> 3);
    (
        key,
        ((cell.x & 7) | (cell.y & 7) << 3 | (cell.z & 7) << 6) as usize,
    )
}

/// Sorts keys.
pub fn order(key: IVector) -> (i32, i32, i32) {
    (key.x, key.y, key.z)
}

/// All steps of up to `range` cells.
pub fn neighbours(range: i32) -> impl Iterator<Item = IVector> {
    let all = move || -range..=range;
    all().flat_map(move |x| all().flat_map(move |y| all().map(move |z| IVector::new(x, y, z))))
}

/// Whether a cell with these neighbours shows no side: it is empty, or filled cells lie across all of its faces.
pub fn is_hidden(near: u32) -> bool {
    near & SELF == 0 || near & FACES == FACES
}

/// The bit of a neighbour.
pub fn bit(step: IVector) -> u32 {
    1 << ((step.x + 1) + 3 * (step.y + 1) + 9 * (step.z + 1))
}

/// The way to the nearest cell of a kind.
pub struct Way {
    /// Its length, squared \[m²\].
    pub square: f64,
    step: DVec3,
    /// The cell's direction, for a way of no length.
    towards: IVector,
}

impl Way {
    /// To nowhere.
    pub fn none() -> Self {
        Self {
            square: f64::INFINITY,
            step: DVec3::ZERO,
            towards: IVector::Y,
        }
    }

    /// Looks at the neighbours whose bits are set: those across the three near faces, those between them, and the rest
    /// only as long as they could be nearer.
    #[inline]
    pub fn try_neighbours(&mut self, wanted: u32, low: DVec3, high: DVec3) {
        let side = low.cmpge(high).bitmask() as usize;
        let near = wanted & OCTANTS[side];
        self.try_bits(near & FACES, low, high);
        let nearest = low.min(high).min_element();
        if self.square <= nearest * nearest {
            return;
        }
        self.try_bits(near & !FACES, low, high);
        let farther = low.max(high).min_element();
        if self.square <= farther * farther {
            return;
        }
        self.try_bits(wanted & !OCTANTS[side], low, high);
    }

    #[inline]
    fn try_bits(&mut self, mut bits: u32, low: DVec3, high: DVec3) {
        while bits != 0 {
            let i = bits.trailing_zeros() as i32;
            bits &= bits - 1;
            let step = IVector::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
            self.try_cell(step, low, high, DVec3::ZERO);
        }
    }

    /// Looks at the cell `cell` steps away; `size` is a cell's, which neighbours do not need.
    #[inline]
    pub fn try_cell(&mut self, cell: IVector, low: DVec3, high: DVec3, size: DVec3) {
        let along = |n: i32, low: f64, high: f64, size: f64| match n {
            0 => 0.0,
            n if n > 0 => high + f64::from(n - 1) * size,
            n => -low + f64::from(n + 1) * size,
        };
        let step = DVec3::new(
            along(cell.x, low.x, high.x, size.x),
            along(cell.y, low.y, high.y, size.y),
            along(cell.z, low.z, high.z, size.z),
        );
        let square = step.length_squared();
        if square < self.square {
            *self = Self {
                square,
                step,
                towards: cell,
            };
        }
    }

    /// Along the way (`side` 1) or against it (−1).
    pub fn normal(&self, side: f64) -> DVec3 {
        let fallback = self.towards.as_dvec3().try_normalize().unwrap_or(DVec3::Y);
        primitive::direction(self.step, fallback).1 * side
    }
}
