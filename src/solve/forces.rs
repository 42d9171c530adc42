//! The force pass over springs.
//!
//! One loop for every kind of spring: what a body lacks (damping, limits) is left out by a constant parameter of the
//! function, not by a branch per spring. Elastic and damping forces are kept apart per node because the energy ledger
//! needs the work of damping by itself, and that is known only when the velocity after the substep is.

use super::springs::SpringTable;
use crate::body::state::{Particle, State};
use crate::law::{plastic, spring};
use crate::math::Scalar;

/// Forces on one node \[N\].
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Force<S> {
    pub elastic: [S; 3],
    pub pad: S,
    pub damping: [S; 3],
    pub pad2: S,
}

/// What happened in a pass.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Happened {
    /// Plastic work \[J\].
    pub plastic: f64,
    /// Energy of the springs that broke \[J\].
    pub fracture: f64,
}

/// A spring that yielded for the first time, or broke, at the state of the pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LimitEvent<S> {
    pub spring: u32,
    pub broke: bool,
    pub tension: S,
    pub energy: S,
}

/// Adds the force of every spring to its nodes. With `commit`, plastic flow and breaking are written to the state;
/// without, they only limit the force, as the inner stages of a scheme need.
pub(crate) fn add_spring_forces<S: Scalar>(
    table: &mut SpringTable<S>,
    state: &mut State<S>,
    forces: &mut [Force<S>],
    events: &mut Vec<LimitEvent<S>>,
    commit: bool,
) -> Happened {
    match (table.limits.is_empty(), commit, table.damped) {
        (true, _, false) => pass::<S, false, false, false>(table, state, forces, events),
        (true, _, true) => pass::<S, false, false, true>(table, state, forces, events),
        (false, false, false) => pass::<S, true, false, false>(table, state, forces, events),
        (false, false, true) => pass::<S, true, false, true>(table, state, forces, events),
        (false, true, false) => pass::<S, true, true, false>(table, state, forces, events),
        (false, true, true) => pass::<S, true, true, true>(table, state, forces, events),
    }
}

#[inline(always)]
fn sub<S: Scalar>(a: [S; 3], b: [S; 3]) -> [S; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Scalar product.
#[inline(always)]
pub(crate) fn dot<S: Scalar>(a: [S; 3], b: [S; 3]) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Direction from `a` to `b`, and their distance. Coincident nodes have no direction and get no force.
#[inline(always)]
pub(crate) fn axis<S: Scalar>(a: &Particle<S>, b: &Particle<S>) -> ([S; 3], S) {
    let d = sub(b.x, a.x);
    let squared = dot(d, d);
    let length = squared.sqrt();
    let inverse = S::ONE / squared.max(S::of(1e-30)).sqrt();
    ([d[0] * inverse, d[1] * inverse, d[2] * inverse], length)
}

fn pass<S: Scalar, const LIMITED: bool, const COMMIT: bool, const DAMPED: bool>(
    table: &mut SpringTable<S>,
    state: &mut State<S>,
    forces: &mut [Force<S>],
    events: &mut Vec<LimitEvent<S>>,
) -> Happened {
    let mut happened = Happened::default();
    let mut plastic_work = S::ZERO;
    let particles = &state.particles[..];
    let springs = table.links.len();
    let rest = &mut state.rest[..springs];
    let flows = &mut state.flow[..springs];
    for i in 0..springs {
        let link = table.links[i];
        let (ia, ib) = (link.a as usize, link.b as usize);
        let (a, b) = (&particles[ia], &particles[ib]);
        let (n, length) = axis(a, b);
        let elongation = length - rest[i];
        let mut tension = spring::tension(link.stiffness, elongation);
        if LIMITED {
            let limit = &table.limits[i];
            let mapped = plastic::return_map(link.stiffness, elongation, flows[i], &limit.yields);
            tension = mapped.tension;
            if COMMIT {
                let moved = mapped.flow.abs();
                let event = |broke, energy| LimitEvent {
                    spring: i as u32,
                    broke,
                    tension,
                    energy,
                };
                if flows[i] == S::ZERO && moved > S::ZERO {
                    let energy = spring::energy(link.stiffness, elongation - mapped.flow);
                    events.push(event(false, energy));
                }
                plastic_work += tension.abs() * moved;
                rest[i] += mapped.flow;
                flows[i] += moved;
                if tension > limit.break_force || length > limit.break_length {
                    let energy = spring::energy(link.stiffness, length - rest[i]);
                    events.push(event(true, energy));
                    happened.fracture += energy.f64();
                    state.broken[i] = true;
                    table.cut(i);
                    continue;
                }
            }
        }
        let pull = [n[0] * tension, n[1] * tension, n[2] * tension];
        if DAMPED {
            let viscous = spring::damping(link.damping, dot(sub(b.v, a.v), n));
            let drag = [n[0] * viscous, n[1] * viscous, n[2] * viscous];
            for k in 0..3 {
                forces[ia].damping[k] += drag[k];
                forces[ib].damping[k] -= drag[k];
            }
        }
        for k in 0..3 {
            forces[ia].elastic[k] += pull[k];
            forces[ib].elastic[k] -= pull[k];
        }
    }
    happened.plastic = plastic_work.f64();
    happened
}
