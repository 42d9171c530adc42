//! Contacts of shadows with each other.
//!
//! What presses on a rigid body in a heap feels what that body presses on. Rapier finds these contacts and answers them
//! once per step; between its answers the shadows keep them, so that a body on a floor gives way to nothing above it, and
//! to everything beside it. Their impulses stay among the shadows: Rapier gets only what deformables gave.

use super::climb::Climb;
use super::contact::Response;
use super::settled::{Give, Settled};
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
    /// What the pass makes of it, the second one's point being that which gets the impulse.
    pub response: Response,
    /// Which of the shadows give way; set by the pass.
    pub moves: [bool; 2],
}

/// Starts a substep of h s: shadows get what the rows gave them in the last one, or that share of it which leads farthest
/// down.
pub(super) fn start_rigid(rows: &mut [RigidRow], shadows: &mut [Shadow], h: f64) {
    let mut climb = Climb::default();
    for row in &mut *rows {
        row.prepare(shadows, h);
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
        self.normal_impulse * (v.dot(self.normal) - self.response.allowed)
            + self.friction_impulse.dot(v - self.belt)
    }

    /// The speed that it has to stop in a substep of h s \[m/s\].
    pub(super) fn closing(&self, shadows: &[Shadow], h: f64) -> f64 {
        allowed_velocity(-self.gap, h, 0.0) - self.velocity(shadows).dot(self.normal)
    }

    fn prepare(&mut self, shadows: &[Shadow], h: f64) {
        let sides = self.shadows.map(|i| &shadows[i as usize]);
        self.moves = sides.map(Shadow::gives_way);
        self.response = Response {
            allowed: allowed_velocity(-self.gap, h, 0.0),
            ..Response::default()
        };
        for (k, side) in sides
            .into_iter()
            .enumerate()
            .filter(|(k, _)| self.moves[*k])
        {
            self.response.rigid += side.response_matrix(self.arms[k]) * self.shares[k];
        }
        self.response.mass = self.response.mass_along(self.normal);
        self.response.give = Give::of(0.0, &self.response.rigid);
    }

    /// One visit of a pass; whether it was not settled yet.
    pub(super) fn solve(&mut self, shadows: &mut [Shadow], settled: Settled) -> bool {
        let mut relative = self.velocity(shadows);
        let Response { allowed, mass, .. } = self.response;
        let jn = normal_impulse(
            self.normal_impulse,
            allowed,
            relative.dot(self.normal),
            mass,
        );
        let pressed = jn - self.normal_impulse;
        let mut impulse = self.normal * pressed;
        self.normal_impulse = jn;
        let limit = self.friction * jn;
        if limit > 0.0 || self.friction_impulse != DVec3::ZERO {
            relative += self.response.to(impulse) - self.belt;
            let slip = relative - self.normal * relative.dot(self.normal);
            let mass = self.response.mass_along(slip);
            if mass > 0.0 {
                let jt = friction_impulse(self.friction_impulse, slip, mass, limit);
                let rubbed = jt - self.friction_impulse;
                self.friction_impulse = jt;
                impulse += rubbed;
            }
        }
        self.push(shadows, impulse);
        let change = impulse.length_squared();
        settled.felt(change, jn * jn, self.response.give).any()
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

    fn push(&self, shadows: &mut [Shadow], impulse: DVec3) {
        if impulse == DVec3::ZERO {
            return;
        }
        for k in (0..2).filter(|k| self.moves[*k]) {
            let sign = [-1.0, 1.0][k];
            let shadow = &mut shadows[self.shadows[k] as usize];
            shadow.push(self.arms[k], impulse * (sign * self.shares[k]));
        }
    }
}
