//! What the passes over springs read: slots by slices, the nodes at the other ends, constants, and what bounds an elongation.

use super::ranges::Ranges;
use super::sell::Layout;
use super::vector::{Half, LANES, Reader, Run, Runs, Slot, Vector, Wide};
use crate::body::state::Particle;
use std::ops::Range;

/// The layout over the nodes.
#[derive(Clone, Copy)]
pub struct Table<'a> {
    layout: &'a Layout,
    particles: &'a [Particle<f32>],
    own: Reader<'a, Particle<f32>>,
    far: Reader<'a, Particle<f32>>,
}

/// The nodes at the other ends of a slot.
pub trait End<V> {
    /// Whether a lane without a spring has another node there than its own, which has nothing to do with it.
    const STRAYS: bool;
    /// Where they are \[m\].
    fn place(&self, part: usize) -> [V; 3];
    /// Their velocities \[m/s\].
    fn velocity(&self, part: usize) -> [V; 3];
    /// How far they swing, see [`Particle::swing`].
    fn swing(&self, part: usize) -> V;
}

impl<V: Vector> End<V> for Slot<'_, Particle<f32>> {
    const STRAYS: bool = false;

    #[inline(always)]
    fn place(&self, part: usize) -> [V; 3] {
        let [x, y, z, _] = self.columns(part, Half::First);
        [x, y, z]
    }

    #[inline(always)]
    fn velocity(&self, part: usize) -> [V; 3] {
        let [x, y, z, _] = self.columns(part, Half::Second);
        [x, y, z]
    }

    #[inline(always)]
    fn swing(&self, part: usize) -> V {
        let [.., swing] = self.columns(part, Half::Second);
        swing
    }
}

/// Rest lengths, and whether an elongation is one at which nothing happens.
pub trait Rule<V: Vector> {
    /// Whether there is anything to ask.
    const LIMITED: bool;
    /// Whether it asks of lanes without a spring what it asks of the others.
    const ASKS_ALL: bool;
    /// What it knows of a slot besides its constants.
    type Slot: Copy;
    /// Rest length of a part of a slot of these constants \[m\].
    fn rest(&self, slot: Self::Slot, at: (usize, usize)) -> V;
    /// Of the lanes that were `within`, those whose elongation is in range.
    fn keep(
        &self,
        within: V::Mask,
        elongation: V,
        rest: V,
        slot: Self::Slot,
        at: (usize, usize),
    ) -> V::Mask;
}

/// Springs without limits, by constants.
#[derive(Clone, Copy)]
pub struct Free<'a>(pub &'a [Wide]);

impl<V: Vector> Rule<V> for Free<'_> {
    const LIMITED: bool = false;
    const ASKS_ALL: bool = false;
    type Slot = usize;

    #[inline(always)]
    fn rest(&self, _: usize, (which, part): (usize, usize)) -> V {
        V::load(&self.0[which], part)
    }

    #[inline(always)]
    fn keep(&self, within: V::Mask, _: V, _: V, _: usize, _: (usize, usize)) -> V::Mask {
        within
    }
}

/// Springs with limits, by slots from one on; none of those that are `UNTOUCHED` has gone beyond its slack.
#[derive(Clone, Copy)]
pub struct BySlot<'a, const UNTOUCHED: bool> {
    pub first: usize,
    pub rest: &'a [Wide],
    pub ranges: &'a [Ranges],
}

impl<'a, const UNTOUCHED: bool> BySlot<'a, UNTOUCHED> {
    /// The slots of a slice, with what is known of each.
    #[inline(always)]
    pub fn slots<E>(
        &self,
        range: Range<usize>,
        slots: impl Iterator<Item = (usize, E, usize)>,
    ) -> impl Iterator<Item = ((&'a Wide, &'a Ranges), E, usize)> {
        let own = range.start - self.first..range.end - self.first;
        let known = self.rest[own.clone()].iter().zip(&self.ranges[own]);
        let each = slots.zip(known);
        each.map(|((_, far, which), known)| (known, far, which))
    }
}

impl<'a, V: Vector, const UNTOUCHED: bool> Rule<V> for BySlot<'a, UNTOUCHED> {
    const LIMITED: bool = true;
    const ASKS_ALL: bool = true;
    type Slot = (&'a Wide, &'a Ranges);

    #[inline(always)]
    fn rest(&self, (rest, _): Self::Slot, (_, part): (usize, usize)) -> V {
        V::load(rest, part)
    }

    #[inline(always)]
    fn keep(
        &self,
        within: V::Mask,
        elongation: V,
        rest: V,
        (_, ranges): Self::Slot,
        (_, part): (usize, usize),
    ) -> V::Mask {
        if UNTOUCHED {
            let slack: V = ranges.slack(part);
            slack.also_above(elongation.abs(), within)
        } else {
            ranges.keep(part, within, elongation, rest)
        }
    }
}

/// Springs of a regular slice with limits of which none has gone beyond its slack, by constants.
#[derive(Clone, Copy)]
pub struct Untouched<'a> {
    pub rest: &'a [Wide],
    pub slacks: &'a [Wide],
}

impl<V: Vector> Rule<V> for Untouched<'_> {
    const LIMITED: bool = true;
    const ASKS_ALL: bool = false;
    type Slot = usize;

    #[inline(always)]
    fn rest(&self, _: usize, (which, part): (usize, usize)) -> V {
        V::load(&self.rest[which], part)
    }

    #[inline(always)]
    fn keep(
        &self,
        within: V::Mask,
        elongation: V,
        _: V,
        _: usize,
        (which, part): (usize, usize),
    ) -> V::Mask {
        let slack: V = V::load(&self.slacks[which], part);
        slack.also_above(elongation.abs(), within)
    }
}

impl<'a> Table<'a> {
    /// The layout over these nodes; `None` if there are too few.
    pub fn of(layout: &'a Layout, particles: &'a [Particle<f32>]) -> Option<Self> {
        Some(Self {
            own: layout.own.of(particles)?,
            far: layout.far.of(particles)?,
            layout,
            particles,
        })
    }

    pub fn slices(&self) -> usize {
        self.layout.slices()
    }

    /// The first slot of a slice, or the end.
    pub fn first_slot(&self, slice: usize) -> usize {
        self.layout.firsts[slice] as usize
    }

    /// The nodes, sixteen and sixteen, which are slices where rows keep the order of nodes; but for the last few.
    pub fn together(&self) -> &'a [[Particle<f32>; LANES]] {
        self.particles.as_chunks().0
    }

    /// Whether rows keep the order of nodes.
    pub fn keeps_order(&self) -> bool {
        !self.layout.regular.is_empty()
    }

    pub fn is_damped(&self) -> bool {
        !self.layout.damping.is_empty()
    }

    /// The place of a slice's own nodes.
    #[inline(always)]
    pub fn own(&self, slice: usize) -> Slot<'a, Particle<f32>> {
        self.own.slot(slice)
    }

    /// Rest lengths of constants.
    pub fn rests(&self) -> &'a [Wide] {
        &self.layout.rest
    }

    /// Whether the springs of a slice go to nodes that follow each other.
    #[inline(always)]
    pub fn is_regular(&self, slice: usize) -> bool {
        self.layout.regular.get(slice).is_some_and(|r| *r)
    }

    /// Which slots are those of a slice.
    pub fn range(&self, slice: usize) -> Range<usize> {
        self.layout.slots(slice)
    }

    /// The slots of a slice, each with its other ends and its constants.
    #[inline(always)]
    pub fn slots(
        &self,
        slice: usize,
    ) -> impl Iterator<Item = (usize, Slot<'a, Particle<f32>>, usize)> {
        let slots = self.layout.slots(slice);
        let which = &self.layout.which[slots.clone()];
        let each = self.far.slots(slots.clone()).zip(which);
        slots
            .zip(each)
            .map(|(slot, (far, &which))| (slot, far, which as usize))
    }

    /// The same of a regular slice.
    #[inline(always)]
    pub fn regular_slots<'m>(
        &self,
        slice: usize,
        runs: &Runs<'m>,
    ) -> impl Iterator<Item = (usize, Run<'m>, usize)> + use<'a, 'm> {
        let slots = self.layout.slots(slice);
        let which = &self.layout.which[slots.clone()];
        let each = runs.slots(slots.clone()).zip(which);
        slots
            .zip(each)
            .map(|(slot, (far, &which))| (slot, far, which as usize))
    }

    /// Stiffness of a slot \[N/m\].
    #[inline(always)]
    pub fn stiffness<V: Vector>(&self, which: usize, part: usize) -> V {
        V::load(&self.layout.stiffness[which], part)
    }

    /// Viscosity of a slot \[N·s/m\].
    #[inline(always)]
    pub fn damping<V: Vector>(&self, which: usize, part: usize) -> V {
        V::load(&self.layout.damping[which], part)
    }
}
