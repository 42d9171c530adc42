//! Which copy of a spring counts. Both ends of a spring find the same; that of the lower node tells of it.

use super::vector::LANES;
use std::ops::Range;

/// For so many slots one place is kept.
const STEP: usize = 16;

/// Where a spring was that broke.
const BROKEN: u32 = u32::MAX;

/// The springs of slots, each once.
#[derive(Clone, Debug, Default)]
pub struct Telling {
    /// Per slot one bit for each lane that tells of a spring, broken or not.
    pub lanes: Vec<u16>,
    /// The place of the first spring of every [`STEP`]-th slot.
    firsts: Vec<u32>,
    /// Which they are, by slots and lanes.
    springs: Vec<u32>,
}

impl Telling {
    /// Adds a slot.
    pub fn push(&mut self, springs: [Option<u32>; LANES]) {
        let bits = springs.iter().enumerate();
        let bits = bits.map(|(l, s)| u16::from(s.is_some()) << l);
        if self.lanes.len().is_multiple_of(STEP) {
            self.firsts.push(self.springs.len() as u32);
        }
        self.lanes.push(bits.sum());
        self.springs.extend(springs.iter().flatten());
    }

    /// Slots and lanes that tell of springs which hold, and those springs.
    pub fn of(&self, slots: Range<usize>) -> impl Iterator<Item = (usize, usize, usize)> {
        let springs = match slots.is_empty() {
            true => &[],
            false => &self.springs[self.first(slots.start)..],
        };
        let lanes = slots.flat_map(|slot| {
            let bits = self.lanes[slot];
            let lanes = (0..LANES).filter(move |l| bits >> l & 1 == 1);
            lanes.map(move |lane| (slot, lane))
        });
        let each = lanes.zip(springs).filter(|(_, spring)| **spring != BROKEN);
        each.map(|((slot, lane), &spring)| (slot, lane, spring as usize))
    }

    /// The spring that a lane tells of, if it does and the spring holds.
    pub fn spring(&self, slot: usize, lane: usize) -> Option<u32> {
        let spring = self.springs[self.place(slot, lane)?];
        (spring != BROKEN).then_some(spring)
    }

    /// Takes the spring from a lane that tells of one.
    pub fn take(&mut self, slot: usize, lane: usize) {
        if let Some(place) = self.place(slot, lane) {
            self.springs[place] = BROKEN;
        }
    }

    fn place(&self, slot: usize, lane: usize) -> Option<usize> {
        let bits = self.lanes[slot];
        let before = bits & ((1 << lane) - 1);
        (bits >> lane & 1 == 1).then(|| self.first(slot) + before.count_ones() as usize)
    }

    /// The place of the first spring of a slot.
    fn first(&self, slot: usize) -> usize {
        let step = slot / STEP;
        let before = self.lanes[STEP * step..slot].iter();
        let before: u32 = before.map(|bits| bits.count_ones()).sum();
        (self.firsts[step] + before) as usize
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.lanes[..])
            + size_of_val(&self.firsts[..])
            + size_of_val(&self.springs[..])
    }
}
