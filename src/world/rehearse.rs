//! When in Rapier's step bodies with rigid contacts or joints get their impulses: a shooting method.
//!
//! The mean force moves a body by s·P·dt/m, whenever in the step its impulses came: one that came early would have carried
//! it twice as far, and at the end of a long lever that is centimetres. For a free body the right split into an early
//! impulse and a force is known in closed form. Contacts are one-sided, and an early impulse may open them or press them
//! harder. So Rapier's step is rehearsed with the shadows, which know these contacts and joints, and the split is corrected
//! by where it would leave each body, as long as that brings it closer to where its shadow is.

use super::RapierParts;
use super::group::Touched;
use super::substep::Group;
use crate::coupling::handover::Split;
use crate::coupling::observe::Answer;
use crate::math::{DMat3, DVec3};
use crate::solve::rows::solve_between_shadows;
use crate::solve::shadow::Shadow;

/// How often a split is corrected at most.
const ROUNDS: usize = 8;
/// How many times what a free body needs a correction is at most.
const MOST: f64 = 16.0;
/// A miss of less is none, in length units.
const SMALL: f64 = 2e-5;
/// Passes over the rigid contacts in one of Rapier's solver iterations, and the relative change that counts as settled.
const PASSES: usize = 12;
const SETTLED: f64 = 1e-3;

/// Where a body misses its shadow: displacement \[m\] and turn \[rad\].
type Miss = (DVec3, DVec3);

/// One body's part in the rehearsals.
#[derive(Clone, Copy)]
struct Trial {
    split: Split,
    /// The best split so far, and by how much it misses \[kg·m²\].
    best: (Split, f64),
    /// The miss before the last correction, and how many times what a free body needs that was.
    last: Option<(Miss, f64)>,
    corrects: bool,
}

impl Group {
    /// The split of every touched body's impulses over a step of `dt` s.
    pub fn splits(&self, parts: &RapierParts, dt: f64) -> Vec<Split> {
        let is_trial = |t: &Touched, end: &Shadow| {
            let given = end.impulse != DVec3::ZERO || end.torque != DVec3::ZERO;
            given && t.answer == Answer::Constrained
        };
        let pairs = self.touched.iter().zip(&self.shadows[1..]);
        let mut trials: Vec<Trial> = pairs.map(|(t, end)| Trial::new(is_trial(t, end))).collect();
        // What is held together is solved with the iterations of the body that asks for most.
        let bodies = self.touched.iter().filter_map(|t| parts.bodies.get(t.body));
        let additional = bodies.map(|b| b.additional_solver_iterations()).max();
        let iterations =
            parts.integration_parameters.num_solver_iterations + additional.unwrap_or(0);
        let iterations = iterations.max(1);
        let small = SMALL * parts.length_unit();
        let share = (iterations as f64 + 1.0) / (2.0 * iterations as f64);
        for _ in 0..ROUNDS {
            // With one iteration Rapier gives force and impulse the same displacement: nothing to split.
            if share >= 1.0 || trials.iter().all(|p| !p.corrects) {
                break;
            }
            let reached = self.rehearse(&trials, iterations, dt);
            for ((trial, end), reached) in
                trials.iter_mut().zip(&self.shadows[1..]).zip(&reached[1..])
            {
                if trial.corrects {
                    trial.correct(end, reached, (share, dt), small);
                }
            }
        }
        trials.iter().map(|p| p.best.0).collect()
    }

    /// Where the shadows end if they get their impulses as Rapier's bodies will.
    fn rehearse(&self, trials: &[Trial], iterations: usize, dt: f64) -> Vec<Shadow> {
        let h = dt / iterations as f64;
        let mut shadows = vec![Shadow::FIXED];
        for ((touched, end), trial) in self.touched.iter().zip(&self.shadows[1..]).zip(trials) {
            let mut shadow = touched.start;
            let (early, turn) = (trial.split.impulse, trial.split.torque);
            shadow.take(early, turn);
            let mut rest = Shadow {
                v: DVec3::ZERO,
                w: DVec3::ZERO,
                ..shadow
            };
            rest.take((end.impulse - early) / dt, (end.torque - turn) / dt);
            shadow.acceleration += rest.v;
            shadow.spin_up += rest.w;
            shadows.push(shadow);
        }
        let mut rows = self.rows.rigid.clone();
        for row in &mut rows {
            (row.normal_impulse, row.friction_impulse) = Default::default();
            row.gap = row.gap_at_start;
        }
        let mut joints = self.rows.joints.clone();
        for row in &mut joints {
            row.impulses = Default::default();
        }
        for _ in 0..iterations {
            for shadow in &mut shadows[1..] {
                shadow.accelerate(h);
            }
            solve_between_shadows(&mut rows, &mut joints, &mut shadows, (h, PASSES, SETTLED));
            for shadow in &mut shadows[1..] {
                shadow.advance(h);
            }
        }
        shadows
    }
}

impl Trial {
    fn new(corrects: bool) -> Self {
        Self {
            split: Split::NONE,
            best: (Split::NONE, f64::INFINITY),
            last: None,
            corrects,
        }
    }

    /// Moves the split by what it missed, if the last correction was one; else goes back and stops. In a step of `dt` s a
    /// force displaces by the `share` of what an impulse does that is given at its start.
    fn correct(&mut self, end: &Shadow, reached: &Shadow, (share, dt): (f64, f64), small: f64) {
        let turn = (end.rot * reached.rot.inverse()).to_scaled_axis();
        let miss: Miss = (end.com - reached.com, turn);
        let momentum = |inverse: DMat3, by: DVec3| {
            let m = inverse.inverse();
            if m.is_finite() { m * by } else { DVec3::ZERO }
        };
        let by = (
            momentum(end.inv_mass, miss.0),
            momentum(end.inv_inertia, miss.1),
        );
        let size = by.0.dot(miss.0) + by.1.dot(miss.1);
        if size.is_nan() || size >= self.best.1 {
            self.split = self.best.0;
            self.corrects = false;
            return;
        }
        self.best = (self.split, size);
        let inverse = end.inv_mass;
        let response = (inverse.x_axis.x + inverse.y_axis.y + inverse.z_axis.z) / 3.0;
        if size * response <= small * small {
            self.corrects = false;
            return;
        }
        // What hangs on other bodies gives way less than a free one: what the last correction did tells how much less.
        let weigh = |a: Miss| by.0.dot(a.0) + by.1.dot(a.1);
        let scale = self.last.map_or(1.0, |(last, scale)| {
            let (before, now) = (weigh(last), weigh(miss));
            (scale * before / (before - now)).clamp(1.0, MOST)
        });
        self.last = Some((miss, scale));
        let more = scale / ((1.0 - share) * dt);
        self.split.impulse += by.0 * more;
        self.split.torque += by.1 * more;
        self.limit(end, (share / (1.0 - share)).max(1.0));
    }

    /// No more than `most` times what the body gets: an impulse at the very start of the step asks for itself there, one at
    /// the very end for −s/(1 − s) of itself. More than that is not about when impulses came, but about a contact that one
    /// of the two worlds has and the other has not, and would carry the body about without giving it any velocity.
    fn limit(&mut self, end: &Shadow, most: f64) {
        let energy = |impulse: DVec3, torque: DVec3| {
            impulse.dot(end.inv_mass * impulse) + torque.dot(end.inv_inertia * torque)
        };
        let given = energy(end.impulse, end.torque);
        let moved = energy(self.split.impulse, self.split.torque);
        if moved > most * most * given {
            let by = most * (given / moved).sqrt();
            self.split.impulse *= by;
            self.split.torque *= by;
        }
    }
}
