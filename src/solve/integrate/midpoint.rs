//! Explicit midpoint (RK2): a half step of explicit Euler, then a whole step with the slope found there.

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
    let half = S::of(0.5) * h;
    solver.save_start(state);
    solver.evaluate(state, field, Some(Commit::after(h)), S::ZERO);
    for (i, p) in state.particles.iter_mut().enumerate() {
        let a = acceleration(
            p,
            &solver.forces.at(i),
            applied_at(&solver.applied, i),
            solver.external.gravity,
        );
        for (k, a) in a.into_iter().enumerate() {
            p.x[k] += half * p.v[k];
            p.v[k] += half * a;
        }
    }
    solver.evaluate(state, field, None, half);
    let mut sums = Sums::new();
    for i in 0..state.particles.len() {
        let p = &mut state.particles[i];
        let applied = applied_at(&solver.applied, i);
        let a = acceleration(p, &solver.forces.at(i), applied, solver.external.gravity);
        let moved = [h * p.v[0], h * p.v[1], h * p.v[2]];
        sums.book(p, &solver.forces.at(i), applied, moved);
        let (x, v) = solver.start[i];
        p.x = x;
        for (k, a) in a.into_iter().enumerate() {
            p.v[k] = v[k] + h * a;
        }
        sums.speed(p.v);
        state.displace(i, moved);
    }
    sums.flush(solver);
}
