//! What is kept of rigid bodies and of everything together, after every step.
//!
//! Deformables have the recorder, which sees every substep. Of a rigid body there is nothing between two steps that Rapier
//! would tell.

use super::super::super::{Run, survey};
use crate::math::{DVec3, wide};
use crate::world::TouchEventKind;
use rapier3d::dynamics::RigidBodyHandle;

/// A rigid body over time.
pub(super) struct Path {
    pub body: RigidBodyHandle,
    pub centers: Vec<DVec3>,
    pub linvels: Vec<DVec3>,
    pub angvels: Vec<DVec3>,
}

/// Everything that is sampled once per step.
pub(super) struct Trace {
    pub times: Vec<f64>,
    pub paths: Vec<Path>,
    /// Speed of the fastest node or rigid body \[m/s\].
    pub fastest: Vec<f64>,
    pub attachments_broken: usize,
    pub contacts_begun: usize,
}

impl Trace {
    /// Begins with the worlds as they are. Fixed bodies are not followed.
    pub fn begin(run: &Run) -> Self {
        let movable = run.cast.bodies.iter().filter(|(_, handle)| {
            let body = run.world.bodies.get(*handle);
            body.is_some_and(|b| !b.is_fixed())
        });
        let path = |&(_, body): &(String, RigidBodyHandle)| Path {
            body,
            centers: Vec::new(),
            linvels: Vec::new(),
            angvels: Vec::new(),
        };
        let mut trace = Self {
            times: Vec::new(),
            paths: movable.map(path).collect(),
            fastest: Vec::new(),
            attachments_broken: 0,
            contacts_begun: 0,
        };
        trace.sample(run);
        trace
    }

    pub fn sample(&mut self, run: &Run) {
        self.times.push(run.deformables.time());
        for path in &mut self.paths {
            if let Some(body) = run.world.bodies.get(path.body) {
                path.centers.push(wide(body.center_of_mass()));
                path.linvels.push(wide(body.linvel()));
                path.angvels.push(wide(body.angvel()));
            }
        }
        let soft = survey::fastest_node(&run.deformables);
        self.fastest
            .push(soft.max(survey::fastest_rigid(&run.world)));
        let report = run.deformables.report();
        self.attachments_broken += report.broken_attachments.len();
        let begun = |e: &&crate::world::TouchEvent| e.kind == TouchEventKind::Started;
        self.contacts_begun += report.events.iter().filter(begun).count();
    }

    pub fn path(&self, body: RigidBodyHandle) -> Option<&Path> {
        self.paths.iter().find(|p| p.body == body)
    }
}
