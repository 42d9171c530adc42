//! Groups: deformables that touch or are attached to the same moving body share their substeps and their rows.

mod dissolve;
mod form;

use super::kinematic::Courses;
use super::substep::Group;
use crate::coupling::constraints::RigidConstraints;
use crate::coupling::handover;
use crate::coupling::linkage::Mobility;
use crate::coupling::memory::{BodyMemory, Response};
use crate::coupling::observe::{self, Answer, Surroundings};
use crate::math::{DQuat, DVec3, wide};
use crate::solve::shadow::Shadow;
use rapier3d::dynamics::RigidBodyHandle;
use std::collections::BTreeMap;

/// A rigid body that deformables of a group can touch.
#[derive(Clone, Debug)]
pub(super) struct Touched {
    pub body: RigidBodyHandle,
    pub answer: Answer,
    pub mobility: Mobility,
    pub start: Shadow,
    /// Where the body's centre of mass is, and its orientation: a shadow may start apart from it.
    pub at: (DVec3, DQuat),
    /// The body's centre of mass in its own frame \[m\].
    pub local_com: DVec3,
    /// Whether it was put where its shadow was in the last step, because of what it holds.
    pub was_put: bool,
    /// The set of bodies with which it lands in this step, if it does, see [`super::landing`].
    pub lands: Option<BodyKey>,
}

/// A body that has been handed its first part and waits for the rest.
#[derive(Clone, Debug)]
pub(super) struct Waiting {
    pub touched: Touched,
    pub end: Shadow,
    pub pending: handover::Pending,
    /// Whether any node lay within 2 mm at the end of the substeps.
    pub near: bool,
    /// Whether it holds a node that is deep in what never moves, and has to get it out.
    pub holds: bool,
    /// Whether it touches a deformable of a group that something leads, or that something moves with.
    pub led: bool,
    /// Whether it was put where its shadow is.
    pub put: bool,
}

/// A sortable key of a body.
pub(super) type BodyKey = (u32, u32);

/// The body of a key.
pub(super) fn handle_of((index, generation): BodyKey) -> RigidBodyHandle {
    RigidBodyHandle::from_raw_parts(index, generation)
}

/// Where shadows ended: centres of mass \[m\] and orientations.
pub(super) type Ends = BTreeMap<BodyKey, (DVec3, DQuat)>;

/// What shadows are made of: what is remembered of bodies, their joints and contacts, and what is around them.
pub(super) struct Origins<'a> {
    pub memory: &'a mut BTreeMap<BodyKey, BodyMemory>,
    pub constraints: &'a RigidConstraints,
    pub around: &'a Surroundings<'a>,
    /// Of kinematic bodies.
    pub courses: &'a Courses,
    /// Length of the rigid step \[s\].
    pub dt: f64,
}

impl Origins<'_> {
    /// Index of the shadow of a body in the group, made if it is not there. Shadow 0 is the fixed world.
    pub fn shadow(&mut self, group: &mut Group, body: Option<RigidBodyHandle>) -> u32 {
        let around = self.around;
        let Some((handle, body)) = body.and_then(|h| Some((h, around.bodies.get(h)?))) else {
            return 0;
        };
        if let Some(i) = group.touched.iter().position(|t| t.body == handle) {
            return i as u32 + 1;
        }
        let answer = observe::answer(handle, body, self.constraints, around);
        let (mobility, response) = if answer == Answer::None {
            (Mobility::free(body, around.gravity), Response::all(1.0))
        } else {
            let memory = self.memory.entry(handle.into_raw_parts()).or_default();
            observe::response(handle, body, answer, memory, around, self.dt)
        };
        let mut start = observe::shadow(body, answer, &mobility, response, around, self.dt);
        if let Some(course) = self.courses.get(&handle.into_raw_parts()) {
            start.lead_on(course.bend, self.dt);
        }
        let at = (start.com, start.rot);
        let memory = self.memory.get(&handle.into_raw_parts());
        if let Some(memory) = memory {
            (start.com, start.rot) = memory.apart(start.com, start.rot);
        }
        let was_put = memory.is_some_and(|m| m.was_put);
        group.touched.push(Touched {
            body: handle,
            answer,
            mobility,
            start,
            at,
            local_com: wide(body.local_center_of_mass()),
            was_put,
            lands: None,
        });
        group.shadows.push(start);
        group.shadows.len() as u32 - 1
    }
}
