//! The rates of nodes by rows, for the stable substep; [`crate::solve::stable`] says what they are and has the scalar loop.

use super::mirror::Copied;
use super::sell::Sell;
use super::table::{End, Table};
use super::trial::Trial;
use super::vector::{Half, LANES, Pass, Runs, Vector, Wide, Width, Writer, run};
use crate::body::state::State;
use crate::law::stable::{Resistance, sideways};
use crate::solve::solver::Solver;
use crate::solve::springs::Rows;
use crate::solve::stable::Rates;

/// Writes the rates; `false` where there are no rows to do it by.
pub(crate) fn rates(
    solver: &mut Solver<f32>,
    state: &State<f32>,
    rates: &mut [Rates<f32>],
) -> bool {
    let Rows::Made(sell) = &mut solver.table.rows else {
        return false;
    };
    let Sell {
        layout,
        limits,
        mirror,
        ..
    } = &mut **sell;
    let (Some(table), Some(out)) = (
        Table::of(layout, &state.particles),
        layout.out.of_mut(rates),
    ) else {
        return false;
    };
    if Width::of(solver.kernel) == Width::Portable {
        return false;
    }
    if layout.regular.contains(&true) {
        run(solver.kernel, mirror.copying(table, Copied::Swings));
    }
    let Some(runs) = layout.starts.of(&mirror.columns) else {
        return false;
    };
    let pass = NodeRates {
        rest: limits.as_ref().map_or(&[], |l| &l.rest[..]),
        out,
        table,
        runs,
    };
    run(solver.kernel, pass);
    true
}

/// Nodes at such a distance have a direction \[m\].
const ONE_PLACE: f64 = 1e-14;

struct NodeRates<'a> {
    table: Table<'a>,
    runs: Runs<'a>,
    /// Rest lengths by slot, where they can change, else empty.
    rest: &'a [Wide],
    out: Writer<'a, Rates<f32>>,
}

impl Pass for NodeRates<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector>(self) {
        if self.table.is_damped() {
            self.slices::<V, true>();
        } else {
            self.slices::<V, false>();
        }
    }
}

impl NodeRates<'_> {
    #[inline(always)]
    fn slices<V: Vector, const DAMPED: bool>(mut self) {
        for slice in 0..self.table.slices() {
            for part in 0..LANES / V::LANES {
                let [stiff, damp] = if self.table.is_regular(slice) {
                    let slots = self.table.regular_slots(slice, &self.runs);
                    self.of_nodes::<V, _, DAMPED>((slice, part), slots)
                } else {
                    let slots = self.table.slots(slice);
                    self.of_nodes::<V, _, DAMPED>((slice, part), slots)
                };
                let rates = [stiff, damp, V::ZERO, V::ZERO];
                self.out.put(slice, part, rates);
            }
        }
    }

    #[inline(always)]
    fn of_nodes<V: Vector, E: End<V>, const DAMPED: bool>(
        &self,
        (slice, part): (usize, usize),
        slots: impl Iterator<Item = (usize, E, usize)>,
    ) -> [V; 2] {
        let own = self.table.own(slice);
        let [x, y, z, inv_mass] = own.columns::<V>(part, Half::First);
        let [.., swing] = own.columns::<V>(part, Half::Second);
        let per_swing = V::above(inv_mass, V::ZERO, inv_mass / swing, V::ZERO);
        let [mut stiff, mut damp] = [Resistance::default(); 2];
        for (slot, far, which) in slots {
            let rest = match self.rest.get(slot) {
                Some(rest) => V::load(rest, part),
                None => V::load(&self.table.rests()[which], part),
            };
            let trial = Trial::new([x, y, z], &far, part, rest);
            let w = inv_mass + far.swing(part) * per_swing;
            let stiffness = self.table.stiffness::<V>(which, part);
            let direction = trial.direction();
            let shortness = rest * trial.inverse;
            // Nodes in one place are rare.
            let apart = V::above(stiffness, V::ZERO, trial.length, V::ONE);
            let sideways = if apart.all_above(V::of(ONE_PLACE)) {
                (V::ONE - shortness).max(V::ZERO)
            } else {
                sideways(direction, shortness)
            };
            let along = stiffness * w;
            stiff.add(direction, along, along * sideways);
            if DAMPED {
                damp.add_along(direction, self.table.damping::<V>(which, part) * w);
            }
        }
        let damp = if DAMPED { damp.largest() } else { V::ZERO };
        [stiff.largest(), damp]
    }
}
