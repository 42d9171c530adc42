//! The force pass over springs: by the kernels of [`super::kernel`] where the scalar is `f32`, else by a scalar loop.
//!
//! One loop for every kind of spring: what a body lacks (damping, limits) is left out by a constant parameter of the
//! function, not by a branch per spring. Elastic and damping forces are kept apart per node because the energy ledger
//! needs the work of damping by itself, and that is known only when the velocity after the substep is.

use super::kernel::{self, Kernel, of_f32_mut};
use super::springs::SpringTable;
use crate::body::state::{Particle, State};
use crate::law::{plastic, spring};
use crate::math::Scalar;

/// Four lanes, of which the last one carries nothing: what a vector register holds of a node.
pub(crate) type Lanes<S> = [S; 4];

/// Forces on one node \[N\].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Force<S> {
    pub elastic: Lanes<S>,
    pub damping: Lanes<S>,
}

/// Forces on all nodes \[N\].
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(crate) struct Forces<S> {
    /// One for each node, and one more that means nothing.
    pub elastic: Vec<Lanes<S>>,
    /// As many, or none where nothing was damped at the last evaluation.
    pub damping: Vec<Lanes<S>>,
}

impl<S: Scalar> Force<S> {
    /// Elastic and damping force.
    #[inline(always)]
    pub fn sum(&self) -> [S; 3] {
        [0, 1, 2].map(|k| self.elastic[k] + self.damping[k])
    }
}

impl<S: Scalar> Forces<S> {
    /// None yet on so many nodes.
    pub fn new(nodes: usize) -> Self {
        Self {
            elastic: vec![Default::default(); nodes + 1],
            damping: Vec::new(),
        }
    }

    /// Whether they are as many as so many nodes want.
    #[cfg(feature = "serde-serialize")]
    pub fn are_of(&self, nodes: usize) -> bool {
        let damping = self.damping.len();
        self.elastic.len() == nodes + 1 && (damping == 0 || damping == nodes + 1)
    }

    /// Those on a node.
    #[inline(always)]
    pub fn at(&self, node: usize) -> Force<S> {
        Force {
            elastic: self.elastic[node],
            damping: self.damping.get(node).copied().unwrap_or_default(),
        }
    }

    /// Makes room for damping forces, or leaves none.
    pub fn set_damped(&mut self, damped: bool) {
        let wanted = if damped { self.elastic.len() } else { 0 };
        self.damping.resize(wanted, Default::default());
    }

    /// Makes all zero.
    pub fn clear(&mut self) {
        self.elastic.fill(Default::default());
        self.damping.fill(Default::default());
    }

    /// Makes all so many times as large.
    pub fn scale(&mut self, by: S) {
        let all = self.elastic.iter_mut().chain(&mut self.damping);
        all.for_each(|f| *f = scale(*f, by));
    }
}

/// What happened in a pass.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Happened {
    /// Plastic work \[J\].
    pub plastic: f64,
    /// Energy that went with the springs that broke \[J\].
    pub fracture: f64,
}

/// Says that flow and breaking are to be written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Commit<S> {
    /// Time since the last one \[s\].
    pub since: S,
    /// By how much velocities stand before the positions, half a substep or nothing \[s\]. What a tension does to them in that time
    /// counts as kinetic energy, and goes with the spring that breaks.
    pub lead: S,
}

impl<S: Scalar> Commit<S> {
    /// Where velocities are those of the positions, `since` s after the last.
    pub fn after(since: S) -> Self {
        Self {
            since,
            lead: S::ZERO,
        }
    }
}

/// A spring that yielded for the first time, or broke, at the state of the pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LimitEvent<S> {
    pub spring: u32,
    pub broke: bool,
    pub tension: S,
    pub energy: S,
}

/// Writes the force of springs, and of drag D \[N·s/m\], on every node. With `commit` plastic flow and breaking are written to the
/// state; without, they only limit the force, as the inner stages of a scheme need. Damping forces need room, see [`Forces::set_damped`].
pub(crate) fn spring_forces<S: Scalar>(
    kernel: Kernel,
    table: &mut SpringTable<S>,
    state: &mut State<S>,
    forces: &mut Forces<S>,
    events: &mut Vec<LimitEvent<S>>,
    (commit, drag): (Option<Commit<S>>, S),
) -> Happened {
    if let (Some(table), Some(state), Some(forces), Some(events)) = (
        of_f32_mut(table),
        of_f32_mut(state),
        of_f32_mut(forces),
        of_f32_mut(events),
    ) {
        let narrow = |x: S| x.f64() as f32;
        let commit = commit.map(|Commit { since, lead }| Commit {
            since: narrow(since),
            lead: narrow(lead),
        });
        let settings = (commit, narrow(drag));
        let done = kernel::spring_forces(kernel, table, state, forces, events, settings);
        if let Some(happened) = done {
            return happened;
        }
    }
    forces.clear();
    if drag > S::ZERO {
        for (f, p) in forces.damping.iter_mut().zip(&state.particles) {
            for (f, v) in f.iter_mut().zip(p.v) {
                *f = -(drag * v);
            }
        }
    }
    add_spring_forces(table, state, forces, events, commit)
}

/// The scalar pass: adds the force of every spring to its nodes. For scalars other than `f32`, and what the kernels are
/// checked against.
pub(crate) fn add_spring_forces<S: Scalar>(
    table: &mut SpringTable<S>,
    state: &mut State<S>,
    forces: &mut Forces<S>,
    events: &mut Vec<LimitEvent<S>>,
    commit: Option<Commit<S>>,
) -> Happened {
    let c = commit.unwrap_or(Commit::after(S::ZERO));
    match (table.limits.is_empty(), commit.is_some(), table.damped) {
        (true, _, false) => pass::<S, false, false, false>(table, state, forces, events, c),
        (true, _, true) => pass::<S, false, false, true>(table, state, forces, events, c),
        (false, false, false) => pass::<S, true, false, false>(table, state, forces, events, c),
        (false, false, true) => pass::<S, true, false, true>(table, state, forces, events, c),
        (false, true, false) => pass::<S, true, true, false>(table, state, forces, events, c),
        (false, true, true) => pass::<S, true, true, true>(table, state, forces, events, c),
    }
}

/// Scalar product of three components.
#[inline(always)]
pub(crate) fn dot<S: Scalar>(a: [S; 3], b: [S; 3]) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn dot_lanes<S: Scalar>(a: Lanes<S>, b: Lanes<S>) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The lanes that mean something.
#[inline(always)]
pub(crate) fn three<S: Scalar>(a: Lanes<S>) -> [S; 3] {
    [a[0], a[1], a[2]]
}

#[inline(always)]
fn sub<S: Scalar>(a: Lanes<S>, b: Lanes<S>) -> Lanes<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}

#[inline(always)]
fn scale<S: Scalar>(a: Lanes<S>, by: S) -> Lanes<S> {
    [a[0] * by, a[1] * by, a[2] * by, a[3] * by]
}

#[inline(always)]
pub(crate) fn add_to<S: Scalar>(sum: &mut Lanes<S>, a: Lanes<S>) {
    *sum = [sum[0] + a[0], sum[1] + a[1], sum[2] + a[2], sum[3] + a[3]];
}

#[inline(always)]
fn position<S: Scalar>(p: &Particle<S>) -> Lanes<S> {
    [p.x[0], p.x[1], p.x[2], p.inv_mass]
}

#[inline(always)]
fn velocity<S: Scalar>(p: &Particle<S>) -> Lanes<S> {
    [p.v[0], p.v[1], p.v[2], p.swing]
}

/// The way from `a` to `b` (the fourth lane means nothing), its length, and 1/length. Coincident nodes get no force.
#[inline(always)]
fn reach<S: Scalar>(a: &Particle<S>, b: &Particle<S>) -> (Lanes<S>, S, S) {
    let d = sub(position(b), position(a));
    let length = dot_lanes(d, d).max(S::of(spring::LEAST_SQUARE)).sqrt();
    (d, length, S::ONE / length)
}

/// Direction from `a` to `b` (the fourth lane means nothing), and 1 over their distance. Coincident nodes have no direction.
#[inline(always)]
pub(crate) fn axis<S: Scalar>(a: &Particle<S>, b: &Particle<S>) -> (Lanes<S>, S) {
    let (d, _, inverse) = reach(a, b);
    (scale(d, inverse), inverse)
}

fn pass<S: Scalar, const LIMITED: bool, const COMMIT: bool, const DAMPED: bool>(
    table: &mut SpringTable<S>,
    state: &mut State<S>,
    forces: &mut Forces<S>,
    events: &mut Vec<LimitEvent<S>>,
    commit: Commit<S>,
) -> Happened {
    let mut happened = Happened::default();
    let old_events = events.len();
    let particles = &state.particles[..];
    let links = &table.links[..];
    let rest = &mut state.rest[..links.len()];
    let flows = &mut state.flow[..links.len()];
    let limits = &table.limits[..if LIMITED { links.len() } else { 0 }];
    for (i, link) in links.iter().enumerate() {
        let (ia, ib) = (link.a as usize, link.b as usize);
        let (a, b) = (&particles[ia], &particles[ib]);
        let (d, length, inverse) = reach(a, b);
        let elongation = length - rest[i];
        let mut tension = spring::tension(link.stiffness, elongation);
        let mut viscosity = link.damping;
        if LIMITED && limits[i].may_matter(tension, length) {
            let limit = &limits[i];
            let mapped =
                plastic::return_map(link.stiffness, rest[i], elongation, flows[i], &limit.yields);
            tension = mapped.tension;
            let breaks = (tension > limit.break_force) | (length > limit.break_length);
            // Rare, and in runs: springs flow together, for many substeps.
            if COMMIT && (mapped.flow != S::ZERO || breaks) {
                let event = |broke| LimitEvent {
                    spring: i as u32,
                    broke,
                    tension,
                    energy: spring::energy(link.stiffness, elongation - mapped.flow),
                };
                let rate = dot_lanes(sub(velocity(b), velocity(a)), d) * inverse;
                if mapped.flow != S::ZERO {
                    // The trapezoid, as for every other work: the tension of the last commit follows from the rate.
                    let last = link.stiffness * (elongation - commit.since * rate);
                    happened.plastic += plastic::work(last, &mapped).f64();
                    if flows[i] == S::ZERO {
                        events.push(event(false));
                    }
                    rest[i] += mapped.flow;
                    flows[i] += mapped.flow.abs();
                }
                if breaks {
                    let event = event(true);
                    happened.fracture += (event.energy - commit.lead * tension * rate).f64();
                    events.push(event);
                    (tension, viscosity) = (S::ZERO, S::ZERO);
                }
            }
        }
        let pull = scale(d, tension * inverse);
        if DAMPED {
            let rate = dot_lanes(sub(velocity(b), velocity(a)), d) * inverse;
            let viscous = scale(d, spring::damping(viscosity, rate) * inverse);
            add_to(&mut forces.damping[ia], viscous);
            add_to(&mut forces.damping[ib], scale(viscous, -S::ONE));
        }
        add_to(&mut forces.elastic[ia], pull);
        add_to(&mut forces.elastic[ib], scale(pull, -S::ONE));
    }
    table.cut_broken(state, &events[old_events..]);
    happened
}
