//! Gravity, time and substeps.

use super::super::check::{COUNT, DURATION, FINITE, NOT_NEGATIVE, PASSES, SHARE, SHORTEST, STEP};
use super::super::decode::Decoder;
use super::super::schema::{choice, record};
use super::super::tree::Node;

/// Most steps of a run.
const MOST_STEPS: f64 = 1.0e7;

record! {
    /// Gravity, time and substeps.
    pub struct World {
        /// Acceleration of gravity \[m/s²\].
        gravity: [f64; 3] = [0.0, -9.81, 0.0], FINITE;
        /// Step of the world \[s\].
        dt: f64 = 1.0 / 60.0, STEP;
        /// Simulated time \[s\].
        duration: f64 = 1.0, DURATION;
        /// When to stop before that.
        stop: Option<Stop> = None;
        /// Substeps of deformables that have none of their own.
        substeps: Substepping = Substepping::usual();
        /// How deformables are advanced that have no scheme of their own.
        integrator: Scheme = Scheme::SymplecticEuler;
        /// Longest step of Rapier while a deformable can touch an awake dynamic body \[s\]; 0 for every substep.
        max_rigid_dt: f64 = 1.0 / 240.0, NOT_NEGATIVE;
        /// Gauss–Seidel passes over the contacts of a substep.
        passes: usize = 4, PASSES;
        /// What `random(i)` in formulas begins with; `--seed` changes it.
        seed: u64 = 0;
        /// Time between samples of positions and momentum \[s\].
        history: f64 = 1.0e-3, super::super::check::INTERVAL;
        /// Time between samples of the energies \[s\].
        energy: f64 = 5.0e-3, super::super::check::INTERVAL;
    }
    then steps
}

impl Default for World {
    fn default() -> Self {
        Self {
            gravity: [0.0, -9.81, 0.0],
            dt: 1.0 / 60.0,
            duration: 1.0,
            stop: None,
            substeps: Substepping::usual(),
            integrator: Scheme::SymplecticEuler,
            max_rigid_dt: 1.0 / 240.0,
            passes: 4,
            seed: 0,
            history: 1.0e-3,
            energy: 5.0e-3,
        }
    }
}

fn steps(world: &World, node: &Node, d: &mut Decoder) -> Option<()> {
    let most = |interval: f64| world.duration / interval > MOST_STEPS;
    for (what, interval) in [
        ("steps of dt", world.dt),
        ("samples of history", world.history),
        ("samples of energy", world.energy),
    ] {
        if most(interval) {
            d.wrong(node.at, |_| {
                let n = world.duration / interval;
                format!("the duration is {n:.0} {what}, at most {MOST_STEPS} are possible")
            });
            return None;
        }
    }
    Some(())
}

choice! {
    /// How many substeps a deformable gets.
    pub enum Substepping {
        /// As many as stability needs.
        Auto {
            /// Fraction of the longest stable substep that is used.
            safety: f64 = 0.9, SHARE;
            /// A body that needs shorter substeps is refused \[s\].
            min_h: f64 = 1.0e-7, SHORTEST;
        };
        /// This many per step; refused where unstable.
        Fixed(usize, COUNT);
        /// This many per step, stable or not.
        Unchecked(usize, COUNT);
    }
}

impl Substepping {
    /// The default of every deformable.
    pub const fn usual() -> Self {
        Self::Auto {
            safety: 0.9,
            min_h: 1.0e-7,
        }
    }
}

choice! {
    /// How deformables are advanced.
    pub enum Scheme {
        /// Order 1; grows unless damped.
        ExplicitEuler;
        /// Order 1, symplectic.
        SymplecticEuler;
        /// Order 2, symplectic.
        VelocityVerlet;
        /// Order 2; grows slowly when undamped.
        Midpoint;
        /// Order 4; loses a little energy.
        Rk4;
    }
}

choice! {
    /// When a run ends before its time.
    pub enum Stop {
        /// Once no node and no rigid body has been faster than this for a while.
        AtRest {
            /// Speed \[m/s\].
            speed: f64 = 1.0e-3, NOT_NEGATIVE;
            /// How long \[s\].
            during: f64 = 0.1, NOT_NEGATIVE;
        };
        /// At the first spring or attachment that breaks.
        Broken;
    }
}
