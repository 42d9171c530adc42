//! Joints between shadows.
//!
//! What hangs on a joint feels what pushes its partner. All locked axes of a joint are solved at once, because at the end
//! of a long lever each of them alone undoes what the others did.

use crate::math::DVec3;
use crate::math::na::{Cholesky, Const, SMatrix, SVector};
use crate::solve::shadow::Shadow;

/// How much of a joint's opening is taken back in a substep.
const PULL_BACK: f64 = 0.2;
/// What keeps directions in which nothing moves from dividing by zero.
const FLOOR: f64 = 1e-9;

/// The locked axes of a joint of two shadows.
#[derive(Clone, Debug, Default)]
pub struct JointRow {
    /// Indices into the shadows; 0 for the fixed world.
    pub shadows: [u32; 2],
    /// The anchor on each, from its centre of mass in its own axes \[m\].
    pub anchors: [DVec3; 2],
    /// The joint's axes on the first, in its own axes.
    pub axes: [DVec3; 3],
    /// Which displacements along these axes, and turns about them, are locked.
    pub locked: [bool; 6],
    /// How far the joint is open at the start of the rigid step \[m\]: for Rapier to mend.
    pub open: DVec3,
    /// Accumulated impulses of this substep, at its start those of the last one \[N·s\], \[N·m·s\].
    pub impulses: SVector<f64, 6>,
    /// Directions in the world, and arms about both centres of mass; set by the pass, as what follows.
    pub directions: [DVec3; 3],
    /// From the centres of mass to the second's anchor \[m\].
    pub arms: [DVec3; 2],
    /// Velocity that takes back what has opened \[m/s\].
    pub bias: SVector<f64, 6>,
    /// Factors of the response of the locked axes to their impulses; `None` if nothing moves.
    pub factors: Option<Cholesky<f64, Const<6>>>,
}

impl JointRow {
    /// Finds the axes at the start of a substep of h s, and lets the shadows take the impulses of the last one.
    pub(super) fn start(&mut self, shadows: &mut [Shadow], h: f64) {
        let [a, b] = self.shadows.map(|i| shadows[i as usize]);
        let first = a.rot * self.anchors[0];
        let second = b.rot * self.anchors[1];
        self.arms = [b.com + second - a.com, second];
        self.directions = self.axes.map(|axis| a.rot * axis);
        let opening = self.arms[0] - first;
        let mut response = SMatrix::<f64, 6, 6>::zeros();
        for i in 0..6 {
            self.bias[i] = 0.0;
            if !self.locked[i] {
                response[(i, i)] = 1.0;
                self.impulses[i] = 0.0;
                continue;
            }
            if i < 3 {
                let opened = opening.dot(self.directions[i]) - self.open[i];
                self.bias[i] = -PULL_BACK * opened / h;
            }
            let (moved, other) = (self.response(&a, i, 0), self.response(&b, i, 1));
            for k in (0..6).filter(|k| self.locked[*k]) {
                response[(k, i)] = self.along(k, &[moved, other]);
            }
        }
        let trace: f64 = (0..6)
            .filter(|i| self.locked[*i])
            .map(|i| response[(i, i)])
            .sum();
        for i in (0..6).filter(|i| self.locked[*i]) {
            response[(i, i)] += FLOOR * trace;
        }
        self.factors = (trace > 0.0).then(|| Cholesky::new(response)).flatten();
        let impulses = self.impulses;
        self.push(shadows, &impulses);
    }

    /// One visit of a pass; whether it was not settled yet.
    pub(super) fn solve(&mut self, shadows: &mut [Shadow], tolerance: f64) -> bool {
        let Some(factors) = &self.factors else {
            return false;
        };
        let [a, b] = self.shadows.map(|i| &shadows[i as usize]);
        let motions = [(a.v, a.w), (b.v, b.w)];
        let mut wanted = SVector::zeros();
        for i in (0..6).filter(|i| self.locked[*i]) {
            wanted[i] = self.bias[i] - self.along(i, &motions);
        }
        let change = factors.solve(&wanted);
        self.impulses += change;
        self.push(shadows, &change);
        change.norm() > tolerance * self.impulses.norm()
    }

    /// What axis `i` sees of velocities and spins: those of the second less those of the first.
    fn along(&self, i: usize, motions: &[(DVec3, DVec3); 2]) -> f64 {
        let axis = self.directions[i % 3];
        let seen = |k: usize| {
            let (v, w) = motions[k];
            let moved = if i < 3 { v + w.cross(self.arms[k]) } else { w };
            moved.dot(axis)
        };
        seen(1) - seen(0)
    }

    /// The motion that a unit impulse along axis `i` gives to one side.
    fn response(&self, shadow: &Shadow, i: usize, side: usize) -> (DVec3, DVec3) {
        let mut still = Shadow {
            v: DVec3::ZERO,
            w: DVec3::ZERO,
            ..*shadow
        };
        let mut unit = SVector::zeros();
        unit[i] = 1.0;
        self.give(&mut still, side, &unit);
        (still.v, still.w)
    }

    fn push(&self, shadows: &mut [Shadow], impulses: &SVector<f64, 6>) {
        for side in 0..2 {
            self.give(&mut shadows[self.shadows[side] as usize], side, impulses);
        }
    }

    fn give(&self, shadow: &mut Shadow, side: usize, impulses: &SVector<f64, 6>) {
        let sum = |first: usize| {
            let parts = (0..3).map(|i| self.directions[i] * impulses[first + i]);
            parts.sum::<DVec3>() * [-1.0, 1.0][side]
        };
        let linear = sum(0);
        shadow.take(linear, self.arms[side].cross(linear) + sum(3));
    }
}
