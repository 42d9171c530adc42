//! Where a set of nodes is and how fast it moves, over time.
//!
//! A single node of a crash body rings with its springs. Laboratories screw an accelerometer to a stiff place; the mean
//! over a set of nodes (a cabin floor, the whole body) is the same idea and needs less filtering.

use crate::body::NodeId;
use crate::math::DVec3;
use crate::world::{Deformable, DeformableHandle};

/// Samples of position and velocity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moments {
    /// Time of each sample \[s\].
    pub times: Vec<f64>,
    /// Mean position, weighted by mass \[m\].
    pub positions: Vec<DVec3>,
    /// Mean velocity, weighted by mass \[m/s\].
    pub velocities: Vec<DVec3>,
}

impl Moments {
    /// Mean acceleration along `axis` (0, 1, 2) between samples \[m/s²\], the intervals' edges being [`Self::times`].
    pub fn accelerations(&self, axis: usize) -> Vec<f64> {
        let along = |v: &DVec3| v.to_array().get(axis).copied().unwrap_or(0.0);
        self.times
            .windows(2)
            .zip(self.velocities.windows(2))
            .map(|(t, v)| (along(&v[1]) - along(&v[0])) / (t[1] - t[0]))
            .collect()
    }

    pub(super) fn push(&mut self, time: f64, position: DVec3, velocity: DVec3) {
        self.times.push(time);
        self.positions.push(position);
        self.velocities.push(velocity);
    }
}

/// Some nodes of a deformable whose mean is followed.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeSet {
    /// A name for tables, without commas.
    pub name: String,
    /// The deformable.
    pub deformable: DeformableHandle,
    /// Its nodes.
    pub nodes: Vec<NodeId>,
    /// The samples.
    pub history: Moments,
}

impl NodeSet {
    /// Mean position and velocity, weighted by mass; `None` if no node exists.
    pub fn mean(&self, body: &Deformable) -> Option<(DVec3, DVec3)> {
        let (mut mass, mut x, mut v) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for &node in &self.nodes {
            let (Some(m), Some(position), Some(velocity)) = (
                body.node_mass(node),
                body.position(node),
                body.linvel_of(node),
            ) else {
                continue;
            };
            let m = f64::from(m);
            mass += m;
            x += position * m;
            v += velocity * m;
        }
        (mass > 0.0).then(|| (x / mass, v / mass))
    }

    pub(super) fn sample(&mut self, body: &Deformable, time: f64) {
        if let Some((x, v)) = self.mean(body) {
            self.history.push(time, x, v);
        }
    }
}
