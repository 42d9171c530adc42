//! A deformable as it is saved: blueprint, state and settings. Tables, topology and elements follow from these, so a
//! snapshot does not depend on how a kernel lays them out.

use crate::body::state::Particle;
use crate::body::{Blueprint, BuildError, Embedded, State, Topology};
use crate::contact::encounter::outline::Outline;
use crate::contact::target::SurfaceProperties;
use crate::math::{DVec3, Real, Vector};
use crate::solve::external::External;
use crate::solve::fem::{Model, Part};
use crate::solve::forces::Forces;
use crate::solve::work::Work;
use crate::solve::{Integrator, Solver};
use crate::world::course::NodeCourses;
use crate::world::sleep::Sleep;
use crate::world::span::Way;
use crate::world::steady::Steadiness;
use crate::world::{Deformable, DeformableParameters, Substeps};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::sync::Arc;

#[derive(Serialize, Deserialize)]
struct Saved {
    blueprint: Blueprint,
    state: State<Real>,
    external: External<Real>,
    work: Work,
    time: f64,
    last_substep: Option<f64>,
    stiffest: f64,
    stable_h: f64,
    forces: Forces<Real>,
    applied: Vec<[Real; 3]>,
    speed_squared: Real,
    surface: SurfaceProperties,
    /// Whether it has met another deformable.
    met: bool,
    gravity_scale: Real,
    integrator: Option<Integrator>,
    substeps: Option<Substeps>,
    defaults: DeformableParameters,
    enabled: bool,
    frozen: bool,
    sleep: Sleep,
    node_forces: Vec<(Vector, Vector)>,
    led: Vec<(u32, DVec3)>,
    courses: NodeCourses,
    datum: DVec3,
    moment: DVec3,
    moved_out: Vec<(u32, DVec3, DVec3)>,
    edits: u64,
    moved: f64,
    way: Option<Way>,
    shifted: f64,
    h: f64,
    steady: Steadiness,
    links: f64,
    told: Vec<u32>,
    /// Low and high half: not every format has 128 bits.
    user_data: [u64; 2],
}

/// Blueprint, state and settings; a force field is left out.
impl Serialize for Deformable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Saved::of(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Deformable {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let saved = Saved::deserialize(deserializer)?;
        if let Some(what) = saved.mismatch() {
            return Err(D::Error::custom(format_args!(
                "a deformable with {what} it does not have"
            )));
        }
        saved.restore().map_err(D::Error::custom)
    }
}

impl Saved {
    fn of(body: &Deformable) -> Self {
        let solver = &body.solver;
        Self {
            blueprint: body.blueprint.clone(),
            state: body.state.clone(),
            external: solver.external.clone(),
            work: solver.work,
            time: solver.time,
            last_substep: solver.last_substep,
            stiffest: solver.stiffest,
            stable_h: solver.stable_h,
            forces: solver.forces.clone(),
            applied: solver.applied.clone(),
            speed_squared: solver.speed_squared,
            surface: body.surface,
            met: body.outline.is_some(),
            gravity_scale: body.gravity_scale,
            integrator: body.integrator,
            substeps: body.substeps,
            defaults: body.defaults,
            enabled: body.enabled,
            frozen: body.frozen,
            sleep: body.sleep,
            node_forces: body.node_forces.clone(),
            led: body.led.clone(),
            courses: body.courses.clone(),
            datum: body.datum,
            moment: body.moment,
            moved_out: body.moved_out.clone(),
            edits: body.edits,
            moved: body.moved,
            way: body.way,
            shifted: body.shifted,
            h: body.h,
            steady: body.steady,
            links: body.links,
            told: body.told.clone(),
            user_data: [body.user_data as u64, (body.user_data >> 64) as u64],
        }
    }

    /// What does not fit together: lists of other lengths than they must have, indices of what there is not.
    fn mismatch(&self) -> Option<&'static str> {
        let (blueprint, state) = (&self.blueprint, &self.state);
        let (nodes, springs) = (blueprint.nodes.len(), blueprint.springs.len());
        let known = |n: &u32| (*n as usize) < nodes;
        let none_or = |length: usize, count: usize| length == 0 || length == count;
        let skin = blueprint.skin.iter().all(|skin| {
            let mut corners = skin.triangles.iter().flatten();
            let mut nodes = skin.bindings.iter().flat_map(|b| &b.nodes);
            corners.all(|v| (*v as usize) < skin.bindings.len()) && nodes.all(known)
        });
        let checks = [
            (
                state.particles.len() == nodes && state.low.len() == nodes,
                "nodes",
            ),
            (
                state.particles.iter().all(Particle::swings_soundly),
                "swings",
            ),
            (
                [state.rest.len(), state.flow.len(), state.broken.len()] == [springs; 3],
                "springs",
            ),
            (
                blueprint.springs.iter().all(|s| s.nodes.iter().all(known)),
                "ends of springs",
            ),
            (
                blueprint.faces.iter().flatten().all(known),
                "corners of faces",
            ),
            (skin, "corners of its skin"),
            (self.forces.are_of(nodes), "forces"),
            (
                none_or(self.applied.len(), nodes)
                    && none_or(self.node_forces.len(), nodes)
                    && none_or(self.external.node_forces.len(), nodes),
                "forces on nodes",
            ),
            (
                self.led.iter().all(|(n, _)| known(n))
                    && self.courses.nodes().all(known)
                    && self.moved_out.iter().all(|(n, ..)| known(n))
                    && self.told.iter().all(known),
                "nodes that are led",
            ),
            (
                blueprint
                    .solid
                    .iter()
                    .all(|s| s.mesh.nodes.len() == nodes && s.mesh.check().is_ok()),
                "tets",
            ),
        ];
        let bad = checks.into_iter().find(|(fits, _)| !fits);
        bad.map(|(_, what)| what)
    }

    fn restore(self) -> Result<Deformable, BuildError> {
        let (blueprint, state) = (self.blueprint, self.state);
        let mut solver = Solver::new(&blueprint.springs, &state);
        if let Some(solid) = &blueprint.solid {
            let masses: Vec<f64> = blueprint.nodes.iter().map(|n| n.mass.into()).collect();
            let model = Arc::new(Model::new(&solid.mesh, solid.solid)?);
            solver = solver.with_elements(Part::new(model, &masses));
        }
        let solver = Solver {
            kernel: self.defaults.kernel,
            external: self.external,
            work: self.work,
            time: self.time,
            last_substep: self.last_substep,
            stiffest: self.stiffest,
            stable_h: self.stable_h,
            forces: self.forces,
            applied: self.applied,
            speed_squared: self.speed_squared,
            ..solver
        };
        let embedded = Embedded::of(&blueprint);
        let touching = embedded.as_ref().map_or(&blueprint, |e| &e.blueprint);
        let mut body = Deformable {
            slots: vec![u32::MAX; state.particles.len()],
            backup: state.clone(),
            topology: Arc::new(Topology::of(&blueprint)),
            outline: self.met.then(|| Box::new(Outline::new(touching))),
            embedded,
            blueprint,
            state,
            solver,
            surface: self.surface,
            gravity_scale: self.gravity_scale,
            integrator: self.integrator,
            substeps: self.substeps,
            defaults: self.defaults,
            enabled: self.enabled,
            frozen: self.frozen,
            sleep: self.sleep,
            node_forces: self.node_forces,
            led: self.led,
            courses: self.courses,
            datum: self.datum,
            moment: self.moment,
            moved_out: self.moved_out,
            edits: self.edits,
            moved: self.moved,
            way: self.way,
            shifted: self.shifted,
            h: self.h,
            steady: self.steady,
            links: self.links,
            told: self.told,
            user_data: u128::from(self.user_data[0]) | u128::from(self.user_data[1]) << 64,
            ..Deformable::default()
        };
        body.tear_anew();
        Ok(body)
    }
}
