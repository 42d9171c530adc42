//! Springs with limits by slots, and in which range of elongation nothing happens to them.

use super::table::BySlot;
use super::vector::{Half, LANES, Places, Vector, Wide};
use crate::solve::springs::Limit;

/// What springs that yield or break have besides, per slot.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Which spring; one behind the last for none.
    pub springs: Places,
    /// Per slot one bit for each lane whose copy of a spring is the one that counts: that of the lower node.
    pub telling: Vec<u16>,
    /// Rest length and accumulated flow \[m\].
    pub rest: Vec<Wide>,
    pub flow: Vec<Wide>,
    pub ranges: Vec<Range>,
    /// Per set of constants the slack of each lane, see [`slack`]. Empty where no slice is regular.
    pub slacks: Vec<Wide>,
    /// Per part of a slice whether a spring was out of its range in the last pass.
    pub busy: Vec<[bool; 4]>,
    /// Per slice whether it is regular and no spring of it has ever gone beyond its slack, so that all have the rest lengths of
    /// the constants.
    pub untouched: Vec<bool>,
    /// Per slice whether the state does not have yet what has flowed.
    pub unsaved: Vec<bool>,
}

/// The limits of some slices: what a pass changes of them is its own.
pub struct Span<'a> {
    pub springs: &'a Places,
    pub telling: &'a [u16],
    pub slacks: &'a [Wide],
    slots: BySlots<'a>,
    slices: BySlices<'a>,
}

/// Of the slots from one on.
struct BySlots<'a> {
    first: usize,
    rest: &'a mut [Wide],
    flow: &'a mut [Wide],
    ranges: &'a mut [Range],
}

/// Of the slices from one on.
struct BySlices<'a> {
    first: usize,
    busy: &'a mut [[bool; 4]],
    untouched: &'a mut [bool],
    unsaved: &'a mut [bool],
}

/// No spring of a slot flows or breaks while its elongation over its rest length lies between these two; NaN where they are not
/// known.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    least: f32,
    most: f32,
}

/// By how much a spring may be longer or shorter than at rest, at most, while nothing happens to it \[m\], if it has not flowed:
/// less than the law allows by more than the law is rounded.
pub fn slack(limit: &Limit<f32>, stiffness: f32, rest: f32) -> f32 {
    // A quotient 0/0 is of a spring without stiffness, which has no limit; `min` drops it.
    let force = limit.yields.tension.min(limit.yields.compression);
    let most = (force.min(limit.break_force) / stiffness).min(limit.break_length - rest);
    if most < f32::INFINITY {
        most - (1e-5 * most.abs() + 1e-6 * rest.abs())
    } else {
        f32::INFINITY
    }
}

impl Range {
    pub const UNKNOWN: Self = Self {
        least: f32::NAN,
        most: f32::NAN,
    };

    /// What was `within`, or 0 for elongations out of range.
    #[inline(always)]
    pub fn keep<V: Vector>(&self, within: V, elongation: V, rest: V) -> V {
        let [least, most] = [self.least, self.most].map(|x| V::of(x.into()) * rest);
        let within = V::above(most, elongation, within, V::ZERO);
        V::above(elongation, least, within, V::ZERO)
    }

    #[inline(always)]
    pub fn forget(&mut self) {
        *self = Self::UNKNOWN;
    }

    #[inline(always)]
    pub fn is_known(&self) -> bool {
        !self.most.is_nan()
    }
}

impl Limits {
    /// All of them.
    pub fn span(&mut self) -> Span<'_> {
        Span {
            springs: &self.springs,
            telling: &self.telling,
            slacks: &self.slacks,
            slots: BySlots {
                first: 0,
                rest: &mut self.rest,
                flow: &mut self.flow,
                ranges: &mut self.ranges,
            },
            slices: BySlices {
                first: 0,
                busy: &mut self.busy,
                untouched: &mut self.untouched,
                unsaved: &mut self.unsaved,
            },
        }
    }
}

impl<'a> Span<'a> {
    /// What lies before a slice and its first slot, and the others.
    pub fn cut(self, slice: usize, slot: usize) -> [Self; 2] {
        let (slots, slices) = (self.slots, self.slices);
        let (rest, rests) = slots.rest.split_at_mut(slot - slots.first);
        let (flow, flows) = slots.flow.split_at_mut(slot - slots.first);
        let (range, ranges) = slots.ranges.split_at_mut(slot - slots.first);
        let (busy, busies) = slices.busy.split_at_mut(slice - slices.first);
        let (untouched, others) = slices.untouched.split_at_mut(slice - slices.first);
        let (unsaved, rest_unsaved) = slices.unsaved.split_at_mut(slice - slices.first);
        let span = |slots, slices| Self {
            springs: self.springs,
            telling: self.telling,
            slacks: self.slacks,
            slots,
            slices,
        };
        let by_slots = |first, rest, flow, ranges| BySlots {
            first,
            rest,
            flow,
            ranges,
        };
        let by_slices = |first, busy, untouched, unsaved| BySlices {
            first,
            busy,
            untouched,
            unsaved,
        };
        [
            span(
                by_slots(slots.first, rest, flow, range),
                by_slices(slices.first, busy, untouched, unsaved),
            ),
            span(
                by_slots(slot, rests, flows, ranges),
                by_slices(slice, busies, others, rest_unsaved),
            ),
        ]
    }

    /// Whether a spring of a part of a slice was out of its range in the last pass.
    #[inline(always)]
    pub fn is_busy(&self, slice: usize, part: usize) -> bool {
        self.slices.busy[slice - self.slices.first][part]
    }

    #[inline(always)]
    pub fn set_busy(&mut self, slice: usize, part: usize, busy: bool) {
        self.slices.busy[slice - self.slices.first][part] = busy;
    }

    /// Whether a slice is regular and no spring of it has gone beyond its slack.
    #[inline(always)]
    pub fn is_untouched(&self, slice: usize) -> bool {
        self.slices.untouched[slice - self.slices.first]
    }

    #[inline(always)]
    pub fn touch(&mut self, slice: usize) {
        self.slices.untouched[slice - self.slices.first] = false;
    }

    /// Notes that springs of a slice may have flowed.
    #[inline(always)]
    pub fn set_unsaved(&mut self, slice: usize) {
        self.slices.unsaved[slice - self.slices.first] = true;
    }

    /// The rule of springs by slots.
    #[inline(always)]
    pub fn rule(&self) -> BySlot<'_> {
        BySlot {
            first: self.slots.first,
            rest: self.slots.rest,
            ranges: self.slots.ranges,
        }
    }

    #[inline(always)]
    pub fn range(&mut self, slot: usize) -> &mut Range {
        &mut self.slots.ranges[slot - self.slots.first]
    }

    /// Rest lengths of a slot \[m\].
    #[inline(always)]
    pub fn rest(&mut self, slot: usize) -> &mut Wide {
        &mut self.slots.rest[slot - self.slots.first]
    }

    /// Accumulated flow of a slot \[m\].
    #[inline(always)]
    pub fn flow(&mut self, slot: usize) -> &mut Wide {
        &mut self.slots.flow[slot - self.slots.first]
    }

    /// Finds the range of a slot, which lies within what the law allows by more than the law is rounded.
    #[inline(always)]
    pub fn find_range<V: Vector>(&mut self, slot: usize, table: &[Limit<f32>], stiffness: &Wide) {
        let Some(rows) = self.springs.of(table) else {
            return;
        };
        let [mut most, mut least] = [V::of(f64::INFINITY), V::of(f64::NEG_INFINITY)];
        let mut shortest = V::of(f64::INFINITY);
        for part in 0..LANES / V::LANES {
            let limits = rows.slot(slot);
            let [tension, compression, hardening, _] = limits.columns::<V>(part, Half::First);
            let [break_force, break_length, ..] = limits.columns::<V>(part, Half::Second);
            let k = V::load(stiffness, part);
            let rest = V::load(self.rest(slot), part);
            let grown = hardening * V::load(self.flow(slot), part);
            // A quotient 0/0 is of a spring without stiffness, which has no limit; `min` and `max` drop it.
            let longest = ((tension + grown).min(break_force) / k).min(break_length - rest);
            most = (longest / rest).min(most);
            least = (-(compression + grown) / k / rest).max(least);
            shortest = shortest.min(rest);
        }
        let (mut range, mut positive) = ([f32::NEG_INFINITY, f32::INFINITY], true);
        for l in 0..V::LANES {
            range[0] = range[0].max(least.lane(l) as f32);
            range[1] = range[1].min(most.lane(l) as f32);
            positive &= shortest.lane(l) > 0.0;
        }
        let margin = |x: f32| {
            if x.is_finite() {
                1e-5 * x.abs() + 1e-6
            } else {
                0.0
            }
        };
        if positive {
            *self.range(slot) = Range {
                least: range[0] + margin(range[0]),
                most: range[1] - margin(range[1]),
            };
        }
    }
}
