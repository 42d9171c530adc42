//! One body's part in the rehearsals: how its impulses are split, and corrected by where that leaves it.

use crate::coupling::handover::{Split, Wrench};
use crate::math::{DMat3, DVec3};
use crate::solve::shadow::Shadow;

/// How many times what a free body needs a correction is at most.
const MOST: f64 = 16.0;

/// Where a body misses its shadow: displacement \[m\] and turn \[rad\].
type Miss = (DVec3, DVec3);

/// By how much a body may miss its shadow.
#[derive(Clone, Copy)]
pub struct Tolerance {
    /// \[m\].
    pub small: f64,
    /// And no more than this share of the way that the impulses move it.
    pub share: Option<f64>,
    /// But always by as much as this \[m\].
    pub rounding: f64,
}

/// One body's part in the rehearsals.
#[derive(Clone, Copy)]
pub struct Trial {
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
    /// Whether another correction may bring it closer.
    pub corrects: bool,
}

impl Trial {
    /// That of what is given as a force, until corrections find better.
    pub fn new(corrects: bool) -> Self {
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
    pub fn at_once(given: Wrench) -> Self {
        Self {
            early: given,
            best: (given, 0.0),
            ..Self::new(false)
        }
    }

    /// The split that is tried now.
    pub fn split(&self, end: &Shadow, share: f64) -> Split {
        self.split_of(self.early, end, share)
    }

    /// The best split so far.
    pub fn best(&self, end: &Shadow, share: f64) -> Split {
        self.split_of(self.best.0, end, share)
    }

    /// The split that moves a free body as an early impulse would, forwards or backwards, with the rest as a force, which
    /// displaces by the `share` of what an impulse does that is given at the start.
    fn split_of(&self, early: Wrench, end: &Shadow, share: f64) -> Split {
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
    pub fn correct(
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
            let s = Trial::new(true).split_of(given, &end, SHARE);
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
        for _ in 0..8 {
            let Split { early, late, .. } = trial.split(&end, SHARE);
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
