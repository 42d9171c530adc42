//! What the table of springs and the state tell each other.

use super::ranges::CALM;
use super::sell::{Layout, Sell, least_length};
use super::vector::LANES;
use crate::body::state::State;
use crate::solve::springs::Link;

impl Sell {
    /// Writes to the state what has flowed since the last time.
    pub(crate) fn write_back(&mut self, state: &mut State<f32>) {
        let Some(limits) = &mut self.limits else {
            return;
        };
        let unsaved = limits.unsaved.iter_mut().enumerate();
        for (slice, unsaved) in unsaved.filter(|(_, unsaved)| **unsaved) {
            *unsaved = false;
            for (slot, lane, spring) in limits.telling.of(self.layout.slots(slice)) {
                state.rest[spring] = limits.rest[slot].0[lane];
                state.flow[spring] = limits.flow[slot].0[lane];
            }
        }
    }

    /// Takes all force from a spring that has limits, and writes to the state how it was.
    pub(crate) fn cut(&mut self, (spring, link): (usize, &Link<f32>), state: &mut State<f32>) {
        let Some(limits) = &mut self.limits else {
            return;
        };
        let ends = [link.a.min(link.b), link.a.max(link.b)];
        // Springs between the same two nodes have the same order at both.
        let telling = &limits.telling;
        let tells =
            |&(slot, lane): &(usize, usize)| telling.spring(slot, lane) == Some(spring as u32);
        let Some(which) = self.layout.between(ends).position(|at| tells(&at)) else {
            return;
        };
        for ends in [ends, [ends[1], ends[0]]] {
            let Some((slot, lane)) = self.layout.between(ends).nth(which) else {
                continue;
            };
            state.rest[spring] = limits.rest[slot].0[lane];
            state.flow[spring] = limits.flow[slot].0[lane];
            limits.telling.take(slot, lane);
            limits.rest[slot].0[lane] = least_length();
            limits.flow[slot].0[lane] = 0.0;
            self.layout.far.set(slot, lane, ends[0] as usize);
            let slice = self.layout.rows[ends[0] as usize] as usize / LANES;
            limits.busy[slice] = [CALM; 4];
            limits.untouched[slice] = false;
            if let Some(regular) = self.layout.regular.get_mut(slice) {
                *regular = false;
            }
        }
    }
}

impl Layout {
    /// The slots and lanes of the springs from one node to another which hold.
    fn between(&self, [from, to]: [u32; 2]) -> impl Iterator<Item = (usize, usize)> {
        let row = self.rows[from as usize] as usize;
        let lane = row % LANES;
        let slots = self.slots(row / LANES);
        slots
            .map(move |slot| (slot, lane))
            .filter(move |&(slot, lane)| self.far.row(slot, lane) == to as usize)
    }
}
