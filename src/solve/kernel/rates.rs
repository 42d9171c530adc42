//! The rates of nodes by rows, for the stable substep; [`crate::solve::stable`] says what they are and has the scalar loop.

use super::mirror::Copied;
use super::sell::Sell;
use super::table::{End, Table};
use super::trial::Trial;
use super::vector::{Half, LANES, Pass, Runs, Vector, Wide, Width, Writer, run};
use crate::body::state::State;
use crate::law::stable::{Symmetric, about_largest, add_spring, cheap_bound, sideways};
use crate::solve::solver::Solver;
use crate::solve::springs::Rows;
use crate::solve::stable::Rates;

/// Writes the rates of stiffness, and of viscosity where there is any; `false` where there are no rows to do it by.
pub(crate) fn rates(
    solver: &mut Solver<f32>,
    state: &State<f32>,
    [stiff, damp]: &mut [Vec<Rates<f32>>; 2],
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
    let (Some(table), Some(stiff)) = (
        Table::of(layout, &state.particles),
        layout.out.of_mut(stiff),
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
        stiff,
        damp: layout.out.of_mut(damp).filter(|_| table.is_damped()),
        table,
        runs,
    };
    run(solver.kernel, pass);
    true
}

struct NodeRates<'a> {
    table: Table<'a>,
    runs: Runs<'a>,
    /// Rest lengths by slot, where they can change, else empty.
    rest: &'a [Wide],
    stiff: Writer<'a, Rates<f32>>,
    damp: Option<Writer<'a, Rates<f32>>>,
}

impl Pass for NodeRates<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector>(mut self) {
        for slice in 0..self.table.slices() {
            for part in 0..LANES / V::LANES {
                let [stiff, damp] = if self.table.is_regular(slice) {
                    let slots = self.table.regular_slots(slice, &self.runs);
                    self.of_nodes::<V, _>((slice, part), slots)
                } else {
                    self.of_nodes::<V, _>((slice, part), self.table.slots(slice))
                };
                put(&mut self.stiff, (slice, part), stiff);
                if let Some(out) = &mut self.damp {
                    put(out, (slice, part), damp);
                }
            }
        }
    }
}

#[inline(always)]
fn put<V: Vector>(
    out: &mut Writer<'_, Rates<f32>>,
    (slice, part): (usize, usize),
    m: Symmetric<V>,
) {
    let [a, b, c, d, e, f] = m;
    out.put(slice, part, Half::First, [a, b, c, d]);
    let ends = [e, f, cheap_bound(&m), about_largest(&m)];
    out.put(slice, part, Half::Second, ends);
}

impl NodeRates<'_> {
    #[inline(always)]
    fn of_nodes<V: Vector, E: End<V>>(
        &self,
        (slice, part): (usize, usize),
        slots: impl Iterator<Item = (usize, E, usize)>,
    ) -> [Symmetric<V>; 2] {
        let own = self.table.own(slice);
        let [x, y, z, inv_mass] = own.columns::<V>(part, Half::First);
        let [.., swing] = own.columns::<V>(part, Half::Second);
        let per_swing = V::above(swing, V::ZERO, inv_mass / swing, V::ZERO);
        let (mut stiff, mut damp) = ([V::ZERO; 6], [V::ZERO; 6]);
        for (slot, far, which) in slots {
            let rest = match self.rest.get(slot) {
                Some(rest) => V::load(rest, part),
                None => V::load(&self.table.rests()[which], part),
            };
            let trial = Trial::new([x, y, z], &far, part, rest);
            let w = inv_mass + far.swing(part) * per_swing;
            let along = self.table.stiffness::<V>(which, part) * w;
            let direction = trial.direction();
            let across = along * sideways(direction, rest, trial.length);
            add_spring(&mut stiff, direction, along, across);
            if self.damp.is_some() {
                let along = self.table.damping::<V>(which, part) * w;
                add_spring(&mut damp, direction, along, V::ZERO);
            }
        }
        [stiff, damp]
    }
}
