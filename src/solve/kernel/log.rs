//! What happens to springs at their limits for the first and the last time, kept until all threads are done.

use super::SLICES;
use super::sell::Layout;
use crate::solve::forces::LimitEvent;

/// What happened to a spring.
#[derive(Clone, Copy, Debug, Default)]
pub struct Entry {
    pub spring: u32,
    /// Whether it has flowed for the first time, and whether it broke.
    pub yielded: bool,
    pub broke: bool,
    /// \[N\].
    pub tension: f32,
    /// \[J\].
    pub energy: f32,
}

impl Entry {
    /// The events that it stands for.
    pub fn tell(&self, events: &mut Vec<LimitEvent<f32>>) {
        for (happened, broke) in [(self.yielded, false), (self.broke, true)] {
            if happened {
                events.push(LimitEvent {
                    spring: self.spring,
                    broke,
                    tension: self.tension,
                    energy: self.energy,
                });
            }
        }
    }
}

/// Entries by blocks of slices, with places for as many as a block can have.
#[derive(Clone, Debug, Default)]
pub struct Log {
    entries: Vec<Entry>,
    /// Where those of each block begin, and the end.
    pub firsts: Vec<usize>,
}

impl Log {
    /// Makes the places, once: `telling` has per slot a bit for each spring that may have an entry.
    pub fn prepare(&mut self, layout: &Layout, telling: &[u16]) {
        if !self.firsts.is_empty() {
            return;
        }
        let slices = layout.slices();
        let (mut firsts, mut sum) = (vec![0], 0);
        for first in (0..slices).step_by(SLICES) {
            let last = slices.min(first + SLICES) - 1;
            let slots = layout.slots(first).start..layout.slots(last).end;
            let bits = telling[slots].iter().map(|t| t.count_ones() as usize);
            sum += bits.sum::<usize>();
            firsts.push(sum);
        }
        self.firsts = firsts;
        self.entries = vec![Entry::default(); sum];
    }

    /// All of it, to be written.
    pub fn part(&mut self) -> Part<'_> {
        Part {
            entries: &mut self.entries,
            firsts: &self.firsts,
            used: 0,
        }
    }

    /// The first so many entries of a block.
    pub fn of_block(&self, block: usize, count: usize) -> &[Entry] {
        &self.entries[self.firsts[block]..][..count]
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.entries[..]) + size_of_val(&self.firsts[..])
    }
}

/// The entries of some blocks.
pub struct Part<'a> {
    entries: &'a mut [Entry],
    firsts: &'a [usize],
    used: usize,
}

impl Part<'_> {
    pub fn cut(self, at: usize) -> [Self; 2] {
        let (entries, rest) = self.entries.split_at_mut(self.firsts[at] - self.firsts[0]);
        let part = |entries, firsts| Part {
            entries,
            firsts,
            used: 0,
        };
        [
            part(entries, &self.firsts[..=at]),
            part(rest, &self.firsts[at..]),
        ]
    }

    /// Begins with one of its blocks.
    pub fn begin(&mut self, block: usize) {
        self.used = self.firsts[block] - self.firsts[0];
    }

    /// Adds an entry to the block.
    #[inline(always)]
    pub fn push(&mut self, entry: Entry) {
        self.entries[self.used] = entry;
        self.used += 1;
    }

    /// How many entries one of its blocks has been given.
    pub fn count(&self, block: usize) -> usize {
        self.used - (self.firsts[block] - self.firsts[0])
    }
}
