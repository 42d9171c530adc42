//! The rates of nodes by rows, for the stable substep; [`crate::solve::stable`] says what they are and has the scalar loop.

use super::pass::Trial;
use super::table::Table;
use super::vector::{Half, LANES, Pass, Vector, Wide, Width, Writer, run};
use crate::body::state::State;
use crate::law::stable::{Symmetric, add_spring, sideways};
use crate::solve::solver::Solver;
use crate::solve::springs::Rows;
use crate::solve::stable::Rates;

/// Writes the rates of stiffness, and of viscosity where there is any; `false` where there are no rows to do it by.
pub(crate) fn rates(
    solver: &Solver<f32>,
    state: &State<f32>,
    [stiff, damp]: &mut [Vec<Rates<f32>>; 2],
) -> bool {
    let Rows::Made(sell) = &solver.table.rows else {
        return false;
    };
    let out = &sell.layout.out;
    let (Some(table), Some(stiff)) = (Table::of(&sell.layout, &state.particles), out.of_mut(stiff))
    else {
        return false;
    };
    if Width::of(solver.kernel) == Width::Portable {
        return false;
    }
    let pass = NodeRates {
        rest: sell.limits.as_ref().map_or(&[], |l| &l.rest[..]),
        stiff,
        damp: out.of_mut(damp).filter(|_| table.is_damped()),
        table,
    };
    run(solver.kernel, pass);
    true
}

struct NodeRates<'a> {
    table: Table<'a>,
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
                let [stiff, damp] = self.of_nodes::<V>(slice, part);
                let put = |out: &mut Writer<'_, Rates<f32>>, [a, b, c, d, e, f]: Symmetric<V>| {
                    out.put(slice, part, Half::First, [a, b, c, d]);
                    out.put(slice, part, Half::Second, [e, f, V::ZERO, V::ZERO]);
                };
                put(&mut self.stiff, stiff);
                if let Some(out) = &mut self.damp {
                    put(out, damp);
                }
            }
        }
    }
}

impl NodeRates<'_> {
    #[inline(always)]
    fn of_nodes<V: Vector>(&self, slice: usize, part: usize) -> [Symmetric<V>; 2] {
        let own = self.table.own(slice);
        let [x, y, z, inv_mass] = own.columns::<V>(part, Half::First);
        let [.., swing] = own.columns::<V>(part, Half::Second);
        let per_swing = V::above(swing, V::ZERO, inv_mass / swing, V::ZERO);
        let (mut stiff, mut damp) = ([V::ZERO; 6], [V::ZERO; 6]);
        for (slot, far, which) in self.table.slots(slice) {
            let rest = match self.rest.get(slot) {
                Some(rest) => V::load(rest, part),
                None => V::load(&self.table.rests()[which], part),
            };
            let [.., swing] = far.columns::<V>(part, Half::Second);
            let trial = Trial::new([x, y, z], &far, part, rest);
            let w = inv_mass + swing * per_swing;
            let along = self.table.stiffness::<V>(which, part) * w;
            let across = along * sideways(trial.direction, rest, trial.length);
            add_spring(&mut stiff, trial.direction, along, across);
            if self.damp.is_some() {
                let along = self.table.damping::<V>(which, part) * w;
                add_spring(&mut damp, trial.direction, along, V::ZERO);
            }
        }
        [stiff, damp]
    }
}
