//! What a step did, for those who ask.

use super::substep::Group;
use super::touch::TouchEvent;
use super::{AttachmentHandle, DeformableHandle};
use crate::body::BuildError;
use crate::math::Vector;
use rapier3d::geometry::ColliderHandle;

/// What the last step did. A step never panics and returns no `Result`; what went wrong stands here.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StepReport {
    /// The step's dt if it was NaN, negative, longer than 10 s, or not 0 and shorter than a nanosecond: then nothing was done.
    pub invalid_dt: Option<f64>,
    /// Rapier's gravity if it was not finite \[m/s²\]: then nothing was done at all.
    pub invalid_gravity: Option<Vector>,
    /// What is wrong with the world's [`params`](super::DeformableWorld::params): then nothing was done at all.
    pub invalid_params: Option<BuildError>,
    /// How many Rapier steps were made (M).
    pub rigid_steps: usize,
    /// Substeps taken by each deformable, in the order of the set.
    pub substeps: Vec<(DeformableHandle, usize)>,
    /// Spring forces evaluated: springs × substeps.
    pub spring_updates: u64,
    /// Forces of tets evaluated: tets × substeps.
    pub tet_updates: u64,
    /// Bodies frozen in this step because their state became non-finite.
    pub frozen: Vec<DeformableHandle>,
    /// Bodies that asked for too few substeps: taken as asked for `Substeps::Unchecked`, raised for `Substeps::Fixed`.
    pub unstable: Vec<DeformableHandle>,
    /// Colliders in reach whose shape nodes can't touch: custom ones, compounds with a part without volume, shapes that are
    /// not finite.
    pub unsupported: Vec<ColliderHandle>,
    /// Attachments that broke in this step.
    pub broken_attachments: Vec<AttachmentHandle>,
    /// Contacts that began, were strong or ended, in the order of deformables and partners.
    pub events: Vec<TouchEvent>,
    /// Work of deformables on the shadows minus that of the same impulses on the rigid bodies \[J\], beyond what can't be known:
    /// Rapier's velocities stand half a solver iteration of gravity before its positions, but for what contacts and joints have taken of it.
    pub coupling_defect: f64,
}

impl StepReport {
    /// An empty report for the coming step. The memory of events is used again.
    pub(super) fn clear(&mut self) {
        let mut events = std::mem::take(&mut self.events);
        events.clear();
        *self = Self {
            events,
            ..Self::default()
        };
    }

    /// Adds n substeps of a group.
    pub(super) fn add_group(&mut self, group: &Group, n: usize) {
        for (handle, body) in &group.members {
            self.add_substeps(*handle, n);
            self.spring_updates += (n * body.spring_count()) as u64;
            self.tet_updates += (n * body.tet_count()) as u64;
        }
    }

    /// Adds what came of a group.
    pub(super) fn include(&mut self, group: &Self) {
        for &(handle, n) in &group.substeps {
            self.add_substeps(handle, n);
        }
        self.spring_updates += group.spring_updates;
        self.tet_updates += group.tet_updates;
        for &handle in &group.unstable {
            note(&mut self.unstable, handle);
        }
        for &handle in &group.frozen {
            log::warn!("deformable {handle:?} became non-finite and was frozen");
            note(&mut self.frozen, handle);
        }
    }

    fn add_substeps(&mut self, handle: DeformableHandle, n: usize) {
        match self.substeps.iter_mut().find(|(h, _)| *h == handle) {
            Some((_, sum)) => *sum += n,
            None => self.substeps.push((handle, n)),
        }
    }
}

/// Adds `item` unless it is there already.
pub(super) fn note<T: PartialEq>(list: &mut Vec<T>, item: T) {
    if !list.contains(&item) {
        list.push(item);
    }
}
