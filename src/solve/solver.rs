//! The solver of one body: its spring table and elements, forces from outside, scratch of a substep, and sums of work.
//!
//! It advances a [`State`] that it does not own. A substep has three parts: [`Solver::predict`] moves the body freely,
//! rows may then change velocities through `kick`, and [`Solver::finish`] completes schemes that evaluate the
//! force at the new position. What springs have flowed is kept in the order of the kernels until [`Solver::write_back`].

use super::external::{External, ForceField};
use super::fem::Part;
use super::forces::{Commit, Forces, LimitEvent, dot, spring_forces, three};
use super::gauge::Gauge;
use super::integrate::Integrator;
use super::kernel::{self, Kernel, Totals, of_f32, of_f32_mut};
use super::springs::{Rows, SpringTable};
use super::stable::Rates;
use super::threads;
use super::work::Work;
use crate::body::NodeId;
use crate::body::net::Spring;
use crate::body::state::State;
use crate::math::{DVec3, Scalar, Vector};

/// Advances one body of springs and elements. Generic over the scalar, so that the schemes can be checked in `f64`.
///
/// ```
/// use crumple::{body::{Spring, State}, solve::{Integrator, Solver}};
/// // A mass of 1 kg on a spring of 100 N/m, 0.1 m out of rest.
/// let spring = Spring::new(0, 1, 100.0).rest_length(1.0);
/// let mut state = State::<f64>::new([([0.0; 3], [0.0; 3], 0.0), ([1.1, 0.0, 0.0], [0.0; 3], 1.0)], [1.0]);
/// let mut solver = Solver::new(&[spring], &state);
/// for _ in 0..1000 {
///     solver.substep(&mut state, Integrator::VelocityVerlet, 1e-3);
/// }
/// let exact = 1.0 + 0.1 * (10.0_f64 * 1.0).cos();
/// assert!((state.position(1).x - exact).abs() < 1e-4);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Solver<S> {
    pub(crate) table: SpringTable<S>,
    pub(crate) part: Option<Part<S>>,
    /// With which vectors it computes, where its scalar is `f32`.
    pub kernel: Kernel,
    /// Gravity, drag and node forces.
    pub external: External<S>,
    /// Work done so far.
    pub work: Work,
    /// Simulated time \[s\].
    pub time: f64,
    /// How long the last substep was \[s\], if nothing has been changed by hand since, for symplectic Euler.
    pub(crate) last_substep: Option<f64>,
    pub(crate) forces: Forces<S>,
    /// Sum of node forces and field at each node; empty when there are none.
    pub(crate) applied: Vec<[S; 3]>,
    pub(crate) start: Vec<([S; 3], [S; 3])>,
    pub(crate) sums: Vec<([S; 3], [S; 3])>,
    /// Of each block of nodes.
    pub(crate) totals: Vec<Totals>,
    /// Of each node when it was last looked at, and one more.
    pub(crate) last_rates: Vec<Rates<S>>,
    /// A bound of the square of its highest undamped frequency when it was last looked at \[1/s²\].
    pub(crate) stiffest: f64,
    /// Its longest stable substep then \[s\].
    pub(crate) stable_h: f64,
    /// Springs that yielded or broke since the last look. Each does so once.
    pub(crate) events: Vec<LimitEvent<S>>,
    /// Largest squared speed that the last integration pass has seen, before rows gave their impulses; NaN or infinite when a
    /// velocity was.
    pub(crate) speed_squared: S,
    /// Whether threads pay.
    pub(crate) gauge: Gauge,
}

impl<S: Scalar> Solver<S> {
    /// A solver for resolved springs (rest lengths and constants set) and a state that only it changes: rest lengths, flow and
    /// what has broken are read here and then kept track of.
    pub fn new(springs: &[Spring], state: &State<S>) -> Self {
        let table = SpringTable::new(springs, state);
        Self {
            events: Vec::with_capacity(2 * table.limits.len()),
            table,
            forces: Forces::new(state.particles.len()),
            ..Self::default()
        }
    }

    /// The same with finite elements over the nodes.
    pub fn with_elements(self, part: Part<S>) -> Self {
        Self {
            part: Some(part),
            ..self
        }
    }

    /// Whether any force depends on velocities.
    pub(crate) fn is_damped(&self) -> bool {
        let elements = self.part.as_ref().is_some_and(|p| p.model.is_damped());
        self.table.damped || elements || self.external.drag > S::ZERO
    }

    /// Bytes of the tables of springs once it has made a substep: what one without yielding reads, and all of them.
    pub fn table_bytes(&self) -> [usize; 2] {
        let own = size_of_val(&self.table.links[..]) + size_of_val(&self.table.limits[..]);
        match &self.table.rows {
            Rows::Made(sell) => {
                let [hot, all] = sell.bytes();
                [hot, all + own]
            }
            _ => [own; 2],
        }
    }

    /// One whole substep of h s without contact.
    pub fn substep(&mut self, state: &mut State<S>, integrator: Integrator, h: f64) {
        self.substeps(state, integrator, h, 1);
    }

    /// `n` such substeps; faster than one by one where springs flow.
    pub fn substeps(&mut self, state: &mut State<S>, integrator: Integrator, h: f64, n: usize) {
        for _ in 0..n {
            self.predict(state, integrator, h, None);
            self.finish(state, integrator, h, None);
        }
        self.write_back(state);
    }

    /// Writes rest lengths and flow of springs that have flowed to the state, which has them as of the last time; all else
    /// is always there.
    pub fn write_back(&mut self, state: &mut State<S>) {
        self.table.write_back(state);
    }

    /// Makes the table of springs that the first substep would make, and the room that it would.
    pub(crate) fn make_ready(&mut self, state: &State<S>) {
        self.forces.set_damped(self.is_damped());
        if let (Some(table), Some(state)) = (
            of_f32_mut::<_, SpringTable<f32>>(&mut self.table),
            of_f32(state),
        ) {
            kernel::make_rows(self.kernel, table, state);
        }
    }

    /// Moves the body freely over h s.
    pub fn predict(
        &mut self,
        state: &mut State<S>,
        integrator: Integrator,
        h: f64,
        field: Option<&dyn ForceField>,
    ) {
        let (mut gauge, size) = (std::mem::take(&mut self.gauge), self.size(state));
        gauge.run(size, || integrator.predict(self, state, S::of(h), field));
        self.gauge = gauge;
    }

    /// Completes the substep after contact and moves the clock.
    pub fn finish(
        &mut self,
        state: &mut State<S>,
        integrator: Integrator,
        h: f64,
        field: Option<&dyn ForceField>,
    ) {
        let (mut gauge, size) = (std::mem::take(&mut self.gauge), self.size(state));
        gauge.run(size, || integrator.finish(self, state, S::of(h), field));
        gauge.end();
        self.gauge = gauge;
        self.time += h;
    }

    /// How many springs take as long as any of its passes.
    fn size(&self, state: &State<S>) -> usize {
        let elements = self.part.as_ref().map_or(0, Part::size);
        let nodes = threads::NODE * state.particles.len();
        self.table.links.len().max(elements).max(nodes)
    }

    /// Changes the velocity of a node after `predict` by a scheme that takes late impulses: v += Δv, x += h·Δv. Work of damping and external forces follows, see [`Work`].
    pub(crate) fn kick(&mut self, state: &mut State<S>, node: usize, dv: DVec3, h: f64) {
        let dv = [S::of(dv.x), S::of(dv.y), S::of(dv.z)];
        let step = S::of(h);
        for (v, d) in state.particles[node].v.iter_mut().zip(dv) {
            *v += d;
        }
        state.displace(node, [dv[0] * step, dv[1] * step, dv[2] * step]);
        self.work.damping -= 0.5 * h * dot(three(self.forces.at(node).damping), dv).f64();
        if let Some(applied) = self.applied.get(node) {
            self.work.external += 0.5 * h * dot(*applied, dv).f64();
        }
    }

    /// The largest speed that the last integration pass has seen \[m/s\].
    pub(crate) fn top_speed(&self) -> f64 {
        self.speed_squared.f64().sqrt()
    }

    /// The force from outside on a node at the last evaluation \[N\], gravity left out.
    pub(crate) fn applied_force(&self, node: usize) -> DVec3 {
        let applied = self.applied.get(node);
        applied.map_or(DVec3::ZERO, |a| DVec3::from_array(a.map(Scalar::f64)))
    }

    /// Force of springs and elements on a node at the last evaluation, damping left out \[N\].
    pub(crate) fn elastic_force(&self, node: usize) -> DVec3 {
        let f = self.forces.elastic[node];
        DVec3::new(f[0].f64(), f[1].f64(), f[2].f64())
    }

    /// Keeps positions and velocities for schemes whose stages start from them.
    pub(crate) fn save_start(&mut self, state: &State<S>) {
        self.start.clear();
        self.start
            .extend(state.particles.iter().map(|p| (p.x, p.v)));
    }

    /// Drops the forces of the last evaluation, when the state they belong to is given up.
    pub(crate) fn forget_forces(&mut self) {
        self.forces.clear();
        self.applied.clear();
    }

    /// Fills the forces for the state as it is. With `commit` plastic flow and breaking are written. The state is that of `after` s from the start of the substep.
    pub(crate) fn evaluate(
        &mut self,
        state: &mut State<S>,
        field: Option<&dyn ForceField>,
        commit: Option<Commit<S>>,
        after: S,
    ) {
        self.evaluate_applied(state, field, self.time + after.f64());
        self.forces.set_damped(self.is_damped());
        let happened = spring_forces(
            self.kernel,
            &mut self.table,
            state,
            &mut self.forces,
            &mut self.events,
            (commit, self.external.drag),
        );
        if let Some(part) = &mut self.part {
            part.add_forces(self.kernel, &state.particles, &mut self.forces);
        }
        self.work.plastic += happened.plastic;
        self.work.fracture += happened.fracture;
    }

    fn evaluate_applied(&mut self, state: &State<S>, field: Option<&dyn ForceField>, time: f64) {
        self.applied.clear();
        self.applied.extend_from_slice(&self.external.node_forces);
        if !self.applied.is_empty() {
            self.applied.resize(state.particles.len(), [S::ZERO; 3]);
        }
        let Some(field) = field else { return };
        self.applied.resize(state.particles.len(), [S::ZERO; 3]);
        let nodes = threads::Nodes {
            first: 0,
            values: &mut self.applied[..],
        };
        threads::share(nodes, threads::parts(), &|nodes| {
            for (i, sum) in (nodes.first..).zip(nodes.values) {
                let (x, v) = (state.position(i).as_vec3(), state.velocity(i).as_vec3());
                let f: Vector = field.force(NodeId(i as u32), x, v, time);
                for (s, f) in sum.iter_mut().zip(f.to_array()) {
                    *s += S::of(f.into());
                }
            }
        });
    }
}
