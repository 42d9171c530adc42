//! The world of deformables beside a Rapier world.

// A body: built, read, changed and saved.
mod builder;
mod deformable;
mod edit;
mod embed;
mod energies;
mod gross_motion;
mod into;
mod settings;
#[cfg(feature = "statics")]
mod settle;
#[cfg(feature = "serde-serialize")]
mod snapshot;
mod solid;
mod subset;
mod tears;

// A step, from top to bottom.
mod params;
mod parts;
mod step;

// Within it groups of bodies are advanced, by substeps.
mod advance;
mod group;
mod substep;

// In a substep bodies move freely, rows answer, and both are booked.
mod motion;
mod position_correction;
mod solve;
mod work;

// How many substeps there are, and how long.
mod budget;
mod span;
mod steady;

// What may touch what.
mod blow;
mod fast;
mod hooks;
mod known;
mod meet;
mod reach;
mod sense;

// Rigid bodies: what they follow and what follows them, and when they get their impulses.
mod constraints;
mod course;
mod follow;
mod kinematic;
mod laden;
mod landing;
mod lead_back;
mod rehearse;

// Attachments.
mod attach;
mod attachment;
mod ties;

// Rest.
mod sleep;

// What is told of it.
mod debug;
#[cfg(feature = "debug-render")]
mod debug_backend;
mod observer;
mod query;
mod report;
mod touch;

pub use crate::contact::target::SurfaceProperties;
pub use crate::coupling::attach::{Bond, Break, Hold, Load, To};
pub use attach::AttachmentState;
pub use attachment::{AttachError, AttachTo, Attachment};
pub use builder::DeformableBuilder;
pub use debug::{DebugStyle, rgba};
pub use deformable::Deformable;
pub use energies::Energies;
pub use hooks::{DeformableHooks, PairContext};
pub use into::{IntoDeformable, IntoNet, IntoTetMesh};
pub use observer::{
    AttachmentBroke, AttachmentImpulse, NodeImpulse, Observer, PairImpulse, Partner, SpringEvent,
    SpringEventKind, Substep,
};
pub use params::{DeformableParameters, Substeps};
pub use parts::RapierParts;
pub use query::{
    DeformableFilter, DeformableOverlap, DeformableProjection, DeformableRayHit, RayHit,
};
pub use report::StepReport;
#[cfg(feature = "serde-serialize")]
pub use snapshot::SnapshotError;
pub use touch::{PairContact, TouchEvent, TouchEventKind};

use crate::body::BuildError;
use crate::contact::candidates::Candidates;
use crate::contact::encounter::Encounter;
use crate::contact::form::Forms;
use crate::coupling::memory::{BodyMemory, Response};
use crate::math::{Fnv, Vector};
use group::{BodyKey, Waiting};
use rapier3d::data::arena::{Arena, Index};
use rapier3d::geometry::ColliderHandle;
use std::collections::{BTreeMap, BTreeSet};

/// A deformable in a [`DeformableWorld`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct DeformableHandle(pub(crate) Index);

impl DeformableHandle {
    /// What handles are sorted by.
    fn key(self) -> (u32, u32) {
        self.0.into_raw_parts()
    }

    fn of_key((index, generation): (u32, u32)) -> Self {
        Self(Index::from_raw_parts(index, generation))
    }
}

/// An attachment in a [`DeformableWorld`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct AttachmentHandle(pub(crate) Index);

/// Deformable bodies, and everything needed to step them beside a Rapier world.
///
/// ```
/// use crumple::prelude::*;
/// use crumple::rapier3d::prelude::*;
/// let mut world = PhysicsWorld::default();
/// world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::cuboid(5.0, 0.1, 5.0));
/// let mut deformables = DeformableWorld::default();
/// let block = deformables.insert(
///     DeformableBuilder::new(lattice(Vector::splat(0.4), 0.1))
///         .material(Material::rubber())
///         .translation(Vector::new(0.0, 0.4, 0.0)),
/// )?;
/// for _ in 0..60 {
///     deformables.step(&mut world);
/// }
/// assert!((deformables[block].center_of_mass().y - 0.3).abs() < 0.02);
/// # Ok::<(), crumple::body::BuildError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct DeformableWorld {
    /// Settings.
    pub params: DeformableParameters,
    bodies: Arena<Box<Deformable>>,
    attachments: Arena<AttachmentState>,
    memory: BTreeMap<BodyKey, BodyMemory>,
    /// What each deformable touched of each collider in the last step.
    contacts: BTreeMap<((u32, u32), BodyKey), Candidates>,
    /// What pairs of deformables touched of each other in the last step.
    encounters: BTreeMap<(BodyKey, BodyKey), Encounter>,
    meetings: meet::Meetings,
    /// The shapes met so far, as contact sees them.
    forms: Forms,
    waiting: Vec<Waiting>,
    /// The rigid bodies that hold nodes stiffly in the step under way.
    stiffly: BTreeSet<BodyKey>,
    report: StepReport,
    time: f64,
    steps: u64,
    fine_until: f64,
    gravity: Option<Vector>,
    parity: bool,
    /// Colliders of shapes that nodes can't touch, of which the log has been told.
    warned: Vec<ColliderHandle>,
    /// The step of a `before_step` that waits for its other half \[s\].
    half_done: Option<f64>,
    /// How kinematic bodies have moved.
    courses: kinematic::Courses,
    /// What Rapier's BVH knows.
    known: known::Known,
    /// What joined rigid bodies at the end of the last step.
    moorings: sleep::Moorings,
    /// Who touches whom.
    touches: BTreeMap<touch::TouchKey, touch::Touch>,
    /// Groups asleep, and groups that may fall asleep at the end of the step.
    islands: Vec<sleep::Island>,
    drowsy: Vec<sleep::Drowsy>,
    /// What is to be looked at after the Rapier step under way.
    sensing: Vec<sense::Sensing>,
    gate: hooks::Gate,
}

impl DeformableWorld {
    /// An empty world with default settings.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a body: a builder, or a body that was built or taken out of a world before.
    ///
    /// # Errors
    /// Everything building can fail with, and [`BuildError::Unstable`] or [`BuildError::NeverStable`] for a body that is
    /// not stable within its substeps.
    pub fn insert(&mut self, body: impl IntoDeformable) -> Result<DeformableHandle, BuildError> {
        let mut body = body.into_deformable()?;
        body.defaults = self.params;
        if body.node_count() == 0 {
            return Err(BuildError::Empty);
        }
        body.solver.kernel = self.params.kernel;
        body.make_ready();
        body.check_budget()?;
        Ok(DeformableHandle(self.bodies.insert(Box::new(body))))
    }

    /// Removes a body and its attachments. Rigid bodies that slept on it wake in the next step.
    pub fn remove(&mut self, handle: DeformableHandle) -> Option<Deformable> {
        let mut body = self.bodies.remove(handle.0)?;
        body.edit(|body| body.links = 0.0);
        self.drop_stale_attachments(None);
        Some(*body)
    }

    /// Whether the handle is that of a body in this world.
    pub fn contains(&self, handle: DeformableHandle) -> bool {
        self.bodies.contains(handle.0)
    }

    /// How many bodies there are.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// A body.
    pub fn get(&self, handle: DeformableHandle) -> Option<&Deformable> {
        self.bodies.get(handle.0).map(|b| &**b)
    }

    /// A body, to be changed.
    pub fn get_mut(&mut self, handle: DeformableHandle) -> Option<&mut Deformable> {
        self.bodies.get_mut(handle.0).map(|b| &mut **b)
    }

    /// All bodies, in the order of their slots.
    pub fn iter(&self) -> impl Iterator<Item = (DeformableHandle, &Deformable)> {
        self.bodies.iter().map(|(i, b)| (DeformableHandle(i), &**b))
    }

    /// All bodies, to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (DeformableHandle, &mut Deformable)> {
        self.bodies
            .iter_mut()
            .map(|(i, b)| (DeformableHandle(i), &mut **b))
    }

    /// What the last step did.
    pub fn report(&self) -> &StepReport {
        &self.report
    }

    /// Simulated time \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Hash of the state of all bodies and of the coupling memory, bit for bit.
    pub fn state_hash(&self) -> u64 {
        let bodies = self
            .iter()
            .flat_map(|(_, b)| [b.state_hash(), b.sleep.bits()]);
        let memory = self.memory.values().flat_map(|m| {
            let known = m.response.unwrap_or(Response::all(-1.0));
            let [along, about, load] = [known.along, known.about, m.load].map(|v| v.to_array());
            let offset = [m.offset.0, m.offset.1, m.stayed.0].map(|v| v.to_array());
            let rest = [m.asleep]
                .into_iter()
                .chain(m.stayed.1.to_array())
                .map(f64::to_bits);
            let vectors = along.into_iter().chain(about).chain(load);
            let vectors = vectors.chain(offset.into_iter().flatten());
            vectors.map(f64::to_bits).chain(rest)
        });
        let attachments = self.attachments.iter().flat_map(|(_, a)| {
            let average =
                [a.average.force, a.average.moment].map(|v| v.to_array().map(f64::to_bits));
            let [f, m] = average;
            let broken = u64::from(a.is_broken());
            let rest = [a.energy.to_bits(), a.moved_in.to_bits(), broken];
            let moved = a.moved.iter().flat_map(|m| m.to_array().map(f64::to_bits));
            f.into_iter().chain(m).chain(rest).chain(moved)
        });
        let words = bodies.chain(memory).chain(attachments);
        Fnv::of_words(words.chain([u64::from(self.parity)]))
    }

    fn take(&mut self, handle: DeformableHandle) -> Option<Box<Deformable>> {
        self.bodies.get_mut(handle.0).map(std::mem::take)
    }

    fn put_back(&mut self, handle: DeformableHandle, body: Box<Deformable>) {
        if let Some(place) = self.bodies.get_mut(handle.0) {
            *place = body;
        }
    }
}

impl std::ops::Index<DeformableHandle> for DeformableWorld {
    type Output = Deformable;

    /// # Panics
    /// For a handle that is not of this world, like Rapier's sets; [`DeformableWorld::get`] does not panic.
    fn index(&self, handle: DeformableHandle) -> &Deformable {
        &self.bodies[handle.0]
    }
}

impl std::ops::IndexMut<DeformableHandle> for DeformableWorld {
    fn index_mut(&mut self, handle: DeformableHandle) -> &mut Deformable {
        &mut self.bodies[handle.0]
    }
}
