//! The recorder: an observer that keeps channels, histories, ledgers and events.
//!
//! It only reads, so a run gives the same hash with it and without it. Everything is kept in memory until the run is over;
//! events are capped and counted, because a body of fifty thousand springs can yield fifty thousand times.

use super::body::BodyRecord;
use super::channel::Interface;
use super::history::{Moments, NodeSet};
use super::larger;
use super::resample::{ResampleError, Resampled, resample};
use super::stress::TetSet;
use crate::body::{NodeId, TetId};
use crate::world::{
    Deformable, DeformableHandle, DeformableWorld, Observer, SpringEvent, SpringEventKind, Substep,
};
use rapier3d::geometry::ColliderHandle;

/// How often things are sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Between samples of momentum, bounds and node sets \[s\]; never more often than there are substeps.
    pub history: f64,
    /// Between samples of the energies \[s\].
    pub energy: f64,
    /// Most events that are kept; all are counted.
    pub events: usize,
}

impl Default for Sampling {
    fn default() -> Self {
        Self {
            history: 1.0e-4,
            energy: 1.0e-3,
            events: 100_000,
        }
    }
}

/// Why something can't be recorded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The deformable is not in the world.
    #[error("there is no deformable {0:?} in this world")]
    UnknownDeformable(DeformableHandle),
    /// A set of nodes that has none.
    #[error("the node set `{0}` has no nodes")]
    NoNodes(String),
    /// A set of tets that has none.
    #[error("the set of tets `{0}` has none")]
    NoTets(String),
}

/// Records a run.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    /// How often things are sampled.
    pub sampling: Sampling,
    /// One record per deformable, in the order of first sight.
    pub bodies: Vec<BodyRecord>,
    /// Node sets that are followed.
    pub sets: Vec<NodeSet>,
    /// Sets of tets that are followed.
    pub tet_sets: Vec<TetSet>,
    /// The first [`Sampling::events`] events.
    pub events: Vec<SpringEvent>,
    /// How many springs have begun to yield.
    pub yielded: u64,
    /// How many springs have broken.
    pub broken: u64,
}

impl Recorder {
    /// A recorder with the usual sampling.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the present state of all deformables as the beginning. A deformable that is not there yet begins at the end
    /// of its first substep.
    pub fn begin(&mut self, world: &DeformableWorld) {
        for (handle, body) in world.iter() {
            self.place(handle, body, world.time());
        }
    }

    fn place(&mut self, handle: DeformableHandle, body: &Deformable, time: f64) -> (usize, bool) {
        if let Some(i) = self.bodies.iter().position(|b| b.deformable == handle) {
            return (i, false);
        }
        self.bodies.push(BodyRecord::new(handle, body, time));
        (self.bodies.len() - 1, true)
    }

    /// Follows the mean of a set of nodes from now on; returns its index in [`Self::sets`]. What is recorded of its body begins
    /// now, if it has not yet.
    ///
    /// # Errors
    /// [`RecordError`] for an unknown deformable or a set without existing nodes.
    pub fn follow(
        &mut self,
        name: impl Into<String>,
        world: &DeformableWorld,
        deformable: DeformableHandle,
        nodes: Vec<NodeId>,
    ) -> Result<usize, RecordError> {
        let body = world
            .get(deformable)
            .ok_or(RecordError::UnknownDeformable(deformable))?;
        let mut set = NodeSet {
            name: name.into(),
            deformable,
            nodes,
            history: Moments::default(),
        };
        set.sample(body, world.time());
        if set.history.times.is_empty() {
            return Err(RecordError::NoNodes(set.name));
        }
        self.place(deformable, body, world.time());
        self.sets.push(set);
        Ok(self.sets.len() - 1)
    }

    /// Follows the mean stress and strain of a set of tets from now on; returns its index in [`Self::tet_sets`]. What is recorded
    /// of its body begins now, if it has not yet.
    ///
    /// # Errors
    /// [`RecordError`] for an unknown deformable or a set without existing tets.
    pub fn follow_tets(
        &mut self,
        name: impl Into<String>,
        world: &DeformableWorld,
        deformable: DeformableHandle,
        tets: &[TetId],
    ) -> Result<usize, RecordError> {
        let body = world
            .get(deformable)
            .ok_or(RecordError::UnknownDeformable(deformable))?;
        let mut set = TetSet::new(name.into(), deformable, body, tets);
        if set.tets.is_empty() {
            return Err(RecordError::NoTets(set.name));
        }
        set.sample(body, world.time());
        self.place(deformable, body, world.time());
        self.tet_sets.push(set);
        Ok(self.tet_sets.len() - 1)
    }

    /// The record of a deformable.
    pub fn body(&self, deformable: DeformableHandle) -> Option<&BodyRecord> {
        self.bodies.iter().find(|b| b.deformable == deformable)
    }

    /// Force that a collider exerted on all deformables along `axis` (0, 1, 2) in bins of `dt` s \[N\]; zero where it
    /// never touched one.
    ///
    /// # Errors
    /// [`ResampleError`].
    pub fn collider_force(
        &self,
        collider: ColliderHandle,
        axis: usize,
        dt: f64,
    ) -> Result<Resampled, ResampleError> {
        self.force(Interface::Collider(collider), axis, dt)
    }

    /// As [`Self::collider_force`], of any interface.
    ///
    /// # Errors
    /// [`ResampleError`].
    pub fn force(
        &self,
        interface: Interface,
        axis: usize,
        dt: f64,
    ) -> Result<Resampled, ResampleError> {
        // Bodies come and go: all are summed over the time that any was recorded, with no force before and after.
        let recorded = self.bodies.iter().filter(|b| !b.edges.is_empty());
        let ends = recorded.map(|b| (b.edges[0], b.edges[b.edges.len() - 1]));
        let Some((begin, end)) = ends.reduce(|(a, b), (c, d)| (a.min(c), b.max(d))) else {
            return resample(&[], &[], dt);
        };
        if begin >= end {
            return resample(&[], &[], dt);
        }
        let mut sum = resample(&[begin, end], &[0.0], dt)?;
        for body in &self.bodies {
            let Some(channel) = body.find(interface) else {
                continue;
            };
            let force = channel.force_between(&body.edges, [begin, end], axis, dt)?;
            for (s, f) in sum.values.iter_mut().zip(&force.values) {
                *s += f;
            }
        }
        Ok(sum)
    }

    /// Acceleration of a node set along `axis` in bins of `dt` s \[m/s²\].
    ///
    /// # Errors
    /// [`ResampleError`].
    pub fn acceleration(
        &self,
        set: &NodeSet,
        axis: usize,
        dt: f64,
    ) -> Result<Resampled, ResampleError> {
        resample(&set.history.times, &set.history.accelerations(axis), dt)
    }

    /// Deepest that any node was in any collider \[m\].
    pub fn max_depth(&self) -> f64 {
        let channels = self.bodies.iter().flat_map(|b| &b.channels);
        channels.map(|c| c.max_depth).fold(0.0, f64::max)
    }

    /// Largest energy residual of any deformable \[1\].
    pub fn max_residual(&self) -> f64 {
        let residuals = self.bodies.iter().map(BodyRecord::max_residual);
        residuals.fold(0.0, larger)
    }

    /// Largest momentum closure error of any deformable \[1\].
    pub fn momentum_closure(&self) -> f64 {
        let errors = self.bodies.iter().map(|b| b.closure.error());
        errors.fold(0.0, larger)
    }
}

impl Observer for Recorder {
    fn substep(&mut self, substep: &Substep) {
        for (handle, body) in substep.deformables {
            let (i, new) = self.place(*handle, body, substep.time);
            if !new && self.bodies[i].substep(body, substep, &self.sampling) {
                for set in self.sets.iter_mut().filter(|s| s.deformable == *handle) {
                    set.sample(body, substep.time);
                }
                let of_tets = self.tet_sets.iter_mut();
                for set in of_tets.filter(|s| s.deformable == *handle) {
                    set.sample(body, substep.time);
                }
            }
        }
    }

    fn wants_springs(
        &self,
        time: f64,
        deformables: &[(DeformableHandle, Box<Deformable>)],
    ) -> bool {
        deformables.iter().any(|(handle, _)| {
            let known = self.bodies.iter().find(|b| b.deformable == *handle);
            known.is_none_or(|record| record.balances(time))
        })
    }

    fn event(&mut self, event: &SpringEvent) {
        match event.kind {
            SpringEventKind::YieldBegan => self.yielded += 1,
            SpringEventKind::Broke => self.broken += 1,
        }
        if self.events.len() < self.sampling.events {
            self.events.push(*event);
        }
    }
}
