//! Limits of springs by slots, as columns, so that a pass need not gather them spring by spring.
//!
//! Slots share what is the same. In a body of a few materials that is nearly everything, because a lane without a spring takes
//! the limits of the first in its slot. It can't reach them: it goes from a node to itself, so it has neither tension nor length.

use super::trial::Trial;
use super::vector::{LANES, Vector, Wide};
use crate::law::plastic::{self, Yield};
use crate::solve::springs::Limit;
use std::collections::HashMap;
use std::ops::Range;

/// Limits by slots.
#[derive(Clone, Debug, Default)]
pub struct Palette {
    /// Per slot which set.
    which: Vec<u32>,
    /// Per set the yield force in tension \[N\] and H \[N/m\].
    yields: Vec<[Wide; 2]>,
    /// Per set the yield force in compression \[N\]. Empty where it is that in tension.
    compression: Vec<Wide>,
    /// Per set the force \[N\] and the length \[m\] of breaking. Empty where nothing breaks.
    breaks: Vec<[Wide; 2]>,
    /// Whether there are these two.
    uneven: bool,
    breaking: bool,
}

/// Limits of the springs of a part of a slot.
#[derive(Clone, Copy)]
pub struct Bounds<V> {
    pub yields: Yield<V>,
    /// \[N\].
    pub break_force: V,
    /// \[m\].
    pub break_length: V,
}

impl<V: Vector> Bounds<V> {
    /// Which lanes break, and 1 for those that hold, 0 for others.
    #[inline(always)]
    pub fn breaks(&self, trial: &Trial<V>, tension: V) -> (u32, V) {
        let held = V::above(trial.length, self.break_length, V::ZERO, V::ONE);
        let held = V::above(tension, self.break_force, V::ZERO, held);
        (V::ONE.bits_above(held), held)
    }
}

/// Finds what is the same while slots come.
#[derive(Default)]
pub struct Mixer {
    kinds: HashMap<[u32; 5], u32>,
    last: Option<([u32; 5], u32)>,
    sets: HashMap<[u32; LANES], u32>,
}

impl Mixer {
    /// Which of the limits met so far these are.
    fn kind(&mut self, limit: &[f32; 5]) -> u32 {
        let bits = limit.map(f32::to_bits);
        if let Some((last, kind)) = self.last
            && last == bits
        {
            return kind;
        }
        let next = self.kinds.len() as u32;
        let kind = *self.kinds.entry(bits).or_insert(next);
        self.last = Some((bits, kind));
        kind
    }
}

impl Palette {
    /// For springs of these limits.
    pub fn of(limits: &[Limit<f32>]) -> Self {
        let breaks = |l: &Limit<f32>| l.break_force.min(l.break_length) < f32::INFINITY;
        let uneven = |l: &Limit<f32>| l.yields.tension != l.yields.compression;
        Self {
            uneven: limits.iter().any(uneven),
            breaking: limits.iter().any(breaks),
            ..Self::default()
        }
    }

    /// Adds a slot of springs of these limits.
    pub fn push(&mut self, mixer: &mut Mixer, limits: [Option<&Limit<f32>>; LANES]) {
        let first = limits.iter().flatten().next().copied();
        let first = first.unwrap_or(&Limit::NEVER);
        let lanes = limits.map(|limit| numbers(limit.unwrap_or(first)));
        let next = self.yields.len() as u32;
        let key = lanes.each_ref().map(|lane| mixer.kind(lane));
        let which = *mixer.sets.entry(key).or_insert(next);
        if which == next {
            let column = |k: usize| Wide(lanes.map(|lane| lane[k]));
            self.yields.push([column(0), column(1)]);
            if self.uneven {
                self.compression.push(column(2));
            }
            if self.breaking {
                self.breaks.push([column(3), column(4)]);
            }
        }
        self.which.push(which);
    }

    /// Whether anything can break.
    pub fn is_breaking(&self) -> bool {
        self.breaking
    }

    /// Which sets the slots have.
    pub fn sets(&self, slots: Range<usize>) -> &[u32] {
        &self.which[slots]
    }

    /// Limits of a part of a slot of springs of this stiffness \[N/m\].
    #[inline(always)]
    pub fn bounds<V: Vector>(&self, slot: usize, part: usize, stiffness: V) -> Bounds<V> {
        self.bounds_of(self.which[slot] as usize, part, stiffness)
    }

    /// The same of a slot that has this set.
    #[inline(always)]
    pub fn bounds_of<V: Vector>(&self, set: usize, part: usize, stiffness: V) -> Bounds<V> {
        let [tension, hardening] = &self.yields[set];
        let tension = V::load(tension, part);
        let mut compression = tension;
        if self.uneven {
            compression = V::load(&self.compression[set], part);
        }
        let (mut break_force, mut break_length) = (V::of(f64::INFINITY), V::of(f64::INFINITY));
        if self.breaking {
            let [force, length] = &self.breaks[set];
            (break_force, break_length) = (V::load(force, part), V::load(length, part));
        }
        let hardening = V::load(hardening, part);
        Bounds {
            yields: Yield {
                tension,
                compression,
                hardening,
                inverse: plastic::inverse(stiffness, hardening),
            },
            break_force,
            break_length,
        }
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.which[..])
            + size_of_val(&self.yields[..])
            + size_of_val(&self.compression[..])
            + size_of_val(&self.breaks[..])
    }
}

fn numbers(limit: &Limit<f32>) -> [f32; 5] {
    let yields = &limit.yields;
    [
        yields.tension,
        yields.hardening,
        yields.compression,
        limit.break_force,
        limit.break_length,
    ]
}
