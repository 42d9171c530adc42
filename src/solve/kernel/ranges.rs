//! Springs with limits by slots, and in which range of elongation nothing happens to them.

use super::palette::Palette;
use super::table::BySlot;
use super::telling::Telling;
use super::vector::{LANES, Vector, Wide, Width};
use crate::solve::springs::Limit;

/// What springs that yield or break have besides, per slot.
#[derive(Clone, Debug)]
pub struct Limits {
    pub palette: Palette,
    pub telling: Telling,
    /// Rest length and accumulated flow \[m\].
    pub rest: Vec<Wide>,
    pub flow: Vec<Wide>,
    pub ranges: Vec<Ranges>,
    /// Per set of constants the slack of each lane, see [`slack`]. Empty where no slice is regular.
    pub slacks: Vec<Wide>,
    /// For which width parts of slices, and ranges, are what they are: at another one all are busy that were ever touched.
    pub width: Option<Width>,
    /// Per part of a slice how many substeps in which nothing flows are to come before its springs have ranges again.
    pub busy: Vec<[u8; 4]>,
    /// Per slice whether no spring of it has ever gone beyond its slack, so that in a regular one all have the rest lengths of the
    /// constants.
    pub untouched: Vec<bool>,
    /// Per slice whether the state does not have yet what has flowed.
    pub unsaved: Vec<bool>,
}

/// The limits of some slices: what a pass changes of them is its own.
pub struct Span<'a> {
    pub palette: &'a Palette,
    pub telling: &'a Telling,
    pub slacks: &'a [Wide],
    slots: BySlots<'a>,
    slices: BySlices<'a>,
}

/// Of the slots from one on.
struct BySlots<'a> {
    first: usize,
    rest: &'a mut [Wide],
    flow: &'a mut [Wide],
    ranges: &'a mut [Ranges],
}

/// Of the slices from one on.
struct BySlices<'a> {
    first: usize,
    busy: &'a mut [[u8; 4]],
    untouched: &'a mut [bool],
    unsaved: &'a mut [bool],
}

/// No spring of half a slot flows or breaks while its elongation over its rest length lies between these two, by halves; of the
/// whole slot where it is not cut into parts. NaN where that is not known, and without meaning where the part of the slice
/// is busy. Of a slice that is not regular and untouched the second is the least slack \[m\].
#[derive(Clone, Copy, Debug)]
pub struct Ranges {
    least: [f32; 2],
    most: [f32; 2],
}

/// In which half of a slot a part lies.
#[inline(always)]
pub fn half<V: Vector>(part: usize) -> usize {
    part * V::LANES / (LANES / 2)
}

/// After so many substeps in which nothing flows a part of a slice is calm: a range costs about two passes to find.
pub const CALM: u8 = 8;

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

impl Ranges {
    pub const UNKNOWN: Self = Self {
        least: [f32::NAN; 2],
        most: [f32::NAN; 2],
    };

    /// Of springs that have never gone beyond these slacks \[m\].
    pub fn of_slacks(slacks: &Wide) -> Self {
        let least = |lanes: &[f32]| lanes.iter().copied().fold(f32::INFINITY, f32::min);
        let (first, second) = slacks.0.split_at(LANES / 2);
        Self {
            most: [least(first), least(second)],
            ..Self::UNKNOWN
        }
    }

    /// The least slack of a part of an untouched slot \[m\].
    #[inline(always)]
    pub fn slack<V: Vector>(&self, part: usize) -> V {
        let [first, second] = self.most;
        let least = if V::LANES == LANES {
            first.min(second)
        } else {
            self.most[half::<V>(part)]
        };
        V::of(least.into())
    }

    /// Of the lanes of a part that were `within`, those whose elongation is in range.
    #[inline(always)]
    pub fn keep<V: Vector>(&self, part: usize, within: V::Mask, elongation: V, rest: V) -> V::Mask {
        let half = half::<V>(part);
        let least = V::of(self.least[half].into()) * rest;
        let most = V::of(self.most[half].into()) * rest;
        elongation.also_above(least, most.also_above(elongation, within))
    }
}

impl Limits {
    /// Whether any of the regular slices is not what it was at first. Only then are velocities asked of the mirror.
    pub fn any_touched(&self, regular: &[bool]) -> bool {
        let mut slices = self.untouched.iter().zip(regular);
        slices.any(|(untouched, regular)| *regular && !*untouched)
    }

    /// All of them, for a pass of this width.
    pub fn span(&mut self, width: Width) -> Span<'_> {
        if self.width.replace(width) != Some(width) {
            let slices = self.busy.iter_mut().zip(&self.untouched);
            for (busy, _) in slices.filter(|(_, untouched)| !**untouched) {
                *busy = [CALM; 4];
            }
        }
        Span {
            palette: &self.palette,
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
            palette: self.palette,
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

    /// Whether springs of a part of a slice have no ranges, because some have flowed lately or been out of theirs.
    #[inline(always)]
    pub fn is_busy(&self, slice: usize, part: usize) -> bool {
        self.slices.busy[slice - self.slices.first][part] > 0
    }

    /// Notes whether nothing flowed or broke, and says whether springs are to have ranges from now on.
    #[inline(always)]
    pub fn calm(&mut self, slice: usize, part: usize, quiet: bool) -> bool {
        let busy = &mut self.slices.busy[slice - self.slices.first][part];
        // What was out of its range though nothing flowed would be so again.
        *busy = if quiet && *busy > 0 { *busy - 1 } else { CALM };
        *busy == 0
    }

    /// Whether no spring of a slice has gone beyond its slack.
    #[inline(always)]
    pub fn is_untouched(&self, slice: usize) -> bool {
        self.slices.untouched[slice - self.slices.first]
    }

    /// Notes that it is so no longer.
    #[inline(always)]
    pub fn touch(&mut self, slice: usize) {
        let slice = slice - self.slices.first;
        if std::mem::take(&mut self.slices.untouched[slice]) {
            self.slices.busy[slice] = [CALM; 4];
        }
    }

    /// Notes that springs of a slice may have flowed.
    #[inline(always)]
    pub fn set_unsaved(&mut self, slice: usize) {
        self.slices.unsaved[slice - self.slices.first] = true;
    }

    /// The rule of springs by slots, of untouched slices or of others.
    #[inline(always)]
    pub fn rule<const UNTOUCHED: bool>(&self) -> BySlot<'_, UNTOUCHED> {
        BySlot {
            first: self.slots.first,
            rest: self.slots.rest,
            ranges: self.slots.ranges,
        }
    }

    /// Rest lengths and accumulated flows of slots \[m\], to write to, and which set of limits is theirs.
    #[inline(always)]
    pub fn memory(
        &mut self,
        slots: std::ops::Range<usize>,
    ) -> impl Iterator<Item = (&mut Wide, &mut Wide, usize)> {
        let own = slots.start - self.slots.first..slots.end - self.slots.first;
        let sets = self.palette.sets(slots);
        let rest = self.slots.rest[own.clone()].iter_mut();
        let flow = self.slots.flow[own].iter_mut();
        let each = rest.zip(flow).zip(sets);
        each.map(|((rest, flow), set)| (rest, flow, *set as usize))
    }

    /// Rest lengths of a slot \[m\].
    #[inline(always)]
    pub fn rest(&self, slot: usize) -> &Wide {
        &self.slots.rest[slot - self.slots.first]
    }

    /// Accumulated flow of a slot \[m\].
    #[inline(always)]
    pub fn flow(&self, slot: usize) -> &Wide {
        &self.slots.flow[slot - self.slots.first]
    }

    /// Finds the range of a part of a slot, which lies within what the law allows by more than the law is rounded.
    #[inline(always)]
    pub fn find_range<V: Vector>(&mut self, slot: usize, part: usize, stiffness: V) {
        if V::LANES < LANES / 2 {
            // Parts that share a half would have to agree. No pass over springs is so narrow.
            return;
        }
        let limits = self.palette.bounds::<V>(slot, part, stiffness);
        let rest = V::load(self.rest(slot), part);
        let grown = limits.yields.hardening * V::load(self.flow(slot), part);
        let [tension, compression] = [limits.yields.tension, limits.yields.compression];
        // A quotient 0/0 is of a spring without stiffness, which has no limit; `min` and `max` drop it.
        let longest = (tension + grown).min(limits.break_force) / stiffness;
        let most = longest.min(limits.break_length - rest) / rest;
        let least = -(compression + grown) / stiffness / rest;
        let (mut range, mut positive) = ([f32::NEG_INFINITY, f32::INFINITY], true);
        for l in 0..V::LANES {
            range[0] = range[0].max(least.lane(l) as f32);
            range[1] = range[1].min(most.lane(l) as f32);
            positive &= rest.lane(l) > 0.0;
        }
        let margin = |x: f32| {
            if x.is_finite() {
                1e-5 * x.abs() + 1e-6
            } else {
                0.0
            }
        };
        let (half, ranges) = (half::<V>(part), &mut self.slots.ranges);
        let found = [range[0] + margin(range[0]), range[1] - margin(range[1])];
        let [least, most] = if positive { found } else { [f32::NAN; 2] };
        let ranges = &mut ranges[slot - self.slots.first];
        (ranges.least[half], ranges.most[half]) = (least, most);
    }
}
