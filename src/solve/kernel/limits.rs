//! Springs at their limits.
//!
//! A part of a slice is computed as if no spring had any; if then one was out of its range, all is computed again, by a function
//! of its own that asks the law of plasticity wherever it may matter. So the usual loop has neither a branch nor a call.

use super::log::{self, Entry};
use super::pass::{Nodes, Trial, add_springs};
use super::ranges::Span;
use super::table::{End, Table, Untouched};
use super::vector::{Aside, Half, LANES, Runs, Slot, Vector, Wide};
use crate::body::state::Particle;
use crate::law::plastic::{self, Yield};
use crate::law::spring;
use crate::solve::forces::{Happened, LimitEvent};
use crate::solve::springs::Limit;

/// What springs at their limits read and write in a pass.
pub struct Limited<'a> {
    pub limits: Span<'a>,
    pub table: &'a [Limit<f32>],
    pub book: Book<'a>,
    /// Time since the last commit \[s\]; none where nothing is to be written.
    pub commit: Option<f32>,
    /// Plastic work \[J\] by lanes: a sum whose order does not depend on the width.
    pub plastic: [f64; LANES],
    pub fracture: f64,
}

/// Where events are written.
pub enum Book<'a> {
    /// To the list of them.
    Events(&'a mut Vec<LimitEvent<f32>>),
    /// To a log, because other parts of the body are computed at once.
    Log(log::Part<'a>),
}

/// Sums over a block.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    pub happened: Happened,
    /// How many entries of the log are its.
    pub logged: usize,
}

impl<'a> Limited<'a> {
    /// The whole of a body.
    pub fn new(
        limits: Span<'a>,
        table: &'a [Limit<f32>],
        book: Book<'a>,
        commit: Option<f32>,
    ) -> Self {
        Self {
            limits,
            table,
            book,
            commit,
            plastic: [0.0; LANES],
            fracture: 0.0,
        }
    }

    /// Whether it can't be cut, because it writes to the list of events.
    pub fn is_whole(&self) -> bool {
        matches!(self.book, Book::Events(_))
    }

    /// The first so many blocks, that is what lies before a slice and its first slot, and the others.
    pub fn cut(self, at: usize, (slice, slot): (usize, usize)) -> [Option<Self>; 2] {
        let Book::Log(log) = self.book else {
            return [Some(self), None];
        };
        let [limits, others] = self.limits.cut(slice, slot);
        let [log, rest] = log.cut(at);
        let of = |limits, log| Self::new(limits, self.table, Book::Log(log), self.commit);
        [Some(of(limits, log)), Some(of(others, rest))]
    }

    /// Begins with one of its blocks.
    pub fn begin(&mut self, block: usize) {
        (self.plastic, self.fracture) = ([0.0; LANES], 0.0);
        if let Book::Log(log) = &mut self.book {
            log.begin(block);
        }
    }

    /// What happened in the block.
    pub fn end(&self, block: usize) -> Outcome {
        Outcome {
            happened: Happened {
                plastic: self.plastic.iter().sum(),
                fracture: self.fracture,
            },
            logged: match &self.book {
                Book::Events(_) => 0,
                Book::Log(log) => log.count(block),
            },
        }
    }
}

impl Limited<'_> {
    /// All springs of a part of a slice.
    #[inline(always)]
    pub fn add_springs<V: Vector, const DAMPED: bool>(
        &mut self,
        table: &Table,
        runs: &Runs,
        (slice, part): (usize, usize),
        nodes: Nodes<V>,
    ) -> Nodes<V> {
        let limits = &self.limits;
        if !limits.is_busy(slice, part) {
            let (sums, within) = if limits.is_untouched(slice) {
                let rule = Untouched {
                    rest: table.rests(),
                    slacks: limits.slacks,
                };
                let slots = table.regular_slots(slice, runs);
                add_springs::<V, _, _, DAMPED>(table, slots, part, nodes, &rule)
            } else {
                let rule = limits.rule();
                add_springs::<V, _, _, DAMPED>(table, table.slots(slice), part, nodes, &rule)
            };
            if within {
                return sums;
            }
        }
        V::aside(AtLimits::<V, DAMPED> {
            limited: self,
            table,
            slice,
            part,
            nodes,
        })
    }
}

/// A part of a slice of which a spring may be at a limit.
struct AtLimits<'a, 'b, V, const DAMPED: bool> {
    limited: &'a mut Limited<'b>,
    table: &'a Table<'a>,
    slice: usize,
    part: usize,
    nodes: Nodes<V>,
}

impl<V: Vector, const DAMPED: bool> Aside<V> for AtLimits<'_, '_, V, DAMPED> {
    type Output = Nodes<V>;

    #[inline(always)]
    fn run(self) -> Nodes<V> {
        let Self {
            limited,
            table,
            slice,
            part,
            mut nodes,
        } = self;
        limited.limits.touch(slice);
        let own = table.own(slice);
        if !DAMPED {
            nodes.velocity = own.velocity(part);
        }
        let mut busy = false;
        for (slot, far, which) in table.slots(slice) {
            let rest = V::load(limited.limits.rest(slot), part);
            let trial = Trial::new(nodes.at, &far, part, rest);
            let stiffness = table.stiffness(which, part);
            let mut tension = spring::tension(stiffness, trial.elongation);
            let mut held = V::ONE;
            let range = limited.limits.range(slot);
            let within = range.keep(V::ONE, trial.elongation, rest);
            if !within.all_above(V::ZERO) {
                busy = true;
                let slots = Slots {
                    slot,
                    part,
                    which,
                    far,
                };
                (tension, held) = limited.answer(table, &slots, &nodes, &trial, (stiffness, rest));
            }
            nodes.pull(&trial, tension);
            if DAMPED {
                let rate = nodes.rate(&trial, &far, part);
                nodes.damp(&trial, rate, table.damping::<V>(which, part) * held);
            }
        }
        limited.limits.set_busy(slice, part, busy);
        if busy && limited.commit.is_some() {
            limited.limits.set_unsaved(slice);
        }
        nodes
    }
}

/// Where springs are.
struct Slots<'a> {
    slot: usize,
    part: usize,
    which: usize,
    far: Slot<'a, Particle<f32>>,
}

/// What the law says of springs that break, or flow for the first time.
struct Answers {
    tension: Wide,
    energy: Wide,
    /// One bit for each lane.
    yields: u32,
    breaks: u32,
    /// How many lanes there are.
    lanes: usize,
}

/// The lanes of a vector in the first places.
#[inline(always)]
fn wide<V: Vector>(value: V) -> Wide {
    let mut wide = Wide([0.0; LANES]);
    value.store(&mut wide, 0);
    wide
}

impl Limited<'_> {
    /// Tension of springs \[N\], and 1 where they hold, 0 where they break.
    #[inline(always)]
    fn answer<V: Vector>(
        &mut self,
        table: &Table,
        at: &Slots,
        nodes: &Nodes<V>,
        trial: &Trial<V>,
        (stiffness, rest): (V, V),
    ) -> (V, V) {
        let (slot, part) = (at.slot, at.part);
        let Some(rows) = self.limits.springs.of(self.table) else {
            return (V::ZERO, V::ZERO);
        };
        let rows = rows.slot(slot);
        let [tension, compression, hardening, inverse] = rows.columns(part, Half::First);
        let [break_force, break_length, ..] = rows.columns(part, Half::Second);
        let yields = Yield {
            tension,
            compression,
            hardening,
            inverse,
        };
        let flow = V::load(self.limits.flow(slot), part);
        let mapped = plastic::return_map(stiffness, trial.elongation, flow, &yields);
        let Some(h) = self.commit else {
            return (mapped.tension, V::ONE);
        };
        let flows = mapped.flow.abs().bits_above(V::ZERO);
        let breaks = mapped.tension.bits_above(break_force) | trial.length.bits_above(break_length);
        // Both ends of a spring find the same. That of the lower node tells of events; of plastic work each has a half.
        let telling = u32::from(self.limits.telling[slot]) >> (part * V::LANES);
        if flows != 0 {
            (rest + mapped.flow).store(self.limits.rest(slot), part);
            (flow + mapped.flow.abs()).store(self.limits.flow(slot), part);
            self.limits.range(slot).forget();
            // The trapezoid, as for every other work: the tension of the last commit follows from the rate.
            let rate = nodes.rate(trial, &at.far, part);
            let last = stiffness * (trial.elongation - V::of(h.into()) * rate);
            let work = wide(plastic::work(last, &mapped));
            let sums = &mut self.plastic[part * V::LANES..][..V::LANES];
            for (sum, work) in sums.iter_mut().zip(&work.0) {
                *sum += 0.5 * f64::from(*work);
            }
        } else if !self.limits.range(slot).is_known() {
            self.limits
                .find_range::<V>(slot, self.table, table.stiffness_of(at.which));
        }
        let yields = flows & !flow.bits_above(V::ZERO);
        if (yields | breaks) & telling != 0 {
            self.tell(
                at,
                &Answers {
                    tension: wide(mapped.tension),
                    energy: wide(spring::energy(stiffness, trial.elongation - mapped.flow)),
                    yields: yields & telling,
                    breaks: breaks & telling,
                    lanes: V::LANES,
                },
            );
        }
        if breaks == 0 {
            return (mapped.tension, V::ONE);
        }
        let unbroken = |value: V| {
            let held = V::above(trial.length, break_length, V::ZERO, value);
            V::above(mapped.tension, break_force, V::ZERO, held)
        };
        (unbroken(mapped.tension), unbroken(V::ONE))
    }

    /// Writes down what happened to springs.
    #[inline(always)]
    fn tell(&mut self, at: &Slots, outcome: &Answers) {
        let mut bits = outcome.yields | outcome.breaks;
        while bits != 0 {
            let l = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let entry = Entry {
                spring: self
                    .limits
                    .springs
                    .row(at.slot, at.part * outcome.lanes + l) as u32,
                yielded: outcome.yields >> l & 1 == 1,
                broke: outcome.breaks >> l & 1 == 1,
                tension: outcome.tension.0[l],
                energy: outcome.energy.0[l],
            };
            if entry.broke {
                self.fracture += f64::from(entry.energy);
            }
            match &mut self.book {
                Book::Events(events) => entry.tell(events),
                Book::Log(log) => log.push(entry),
            }
        }
    }
}
