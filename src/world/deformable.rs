//! A deformable body in the world: blueprint, state, solver and settings, and the face through which users read it.

use super::course::NodeCourses;
use super::motion::{Books, Start};
use super::params::{DeformableParameters, Substeps};
use super::sleep::Sleep;
use super::span::{Span, Way};
use super::steady::Steadiness;
use super::subset::Incident;
use crate::body::search::tree::Cache;
use crate::body::tears::Seams;
use crate::body::{Blueprint, Embedded, NodeId, SpringId, State, Topology};
use crate::contact::encounter::outline::Outline;
use crate::contact::target::SurfaceProperties;
use crate::math::{DVec3, Fnv, Real, Vector, narrow};
use crate::solve::external::ForceField;
use crate::solve::{Integrator, Solver};
use std::sync::{Arc, OnceLock};

/// A deformable body.
#[derive(Clone, Default)]
pub struct Deformable {
    pub(super) blueprint: Blueprint,
    pub(super) state: State<Real>,
    pub(super) solver: Solver<Real>,
    pub(super) surface: SurfaceProperties,
    /// Made when it first meets another deformable.
    pub(super) outline: Option<Box<Outline>>,
    pub(super) topology: Arc<Topology>,
    /// Made when its first spring breaks.
    pub(super) seams: Option<Arc<Seams>>,
    /// What touches in their place.
    pub(super) embedded: Option<Box<Embedded>>,
    pub(super) gravity_scale: Real,
    pub(super) integrator: Option<Integrator>,
    pub(super) substeps: Option<Substeps>,
    /// The world's settings, for what a body has none of its own.
    pub(super) defaults: DeformableParameters,
    pub(super) field: Option<Arc<dyn ForceField>>,
    pub(super) enabled: bool,
    pub(super) frozen: bool,
    pub(super) sleep: Sleep,
    /// Persistent force and force of the coming step on each node \[N\]; empty when none was ever set.
    pub(super) node_forces: Vec<(Vector, Vector)>,
    /// Nodes led to a point of the world by the end of the coming step.
    pub(super) led: Vec<(u32, DVec3)>,
    /// How led nodes have moved.
    pub(super) courses: NodeCourses,
    /// What places are measured from for the energy of gravity \[m\].
    pub(super) datum: DVec3,
    /// Σ m·(x − datum) of the free nodes where they were inserted, or have been freed or weighed since: there the energy of gravity
    /// is 0 \[kg·m\].
    pub(super) moment: DVec3,
    /// Maps nodes to row nodes within a substep.
    pub(super) slots: Vec<u32>,
    /// Positions and velocities at the start of the rigid step, to go back to if the step goes wrong.
    pub(super) backup: State<Real>,
    /// Particles and work before the free motion, for schemes that predict anew after rows.
    pub(super) start: Start,
    /// Nodes moved at position level in the last substep, by how much \[m\], and against which elastic force \[N\].
    pub(super) moved_out: Vec<(u32, DVec3, DVec3)>,
    /// How often nodes were moved from outside: what contact remembers of them is void then.
    pub(super) edits: u64,
    /// A bound on how far any node moved in the last substep \[m\].
    pub(super) moved: f64,
    /// How its nodes moved in that, if it could meet others, and nothing has moved them since.
    pub(super) way: Option<Way>,
    /// Between which velocities they go into the coming one, if it can.
    pub(super) span: Span,
    /// How far nodes were moved after the last step's substeps to lie on their rigid bodies \[m\].
    pub(super) shifted: f64,
    /// What was booked at the start of the rigid step.
    pub(super) books: Books,
    pub(super) h: f64,
    /// How much that has changed of late.
    pub(super) steady: Steadiness,
    /// Elastic energy in the links of its attachments \[J\].
    pub(super) links: f64,
    /// Nodes whose velocities were set since the last substep, in ascending order.
    pub(super) told: Vec<u32>,
    /// Those of the start of the rigid step.
    pub(super) told_before: Vec<u32>,
    /// Made when energies of some of its nodes are first asked for; copies share it.
    pub(super) incident: OnceLock<Arc<Incident>>,
    /// What queries remember until the nodes move.
    pub(super) cache: Cache,
    /// Anything the user wants to keep with the body.
    pub user_data: u128,
}

impl std::fmt::Debug for Deformable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Deformable")
            .field("nodes", &self.node_count())
            .field("springs", &self.spring_count())
            .field("tets", &self.tet_count())
            .field("enabled", &self.enabled)
            .field("frozen", &self.frozen)
            .finish_non_exhaustive()
    }
}

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

    /// Copies of what moves it and of where it is, to measure how long that takes.
    #[cfg(feature = "scenario")]
    pub(crate) fn motion(&self) -> (Solver<Real>, State<Real>) {
        (self.solver.clone(), self.state.clone())
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

    pub(super) fn nodes_with_mass(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
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
            self.mapped(i, self.length_of(i), link.stiffness.into())
                .tension,
        )
    }

    pub(super) fn length_of(&self, spring: usize) -> f64 {
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

    /// Largest strain of any unbroken spring and any edge of a tet now, as length over first rest length minus 1.
    pub fn max_strain(&self) -> f64 {
        (0..self.spring_count())
            .filter(|&i| !self.state.broken[i])
            .map(|i| {
                let rest = f64::from(self.blueprint.springs[i].rest_length.unwrap_or(1.0));
                (self.length_of(i) / rest - 1.0).abs()
            })
            .fold(self.max_edge_strain(), f64::max)
    }

    /// Where the vertices of the skin are now \[m\]; the nodes themselves where it has none.
    pub fn skin_positions(&self) -> Vec<Vector> {
        let Some(skin) = &self.blueprint.skin else {
            return self.positions().collect();
        };
        skin.bindings
            .iter()
            .map(|binding| {
                let parts = binding.parts();
                let local: DVec3 = parts.map(|(n, w)| self.state.local(n) * w).sum();
                narrow(self.state.origin + local)
            })
            .collect()
    }

    /// The triangles between [`Self::skin_positions`], counter-clockwise seen from outside: those of the skin, or the faces of the
    /// nodes where it has none. They stay the same; of the latter [`Self::whole_faces`] leaves out what is torn.
    pub fn skin_triangles(&self) -> &[[u32; 3]] {
        let skin = self.blueprint.skin.as_ref();
        skin.map_or(&self.blueprint.faces, |skin| &skin.triangles)
    }

    /// The faces between its nodes that are not torn, see [`Self::is_torn`].
    pub fn whole_faces(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let faces = (0..).zip(&self.blueprint.faces);
        let whole = faces.filter(|(face, _)| !self.topology.is_torn(*face));
        whole.map(|(_, nodes)| *nodes)
    }

    /// Length of the last substep taken \[s\]; 0 before the first step.
    pub fn substep_length(&self) -> f64 {
        self.h
    }

    /// Whether it takes part in the simulation.
    pub fn is_enabled(&self) -> bool {
        self.enabled && !self.frozen
    }

    /// Whether it is advanced: enabled, not frozen, and awake.
    pub(super) fn is_active(&self) -> bool {
        self.is_enabled() && !self.sleep.asleep
    }

    /// Whether it was frozen because its state became non-finite.
    pub fn is_frozen(&self) -> bool {
        self.frozen
    }

    /// Friction and collision groups.
    pub fn surface(&self) -> &SurfaceProperties {
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

    /// Hash of the whole state, bit for bit: FNV-1a over its words.
    pub fn state_hash(&self) -> u64 {
        let floats = self
            .state
            .particles
            .iter()
            .flat_map(|p| p.x.iter().chain(&p.v))
            .chain(self.state.low.iter().flat_map(|low| &low[..3]))
            .chain(&self.state.rest)
            .chain(&self.state.flow)
            .map(|x| u64::from(x.to_bits()));
        let words = floats
            .chain(self.state.origin.to_array().map(f64::to_bits))
            .chain(self.state.broken.iter().map(|b| u64::from(*b)))
            .chain(self.told.iter().map(|n| u64::from(*n)));
        Fnv::of_words(words)
    }
}
