//! Symplectic (semi-implicit) Euler: v += h·F(x, v)/m, then x += h·v. Read as leapfrog its velocities stand at half
//! steps, which is what makes the work sums exact. Damping uses the last velocity (lagged).
//!
//! Where the substep is another one than before, forces within the body act from the middle of the one to the middle of the
//! other. Those from outside act for the new one, so that what falls freely has the velocity of its time.

use super::{Sums, acceleration, applied_at};
use crate::body::state::State;
use crate::math::Scalar;
use crate::solve::external::ForceField;
use crate::solve::forces::Commit;
use crate::solve::kernel::{self, of_f32_mut};
use crate::solve::solver::Solver;

pub(super) fn predict<S: Scalar>(
    solver: &mut Solver<S>,
    state: &mut State<S>,
    h: S,
    field: Option<&dyn ForceField>,
) {
    let last = solver.last_substep.take().map_or(h, S::of);
    let commit = Commit {
        since: last,
        lead: S::of(0.5) * last,
    };
    solver.evaluate(state, field, Some(commit), S::ZERO);
    if last != h {
        let share = S::of(0.5) * (S::ONE + last / h);
        solver.forces.scale(share);
    }
    let half = S::of(0.5) * h;
    let mut sums = Sums::new();
    let moved = by_kernel(solver, state, h, &mut sums);
    for i in moved..state.particles.len() {
        let p = &mut state.particles[i];
        let applied = applied_at(&solver.applied, i);
        let a = acceleration(p, &solver.forces.at(i), applied, solver.external.gravity);
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
        sums.book(p, &solver.forces.at(i), applied, mean);
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

#[cfg(test)]
mod tests {
    use crate::body::net::Spring;
    use crate::body::state::State;
    use crate::solve::Integrator;
    use crate::solve::solver::Solver;

    /// Symptom: the energy of a block that struck a plate jumped by ½Δh times the power of its forces in the middle of the blow.
    /// Cause: there the substep was chosen anew, and velocities, which stand half a substep back, were taken for those of the
    /// new one.
    #[test]
    fn a_change_of_the_substep_gives_no_energy() {
        let spring = Spring::new(0, 1, 100.0).rest_length(1.0);
        let free = ([1.1, 0.0, 0.0], [0.01, 0.0, 0.0], 1.0);
        let mut state = State::<f64>::new([([0.0; 3], [0.0; 3], 0.0), free], [1.0]);
        let mut solver = Solver::new(&[spring], &state);
        let (mut time, mut most, mut last) = (0.0_f64, 0.0_f64, 2e-3);
        while time < 5.0 {
            // Long ones where the mass slows down or speeds up the most, so that all changes would give energy.
            let long = (20.0 * time).cos() > 0.0;
            let h = if long { 2e-3 } else { 5e-4 };
            solver.last_substep = Some(last);
            solver.substep(&mut state, Integrator::SymplecticEuler, h);
            (time, last) = (time + h, h);
            let x = state.position(1).x;
            most = most.max((x - 1.0 - 0.1 * (10.0 * time).cos()).abs());
        }
        assert!(most < 2e-4, "{most} m off");
    }
}
