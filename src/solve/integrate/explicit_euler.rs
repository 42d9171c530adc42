//! Explicit (forward) Euler exactly as the textbook writes it: X += h·V with the old V, then V += h·F/m.

use super::{Sums, acceleration, applied_at};
use crate::body::state::State;
use crate::math::Scalar;
use crate::solve::external::ForceField;
use crate::solve::forces::Commit;
use crate::solve::solver::Solver;

pub(super) fn predict<S: Scalar>(
    solver: &mut Solver<S>,
    state: &mut State<S>,
    h: S,
    field: Option<&dyn ForceField>,
) {
    solver.evaluate(state, field, Some(Commit::after(h)), S::ZERO);
    let mut sums = Sums::new();
    for i in 0..state.particles.len() {
        let p = state.particles[i];
        let applied = applied_at(&solver.applied, i);
        let a = acceleration(&p, &solver.forces.at(i), applied, solver.external.gravity);
        let moved = [h * p.v[0], h * p.v[1], h * p.v[2]];
        sums.book(&p, &solver.forces.at(i), applied, moved);
        state.displace(i, moved);
        let v = &mut state.particles[i].v;
        for k in 0..3 {
            v[k] += h * a[k];
        }
        sums.speed(*v);
    }
    sums.flush(solver);
}
