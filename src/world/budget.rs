//! How many substeps a body needs, and whether it gets them.

use super::Deformable;
use super::params::Substeps;
use super::steady::{SHAPE, SHAPE_OF_TETS, Steadiness, is_lively, steady_count};
use crate::body::{BuildError, Solid};
use crate::math::Real;
use crate::solve::stable::StableStep;

/// What share of the stable substep is short enough for tets that are met at the speed of sound: it crushes the smallest by about
/// a twelfth. With a quarter nothing becomes non-finite either, but the energies of thin plates are off by a third.
const CRUSH: f64 = 0.15;
/// After how long their stable substep is another one, in such substeps.
const STALE: f64 = 0.5;
/// The fastest blow that substeps are shortened for, in speeds of sound.
const FASTEST: f64 = 4.0;

impl Deformable {
    /// The longest stable substep of its scheme now, and the spring or tet that sets it.
    pub fn stable_step(&self) -> StableStep {
        self.solver.stable_step(&self.state, self.integrator())
    }

    /// Makes the table of springs that the first substep would make, and learns how the body swings.
    pub(super) fn make_ready(&mut self) {
        let integrator = self.integrator();
        self.solver.make_ready(&self.state);
        self.solver.learn(&mut self.state, integrator);
    }

    /// Whether the body is stable within its budget after a change. What was known of how it swings may be a loose bound by
    /// then, so it is learned anew before the body is refused, and forgotten again if it is.
    pub(super) fn check_changed(&mut self) -> Result<(), BuildError> {
        self.check_budget().or_else(|_| {
            let before: Vec<Real> = self.state.particles.iter().map(|p| p.swing).collect();
            let integrator = self.integrator();
            self.solver.learn(&mut self.state, integrator);
            self.check_budget().inspect_err(|_| {
                let particles = self.state.particles.iter_mut();
                particles.zip(before).for_each(|(p, swing)| p.swing = swing);
            })
        })
    }

    /// Whether the body is stable within its budget.
    pub(super) fn check_budget(&self) -> Result<(), BuildError> {
        let substeps = self.substeps();
        substeps.check()?;
        let stable = self.stable_step();
        let min_h = match substeps {
            Substeps::Auto { safety, min_h } => min_h / safety,
            Substeps::Fixed(n) => self.defaults.expected_dt / n as f64,
            Substeps::Unchecked(_) => return Ok(()),
        };
        let integrator = self.integrator().name();
        let is_short = stable.h <= 0.0 || stable.h < min_h;
        match (stable.spring, stable.element) {
            (Some(spring), _) if stable.never => {
                Err(BuildError::NeverStable { integrator, spring })
            }
            (_, Some(_)) if stable.never => Err(BuildError::NeverStableSolid { integrator }),
            _ if is_short && self.longest_by_drag() < min_h => {
                Err(self.unstable_by_drag(stable.h, min_h))
            }
            (Some(spring), _) if is_short => Err(self.unstable(spring, stable.h, min_h)),
            (_, Some(tet)) if is_short => Err(self.unstable_tet(tet, stable.h, min_h)),
            _ => Ok(()),
        }
    }

    /// The longest stable substep of a body that nothing but its drag acts on \[s\].
    fn longest_by_drag(&self) -> f64 {
        let rate = f64::from(self.drag()) / f64::from(self.lightest());
        self.integrator().stable_step(0.0, rate, f64::INFINITY)
    }

    /// Mass of the lightest node that is not pinned \[kg\].
    fn lightest(&self) -> Real {
        let pairs = self.state.particles.iter().zip(&self.blueprint.nodes);
        let free = pairs.filter(|(p, _)| p.inv_mass > 0.0);
        free.map(|(_, n)| n.mass).fold(Real::INFINITY, Real::min)
    }

    fn unstable_by_drag(&self, needed_h: f64, min_h: f64) -> BuildError {
        BuildError::UnstableDrag {
            drag: self.drag(),
            mass: self.lightest(),
            needed_h,
            min_h,
        }
    }

    fn unstable_tet(&self, tet: u32, needed_h: f64, min_h: f64) -> BuildError {
        let solid = self.solid().copied().unwrap_or_default();
        let mesh = self.blueprint.solid.as_deref().map(|s| &s.mesh);
        let volume = mesh.and_then(|m| m.corner_volumes().nth(tet as usize));
        BuildError::UnstableTet {
            tet,
            young: solid.young,
            poisson: solid.poisson,
            density: solid.density,
            volume: volume.unwrap_or(0.0),
            needed_h,
            min_h,
        }
    }

    fn unstable(&self, spring: u32, needed_h: f64, min_h: f64) -> BuildError {
        let s = &self.blueprint.springs[spring as usize];
        let mass = |n: u32| self.blueprint.nodes[n as usize].mass;
        BuildError::Unstable {
            spring,
            stiffness: s.stiffness,
            damping: s.damping,
            mass_a: mass(s.nodes[0]),
            mass_b: mass(s.nodes[1]),
            needed_h,
            min_h,
        }
    }

    /// How many substeps a stretch of `dt` s needs, and whether it asked for too few. `frame` is the world's step.
    pub(super) fn substeps_for(&self, dt: f64, frame: f64) -> (usize, bool) {
        let integrator = self.integrator();
        let stable = self.solver.longest_stable_step(&self.state, integrator);
        self.substeps_of(&stable, dt, frame, f64::INFINITY)
    }

    /// How many of its last substeps a stretch of `dt` s holds; what it needs before there were any.
    pub(super) fn last_substeps(&self, dt: f64) -> usize {
        if self.h > 0.0 {
            (dt / self.h - 1e-6).ceil() as usize
        } else {
            self.substeps_for(dt, dt).0
        }
    }

    /// The substep that it would take if Rapier's steps, of `dt` s now, left it the choice \[s\].
    pub(super) fn own_substep(&self, dt: f64) -> f64 {
        match self.substeps() {
            Substeps::Auto { safety, min_h } if self.solver.stable_h > 0.0 => {
                let longest = self.solver.stable_h * self.steady.share(safety);
                longest.max(min_h)
            }
            _ => dt / self.last_substeps(dt).max(1) as f64,
        }
    }

    /// As [`Self::substeps_for`] for a body that something meets at `closing` m/s, and takes the opportunity to learn how it swings,
    /// for a longer substep next time. Says also after what time that is to be done again \[s\].
    pub(super) fn review(&mut self, dt: f64, frame: f64, closing: f64) -> (usize, bool, f64) {
        let integrator = self.integrator();
        let stable = self.solver.review(&mut self.state, integrator);
        let (n, unstable) = self.review_of(&stable, dt, frame, closing);
        (n, unstable, stable.h * self.mach(closing).recip() * STALE)
    }

    /// How fast something meets it, in speeds of sound; 0 for what has no tets. What is faster than [`FASTEST`] explodes.
    fn mach(&self, closing: f64) -> f64 {
        let sound = self.solid().map_or(f64::INFINITY, Solid::sound_speed);
        (closing / sound).min(FASTEST)
    }

    fn review_of(
        &mut self,
        stable: &StableStep,
        dt: f64,
        frame: f64,
        closing: f64,
    ) -> (usize, bool) {
        let integrator = self.integrator();
        // Of what a substep crushes its stable length knows nothing.
        let most = CRUSH / self.mach(closing);
        let Substeps::Auto { safety, min_h } = self.substeps() else {
            self.steady = Steadiness::default();
            return self.substeps_of(stable, dt, frame, most);
        };
        let mut steady = self.steady;
        let decay = || self.decay(stable, dt);
        let shape = if self.solver.part.is_some() {
            SHAPE_OF_TETS
        } else {
            SHAPE
        };
        steady.note((self.h, frame), shape, integrator, decay);
        self.steady = steady;
        let needed = self.substeps_of(stable, dt, frame, most);
        let longest = |share: f64| (stable.h * share.min(most)).max(min_h);
        let shorter = longest(safety) / longest(steady.share(safety));
        self.steady.ask(dt / needed.0 as f64, shorter);
        needed
    }

    /// What share of the energy of its fastest mode damping takes until it is reviewed again, in a rigid step of which `dt` s are left,
    /// at least.
    fn decay(&self, stable: &StableStep, dt: f64) -> f64 {
        dt.min(self.defaults.review_interval) * self.solver.least_decay(&self.state, 2.0 / stable.h)
    }

    /// How many substeps: if they are found automatically, of `most` times the stable length or less, and no shorter than asked for.
    fn substeps_of(&self, stable: &StableStep, dt: f64, frame: f64, most: f64) -> (usize, bool) {
        let count = |h: f64| ((dt / h).ceil() as usize).max(1);
        let share = |n: usize| ((n as f64 * dt / frame).round() as usize).max(1);
        let never = stable.never || stable.h <= 0.0;
        match self.substeps() {
            // A scheme that became unstable at every substep, or a budget that lost its bounds, after insertion: no number
            // is right, so a moderate one is taken and reported.
            Substeps::Auto { safety, min_h }
                if never || safety.is_nan() || safety <= 0.0 || min_h.is_nan() =>
            {
                (count(1e-4), true)
            }
            Substeps::Auto { safety, min_h } => {
                let longest = stable.h * self.steady.share(safety).min(most);
                let mut n = count(longest.max(min_h).max(1e-9));
                let steady = steady_count(n, dt / self.h);
                if steady != n && is_lively(self.decay(stable, dt)) {
                    n = steady;
                }
                (n, dt / n as f64 > stable.h * (1.0 + 1e-9))
            }
            Substeps::Fixed(n) => {
                let needed = if never { 0 } else { count(stable.h) };
                (share(n).max(needed), never || share(n) < needed)
            }
            Substeps::Unchecked(n) => (share(n), dt / share(n) as f64 > stable.h),
        }
    }
}
