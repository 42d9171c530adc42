//! Springs at their limits.
//!
//! A part of a slice is computed as if no spring had any. If then one was out of its range, all is computed by a function of its
//! own that asks the law of plasticity for every spring, now and until none has flowed for a while. So the usual loop has
//! neither a branch nor a call, and the other one no branch that could not be foreseen: where springs swing about their yield
//! force, to guess wrong and then wait for constants took longer than the law.

use super::log::{self, Entry};
use super::pass::add_springs;
use super::ranges::Span;
use super::table::{End, Table, Untouched};
use super::telling::Telling;
use super::trial::{Nodes, Trial};
use super::vector::{Aside, LANES, Runs, Vector, Wide};
use crate::law::plastic;
use crate::law::spring;
use crate::solve::forces::{Commit, Happened, LimitEvent};

/// What springs at their limits read and write in a pass.
pub struct Limited<'a> {
    pub limits: Span<'a>,
    /// Whether the mirror has velocities.
    pub velocities: bool,
    pub book: Book<'a>,
    /// Nothing where nothing is to be written.
    pub commit: Option<Commit<f32>>,
    /// Plastic work \[J\] by lanes: a sum whose order does not depend on the width.
    pub plastic: [f64; LANES],
    /// Energy that went with broken springs \[J\], likewise.
    pub fracture: [f64; LANES],
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
        velocities: bool,
        book: Book<'a>,
        commit: Option<Commit<f32>>,
    ) -> Self {
        Self {
            limits,
            velocities,
            book,
            commit,
            plastic: [0.0; LANES],
            fracture: [0.0; LANES],
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
        let of = |limits, log| Self::new(limits, self.velocities, Book::Log(log), self.commit);
        [Some(of(limits, log)), Some(of(others, rest))]
    }

    /// Begins with one of its blocks.
    pub fn begin(&mut self, block: usize) {
        (self.plastic, self.fracture) = ([0.0; LANES], [0.0; LANES]);
        if let Book::Log(log) = &mut self.book {
            log.begin(block);
        }
    }

    /// What happened in the block.
    pub fn end(&self, block: usize) -> Outcome {
        Outcome {
            happened: Happened {
                plastic: self.plastic.iter().sum(),
                fracture: self.fracture.iter().sum(),
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
        let place = (slice, part);
        if self.limits.is_untouched(slice) {
            let (sums, within) = if table.is_regular(slice) {
                let rule = Untouched {
                    rest: table.rests(),
                    slacks: self.limits.slacks,
                };
                let slots = table.regular_slots(slice, runs);
                add_springs::<V, _, _, DAMPED>(table, slots, part, nodes, &rule)
            } else {
                let rule = self.limits.rule::<true>();
                let slots = rule.slots(table.range(slice), table.slots(slice));
                add_springs::<V, _, _, DAMPED>(table, slots, part, nodes, &rule)
            };
            if within {
                return sums;
            }
        }
        if self.velocities && table.is_regular(slice) {
            let slots = || table.regular_slots(slice, runs);
            self.add_touched::<V, _, _, DAMPED>(table, place, slots, nodes)
        } else {
            let slots = || table.slots(slice);
            self.add_touched::<V, _, _, DAMPED>(table, place, slots, nodes)
        }
    }

    /// The same of a slice that is not untouched, or is not from now on: rest lengths and ranges are those of slots.
    #[inline(always)]
    fn add_touched<V, E, I, const DAMPED: bool>(
        &mut self,
        table: &Table,
        (slice, part): (usize, usize),
        slots: impl Fn() -> I,
        nodes: Nodes<V>,
    ) -> Nodes<V>
    where
        V: Vector,
        E: End<V>,
        I: Iterator<Item = (usize, E, usize)>,
    {
        if !self.limits.is_untouched(slice) && !self.limits.is_busy(slice, part) {
            let rule = self.limits.rule::<false>();
            let slots = rule.slots(table.range(slice), slots());
            let (sums, within) = add_springs::<V, _, _, DAMPED>(table, slots, part, nodes, &rule);
            if within {
                return sums;
            }
        }
        V::aside(AtLimits::<V, _, DAMPED> {
            limited: self,
            table,
            slots: slots(),
            slice,
            part,
            nodes,
        })
    }
}

/// A part of a slice of which a spring may be at a limit.
struct AtLimits<'a, 'b, V, I, const DAMPED: bool> {
    limited: &'a mut Limited<'b>,
    table: &'a Table<'a>,
    slots: I,
    slice: usize,
    part: usize,
    nodes: Nodes<V>,
}

impl<V, E, I, const DAMPED: bool> Aside<V> for AtLimits<'_, '_, V, I, DAMPED>
where
    V: Vector,
    E: End<V>,
    I: Iterator<Item = (usize, E, usize)>,
{
    type Output = Nodes<V>;

    #[inline(always)]
    fn run(self) -> Nodes<V> {
        match self.limited.commit {
            Some(commit) if self.limited.limits.palette.is_breaking() => {
                self.commit::<true>(commit)
            }
            Some(commit) => self.commit::<false>(commit),
            None => self.try_out(),
        }
    }
}

impl<V, E, I, const DAMPED: bool> AtLimits<'_, '_, V, I, DAMPED>
where
    V: Vector,
    E: End<V>,
    I: Iterator<Item = (usize, E, usize)>,
{
    /// Forces in the midst of a substep: nothing is written.
    #[inline(always)]
    fn try_out(self) -> Nodes<V> {
        let (part, mut nodes) = (self.part, self.nodes);
        let limits = &self.limited.limits;
        for (slot, far, which) in self.slots {
            let stiffness = self.table.stiffness(which, part);
            let rest = V::load(limits.rest(slot), part);
            let trial = Trial::new(nodes.at, &far, part, rest).without_strays::<E>(stiffness);
            let law = limits.palette.bounds(slot, part, stiffness);
            let flow = V::load(limits.flow(slot), part);
            let mapped = plastic::return_map(stiffness, rest, trial.elongation, flow, &law.yields);
            nodes.pull(&trial, mapped.tension);
            if DAMPED {
                let rate = nodes.rate(&trial, &far, part);
                nodes.damp(&trial, rate, self.table.damping(which, part));
            }
        }
        nodes
    }

    /// Forces at the end of a substep: springs flow, and break where any can.
    #[inline(always)]
    fn commit<const BREAKING: bool>(self, commit: Commit<f32>) -> Nodes<V> {
        let Self {
            limited,
            table,
            slots,
            slice,
            part,
            mut nodes,
        } = self;
        limited.limits.touch(slice);
        if !DAMPED {
            nodes.velocity = table.own(slice).velocity(part);
        }
        let [since, lead] = [commit.since, commit.lead].map(|x| V::of(x.into()));
        let (mut flowed, mut broke) = (0, 0);
        let mut plastic = [0.0; LANES];
        let palette = limited.limits.palette;
        let mut teller = Teller {
            telling: limited.limits.telling,
            fracture: &mut limited.fracture,
            book: &mut limited.book,
        };
        let memory = limited.limits.memory(table.range(slice));
        for ((slot, far, which), (rest, flow, set)) in slots.zip(memory) {
            let [old_rest, old_flow] = [V::load(rest, part), V::load(flow, part)];
            let stiffness = table.stiffness(which, part);
            let trial = Trial::new(nodes.at, &far, part, old_rest).without_strays::<E>(stiffness);
            let law = palette.bounds_of(set, part, stiffness);
            let mapped =
                plastic::return_map(stiffness, old_rest, trial.elongation, old_flow, &law.yields);
            let amount = mapped.flow.abs();
            let flows = amount.bits_above(V::ZERO);
            (old_rest + mapped.flow).store(rest, part);
            (old_flow + amount).store(flow, part);
            let (breaks, held) = if BREAKING {
                law.breaks(&trial, mapped.tension)
            } else {
                (0, V::ONE)
            };
            let rate = nodes.rate(&trial, &far, part);
            // The trapezoid, as for every other work: the tension of the last commit follows from the rate.
            let last = stiffness * (trial.elongation - since * rate);
            add_work::<V>(&mut plastic, plastic::work(last, &mapped));
            let yields = flows & !old_flow.bits_above(V::ZERO);
            if yields | breaks != 0 {
                let lanes = Lanes {
                    slot,
                    first: part * V::LANES,
                    yields,
                    breaks,
                };
                let energy = spring::energy(stiffness, trial.elongation - mapped.flow);
                let lost = energy - lead * mapped.tension * rate;
                let told = [mapped.tension, energy, lost].map(wide);
                teller.tell(&lanes, &told);
            }
            let of_held = |x| {
                if BREAKING {
                    V::above(held, V::ZERO, x, V::ZERO)
                } else {
                    x
                }
            };
            nodes.pull(&trial, of_held(mapped.tension));
            if DAMPED {
                nodes.damp(&trial, rate, of_held(table.damping(which, part)));
            }
            flowed |= flows;
            broke |= breaks;
        }
        if flowed != 0 {
            // Both ends of a spring find the same, and each has a half.
            let sums = &mut limited.plastic[part * V::LANES..][..V::LANES];
            sums.iter_mut()
                .zip(plastic)
                .for_each(|(sum, work)| *sum += 0.5 * work);
            limited.limits.set_unsaved(slice);
        }
        if limited.limits.calm(slice, part, flowed | broke == 0) {
            for (slot, _, which) in table.slots(slice) {
                let stiffness = table.stiffness(which, part);
                limited.limits.find_range::<V>(slot, part, stiffness);
            }
        }
        nodes
    }
}

/// Springs of a part of a slot that break, or flow for the first time: one bit for each lane.
struct Lanes {
    slot: usize,
    /// The first lane of the part.
    first: usize,
    yields: u32,
    breaks: u32,
}

/// The lanes of a vector in the first places.
#[inline(always)]
fn wide<V: Vector>(value: V) -> Wide {
    let mut wide = Wide([0.0; LANES]);
    value.store(&mut wide, 0);
    wide
}

/// Adds plastic work \[J\] to sums by lanes.
#[inline(always)]
fn add_work<V: Vector>(sums: &mut [f64; LANES], work: V) {
    let work = wide(work);
    for (sum, work) in sums[..V::LANES].iter_mut().zip(&work.0) {
        *sum += f64::from(*work);
    }
}

/// Who writes down what happens to springs.
struct Teller<'a, 'b> {
    telling: &'a Telling,
    fracture: &'a mut [f64; LANES],
    book: &'a mut Book<'b>,
}

impl Teller<'_, '_> {
    /// Writes down what happened to springs, with their tensions \[N\], their energies \[J\], and what of energy goes if
    /// they break \[J\]. The end that counts tells of it.
    #[cold]
    #[inline(never)]
    fn tell(&mut self, lanes: &Lanes, [tension, energy, lost]: &[Wide; 3]) {
        for l in (0..LANES).filter(|l| (lanes.yields | lanes.breaks) >> l & 1 == 1) {
            let Some(spring) = self.telling.spring(lanes.slot, lanes.first + l) else {
                continue;
            };
            let entry = Entry {
                spring,
                yielded: lanes.yields >> l & 1 == 1,
                broke: lanes.breaks >> l & 1 == 1,
                tension: tension.0[l],
                energy: energy.0[l],
            };
            if entry.broke {
                self.fracture[lanes.first + l] += f64::from(lost.0[l]);
            }
            match self.book {
                Book::Events(events) => entry.tell(events),
                Book::Log(log) => log.push(entry),
            }
        }
    }
}
