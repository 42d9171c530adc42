//! Velocity Verlet: v½ = v + ½h·a(x, v½), x += h·v½, v = v½ + ½h·a(x, v½).
//!
//! Damping is c·v½ in both halves. The first half is implicit in v½ and solved by fixed-point passes; damping lagged by a whole
//! step would drop the order to 1. Two passes keep order 2, but then forces that hold a damped body still meet other damping
//! than they were found for, and do work though nothing moves.
//!
//! The work of each force is booked as if, of the two half kicks at a position, damping did its part next to the instant of
//! the position, and all else before and after: then elastic forces work over the trapezoid of the displacements, by which
//! ½m·v⁻·v⁺ + U is kept exactly where they are linear, whatever damping did.

use super::{Sums, acceleration, applied_at, dot};
use crate::body::state::{Particle, State};
use crate::math::Scalar;
use crate::solve::external::ForceField;
use crate::solve::forces::{Commit, Force};
use crate::solve::solver::Solver;

/// What the last pass may still change, in changes by the first \[1\]. Passes contract by ½hc, at most ¼ (see
/// [`verlet`](crate::law::stable::verlet)), so the eighth is the last.
const SETTLED: f64 = 1e-4;
/// Passes after which a velocity that does not settle is left alone: it is not finite, or a force field jumps.
const MOST: usize = 16;

pub(super) fn predict<S: Scalar>(
    solver: &mut Solver<S>,
    state: &mut State<S>,
    h: S,
    field: Option<&dyn ForceField>,
) {
    let half = S::of(0.5) * h;
    solver.save_start(state);
    let damped = solver.is_damped() || field.is_some();
    solver.evaluate(state, field, Some(Commit::after(h)), S::ZERO);
    let kick = half_kick(solver, state, half);
    let (mut change, mut passes) = (kick, 1);
    while damped && change > SETTLED * kick && passes < MOST {
        solver.evaluate(state, field, None, S::ZERO);
        change = half_kick(solver, state, half);
        passes += 1;
    }
    let mut sums = Sums::new();
    for i in 0..state.particles.len() {
        let p = state.particles[i];
        let f = solver.forces.at(i);
        let between = kicked(half, solver.start[i].1, &p, &f);
        let damped = quarter(half, solver.start[i].1, between);
        let moved = quarter(half, between, p.v);
        sums.book_apart(&p, &f, applied_at(&solver.applied, i), damped, moved);
        sums.speed(p.v);
        state.displace(i, [h * p.v[0], h * p.v[1], h * p.v[2]]);
    }
    sums.flush(solver);
}

pub(super) fn finish<S: Scalar>(
    solver: &mut Solver<S>,
    state: &mut State<S>,
    h: S,
    field: Option<&dyn ForceField>,
) {
    let half = S::of(0.5) * h;
    solver.save_start(state);
    solver.evaluate(state, field, None, h);
    half_kick(solver, state, half);
    let mut sums = Sums::new();
    for (i, p) in state.particles.iter().enumerate() {
        let f = solver.forces.at(i);
        let between = kicked(-half, p.v, p, &f);
        let moved = quarter(half, solver.start[i].1, between);
        let damped = quarter(half, between, p.v);
        sums.book_apart(p, &f, applied_at(&solver.applied, i), damped, moved);
        sums.speed(p.v);
    }
    sums.flush(solver);
}

/// v = v_start + ½h·a. Returns the largest change of any velocity \[m/s\].
fn half_kick<S: Scalar>(solver: &Solver<S>, state: &mut State<S>, half: S) -> f64 {
    let mut largest: f64 = 0.0;
    for (i, p) in state.particles.iter_mut().enumerate() {
        let a = acceleration(
            p,
            &solver.forces.at(i),
            applied_at(&solver.applied, i),
            solver.external.gravity,
        );
        let before = p.v;
        for (k, a) in a.into_iter().enumerate() {
            p.v[k] = solver.start[i].1[k] + half * a;
        }
        let change = [0, 1, 2].map(|k| p.v[k] - before[k]);
        largest = largest.max(dot(change, change).f64());
    }
    largest.sqrt()
}

/// A velocity after what damping does to it in that time.
#[inline(always)]
fn kicked<S: Scalar>(time: S, v: [S; 3], p: &Particle<S>, f: &Force<S>) -> [S; 3] {
    let by = time * p.inv_mass;
    [0, 1, 2].map(|k| v[k] + by * f.damping[k])
}

/// Mean displacement over which half a kick works: ½h·(v⁻ + v⁺)/2.
#[inline(always)]
fn quarter<S: Scalar>(half: S, before: [S; 3], after: [S; 3]) -> [S; 3] {
    let q = half * S::of(0.5);
    [
        q * (before[0] + after[0]),
        q * (before[1] + after[1]),
        q * (before[2] + after[2]),
    ]
}
