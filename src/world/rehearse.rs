//! When in Rapier's step bodies with rigid contacts or joints get their impulses: a shooting method.
//!
//! The mean force moves a body by s·P·dt/m, whenever in the step its impulses came: one that came early would have carried
//! it twice as far, and at the end of a long lever that is centimetres. For a free body the right split into an early
//! impulse and a force is known in closed form. Contacts are one-sided, and an early impulse may open them or press them
//! harder. So Rapier's step is rehearsed with the shadows, which know these contacts and joints, and the split is corrected
//! by where it would leave each body, as long as that brings it closer to where its shadow is.
//!
//! What came late could be an early impulse backwards and all the more force, which moves a free body just so. But a body
//! that has struck the ground before a node that it holds does must do so in Rapier's step too, and not be turned away from
//! it before: it gets what came late at the end. No contact answers that in this step, so such a split is judged by the
//! velocity it leaves as well, and where the first one leads astray the early impulse backwards is tried.

mod trial;

use super::RapierParts;
use super::group::Touched;
use super::substep::Group;
use crate::coupling::handover::Split;
use crate::coupling::observe::Answer;
use crate::math::DVec3;
use crate::solve::rows::BetweenShadows;
use crate::solve::shadow::Shadow;
use trial::{Tolerance, Trial};

/// How often a split is corrected at most.
const ROUNDS: usize = 8;
/// A miss of less is none, in length units, of what hangs on joints: they pass on every impulse that corrects it.
const SMALL: f64 = 2e-5;
/// And of what rests on others without a joint: the same miss in every step adds up to 24 times as much between the body and its
/// shadow, at 240 steps a second, see [`BodyMemory::keep_apart`](crate::coupling::memory::BodyMemory::keep_apart).
const SMALL_AT_REST: f64 = 5e-6;
/// Of what holds nodes, no more than this share of the way that the impulses move it: nodes are put where their body is, and misses in
/// step with a vibration would drive it. A plate on a hub that hangs on a joint got 24 J in 24 s from 0.01 J.
const SHARE_OF_WAY: f64 = 0.01;
/// A miss of less is rounding, in length units.
const ROUNDING: f64 = 1e-8;
/// Passes over the rigid contacts in one of Rapier's solver iterations, and the relative change that counts as settled.
const PASSES: usize = 12;
const SETTLED: f64 = 1e-3;

impl Group {
    /// The split of every touched body's impulses over a step of `dt` s.
    pub fn splits(&self, parts: &RapierParts, dt: f64) -> Vec<Split> {
        let is_trial = |t: &Touched, end: &Shadow| {
            end.given() != Default::default() && t.answer == Answer::Constrained
        };
        let pairs = self.touched.iter().zip(&self.shadows[1..]);
        let each = pairs.map(|(t, end)| {
            if t.lands.is_some() {
                Trial::at_once(end.given())
            } else {
                Trial::new(is_trial(t, end))
            }
        });
        let mut trials: Vec<Trial> = each.collect();
        // What is held together is solved with the iterations of the body that asks for most.
        let bodies = self.touched.iter().filter_map(|t| parts.bodies.get(t.body));
        let additional = bodies.map(|b| b.additional_solver_iterations()).max();
        let iterations =
            parts.integration_parameters.num_solver_iterations + additional.unwrap_or(0);
        let iterations = iterations.max(1);
        let tolerances = self.tolerances(parts.length_unit());
        let share = (iterations as f64 + 1.0) / (2.0 * iterations as f64);
        let mut between = self.rows.between_shadows();
        // With one iteration Rapier gives force and impulse the same displacement: nothing to split.
        for _ in 0..ROUNDS {
            if share >= 1.0 || trials.iter().all(|p| !p.corrects) {
                break;
            }
            let reached = self.rehearse(&trials, &mut between, (iterations, share), dt);
            let ends = self.shadows[1..].iter().zip(&reached[1..]);
            let pairs = trials.iter_mut().zip(ends).zip(&tolerances[1..]);
            for ((trial, (end, reached)), tolerance) in pairs {
                if trial.corrects {
                    trial.correct(end, reached, (share, dt), tolerance);
                }
            }
        }
        let ends = trials.iter().zip(&self.shadows[1..]);
        ends.map(|(p, end)| p.best(end, share)).collect()
    }

    /// By how much the body of each shadow may miss it.
    fn tolerances(&self, unit: f64) -> Vec<Tolerance> {
        let at_rest = Tolerance {
            small: SMALL_AT_REST * unit,
            share: None,
            rounding: ROUNDING * unit,
        };
        let mut tolerances = vec![at_rest; self.shadows.len()];
        for shadow in self.rows.joints.iter().flat_map(|j| j.joint.shadows) {
            tolerances[shadow as usize].small = SMALL * unit;
        }
        for attached in &self.attachments {
            tolerances[attached.shadow as usize].share = Some(SHARE_OF_WAY);
        }
        tolerances
    }

    /// Where the shadows end if they get their impulses as Rapier's bodies will.
    fn rehearse(
        &self,
        trials: &[Trial],
        between: &mut BetweenShadows,
        (iterations, share): (usize, f64),
        dt: f64,
    ) -> Vec<Shadow> {
        let h = dt / iterations as f64;
        let mut shadows = vec![Shadow::FIXED];
        for ((touched, end), trial) in self.touched.iter().zip(&self.shadows[1..]).zip(trials) {
            let mut shadow = touched.start.led_straight(dt);
            // What is damped at the end of the step, or on a free body afterwards, follows below.
            shadow.damping = (0.0, 0.0);
            if touched.answer == Answer::Constrained {
                shadow.v -= end.damped.0;
                shadow.w -= end.damped.1;
            }
            let Split { early, late, .. } = trial.split(end, share);
            shadow.take(early.0, early.1);
            let mut rest = Shadow {
                v: DVec3::ZERO,
                w: DVec3::ZERO,
                ..shadow
            };
            let (impulse, torque) = end.given();
            let force = (impulse - early.0 - late.0) / dt;
            rest.take(force, (torque - early.1 - late.1) / dt);
            shadow.acceleration += rest.v;
            shadow.spin_up += rest.w;
            shadows.push(shadow);
        }
        between.restart();
        for _ in 0..iterations {
            for shadow in &mut shadows[1..] {
                shadow.accelerate(h);
            }
            between.solve(&mut shadows, (h, PASSES, SETTLED));
            for shadow in &mut shadows[1..] {
                shadow.advance(h);
            }
        }
        let given = shadows[1..].iter_mut().zip(trials).zip(&self.shadows[1..]);
        for (((shadow, trial), end), touched) in given.zip(&self.touched) {
            let Split { late, .. } = trial.split(end, share);
            match touched.answer {
                Answer::Constrained | Answer::Linked | Answer::None => {}
                Answer::Free => {
                    shadow.v -= end.damped.0;
                    shadow.w -= end.damped.1;
                }
                Answer::Jointed | Answer::Link => {
                    shadow.v /= 1.0 + end.damping.0 * dt;
                    shadow.w /= 1.0 + end.damping.1 * dt;
                }
            }
            shadow.take(late.0, late.1);
        }
        // Joints will pass on what came late; contacts may not be there any more.
        between.restart_joints();
        between.solve_joints(&mut shadows, (h, PASSES, SETTLED));
        shadows
    }
}
