//! The classical Runge–Kutta scheme of order 4. Work of damping and external forces uses the same quadrature.

use super::{Sums, acceleration, applied_at};
use crate::body::state::State;
use crate::math::Scalar;
use crate::solve::external::ForceField;
use crate::solve::forces::Commit;
use crate::solve::solver::Solver;

/// Where the next stage stands (fraction of h from the start) and the weight of this one.
const STAGES: [(f64, f64); 4] = [
    (0.5, 1.0 / 6.0),
    (0.5, 1.0 / 3.0),
    (1.0, 1.0 / 3.0),
    (0.0, 1.0 / 6.0),
];

pub(super) fn predict<S: Scalar>(
    solver: &mut Solver<S>,
    state: &mut State<S>,
    h: S,
    field: Option<&dyn ForceField>,
) {
    solver.save_start(state);
    solver.sums.clear();
    solver
        .sums
        .resize(state.particles.len(), ([S::ZERO; 3], [S::ZERO; 3]));
    let mut sums = Sums::new();
    let mut after = S::ZERO;
    for (stage, (to_next, weight)) in STAGES.into_iter().enumerate() {
        let commit = (stage == 0).then_some(Commit::after(h));
        solver.evaluate(state, field, commit, after);
        let (next, weight) = (h * S::of(to_next), h * S::of(weight));
        after = next;
        for (i, p) in state.particles.iter_mut().enumerate() {
            let applied = applied_at(&solver.applied, i);
            let a = acceleration(p, &solver.forces.at(i), applied, solver.external.gravity);
            let along = [weight * p.v[0], weight * p.v[1], weight * p.v[2]];
            sums.book(p, &solver.forces.at(i), applied, along);
            let (x, v) = solver.start[i];
            let (moved, kicked) = &mut solver.sums[i];
            for k in 0..3 {
                moved[k] += along[k];
                kicked[k] += weight * a[k];
                p.x[k] = x[k] + next * p.v[k];
                p.v[k] = v[k] + next * a[k];
            }
        }
    }
    for i in 0..state.particles.len() {
        let (x, v) = solver.start[i];
        let (moved, kicked) = solver.sums[i];
        let p = &mut state.particles[i];
        p.x = x;
        for k in 0..3 {
            p.v[k] = v[k] + kicked[k];
        }
        sums.speed(p.v);
        state.displace(i, moved);
    }
    sums.flush(solver);
}
