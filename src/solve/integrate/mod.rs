//! Integration schemes: one file each, one signature, parameters in the variant.
//!
//! Every scheme moves the body freely in `predict`, and `finish` completes schemes that need the force at the new
//! position. Rows act once per substep, as an impulse at its start: rows are solved for the mean velocities of the free
//! motion, then the motion is predicted again from the changed velocities. What happens between two impulses is the
//! scheme's own free motion, so contact adds no energy to any scheme; a displacement put on top of a finished step would
//! (a pressed node at rest would gain ½m(ha)² a substep). For symplectic Euler the second prediction is a plain addition.
//! Plastic flow and breaking are committed at the first evaluation of a substep, which is at a true state of the body;
//! inner stages only obey the yield surface.

mod explicit_euler;
mod midpoint;
mod rk4;
mod symplectic_euler;
mod velocity_verlet;

use super::external::ForceField;
use super::forces::{Force, dot, three};
use super::kernel::Totals;
use super::solver::Solver;
use crate::body::state::{Particle, State};
use crate::law::stable;
use crate::math::Scalar;

/// How positions and velocities are advanced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub enum Integrator {
    /// x += h·v with the old v, then v += h·F/m. Order 1; grows unless damped: the textbook's warning.
    ExplicitEuler,
    /// v += h·F/m, then x += h·v with the new v. Order 1, symplectic: energy ripples but does not drift. The default.
    #[default]
    SymplecticEuler,
    /// Half kick, drift, half kick. Order 2, symplectic.
    VelocityVerlet,
    /// Explicit midpoint (RK2). Order 2; grows slowly when undamped.
    Midpoint,
    /// The classical Runge–Kutta scheme. Order 4; loses a little energy.
    Rk4,
}

impl Integrator {
    /// Every scheme.
    pub const ALL: [Self; 5] = [
        Self::ExplicitEuler,
        Self::SymplecticEuler,
        Self::VelocityVerlet,
        Self::Midpoint,
        Self::Rk4,
    ];

    /// Its name in plain words.
    pub fn name(self) -> &'static str {
        match self {
            Self::ExplicitEuler => "explicit Euler",
            Self::SymplecticEuler => "symplectic Euler",
            Self::VelocityVerlet => "velocity Verlet",
            Self::Midpoint => "midpoint",
            Self::Rk4 => "RK4",
        }
    }

    /// The longest stable substep \[s\], given bounds on λ(M⁻¹K) \[1/s²\] and λ(M⁻¹C) \[1/s\] and the least c/k of any
    /// spring \[s\]; 0 when no substep is stable.
    pub fn stable_step(self, stiffness: f64, damping: f64, relaxation: f64) -> f64 {
        match self {
            Self::ExplicitEuler => stable::explicit_euler(relaxation, damping),
            Self::SymplecticEuler => stable::leapfrog(stiffness, damping),
            Self::VelocityVerlet => stable::verlet(stiffness, damping),
            Self::Midpoint => stable::midpoint(stiffness, damping, relaxation),
            Self::Rk4 => stable::rk4(stiffness, damping),
        }
    }

    /// Whether its stable step depends on the least c/k.
    pub(crate) fn needs_relaxation(self) -> bool {
        matches!(self, Self::ExplicitEuler | Self::Midpoint)
    }

    /// Whether an impulse given to a node after the free motion, v += Δv and x += h·Δv, is the same as one given at the
    /// start. It is for schemes that move x by h·v with the final v, and saves a second prediction.
    pub(crate) fn takes_late_impulses(self) -> bool {
        self == Self::SymplecticEuler
    }

    /// Whether what rows ask for is to be approached by solving them again, with forces as their impulses change them. It
    /// is where a body moves by the one velocity that damping meets, and then takes no more than rows asked for. By the
    /// others a pressed node hops: damping takes from the hop, and rows would add it again without end.
    pub(crate) fn settles_rows(self) -> bool {
        self == Self::VelocityVerlet
    }

    pub(super) fn predict<S: Scalar>(
        self,
        solver: &mut Solver<S>,
        state: &mut State<S>,
        h: S,
        field: Option<&dyn ForceField>,
    ) {
        match self {
            Self::ExplicitEuler => explicit_euler::predict(solver, state, h, field),
            Self::SymplecticEuler => symplectic_euler::predict(solver, state, h, field),
            Self::VelocityVerlet => velocity_verlet::predict(solver, state, h, field),
            Self::Midpoint => midpoint::predict(solver, state, h, field),
            Self::Rk4 => rk4::predict(solver, state, h, field),
        }
    }

    pub(super) fn finish<S: Scalar>(
        self,
        solver: &mut Solver<S>,
        state: &mut State<S>,
        h: S,
        field: Option<&dyn ForceField>,
    ) {
        if self == Self::VelocityVerlet {
            velocity_verlet::finish(solver, state, h, field);
        }
    }
}

/// Acceleration of a node \[m/s²\]; 0 for a pinned one.
#[inline(always)]
fn acceleration<S: Scalar>(
    p: &Particle<S>,
    f: &Force<S>,
    applied: [S; 3],
    gravity: [S; 3],
) -> [S; 3] {
    let free = if p.inv_mass > S::ZERO {
        S::ONE
    } else {
        S::ZERO
    };
    let along =
        |k: usize| gravity[k] * free + (f.elastic[k] + f.damping[k] + applied[k]) * p.inv_mass;
    [along(0), along(1), along(2)]
}

/// Sums of a pass over nodes: work of damping and external forces, and the largest squared speed.
#[derive(Clone, Copy)]
struct Sums<S> {
    damping: f64,
    external: f64,
    speed_squared: S,
    all_speeds: S,
}

impl<S: Scalar> Sums<S> {
    fn new() -> Self {
        Self {
            damping: 0.0,
            external: 0.0,
            speed_squared: S::ZERO,
            all_speeds: S::ZERO,
        }
    }

    /// Books the work of a node's forces over the displacement `along` \[m\], and the holder's where it is pinned.
    #[inline(always)]
    fn book(&mut self, p: &Particle<S>, f: &Force<S>, applied: [S; 3], along: [S; 3]) {
        self.book_apart(p, f, applied, along, along);
    }

    /// The same where damping works over another displacement, `damped`, than all else.
    #[inline(always)]
    fn book_apart(
        &mut self,
        p: &Particle<S>,
        f: &Force<S>,
        applied: [S; 3],
        damped: [S; 3],
        along: [S; 3],
    ) {
        let damping = dot(three(f.damping), damped);
        let outside = dot(applied, along);
        self.damping -= damping.f64();
        self.external += outside.f64();
        if p.inv_mass == S::ZERO {
            self.external -= (dot(three(f.elastic), along) + damping + outside).f64();
        }
    }

    #[inline(always)]
    fn speed(&mut self, v: [S; 3]) {
        let squared = dot(v, v);
        self.speed_squared = squared.max(self.speed_squared);
        self.all_speeds += squared;
    }

    /// Adds what a kernel has summed.
    fn include(&mut self, totals: &Totals) {
        self.damping += totals.damping;
        self.external += totals.external;
        self.speed_squared = self.speed_squared.max(S::of(totals.fastest.into()));
        self.all_speeds += S::of(totals.all_speeds.into());
    }

    fn flush(self, solver: &mut Solver<S>) {
        solver.work.damping += self.damping;
        solver.work.external += self.external;
        // `max` drops NaN, the sum does not.
        solver.speed_squared = if self.all_speeds.is_finite() {
            self.speed_squared
        } else {
            self.all_speeds
        };
    }
}

/// The force applied to node `i` from outside, 0 where there is none.
#[inline(always)]
fn applied_at<S: Scalar>(applied: &[[S; 3]], i: usize) -> [S; 3] {
    applied.get(i).copied().unwrap_or([S::ZERO; 3])
}
