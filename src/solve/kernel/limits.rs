//! Springs at their limits.
//!
//! A part of a slice is computed as if no spring had any; if then one was out of its range, all is computed again, by a function
//! of its own that asks the law of plasticity wherever it may matter. So the usual loop has neither a branch nor a call.

use super::pass::{Nodes, Trial, add_springs};
use super::ranges::Limits;
use super::table::{BySlot, End, Table, Untouched};
use super::vector::{Aside, Half, LANES, Runs, Slot, Vector, Wide};
use crate::body::state::Particle;
use crate::law::plastic::{self, Yield};
use crate::law::spring;
use crate::solve::forces::{Happened, LimitEvent};
use crate::solve::springs::Limit;

/// What springs at their limits read and write in a pass.
pub struct Limited<'a> {
    pub limits: &'a mut Limits,
    pub table: &'a [Limit<f32>],
    /// Of the state.
    pub rest: &'a mut [f32],
    pub flow: &'a mut [f32],
    pub events: &'a mut Vec<LimitEvent<f32>>,
    /// Time since the last commit \[s\]; none where nothing is to be written.
    pub commit: Option<f32>,
    /// Plastic work \[J\] by lanes: a sum whose order does not depend on the width.
    pub plastic: [f64; LANES],
    pub fracture: f64,
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
        if !limits.busy[slice][part] {
            let (sums, within) = if limits.untouched[slice] {
                let rule = Untouched {
                    rest: table.rests(),
                    slacks: &limits.slacks,
                };
                let slots = table.regular_slots(slice, runs);
                add_springs::<V, _, _, DAMPED>(table, slots, part, nodes, &rule)
            } else {
                let rule = BySlot {
                    rest: &limits.rest,
                    ranges: &limits.ranges,
                };
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

    pub fn happened(&self) -> Happened {
        Happened {
            plastic: self.plastic.iter().sum(),
            fracture: self.fracture,
        }
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
        limited.limits.untouched[slice] = false;
        let own = table.own(slice);
        if !DAMPED {
            nodes.velocity = own.velocity(part);
        }
        let mut busy = false;
        for (slot, far, which) in table.slots(slice) {
            let rest = V::load(&limited.limits.rest[slot], part);
            let trial = Trial::new(nodes.at, &far, part, rest);
            let stiffness = table.stiffness(which, part);
            let mut tension = spring::tension(stiffness, trial.elongation);
            let mut held = V::ONE;
            let range = &limited.limits.ranges[slot];
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
        limited.limits.busy[slice][part] = busy;
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

/// What the law says of springs to which something happens.
struct Outcome {
    tension: Wide,
    energy: Wide,
    work: Wide,
    /// One bit for each lane.
    flows: u32,
    breaks: u32,
    /// How many there are.
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
        let flow = V::load(&self.limits.flow[slot], part);
        let mapped = plastic::return_map(stiffness, trial.elongation, flow, &yields);
        let Some(h) = self.commit else {
            return (mapped.tension, V::ONE);
        };
        let flows = mapped.flow.abs().bits_above(V::ZERO);
        let breaks = mapped.tension.bits_above(break_force) | trial.length.bits_above(break_length);
        if flows != 0 {
            (rest + mapped.flow).store(&mut self.limits.rest[slot], part);
            (flow + mapped.flow.abs()).store(&mut self.limits.flow[slot], part);
            self.limits.ranges[slot].forget();
        } else if !self.limits.ranges[slot].is_known() {
            self.limits
                .find_range::<V>(slot, self.table, table.stiffness_of(at.which));
        }
        if flows | breaks == 0 {
            return (mapped.tension, V::ONE);
        }
        // Both ends find the same; that of the lower node tells.
        let telling = u32::from(self.limits.telling[slot]) >> (part * V::LANES);
        if (flows | breaks) & telling != 0 {
            // The trapezoid, as for every other work: the tension of the last commit follows from the rate.
            let rate = nodes.rate(trial, &at.far, part);
            let last = stiffness * (trial.elongation - V::of(h.into()) * rate);
            self.book(
                at,
                &Outcome {
                    tension: wide(mapped.tension),
                    energy: wide(spring::energy(stiffness, trial.elongation - mapped.flow)),
                    work: wide(plastic::work(last, &mapped)),
                    flows: flows & telling,
                    breaks: breaks & telling,
                    lanes: V::LANES,
                },
            );
        }
        let unbroken = |value: V| {
            let held = V::above(trial.length, break_length, V::ZERO, value);
            V::above(mapped.tension, break_force, V::ZERO, held)
        };
        (unbroken(mapped.tension), unbroken(V::ONE))
    }

    /// Writes to the state what happened to springs.
    fn book(&mut self, at: &Slots, outcome: &Outcome) {
        let mut bits = outcome.flows | outcome.breaks;
        while bits != 0 {
            let l = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let lane = at.part * outcome.lanes + l;
            let spring = self.limits.springs.row(at.slot, lane);
            let event = |broke| LimitEvent {
                spring: spring as u32,
                broke,
                tension: outcome.tension.0[l],
                energy: outcome.energy.0[l],
            };
            if outcome.flows >> l & 1 == 1 {
                self.plastic[lane] += f64::from(outcome.work.0[l]);
                if self.flow[spring] == 0.0 {
                    self.events.push(event(false));
                }
                self.rest[spring] = self.limits.rest[at.slot].0[lane];
                self.flow[spring] = self.limits.flow[at.slot].0[lane];
            }
            if outcome.breaks >> l & 1 == 1 {
                self.fracture += f64::from(outcome.energy.0[l]);
                self.events.push(event(true));
            }
        }
    }
}
