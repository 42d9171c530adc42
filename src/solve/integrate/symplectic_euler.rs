//! Symplectic (semi-implicit) Euler: v += h·F(x, v)/m, then x += h·v. Read as leapfrog its velocities stand at half
//! steps, which is what makes the work sums exact. Damping uses the last velocity (lagged).

use super::{Sums, acceleration, applied_at};
use crate::body::state::State;
use crate::math::Scalar;
use crate::solve::external::ForceField;
use crate::solve::kernel::{self, of_f32_mut};
use crate::solve::solver::Solver;

pub(super) fn predict<S: Scalar>(
    solver: &mut Solver<S>,
    state: &mut State<S>,
    h: S,
    field: Option<&dyn ForceField>,
) {
    solver.evaluate(state, field, Some(h), S::ZERO);
    let half = S::of(0.5) * h;
    let mut sums = Sums::new();
    let moved = by_kernel(solver, state, h, &mut sums);
    for i in moved..state.particles.len() {
        let p = &mut state.particles[i];
        let applied = applied_at(&solver.applied, i);
        let a = acceleration(p, &solver.forces[i], applied, solver.external.gravity);
        let mut twice_mean = p.v;
        for k in 0..3 {
            p.v[k] += h * a[k];
            twice_mean[k] += p.v[k];
        }
        let v = p.v;
        let mean = [
            half * twice_mean[0],
            half * twice_mean[1],
            half * twice_mean[2],
        ];
        sums.book(p, &solver.forces[i], applied, mean);
        sums.speed(v);
        state.displace(i, [h * v[0], h * v[1], h * v[2]]);
    }
    sums.flush(solver);
}

/// Moves the first nodes by a kernel, if there is one; how many.
fn by_kernel<S: Scalar>(
    solver: &mut Solver<S>,
    state: &mut State<S>,
    h: S,
    sums: &mut Sums<S>,
) -> usize {
    let (Some(solver), Some(state)) = (of_f32_mut(solver), of_f32_mut(state)) else {
        return 0;
    };
    let (moved, totals) = kernel::symplectic_euler(solver, state, h.f64() as f32);
    sums.include(&totals);
    moved
}
