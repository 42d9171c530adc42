//! What the passes over springs read: slots by slices, the nodes at the other ends, constants, and what bounds an elongation.

use super::ranges::{Ranges, half};
use super::sell::Layout;
use super::vector::{Half, LANES, Reader, Run, Runs, Slot, Vector, Wide};
use crate::body::state::Particle;

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
pub trait Rule<V> {
    /// Whether there is anything to ask.
    const LIMITED: bool;
    /// Whether it asks of lanes without a spring what it asks of the others.
    const ASKS_ALL: bool;
    /// Rest length \[m\].
    fn rest(&self, slot: usize, which: usize, part: usize) -> V;
    /// What was `within`, or 0 for elongations out of range.
    fn keep(&self, within: V, elongation: V, rest: V, at: (usize, usize, usize)) -> V;
}

/// Springs without limits, by constants.
#[derive(Clone, Copy)]
pub struct Free<'a>(pub &'a [Wide]);

impl<V: Vector> Rule<V> for Free<'_> {
    const LIMITED: bool = false;
    const ASKS_ALL: bool = false;

    #[inline(always)]
    fn rest(&self, _: usize, which: usize, part: usize) -> V {
        V::load(&self.0[which], part)
    }

    #[inline(always)]
    fn keep(&self, within: V, _: V, _: V, _: (usize, usize, usize)) -> V {
        within
    }
}

/// Springs with limits, by slots from one on.
#[derive(Clone, Copy)]
pub struct BySlot<'a> {
    pub first: usize,
    pub rest: &'a [Wide],
    pub ranges: &'a [Ranges],
}

impl<V: Vector> Rule<V> for BySlot<'_> {
    const LIMITED: bool = true;
    const ASKS_ALL: bool = true;

    #[inline(always)]
    fn rest(&self, slot: usize, _: usize, part: usize) -> V {
        V::load(&self.rest[slot - self.first], part)
    }

    #[inline(always)]
    fn keep(&self, within: V, elongation: V, rest: V, at: (usize, usize, usize)) -> V {
        let (slot, _, part) = at;
        self.ranges[slot - self.first][half::<V>(part)].keep(within, elongation, rest)
    }
}

/// Springs with limits of which none has gone beyond its slack, by constants.
#[derive(Clone, Copy)]
pub struct Untouched<'a> {
    pub rest: &'a [Wide],
    pub slacks: &'a [Wide],
}

impl<V: Vector> Rule<V> for Untouched<'_> {
    const LIMITED: bool = true;
    const ASKS_ALL: bool = false;

    #[inline(always)]
    fn rest(&self, _: usize, which: usize, part: usize) -> V {
        V::load(&self.rest[which], part)
    }

    #[inline(always)]
    fn keep(&self, within: V, elongation: V, _: V, at: (usize, usize, usize)) -> V {
        let (_, which, part) = at;
        let slack = V::load(&self.slacks[which], part);
        V::above(slack, elongation.abs(), within, V::ZERO)
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
    pub fn range(&self, slice: usize) -> std::ops::Range<usize> {
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
