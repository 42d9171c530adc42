//! Bodies held together, and the constraints between them taken in one after the other.

use super::Mobility;
use super::joints::Jacobian;
use crate::coupling::observe::Surroundings;
use crate::math::{DMat3, wide};
use rapier3d::dynamics::RigidBodyHandle;

/// How many bodies are looked at; those beyond count as not there.
const MOST: usize = 12;

/// Bodies held together by joints; the first is the one that is asked about.
pub(super) struct Linkage {
    pub(super) bodies: Vec<RigidBodyHandle>,
    /// Response of all velocities and spins to all impulses, row after row.
    response: Vec<f64>,
    pub(super) acceleration: Vec<f64>,
}

impl Linkage {
    fn size(&self) -> usize {
        6 * self.bodies.len()
    }

    pub(super) fn index(&self, body: RigidBodyHandle) -> Option<usize> {
        self.bodies.iter().position(|b| *b == body)
    }

    /// The bodies joined to `first`, each free as yet.
    pub(super) fn gather(first: RigidBodyHandle, around: &Surroundings) -> Self {
        let mut linkage = Self {
            bodies: vec![first],
            response: Vec::new(),
            acceleration: Vec::new(),
        };
        let mut next = 0;
        while let Some(&current) = linkage.bodies.get(next) {
            next += 1;
            for (a, b, _, _) in around.joints_of(current) {
                let other = if a == current { b } else { a };
                let moves = around.bodies.get(other).is_some_and(|b| b.is_dynamic());
                if moves && linkage.index(other).is_none() && linkage.bodies.len() < MOST {
                    linkage.bodies.push(other);
                }
            }
        }
        let n = linkage.size();
        linkage.response = vec![0.0; n * n];
        linkage.acceleration = vec![0.0; n];
        for i in 0..linkage.bodies.len() {
            let Some(body) = around.bodies.get(linkage.bodies[i]) else {
                continue;
            };
            let mut free = Mobility::free(body, around.gravity);
            let inertia = free.inv_inertia.inverse();
            if body.gyroscopic_forces_enabled() && inertia.is_finite() {
                let w = wide(body.angvel());
                free.spin_up -= free.inv_inertia * w.cross(inertia * w);
            }
            for k in 0..3 {
                linkage.acceleration[6 * i + k] = free.acceleration[k];
                linkage.acceleration[6 * i + 3 + k] = free.spin_up[k];
                for l in 0..3 {
                    linkage.response[(6 * i + k) * n + 6 * i + l] = free.inv_mass.col(l)[k];
                    linkage.response[(6 * i + 3 + k) * n + 6 * i + 3 + l] =
                        free.inv_inertia.col(l)[k];
                }
            }
        }
        linkage
    }

    /// Takes in one constraint: row · a = −bias.
    pub(super) fn hold(&mut self, row: &Jacobian, sides: [Option<usize>; 2], bias: f64) {
        let n = self.size();
        let mut j = Vec::with_capacity(12);
        for (side, part) in sides.into_iter().zip(row.chunks(2)) {
            let Some(side) = side else { continue };
            let [linear, angular] = [part[0], part[1]].map(|v| v.to_array());
            let both = linear.into_iter().chain(angular);
            j.extend(both.enumerate().map(|(k, x)| (6 * side + k, x)));
        }
        let push: Vec<f64> = (0..n)
            .map(|i| j.iter().map(|(k, x)| self.response[i * n + k] * x).sum())
            .collect();
        let along: f64 = j.iter().map(|(k, x)| push[*k] * x).sum();
        let before: f64 = j
            .iter()
            .map(|(k, x)| self.response[k * n + k] * x * x)
            .sum();
        let left = along > 1e-9 * before.max(f64::MIN_POSITIVE);
        if !left || !bias.is_finite() {
            return;
        }
        let rate: f64 = j.iter().map(|(k, x)| self.acceleration[*k] * x).sum();
        let force = (rate + bias) / along;
        for i in 0..n {
            self.acceleration[i] -= push[i] * force;
            let share = push[i] / along;
            for (r, p) in self.response[i * n..(i + 1) * n].iter_mut().zip(&push) {
                *r -= share * p;
            }
        }
    }

    pub(super) fn block(&self, row: usize, column: usize) -> DMat3 {
        let at = |k: usize, l: usize| self.response[(row + k) * self.size() + column + l];
        DMat3::from_cols_array_2d(&[0, 1, 2].map(|l| [0, 1, 2].map(|k| at(k, l))))
    }
}
