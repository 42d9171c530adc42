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

use super::RapierParts;
use super::group::Touched;
use super::substep::Group;
use crate::coupling::handover::{Split, Wrench};
use crate::coupling::observe::Answer;
use crate::math::{DMat3, DVec3};
use crate::solve::rows::BetweenShadows;
use crate::solve::shadow::Shadow;

/// How often a split is corrected at most.
const ROUNDS: usize = 8;
/// How many times what a free body needs a correction is at most.
const MOST: f64 = 16.0;
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

/// Where a body misses its shadow: displacement \[m\] and turn \[rad\].
type Miss = (DVec3, DVec3);

/// By how much a body may miss its shadow.
#[derive(Clone, Copy)]
struct Tolerance {
    /// \[m\].
    small: f64,
    /// And no more than this share of the way that the impulses move it.
    share: Option<f64>,
    /// But always by as much as this \[m\].
    rounding: f64,
}

/// One body's part in the rehearsals.
#[derive(Clone, Copy)]
struct Trial {
    /// By what early impulse a free body would get to its place, forwards or backwards.
    early: Wrench,
    /// The best one so far, and by how much it misses \[kg·m²\].
    best: (Wrench, f64),
    /// The miss before the last correction, and how many times what a free body needs that was.
    last: Option<(Miss, f64)>,
    /// How far the velocity that the mean force leaves leads astray in another step \[kg·m²\].
    by_force: Option<f64>,
    /// Whether what came late is given at the end, or is an early impulse backwards.
    late: bool,
    corrects: bool,
}

impl Group {
    /// The split of every touched body's impulses over a step of `dt` s.
    pub fn splits(&self, parts: &RapierParts, dt: f64) -> Vec<Split> {
        let is_trial = |t: &Touched, end: &Shadow| {
            end.given() != Default::default() && t.answer == Answer::Constrained
        };
        let pairs = self.touched.iter().zip(&self.shadows[1..]);
        let each = pairs.map(|(t, end)| {
            if t.arrives {
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
        let ends = trials.iter().zip(&self.shadows[1..]).zip(&self.touched);
        let splits = ends.map(|((p, end), touched)| Split {
            lands: touched.arrives,
            ..p.split(p.best.0, end, share)
        });
        splits.collect()
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
            let Split { early, late, .. } = trial.split(trial.early, end, share);
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
            let Split { late, .. } = trial.split(trial.early, end, share);
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

impl Trial {
    fn new(corrects: bool) -> Self {
        Self {
            early: Wrench::default(),
            best: (Wrench::default(), f64::INFINITY),
            last: None,
            by_force: None,
            late: true,
            corrects,
        }
    }

    /// All that it is given, at the start.
    fn at_once(given: Wrench) -> Self {
        Self {
            early: given,
            best: (given, 0.0),
            ..Self::new(false)
        }
    }

    /// The split that moves a free body as an early impulse would, forwards or backwards, with the rest as a force, which
    /// displaces by the `share` of what an impulse does that is given at the start.
    fn split(&self, early: Wrench, end: &Shadow, share: f64) -> Split {
        if !self.late || !goes_back(early, end) {
            return Split {
                early,
                ..Split::default()
            };
        }
        let by = -(1.0 - share) / share;
        Split {
            late: (early.0 * by, early.1 * by),
            ..Split::default()
        }
    }

    /// Moves the split by what it missed, if the last correction was one; else goes back and stops. In a step of `dt` s a
    /// force displaces by the `share` of what an impulse does that is given at its start.
    fn correct(
        &mut self,
        end: &Shadow,
        reached: &Shadow,
        (share, dt): (f64, f64),
        tolerance: &Tolerance,
    ) {
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
        let size_of = |(way, turn): Miss| {
            momentum(end.inv_mass, way).dot(way) + momentum(end.inv_inertia, turn).dot(turn)
        };
        let size = size_of(miss);
        // What is given late no contact answers in this step, and what is given backwards may turn a body away from one: by what
        // velocity that leaves beyond what the mean force does, the body will have gone astray in the next step.
        let on: Miss = ((end.v - reached.v) * dt, (end.w - reached.w) * dt);
        let on = size_of(on);
        let by_force = *self.by_force.get_or_insert(on);
        let back = goes_back(self.early, end);
        let astray = if back { (on - by_force).max(0.0) } else { 0.0 };
        let all = size + astray;
        if all.is_nan() || all >= self.best.1 {
            // Impulses that went to and fro, on what hangs on something heavier, were no blow that came late.
            if back && self.late && self.best.0 == Wrench::default() {
                self.late = false;
                return;
            }
            self.early = self.best.0;
            self.corrects = false;
            return;
        }
        self.best = (self.early, all);
        let inverse = end.inv_mass;
        let response = (inverse.x_axis.x + inverse.y_axis.y + inverse.z_axis.z) / 3.0;
        let is_within = |most: f64| size * response <= most * most;
        let is_share = |share: f64| size <= share * share * size_of(end.shift);
        if is_within(tolerance.rounding)
            || tolerance.share.is_none_or(is_share) && is_within(tolerance.small)
        {
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
        self.early.0 += by.0 * more;
        self.early.1 += by.1 * more;
        self.limit(end, (share, dt));
    }

    /// No more than what a free body asks for with these impulses at these instants, or with all of them at the start of
    /// the step or at its end; displacement and turn each for itself. More than that is not about when impulses came, but
    /// about a contact that one of the two worlds has and the other has not, and would carry the body about without giving
    /// it any velocity.
    fn limit(&mut self, end: &Shadow, (share, dt): (f64, f64)) {
        let whole = (share / (1.0 - share)).max(1.0);
        let free = free_early(end, (share, dt));
        let limited = |early: DVec3, free: DVec3, sum: DVec3, inverse: DMat3| {
            // √J: both in what they give a body at rest.
            let norm = |j: DVec3| j.dot(inverse * j).max(0.0).sqrt();
            let most = norm(free).max(whole * norm(sum));
            let wanted = norm(early);
            if wanted > most {
                early * (most / wanted)
            } else {
                early
            }
        };
        let (impulse, torque) = end.given();
        self.early.0 = limited(self.early.0, free.0, impulse, end.inv_mass);
        self.early.1 = limited(self.early.1, free.1, torque, end.inv_inertia);
    }
}

/// Whether an early impulse is against what the body gets in all.
fn goes_back(early: Wrench, end: &Shadow) -> bool {
    let (impulse, torque) = end.given();
    early.0.dot(end.inv_mass * impulse) + early.1.dot(end.inv_inertia * torque) < 0.0
}

/// The early impulse, forwards or backwards, by which a free body gets to its place in a step of `dt` s in which a force
/// displaces by the `share` of what an impulse does that is given at its start.
fn free_early(end: &Shadow, (share, dt): (f64, f64)) -> Wrench {
    let early = |shift: DVec3, sum: DVec3| (shift / dt - sum * share) / (1.0 - share);
    let (shift, turn) = end.shift;
    let (impulse, torque) = end.given();
    (early(shift, impulse), early(turn, torque))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHARE: f64 = 0.625;

    fn free() -> Shadow {
        Shadow {
            inv_mass: DMat3::from_diagonal(DVec3::splat(0.5)),
            inv_inertia: DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0)),
            impulse: DVec3::new(1.0, -2.0, 0.5),
            torque: DVec3::new(0.3, 0.0, -0.1),
            ..Shadow::FIXED
        }
    }

    #[test]
    fn what_is_late_moves_a_free_body_as_an_early_impulse_backwards_would() {
        let end = free();
        let early: Wrench = (DVec3::new(0.4, -0.1, 0.0), DVec3::new(0.0, 0.2, 0.1));
        let back: Wrench = (early.0 * -1.0, early.1 * -1.0);
        // Displacements in what an impulse at the start does.
        let moved = |s: Split| {
            let force = end.impulse - s.early.0 - s.late.0;
            let torque = end.torque - s.early.1 - s.late.1;
            (s.early.0 + force * SHARE, s.early.1 + torque * SHARE)
        };
        for (given, late) in [(early, false), (back, true)] {
            let s = Trial::new(true).split(given, &end, SHARE);
            assert_eq!(s.early == Wrench::default(), late);
            assert_eq!(s.late != Wrench::default(), late);
            let (x, turn) = moved(s);
            let wanted = end.impulse * SHARE + given.0 * (1.0 - SHARE);
            assert!((x - wanted).length() < 1e-12);
            let wanted = end.torque * SHARE + given.1 * (1.0 - SHARE);
            assert!((turn - wanted).length() < 1e-12);
        }
    }

    /// A push and a pull of the same size leave a body without impulse, and elsewhere.
    #[test]
    fn a_body_is_moved_by_impulses_that_cancel() {
        let (h, dt) = (1e-3, 4e-3);
        let start = Shadow {
            impulse: DVec3::ZERO,
            torque: DVec3::ZERO,
            ..free()
        };
        let mut end = start;
        for push in [2.0, 0.0, 0.0, -2.0] {
            let push = DVec3::X * push;
            end.push(DVec3::ZERO, push);
            end.impulse += push;
            end.advance(h);
        }
        assert_eq!(end.impulse, DVec3::ZERO);
        let mut trial = Trial::new(true);
        for _ in 0..ROUNDS {
            let Split { early, late, .. } = trial.split(trial.early, &end, SHARE);
            let force = end.impulse - early.0 - late.0;
            let mut reached = start;
            reached.com += reached.inv_mass * (early.0 + force * SHARE) * dt;
            let tolerance = Tolerance {
                small: 1e-9,
                share: None,
                rounding: 0.0,
            };
            trial.correct(&end, &reached, (SHARE, dt), &tolerance);
        }
        assert!(trial.best.1 < 1e-12, "misses by {:.1e}", trial.best.1);
        assert!((trial.best.0.0.x - 1.5 / (1.0 - SHARE)).abs() < 1e-6);
    }
}
