//! When in Rapier's step bodies that press on others get their impulses.
//!
//! The mean force moves a body by s·P·dt/m, whenever in the step its impulses came: one that came early would have carried
//! it twice as far, and at the end of a long lever that is centimetres. For free bodies and joints the right split into an
//! early impulse and a force is known in closed form. Rigid contacts are one-sided, and an early impulse may open them or
//! press them harder. So Rapier's step is rehearsed with the shadows, which know these contacts, and the split is
//! corrected by where it would leave each body, as long as that brings it closer to where its shadow is.

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
/// How many times its impulses a body gets at the start of the step at most.
const FARTHEST: f64 = 2.0;
/// Passes over the rigid contacts in one of Rapier's solver iterations, and the relative change that counts as settled.
const PASSES: usize = 12;
const SETTLED: f64 = 1e-3;

/// Where a body misses its shadow: displacement \[m\] and turn \[rad\].
type Miss = (DVec3, DVec3);

/// One body's part in the rehearsals.
#[derive(Clone, Copy)]
struct Player {
    split: Split,
    /// The best split so far, and by how much it misses \[kg·m²\].
    best: (Split, f64),
    /// The miss before the last correction, and how many times what a free body needs that was.
    last: Option<(Miss, f64)>,
    corrects: bool,
}

impl Group {
    /// The split of every touched body's impulses over a step of `dt` s that Rapier makes in `iterations`. A miss of less
    /// than `small` m is none.
    pub fn splits(&self, iterations: usize, dt: f64, small: f64) -> Vec<Split> {
        let pressed = |answer| answer == Answer::Pressed;
        let mut players: Vec<Player> = self
            .touched
            .iter()
            .zip(&self.shadows[1..])
            .map(|(t, end)| {
                let corrects = pressed(t.answer) && end.impulse != DVec3::ZERO;
                Player {
                    split: Split::NONE,
                    best: (Split::NONE, f64::INFINITY),
                    last: None,
                    corrects,
                }
            })
            .collect();
        let share = (iterations as f64 + 1.0) / (2.0 * iterations as f64);
        for _ in 0..ROUNDS {
            // With one iteration Rapier gives force and impulse the same displacement: nothing to split.
            if share >= 1.0 || players.iter().all(|p| !p.corrects) {
                break;
            }
            let reached = self.rehearse(&players, iterations, dt);
            for ((player, end), reached) in players
                .iter_mut()
                .zip(&self.shadows[1..])
                .zip(&reached[1..])
            {
                if player.corrects {
                    player.correct(end, reached, (1.0 - share) * dt, small);
                }
            }
        }
        players.iter().map(|p| p.best.0).collect()
    }

    /// Where the shadows end if they get their impulses as Rapier's bodies will.
    fn rehearse(&self, players: &[Player], iterations: usize, dt: f64) -> Vec<Shadow> {
        let h = dt / iterations as f64;
        let mut shadows = vec![Shadow::FIXED];
        for ((touched, end), player) in self.touched.iter().zip(&self.shadows[1..]).zip(players) {
            let mut shadow = touched.start;
            let (early, turn) = (player.split.impulse, player.split.torque);
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

impl Player {
    /// Moves the split by what it missed, if the last correction was one; else goes back and stops. An impulse moved from
    /// the force to the start of the step carries `gain` s farther.
    fn correct(&mut self, end: &Shadow, reached: &Shadow, gain: f64, small: f64) {
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
        if size >= self.best.1 {
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
        let scale = self.last.map_or(1.0, |(last, scale)| {
            let weigh = |a: Miss| by.0.dot(a.0) + by.1.dot(a.1);
            let (before, now) = (weigh(last), weigh(miss));
            (scale * before / (before - now)).clamp(1.0, MOST)
        });
        self.last = Some((miss, scale));
        self.split.impulse += by.0 * (scale / gain);
        self.split.torque += by.1 * (scale / gain);
        // An impulse at the very end of the step asks for −s/(1 − s) = −5/3 of itself at its start: more than that is not
        // about when impulses came, but about a contact that one of the two worlds has and the other has not.
        let weigh = |impulse: DVec3, torque: DVec3| {
            impulse.dot(end.inv_mass * impulse) + torque.dot(end.inv_inertia * torque)
        };
        let given = weigh(end.impulse, end.torque);
        let moved = weigh(self.split.impulse, self.split.torque);
        if moved > FARTHEST * FARTHEST * given {
            let by = FARTHEST * (given / moved).sqrt();
            self.split.impulse *= by;
            self.split.torque *= by;
        }
    }
}
