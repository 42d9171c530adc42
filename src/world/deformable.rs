//! A deformable body in the world: blueprint, state, solver and settings, and the face through which users read and
//! change it. Values are editable, lengths are not.

use super::params::{DeformableParameters, Substeps};
use crate::body::state::Particle;
use crate::body::{Blueprint, BuildError, NodeId, Spring, SpringId, State};
use crate::contact::target::{Surface, wide_rotation};
use crate::law::plastic::{self, Mapped, Yield, return_map};
use crate::law::spring as law;
use crate::math::{DVec3, Pose, Real, Vector, narrow, wide};
use crate::solve::external::ForceField;
use crate::solve::springs::SpringTable;
use crate::solve::stable::StableStep;
use crate::solve::work::Work;
use crate::solve::{Integrator, Solver};
use std::sync::Arc;

/// Energies of a body and the work done on it so far \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// ½Σ m·v⁻·v⁺ with the velocities half a substep before and after for symplectic Euler and velocity Verlet, which are
    /// leapfrog; ½Σ m·v² for the other schemes.
    pub kinetic: f64,
    /// Held by the springs.
    pub elastic: f64,
    /// Σ −m·g·x, relative to where the body was inserted.
    pub gravity: f64,
    /// Sums of dissipation and external work.
    pub work: Work,
}

impl Energies {
    /// Everything that stays constant: kinetic + elastic + gravity + dissipation − external work − work received from
    /// rigid bodies − what moving nodes out of colliders added.
    pub fn balance(&self) -> f64 {
        let w = &self.work;
        self.kinetic + self.elastic + self.gravity + self.dissipated()
            - w.external
            - w.rigid
            - w.push_out
    }

    /// Plastic, damping, fracture and contact losses together.
    pub fn dissipated(&self) -> f64 {
        let w = &self.work;
        w.damping + w.plastic + w.fracture + w.contact_normal + w.contact_friction
    }

    /// What a residual is measured against: kinetic + elastic + dissipation + |work of gravity| + |external work|.
    pub fn scale(&self) -> f64 {
        self.kinetic
            + self.elastic
            + self.dissipated().abs()
            + self.gravity.abs()
            + self.work.external.abs()
            + self.work.rigid.abs()
    }
}

/// A deformable body.
#[derive(Clone, Default)]
pub struct Deformable {
    pub(super) blueprint: Blueprint,
    pub(super) state: State<Real>,
    pub(super) solver: Solver<Real>,
    pub(super) surface: Surface,
    pub(super) gravity_scale: Real,
    pub(super) integrator: Option<Integrator>,
    pub(super) substeps: Option<Substeps>,
    /// The world's settings, for what a body has none of its own.
    pub(super) defaults: DeformableParameters,
    pub(super) field: Option<Arc<dyn ForceField>>,
    pub(super) enabled: bool,
    pub(super) frozen: bool,
    /// Persistent force and force of the coming step on each node \[N\]; empty when none was ever set.
    pub(super) node_forces: Vec<(Vector, Vector)>,
    /// Nodes led to a point of the world by the end of the coming step.
    pub(super) led: Vec<(u32, DVec3)>,
    /// Where gravity potential is zero \[m\].
    pub(super) datum: DVec3,
    /// Maps nodes to row nodes within a substep.
    pub(super) slots: Vec<u32>,
    /// Positions and velocities at the start of the rigid step, to go back to if the step goes wrong.
    pub(super) backup: State<Real>,
    /// Particles and work before the free motion, for schemes that predict anew after rows.
    pub(super) start: Start,
    /// The work done until then.
    pub(super) work_backup: Work,
    pub(super) h: f64,
    /// Anything the user wants to keep with the body.
    pub user_data: u128,
}

/// What a second prediction starts from.
#[derive(Clone, Debug, Default)]
pub(super) struct Start {
    particles: Vec<Particle<Real>>,
    low: Vec<[Real; 3]>,
    work: Work,
}

impl std::fmt::Debug for Deformable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Deformable")
            .field("nodes", &self.node_count())
            .field("springs", &self.spring_count())
            .field("enabled", &self.enabled)
            .field("frozen", &self.frozen)
            .finish_non_exhaustive()
    }
}

/// Reading.
impl Deformable {
    /// How many nodes it has.
    pub fn node_count(&self) -> usize {
        self.state.particles.len()
    }

    /// How many springs it has, broken ones included.
    pub fn spring_count(&self) -> usize {
        self.blueprint.springs.len()
    }

    /// Topology and constants.
    pub fn blueprint(&self) -> &Blueprint {
        &self.blueprint
    }

    /// Position of a node in the world \[m\], in `f64`; `None` for an unknown id.
    pub fn position(&self, node: NodeId) -> Option<DVec3> {
        (node.index() < self.node_count()).then(|| self.state.position(node.index()))
    }

    /// Positions of all nodes in the world \[m\].
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Vector> + '_ {
        (0..self.node_count()).map(|i| narrow(self.state.position(i)))
    }

    /// Velocity of a node \[m/s\]; `None` for an unknown id.
    pub fn linvel_of(&self, node: NodeId) -> Option<DVec3> {
        (node.index() < self.node_count()).then(|| self.state.velocity(node.index()))
    }

    /// Velocities of all nodes \[m/s\].
    pub fn velocities(&self) -> impl ExactSizeIterator<Item = Vector> + '_ {
        (0..self.node_count()).map(|i| narrow(self.state.velocity(i)))
    }

    /// Mass of a node \[kg\]; `None` for an unknown id.
    pub fn node_mass(&self, node: NodeId) -> Option<Real> {
        self.blueprint.nodes.get(node.index()).map(|n| n.mass)
    }

    /// Mass of all nodes \[kg\].
    pub fn mass(&self) -> f64 {
        self.blueprint.nodes.iter().map(|n| f64::from(n.mass)).sum()
    }

    /// Centre of mass in the world \[m\].
    pub fn center_of_mass(&self) -> DVec3 {
        self.weighted(|i| self.state.local(i)) + self.state.origin
    }

    /// Velocity of the centre of mass \[m/s\].
    pub fn linvel(&self) -> DVec3 {
        self.weighted(|i| self.state.velocity(i))
    }

    /// Momentum \[N·s\].
    pub fn momentum(&self) -> DVec3 {
        self.linvel() * self.mass()
    }

    /// Angular momentum about `point` in the world \[N·m·s\].
    pub fn angular_momentum(&self, point: DVec3) -> DVec3 {
        self.nodes_with_mass()
            .map(|(i, m)| (self.state.position(i) - point).cross(self.state.velocity(i)) * m)
            .sum()
    }

    fn nodes_with_mass(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.blueprint
            .nodes
            .iter()
            .map(|n| f64::from(n.mass))
            .enumerate()
    }

    fn weighted(&self, value: impl Fn(usize) -> DVec3) -> DVec3 {
        let sum: DVec3 = self.nodes_with_mass().map(|(i, m)| value(i) * m).sum();
        sum / self.mass().max(f64::MIN_POSITIVE)
    }

    /// Smallest and largest corner of the nodes in the world \[m\].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let first = DVec3::splat(f64::INFINITY);
        let (lo, hi) = (0..self.node_count())
            .map(|i| self.state.local(i))
            .fold((first, -first), |(lo, hi), x| (lo.min(x), hi.max(x)));
        (self.state.origin + lo, self.state.origin + hi)
    }

    /// Tension of a spring now \[N\], negative in compression, 0 when broken; `None` for an unknown id.
    pub fn tension(&self, spring: SpringId) -> Option<f64> {
        let i = spring.index();
        let link = self.solver.table.links.get(i)?;
        Some(
            self.mapped(i, self.length(i), link.stiffness.into())
                .tension,
        )
    }

    /// Tension of a spring at a length, and the flow that the next force evaluation will commit.
    fn mapped(&self, spring: usize, length: f64, stiffness: f64) -> Mapped<f64> {
        let elongation = length - f64::from(self.state.rest[spring]);
        match self.solver.table.limits.get(spring) {
            None => Mapped {
                tension: law::tension(stiffness, elongation),
                flow: 0.0,
            },
            Some(limit) => {
                let y = limit.yields;
                let yields = Yield {
                    tension: f64::from(y.tension),
                    compression: f64::from(y.compression),
                    hardening: f64::from(y.hardening),
                    inverse: f64::from(y.inverse),
                };
                return_map(
                    stiffness,
                    elongation,
                    self.state.flow[spring].into(),
                    &yields,
                )
            }
        }
    }

    fn length(&self, spring: usize) -> f64 {
        let [a, b] = self.blueprint.springs[spring].nodes;
        self.state
            .local(a as usize)
            .distance(self.state.local(b as usize))
    }

    /// Whether a spring has broken; `None` for an unknown id.
    pub fn is_broken(&self, spring: SpringId) -> Option<bool> {
        self.state.broken.get(spring.index()).copied()
    }

    /// Accumulated plastic strain of a spring, Σ|ΔL_p| over its first rest length; `None` for an unknown id.
    pub fn plastic_strain(&self, spring: SpringId) -> Option<Real> {
        let rest = self.blueprint.springs.get(spring.index())?.rest_length?;
        Some(self.state.flow[spring.index()] / rest)
    }

    /// Mean plastic strain of the springs at each node.
    pub fn node_plastic_strain(&self) -> Vec<Real> {
        let mut sums = vec![(0.0, 0.0); self.node_count()];
        for (spring, flow) in self.blueprint.springs.iter().zip(&self.state.flow) {
            let strain = flow / spring.rest_length.unwrap_or(1.0);
            for node in spring.nodes {
                sums[node as usize].0 += strain;
                sums[node as usize].1 += 1.0;
            }
        }
        sums.iter()
            .map(|(s, n)| if *n > 0.0 { s / n } else { 0.0 })
            .collect()
    }

    /// Largest strain of any unbroken spring now, as length over first rest length minus 1.
    pub fn max_strain(&self) -> f64 {
        (0..self.spring_count())
            .filter(|&i| !self.state.broken[i])
            .map(|i| {
                let rest = f64::from(self.blueprint.springs[i].rest_length.unwrap_or(1.0));
                (self.length(i) / rest - 1.0).abs()
            })
            .fold(0.0, f64::max)
    }

    /// Where the vertices of the skin are now \[m\]; the nodes themselves where it has none.
    pub fn skin_positions(&self) -> Vec<Vector> {
        let Some(skin) = &self.blueprint.skin else {
            return self.positions().collect();
        };
        skin.bindings
            .iter()
            .map(|binding| {
                let local: DVec3 = binding
                    .nodes
                    .iter()
                    .zip(binding.weights)
                    .map(|(&n, w)| self.state.local(n as usize) * f64::from(w))
                    .sum();
                narrow(self.state.origin + local)
            })
            .collect()
    }

    /// Energies now and work so far.
    pub fn energies(&self) -> Energies {
        let gravity = self.gravity();
        let mut energies = Energies {
            work: self.solver.work,
            ..Energies::default()
        };
        // Velocities of symplectic Euler stand half a substep back: ½·h·F·v brings the kinetic energy to the positions'.
        let lead = if self.integrator() == Integrator::SymplecticEuler {
            0.5 * self.h
        } else {
            0.0
        };
        let verlet = self.integrator() == Integrator::VelocityVerlet;
        for (i, mass) in self.nodes_with_mass() {
            if self.state.particles[i].inv_mass == 0.0 {
                continue;
            }
            let v = self.state.velocity(i);
            energies.kinetic += mass * (0.5 * v.length_squared() + lead * gravity.dot(v));
            if verlet {
                // Leapfrog by another name: ½m·v⁻·v⁺ with v± = v ± ½h·a.
                let force = self.solver.force(i) + gravity * mass;
                energies.kinetic -= 0.125 * (self.h * force).length_squared() / mass;
            }
            energies.gravity -= mass * gravity.dot(self.state.position(i) - self.datum);
        }
        for (i, link) in self.solver.table.links.iter().enumerate() {
            let stiffness = f64::from(link.stiffness);
            if stiffness == 0.0 {
                continue;
            }
            let (a, b) = (link.a as usize, link.b as usize);
            let d = self.state.local(b) - self.state.local(a);
            let length = d.length();
            let mapped = self.mapped(i, length, stiffness);
            energies.elastic += law::energy(stiffness, mapped.tension / stiffness);
            let rate = (self.state.velocity(b) - self.state.velocity(a)).dot(d)
                / length.max(f64::MIN_POSITIVE);
            let last = stiffness * (length - f64::from(self.state.rest[i]) - self.h * rate);
            energies.work.plastic += plastic::work(last, &mapped);
            energies.kinetic -= lead * mapped.tension * rate;
        }
        energies
    }

    /// The longest stable substep of its scheme now, and the spring that sets it.
    pub fn stable_step(&self) -> StableStep {
        self.solver.stable_step(&self.state, self.integrator())
    }

    /// Length of the last substep taken \[s\]; 0 before the first step.
    pub fn substep_length(&self) -> f64 {
        self.h
    }

    /// Whether it takes part in the simulation.
    pub fn is_enabled(&self) -> bool {
        self.enabled && !self.frozen
    }

    /// Whether it was frozen because its state became non-finite.
    pub fn is_frozen(&self) -> bool {
        self.frozen
    }

    /// Friction and collision groups.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The scheme it is advanced by: its own, or the world's.
    pub fn integrator(&self) -> Integrator {
        self.integrator.unwrap_or(self.defaults.integrator)
    }

    /// How its substeps are chosen: by itself, or by the world.
    pub fn substeps(&self) -> Substeps {
        self.substeps.unwrap_or(self.defaults.substeps)
    }

    /// The acceleration of gravity that acts on it, as of its last step \[m/s²\].
    pub fn gravity(&self) -> DVec3 {
        let g = self.solver.external.gravity;
        DVec3::new(g[0].into(), g[1].into(), g[2].into())
    }
}

/// Changing.
impl Deformable {
    /// Books a change made from outside, so that the energy balance stays closed: it is external work.
    fn edit<T>(&mut self, change: impl FnOnce(&mut Self) -> T) -> T {
        let before = self.energies().balance();
        let result = change(self);
        let after = self.energies().balance();
        self.solver.work.external += after - before;
        result
    }

    /// Enables or disables the body. A disabled body stays where it is and touches nothing.
    pub fn set_enabled(&mut self, enabled: bool) {
        self.enabled = enabled;
    }

    /// Friction and collision groups.
    pub fn surface_mut(&mut self) -> &mut Surface {
        &mut self.surface
    }

    /// Puts a node somewhere in the world \[m\]. Unknown ids and values that are not finite change nothing: `false`.
    pub fn set_position(&mut self, node: NodeId, position: Vector) -> bool {
        let ok = node.index() < self.node_count() && position.is_finite();
        if ok {
            self.edit(|body| body.state.set_position(node.index(), wide(position)));
        }
        ok
    }

    /// Sets the velocity of a node \[m/s\]; a pinned one goes on at it until told otherwise. Unknown ids and values that are not finite change nothing: `false`.
    pub fn set_linvel_of(&mut self, node: NodeId, linvel: Vector) -> bool {
        let ok = node.index() < self.node_count() && linvel.is_finite();
        if ok {
            self.edit(|body| body.state.set_velocity(node.index(), wide(linvel)));
        }
        ok
    }

    /// Gives all nodes that are not pinned one velocity \[m/s\]. Values that are not finite change nothing: `false`.
    pub fn set_linvel(&mut self, linvel: Vector) -> bool {
        self.set_velocities(linvel, Vector::ZERO)
    }

    /// Gives the body the velocity field of a rigid one: `linvel` \[m/s\] of its centre of mass and `angvel` \[rad/s\];
    /// pinned nodes stay. Values that are not finite change nothing: `false`.
    pub fn set_velocities(&mut self, linvel: Vector, angvel: Vector) -> bool {
        let ok = linvel.is_finite() && angvel.is_finite();
        if ok {
            let com = self.center_of_mass();
            self.edit(|body| {
                for i in 0..body.node_count() {
                    if body.state.particles[i].inv_mass == 0.0 {
                        continue;
                    }
                    let arm = body.state.position(i) - com;
                    body.state
                        .set_velocity(i, wide(linvel) + wide(angvel).cross(arm));
                }
            });
        }
        ok
    }

    /// Moves the body rigidly: every node goes through `motion`, velocities are turned with it. Values that are not
    /// finite change nothing: `false`.
    pub fn transform(&mut self, motion: Pose) -> bool {
        let turn = wide_rotation(motion.rotation);
        // A rotation of length 0 is none.
        let ok = motion.is_finite() && turn.is_finite();
        if ok {
            let shift = wide(motion.translation);
            self.edit(|body| {
                for i in 0..body.node_count() {
                    let (x, v) = (body.state.position(i), body.state.velocity(i));
                    body.state.set_position(i, turn * x + shift);
                    body.state.set_velocity(i, turn * v);
                }
                body.state.recentre(1.0);
            });
        }
        ok
    }

    /// Pins a node where it is, or lets it go. Unknown ids change nothing: `false`.
    pub fn set_pinned(&mut self, node: NodeId, pinned: bool) -> bool {
        let ok = node.index() < self.node_count();
        if ok {
            self.edit(|body| {
                let mass = body.blueprint.nodes[node.index()].mass;
                let particle = &mut body.state.particles[node.index()];
                particle.inv_mass = if pinned { 0.0 } else { 1.0 / mass };
                if pinned {
                    particle.v = [0.0; 3];
                }
                body.blueprint.nodes[node.index()].pinned = pinned;
                body.led.retain(|(n, _)| pinned || *n != node.0);
            });
        }
        ok
    }

    /// Leads a pinned node to a point of the world \[m\], to be reached at the end of the coming step. Nodes that are not
    /// pinned, unknown ids and points that are not finite change nothing: `false`.
    pub fn set_kinematic_target(&mut self, node: NodeId, target: Vector) -> bool {
        let ok = target.is_finite()
            && self
                .state
                .particles
                .get(node.index())
                .is_some_and(|p| p.inv_mass == 0.0);
        if ok {
            self.led.retain(|(n, _)| *n != node.0);
            self.led.push((node.0, wide(target)));
        }
        ok
    }

    /// Sets the force that acts on a node until changed \[N\]. Unknown ids and forces that are not finite change
    /// nothing: `false`.
    pub fn set_node_force(&mut self, node: NodeId, force: Vector) -> bool {
        self.force_slot(node, force)
            .map(|(kept, _)| *kept = force)
            .is_some()
    }

    /// Adds to the force that acts on a node during the coming step only \[N\]. Unknown ids and forces that are not
    /// finite change nothing: `false`.
    pub fn add_step_force(&mut self, node: NodeId, force: Vector) -> bool {
        self.force_slot(node, force)
            .map(|(_, once)| *once += force)
            .is_some()
    }

    fn force_slot(&mut self, node: NodeId, force: Vector) -> Option<&mut (Vector, Vector)> {
        if !force.is_finite() || node.index() >= self.node_count() {
            return None;
        }
        self.node_forces
            .resize(self.node_count(), Default::default());
        self.node_forces.get_mut(node.index())
    }

    /// Sets the force field on all nodes; `None` for none.
    pub fn set_force_field(&mut self, field: Option<Arc<dyn ForceField>>) {
        self.field = field;
    }

    /// Changes a spring. Its nodes and rest length at build stay what they are.
    ///
    /// # Errors
    /// A constant out of range, an unknown spring, or a body that would need substeps shorter than its budget; the body
    /// is then as before.
    pub fn set_spring(
        &mut self,
        spring: SpringId,
        change: impl FnOnce(&mut Spring),
    ) -> Result<(), BuildError> {
        let Some(old) = self.blueprint.springs.get(spring.index()).copied() else {
            return Err(BuildError::Value {
                what: "the spring's index",
                value: spring.0.into(),
                must: "less than the number of springs",
            });
        };
        let mut new = old;
        change(&mut new);
        new.nodes = old.nodes;
        new.rest_length = old.rest_length;
        crate::body::error::check_constants(spring.0, &new)?;
        let work = self.solver.work;
        self.put_spring(spring, new);
        self.check_budget().inspect_err(|_| {
            self.put_spring(spring, old);
            self.solver.work = work;
        })
    }

    fn put_spring(&mut self, id: SpringId, spring: Spring) {
        self.edit(|body| {
            body.blueprint.springs[id.index()] = spring;
            body.rebuild_table();
        });
    }

    fn rebuild_table(&mut self) {
        self.solver.table = SpringTable::new(&self.blueprint.springs, &self.state);
    }

    /// Changes the mass of a node \[kg\].
    ///
    /// # Errors
    /// As [`Self::set_spring`].
    pub fn set_node_mass(&mut self, node: NodeId, mass: Real) -> Result<(), BuildError> {
        let bad = |what, value, must| BuildError::Value { what, value, must };
        let Some(old) = self.node_mass(node) else {
            return Err(bad(
                "the node's index",
                node.0.into(),
                "less than the number of nodes",
            ));
        };
        crate::body::error::positive("the node's mass", mass.into())?;
        if !mass.is_normal() {
            return Err(bad(
                "the node's mass",
                mass.into(),
                "large enough to have an inverse",
            ));
        }
        let work = self.solver.work;
        self.put_mass(node, mass);
        self.check_budget().inspect_err(|_| {
            self.put_mass(node, old);
            self.solver.work = work;
        })
    }

    fn put_mass(&mut self, node: NodeId, mass: Real) {
        self.edit(|body| {
            body.blueprint.nodes[node.index()].mass = mass;
            let particle = &mut body.state.particles[node.index()];
            if particle.inv_mass > 0.0 {
                particle.inv_mass = 1.0 / mass;
            }
        });
    }

    /// Whether the body is stable within its budget.
    pub(super) fn check_budget(&self) -> Result<(), BuildError> {
        let substeps = self.substeps();
        substeps.check()?;
        let stable = self.stable_step();
        let min_h = match substeps {
            Substeps::Auto { safety, min_h } => min_h / safety,
            Substeps::Fixed(n) => self.defaults.expected_dt / n as f64,
            Substeps::Unchecked(_) => return Ok(()),
        };
        match stable.spring {
            Some(spring) if stable.never => Err(BuildError::NeverStable {
                integrator: self.integrator().name(),
                spring,
            }),
            Some(spring) if stable.h < min_h => Err(self.unstable(spring, stable.h, min_h)),
            _ => Ok(()),
        }
    }

    fn unstable(&self, spring: u32, needed_h: f64, min_h: f64) -> BuildError {
        let s = &self.blueprint.springs[spring as usize];
        let mass = |n: u32| self.blueprint.nodes[n as usize].mass;
        BuildError::Unstable {
            spring,
            stiffness: s.stiffness,
            damping: s.damping,
            mass_a: mass(s.nodes[0]),
            mass_b: mass(s.nodes[1]),
            needed_h,
            min_h,
        }
    }

    /// How many substeps a stretch of `dt` s needs, and whether it asked for too few. `frame` is the world's step.
    pub(super) fn substeps_for(&self, dt: f64, frame: f64) -> (usize, bool) {
        let stable = self.stable_step();
        let count = |h: f64| ((dt / h).ceil() as usize).max(1);
        let share = |n: usize| ((n as f64 * dt / frame).round() as usize).max(1);
        match self.substeps() {
            // A scheme that became unstable at every substep, or a budget that lost its bounds, after insertion: no number
            // is right, so a moderate one is taken and reported.
            Substeps::Auto { safety, min_h }
                if stable.never || safety.is_nan() || safety <= 0.0 || min_h.is_nan() =>
            {
                (count(1e-4), true)
            }
            Substeps::Auto { safety, min_h } => {
                let n = count((stable.h * safety).max(min_h).max(1e-9));
                (n, dt / n as f64 > stable.h * (1.0 + 1e-9))
            }
            Substeps::Fixed(n) => {
                let needed = if stable.never { 0 } else { count(stable.h) };
                (share(n).max(needed), share(n) < needed)
            }
            Substeps::Unchecked(n) => (share(n), dt / share(n) as f64 > stable.h),
        }
    }

    /// Fills the solver's forces from outside for the coming rigid step, and leads its kinematic nodes for `remaining` s.
    pub(super) fn prepare(&mut self, gravity: Vector, remaining: f64) {
        let gravity = (gravity * self.gravity_scale).to_array();
        if gravity != self.solver.external.gravity {
            self.edit(|body| body.solver.external.gravity = gravity);
        }
        let forces = &mut self.solver.external.node_forces;
        forces.clear();
        forces.extend(
            self.node_forces
                .iter()
                .map(|(kept, once)| (*kept + *once).to_array()),
        );
        for &(node, target) in &self.led {
            let v = (target - self.state.position(node as usize)) / remaining;
            self.state.set_velocity(node as usize, v);
        }
        self.solver.speed_squared = self.max_speed_squared();
    }

    /// Moves freely over h s.
    pub(super) fn predict(&mut self, h: f64) {
        self.h = h;
        if !self.integrator().takes_late_impulses() {
            self.start.particles.clone_from(&self.state.particles);
            self.start.low.clone_from(&self.state.low);
            self.start.work = self.solver.work;
        }
        self.free_motion(h);
    }

    fn free_motion(&mut self, h: f64) {
        let integrator = self.integrator();
        let Self {
            solver,
            state,
            field,
            ..
        } = self;
        solver.predict(state, integrator, h, field.as_deref());
    }

    /// The velocity by which a node has moved in the free motion \[m/s\].
    pub(super) fn free_velocity(&self, node: usize, h: f64) -> DVec3 {
        if self.integrator().takes_late_impulses() {
            return self.state.velocity(node);
        }
        let (x, low) = (self.start.particles[node].x, self.start.low[node]);
        let start = DVec3::new(x[0].into(), x[1].into(), x[2].into())
            + DVec3::new(low[0].into(), low[1].into(), low[2].into());
        (self.state.local(node) - start) / h
    }

    /// Gives rows' velocity changes to the nodes, and moves anew where the scheme wants it.
    pub(super) fn take_impulses(&mut self, changes: impl Iterator<Item = (usize, DVec3)>, h: f64) {
        if self.integrator().takes_late_impulses() {
            for (node, change) in changes {
                self.solver.kick(&mut self.state, node, change, h);
            }
            return;
        }
        let mut changes = changes.peekable();
        if changes.peek().is_none() {
            return;
        }
        self.state.particles.clone_from(&self.start.particles);
        self.state.low.clone_from(&self.start.low);
        // Flow and fracture were committed at the start and stay; the other sums belong to the motion that is taken back.
        self.solver.work = Work {
            plastic: self.solver.work.plastic,
            fracture: self.solver.work.fracture,
            ..self.start.work
        };
        for (node, change) in changes {
            let v = self.state.velocity(node) + change;
            self.state.set_velocity(node, v);
        }
        self.free_motion(h);
    }

    /// Completes the substep.
    pub(super) fn finish(&mut self, h: f64) {
        let integrator = self.integrator();
        let Self {
            solver,
            state,
            field,
            ..
        } = self;
        solver.finish(state, integrator, h, field.as_deref());
    }

    /// Ends a step of the world: led nodes stand at their targets, one-step forces are gone.
    pub(super) fn end_frame(&mut self) {
        let led = std::mem::take(&mut self.led);
        if self.is_enabled() {
            for (node, target) in led {
                self.state.set_position(node as usize, target);
                self.state.set_velocity(node as usize, DVec3::ZERO);
            }
        }
        for (_, once) in &mut self.node_forces {
            *once = Vector::ZERO;
        }
    }

    /// Remembers what [`Self::go_back`] goes back to.
    pub(super) fn back_up(&mut self) {
        self.backup.clone_from(&self.state);
        self.work_backup = self.solver.work;
    }

    /// Back to the start of the rigid step: positions, velocities, what flowed and broke, and the work done.
    pub(super) fn go_back(&mut self) {
        self.state.clone_from(&self.backup);
        self.solver.work = self.work_backup;
        self.solver.events.clear();
        self.rebuild_table();
        self.solver.forget_forces();
    }

    /// Back to the start of the rigid step, at rest, out of the simulation.
    pub(super) fn freeze(&mut self) {
        self.go_back();
        self.edit(|body| {
            for particle in &mut body.state.particles {
                particle.v = [0.0; 3];
            }
        });
        self.frozen = true;
    }

    /// Lets a frozen body take part again, from where it stands and at rest.
    pub fn thaw(&mut self) {
        self.frozen = false;
    }

    /// FNV-1a hash of the whole state, bit for bit.
    pub fn state_hash(&self) -> u64 {
        let floats = self
            .state
            .particles
            .iter()
            .flat_map(|p| p.x.iter().chain(&p.v))
            .chain(self.state.low.iter().flatten())
            .chain(&self.state.rest)
            .chain(&self.state.flow)
            .map(|x| u64::from(x.to_bits()));
        floats
            .chain(self.state.origin.to_array().map(f64::to_bits))
            .chain(self.state.broken.iter().map(|b| u64::from(*b)))
            .fold(0xcbf2_9ce4_8422_2325, |hash, word| {
                (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3)
            })
    }
}
