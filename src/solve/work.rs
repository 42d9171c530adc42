//! Work done on a body, summed every substep in `f64`.
//!
//! Symplectic Euler is leapfrog: with velocities at half steps, an impulse h·F between v⁻ and v⁺ changes the kinetic
//! energy by exactly h·F·(v⁻ + v⁺)/2, which is the trapezoid rule over the displacements before and after it. Every term
//! here is summed that way, from the velocities of the *whole* substep, contact included; anything else leaves a residual
//! of tens of percent in an impact.

/// Sums of work \[J\]. Dissipation counts positive, work of external forces positive when it adds energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Work {
    /// Dissipated by spring damping and drag.
    pub damping: f64,
    /// Dissipated by plastic flow.
    pub plastic: f64,
    /// Energy that went with springs that broke: what they held, by symplectic Euler less what their tension would have done to
    /// the velocities in half a substep. Of one that is torn within a substep that can be nothing, or less.
    pub fracture: f64,
    /// Dissipated by contacts, in the direction of the normal, and held by those that give.
    pub contact_normal: f64,
    /// Dissipated by friction.
    pub contact_friction: f64,
    /// Done by node forces, force fields, and whatever holds or leads pinned nodes.
    pub external: f64,
    /// Received from colliders and attached rigid bodies.
    pub rigid: f64,
    /// Added by moving penetrating nodes out at position level.
    pub push_out: f64,
}
