//! Force channels at the substep rate.
//!
//! What is stored is impulses, not forces: an impulse belongs to the interval it acted in, and the sum over any stretch is
//! exact whatever the substeps were. Deformables of different groups have different substeps, so the edges of the
//! intervals belong to the deformable and a channel is one pair of a deformable and what acts on it.

use super::resample::{ResampleError, Resampled, resample};
use crate::math::DVec3;
use crate::world::{AttachmentHandle, DeformableHandle, Partner};
use rapier3d::geometry::ColliderHandle;

/// What acts on a deformable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Interface {
    /// Contact with a collider.
    Collider(ColliderHandle),
    /// Contact with another deformable.
    Deformable(DeformableHandle),
    /// An attachment, whatever it is to.
    Attachment(AttachmentHandle),
}

impl From<Partner> for Interface {
    fn from(partner: Partner) -> Self {
        match partner {
            Partner::Collider(handle) => Self::Collider(handle),
            Partner::Deformable(handle) => Self::Deformable(handle),
        }
    }
}

/// The impulses of one interface, one per substep of its deformable.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// What acts.
    pub interface: Interface,
    /// Impulse on the deformable in each substep \[N·s\]; 0 where the other side was out of reach.
    pub impulses: Vec<DVec3>,
    /// Deepest point so far \[m\].
    pub max_depth: f64,
    /// When it was that deep \[s\].
    pub depth_time: f64,
    /// Most points that received an impulse in one substep.
    pub max_touching: u32,
    /// First and last end of a substep with an impulse \[s\].
    pub touched: Option<[f64; 2]>,
}

impl Channel {
    pub(super) fn new(interface: Interface) -> Self {
        Self {
            interface,
            impulses: Vec::new(),
            max_depth: 0.0,
            depth_time: 0.0,
            max_touching: 0,
            touched: None,
        }
    }

    /// Adds the impulse of the substep number `index` that ended at `time`.
    pub(super) fn add(&mut self, index: usize, impulse: DVec3, time: f64) {
        self.impulses.resize(index + 1, DVec3::ZERO);
        self.impulses[index] += impulse;
        if impulse != DVec3::ZERO {
            let first = self.touched.map_or(time, |t| t[0]);
            self.touched = Some([first, time]);
        }
    }

    /// Impulse of the whole recording \[N·s\].
    pub fn total(&self) -> DVec3 {
        self.impulses.iter().copied().sum()
    }

    /// Force along one axis (0, 1, 2) in even bins of `dt` s, from the edges of the deformable's substeps.
    ///
    /// # Errors
    /// Those of [`resample`].
    pub fn force(&self, edges: &[f64], axis: usize, dt: f64) -> Result<Resampled, ResampleError> {
        resample(edges, &self.forces(edges, axis), dt)
    }

    /// As [`Self::force`], over a span of time \[s\] that the recording may fill only in part; the rest has no force.
    ///
    /// # Errors
    /// Those of [`resample`].
    pub fn force_between(
        &self,
        edges: &[f64],
        span: [f64; 2],
        axis: usize,
        dt: f64,
    ) -> Result<Resampled, ResampleError> {
        let (mut times, mut values) = (edges.to_vec(), self.forces(edges, axis));
        if let (Some(&first), Some(&last)) = (edges.first(), edges.last()) {
            if span[0] < first {
                times.insert(0, span[0]);
                values.insert(0, 0.0);
            }
            if last < span[1] {
                times.push(span[1]);
                values.push(0.0);
            }
        }
        resample(&times, &values, dt)
    }

    /// Mean force in each substep \[N\].
    fn forces(&self, edges: &[f64], axis: usize) -> Vec<f64> {
        edges
            .windows(2)
            .enumerate()
            .map(|(i, t)| {
                let impulse = self.impulses.get(i).copied().unwrap_or_default();
                impulse.to_array().get(axis).copied().unwrap_or(0.0) / (t[1] - t[0])
            })
            .collect()
    }
}
