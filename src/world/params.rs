//! How deformables are stepped. Rapier's own parameters are read and never written.

use crate::body::BuildError;
use crate::body::error::positive;
use crate::solve::{Integrator, Kernel};

/// How many substeps a body gets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub enum Substeps {
    /// As many as stability needs, found from stiffness, damping, masses, scheme and the current shape. While substeps change,
    /// because frames differ in length or the shape does, what is hardly damped gets more by symplectic Euler and velocity Verlet,
    /// which would gain energy by each change of a substep that is close to the stable one.
    Auto {
        /// Fraction of the stable step that is used, in (0, 1].
        safety: f64,
        /// A body that would need substeps shorter than this \[s\] is refused with an error that names its worst spring.
        min_h: f64,
    },
    /// This many per step of the world. Refused at insertion if unstable for the world's
    /// [`expected_dt`](DeformableParameters::expected_dt); where a longer step, a crushed shape, deformables that meet fast or
    /// rigid bodies that turn fast need more, more are taken and reported, never a softer body.
    Fixed(usize),
    /// This many per step, stable or not: for those who want to see the textbook's explosion. Reported as unstable.
    Unchecked(usize),
}

impl Default for Substeps {
    fn default() -> Self {
        Self::Auto {
            safety: 0.9,
            min_h: 1e-7,
        }
    }
}

impl Substeps {
    /// Checks the range of its numbers.
    pub(crate) fn check(self) -> Result<(), BuildError> {
        match self {
            Self::Auto { safety, min_h } => {
                if !(safety > 0.0 && safety <= 1.0) {
                    return Err(BuildError::Value {
                        what: "the safety factor of the substep",
                        value: safety,
                        must: "in (0, 1]",
                    });
                }
                crate::body::error::not_negative("the shortest substep min_h", min_h).map(|_| ())
            }
            Self::Fixed(n) | Self::Unchecked(n) => {
                positive("the number of substeps", n as f64).map(|_| ())
            }
        }
    }
}

/// Settings of a [`DeformableWorld`](super::DeformableWorld). A step with some that [`Self::check`] refuses does nothing and
/// [reports](super::StepReport::invalid_params) it. How many threads compute (feature `parallel`) is no setting of a
/// world: they are those of Rayon's pool within which it is stepped, else of Rayon's global one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct DeformableParameters {
    /// The scheme of bodies that have none of their own.
    pub integrator: Integrator,
    /// The substeps of bodies that have none of their own.
    pub substeps: Substeps,
    /// The step of the world that [`Substeps::Fixed`] is checked against at insertion \[s\].
    pub expected_dt: f64,
    /// The longest Rapier step while a deformable can touch an awake dynamic body \[s\]; 0 steps Rapier at every substep,
    /// which is the slow reference the coupling is measured against. Rapier is never stepped more often than that. While a
    /// body that carries more than three times its mass in welded or linked nodes touches another one, steps are shorter by as much.
    pub max_rigid_dt: f64,
    /// Gauss–Seidel passes over the rows of a substep: up to 4 times as many over those that hang together, and 64 times as
    /// many while anything sinks in at more than 3 % of [`Self::push_out_speed`]. 0 counts as 1, and there are at most 1,000,000.
    pub passes: usize,
    /// Speed at which penetrating nodes are moved out, in length units per second.
    pub push_out_speed: f64,
    /// The stable substep is found anew at least this often \[s\].
    pub review_interval: f64,
    /// Bodies whose nodes are all slower than this fall asleep, in length units per second; 0 lets none do so.
    pub sleep_speed: f64,
    /// For how long they must have been that slow \[s\].
    pub sleep_after: f64,
    /// With which vectors forces are computed. A matter of speed alone: all give the same bits.
    pub kernel: Kernel,
}

impl DeformableParameters {
    /// Checks the ranges of all numbers.
    ///
    /// # Errors
    /// [`BuildError::Value`], which names the first that is out of range.
    pub fn check(&self) -> Result<(), BuildError> {
        self.substeps.check()?;
        positive("the expected dt", self.expected_dt)?;
        for (what, value) in [
            ("the longest Rapier step", self.max_rigid_dt),
            ("the push-out speed", self.push_out_speed),
            ("the review interval", self.review_interval),
            ("the sleep speed", self.sleep_speed),
            ("the time to sleep after", self.sleep_after),
        ] {
            if value.is_nan() || value < 0.0 {
                let must = "positive, 0 or infinite";
                return Err(BuildError::Value { what, value, must });
            }
        }
        if self.passes > MOST_PASSES {
            return Err(BuildError::Value {
                what: "the number of passes",
                value: self.passes as f64,
                must: "1,000,000 at most",
            });
        }
        Ok(())
    }
}

/// More than any set of rows takes, and few enough to be counted with their factors.
const MOST_PASSES: usize = 1_000_000;

impl Default for DeformableParameters {
    fn default() -> Self {
        Self {
            integrator: Integrator::SymplecticEuler,
            substeps: Substeps::default(),
            expected_dt: 1.0 / 60.0,
            max_rigid_dt: 1.0 / 240.0,
            passes: 4,
            push_out_speed: 0.3,
            review_interval: 1.0 / 240.0,
            sleep_speed: 2e-3,
            sleep_after: 1.0,
            kernel: Kernel::Auto,
        }
    }
}
