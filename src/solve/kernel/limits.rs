//! Springs at their limits.
//!
//! A part of a slice is computed as if no spring had any; if then one was out of its range, all is computed again, by a function
//! of its own that asks the law of plasticity wherever it may matter. So the usual loop has neither a branch nor a call.

use super::pass::{Nodes, Table, Trial};
use super::sell::Limits;
use super::vector::{Aside, Half, LANES, Slot, Vector};
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
        (slice, part): (usize, usize),
        nodes: Nodes<V>,
    ) -> Nodes<V> {
        if !self.limits.busy[slice][part] {
            let limits = &self.limits;
            let place = (slice, part);
            let (sums, within) =
                table.add_springs::<V, true, DAMPED>(place, nodes, &limits.rest, &limits.ranges);
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
        let own = table.own(slice);
        if !DAMPED {
            let [x, y, z, _] = own.columns(part, Half::Second);
            nodes.velocity = [x, y, z];
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
                    own,
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
    own: Slot<'a, Particle<f32>>,
    far: Slot<'a, Particle<f32>>,
}

/// What the law says of springs to which something happens.
struct Outcome<V> {
    tension: V,
    energy: V,
    work: V,
    /// One bit for each lane.
    flows: u32,
    breaks: u32,
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
                .find_range::<V>(slot, self.table, &table.stiffness[at.which]);
        }
        if flows | breaks == 0 {
            return (mapped.tension, V::ONE);
        }
        // The trapezoid, as for every other work: the tension of the last commit follows from the rate.
        let rate = nodes.rate(trial, &at.far, part);
        let last = stiffness * (trial.elongation - V::of(h.into()) * rate);
        let outcome = Outcome {
            tension: mapped.tension,
            energy: spring::energy(stiffness, trial.elongation - mapped.flow),
            work: plastic::work(last, &mapped),
            flows,
            breaks,
        };
        self.book(at, &outcome);
        let unbroken = |value: V| {
            let held = V::above(trial.length, break_length, V::ZERO, value);
            V::above(mapped.tension, break_force, V::ZERO, held)
        };
        (unbroken(mapped.tension), unbroken(V::ONE))
    }

    /// Writes to the state what happened to the springs. Both ends find the same; that of the lower node tells.
    #[inline(always)]
    fn book<V: Vector>(&mut self, at: &Slots, outcome: &Outcome<V>) {
        let mut bits = outcome.flows | outcome.breaks;
        while bits != 0 {
            let l = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let lane = at.part * V::LANES + l;
            if at.own.row(lane) >= at.far.row(lane) {
                continue;
            }
            let spring = self.limits.springs.row(at.slot, lane);
            let event = |broke| LimitEvent {
                spring: spring as u32,
                broke,
                tension: outcome.tension.lane(l) as f32,
                energy: outcome.energy.lane(l) as f32,
            };
            if outcome.flows >> l & 1 == 1 {
                self.plastic[lane] += outcome.work.lane(l);
                if self.flow[spring] == 0.0 {
                    self.events.push(event(false));
                }
                self.rest[spring] = self.limits.rest[at.slot].0[lane];
                self.flow[spring] = self.limits.flow[at.slot].0[lane];
            }
            if outcome.breaks >> l & 1 == 1 {
                self.fracture += outcome.energy.lane(l);
                self.events.push(event(true));
            }
        }
    }
}
