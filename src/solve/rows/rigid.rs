//! Contacts of shadows with each other.
//!
//! What presses on a rigid body in a heap feels what that body presses on. Rapier finds these contacts and answers them
//! once per step; between its answers the shadows keep them, so that a body on a floor gives way to nothing above it, and
//! to everything beside it. Their impulses stay among the shadows: Rapier gets only what deformables gave.

use super::climb::Climb;
use crate::law::row::{allowed_velocity, friction_impulse, normal_impulse};
use crate::math::DVec3;
use crate::solve::shadow::Shadow;

/// A contact point of two shadows.
#[derive(Clone, Copy, Debug, Default)]
pub struct RigidRow {
    /// Indices into the shadows; 0 for the fixed world.
    pub shadows: [u32; 2],
    /// From the centres of mass to the point. They don't turn with the bodies: what a wheel stands on is below its hub,
    /// wherever the point is by now that was there at the start \[m\].
    pub arms: [DVec3; 2],
    /// Distance of the surfaces, negative inside \[m\].
    pub gap: f64,
    /// The same at the start of the rigid step \[m\].
    pub gap_at_start: f64,
    /// From the first to the second.
    pub normal: DVec3,
    /// What each takes of the impulse: 1, or 0 for a body that dominates the other.
    pub shares: [f64; 2],
    /// Coulomb's μ.
    pub friction: f64,
    /// Velocity of the first one's surface over its body \[m/s\]: a conveyor belt.
    pub belt: DVec3,
    /// Accumulated normal impulse of this substep, at its start that of the last one \[N·s\].
    pub normal_impulse: f64,
    /// Accumulated friction impulse on the second, likewise \[N·s\].
    pub friction_impulse: DVec3,
    /// Whether the bodies have pressed on each other in any substep so far.
    pub pressed: bool,
    /// Effective mass along the normal \[kg\]; set by the pass, as what follows.
    pub mass: f64,
    /// Smallest relative normal velocity that is allowed \[m/s\].
    pub allowed: f64,
}

/// Starts a substep of h s: shadows get what the rows gave them in the last one, or that share of it which leads farthest
/// down.
pub(super) fn start_rigid(rows: &mut [RigidRow], shadows: &mut [Shadow], h: f64) {
    let mut climb = Climb::default();
    for row in &mut *rows {
        row.allowed = allowed_velocity(-row.gap, h, 0.0);
        row.mass = row.effective_mass(shadows, row.normal);
        climb.slope += row.slope(shadows);
    }
    for row in &*rows {
        row.push(shadows, row.impulse());
    }
    climb.end = rows.iter().map(|row| row.slope(shadows)).sum();
    let share = climb.lowest();
    if share < 1.0 {
        for row in rows {
            row.push(shadows, row.impulse() * (share - 1.0));
            row.normal_impulse *= share;
            row.friction_impulse *= share;
        }
    }
}

impl RigidRow {
    fn impulse(&self) -> DVec3 {
        self.normal * self.normal_impulse + self.friction_impulse
    }

    /// The slope of what rows minimise along the impulse of this one, times the impulse \[J\].
    fn slope(&self, shadows: &[Shadow]) -> f64 {
        let v = self.velocity(shadows);
        self.normal_impulse * (v.dot(self.normal) - self.allowed)
            + self.friction_impulse.dot(v - self.belt)
    }

    /// One visit of a pass; whether it was not settled yet.
    pub(super) fn solve(&mut self, shadows: &mut [Shadow], tolerance: f64) -> bool {
        let speed = self.velocity(shadows).dot(self.normal);
        let jn = normal_impulse(self.normal_impulse, self.allowed, speed, self.mass);
        let change = jn - self.normal_impulse;
        let mut changed = change.abs() > tolerance * jn;
        self.normal_impulse = jn;
        self.push(shadows, self.normal * change);
        let limit = self.friction * jn;
        if limit > 0.0 || self.friction_impulse != DVec3::ZERO {
            let relative = self.velocity(shadows) - self.belt;
            let slip = relative - self.normal * relative.dot(self.normal);
            let speed = slip.length();
            if speed > 0.0 {
                let mass = self.effective_mass(shadows, slip / speed);
                let jt = friction_impulse(self.friction_impulse, slip, mass, limit);
                let change = jt - self.friction_impulse;
                changed |= change.length() > tolerance * jn;
                self.friction_impulse = jt;
                self.push(shadows, change);
            }
        }
        changed
    }

    /// Ends a substep of h s.
    pub(super) fn end(&mut self, shadows: &[Shadow], h: f64) {
        self.pressed |= self.normal_impulse > 0.0;
        self.gap += h * self.velocity(shadows).dot(self.normal);
    }

    /// Velocity of the second's point relative to the first's \[m/s\].
    fn velocity(&self, shadows: &[Shadow]) -> DVec3 {
        let at = |k: usize| shadows[self.shadows[k] as usize].velocity_at(self.arms[k]);
        at(1) - at(0)
    }

    fn effective_mass(&self, shadows: &[Shadow], direction: DVec3) -> f64 {
        let response = |k: usize| {
            let shadow = &shadows[self.shadows[k] as usize];
            self.shares[k] * shadow.response(self.arms[k], direction)
        };
        let k = response(0) + response(1);
        if k > 0.0 { 1.0 / k } else { 0.0 }
    }

    fn push(&self, shadows: &mut [Shadow], impulse: DVec3) {
        for (k, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let shadow = &mut shadows[self.shadows[k] as usize];
            shadow.push(self.arms[k], impulse * (sign * self.shares[k]));
        }
    }
}
