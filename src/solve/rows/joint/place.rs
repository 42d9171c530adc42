//! Where a joint is: its axes in the world, and how far it has gone along and about them. Angles are measured as Rapier
//! measures them.

use super::{Joint, Mat6, Motions, Vec6};
use crate::math::{DQuat, DVec3};
use crate::solve::shadow::Shadow;
use std::f64::consts::{PI, TAU};

/// A joint in the world.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    /// Along which the second moves, and about which it turns.
    directions: [DVec3; 6],
    /// From the centres of mass to where impulses act: at the second's anchor, or nearly \[m\].
    arms: [DVec3; 2],
    /// From the anchor on the first to that on the second \[m\].
    opening: DVec3,
    /// How the second is turned on the first, by half a turn at most.
    turn: DQuat,
}

impl Place {
    /// Where a joint of shadows is.
    pub fn of(joint: &Joint, [a, b]: [&Shadow; 2]) -> Self {
        let first = a.rot * joint.anchors[0];
        let second = b.rot * joint.anchors[1];
        let mut arms = [b.com + second - a.com, second];
        let [one, two] = [a.rot * joint.frames[0], b.rot * joint.frames[1]];
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| one * axis);
        let opening = arms[0] - first;
        let [x, y, z] = axes;
        let mut directions = [x, y, z, x, y, z];
        if let Some(distance) = joint.axes.coupled.iter().position(|c| *c) {
            let coupled = axes.iter().zip(joint.axes.coupled).filter(|(_, c)| *c);
            let apart: DVec3 = coupled.map(|(axis, _)| *axis * axis.dot(opening)).sum();
            directions[distance] = apart.normalize_or_zero();
        }
        if joint.axes.softness.is_some() {
            // As Rapier has it: along what is locked each is held at its own anchor.
            for (axis, _) in axes.iter().zip(joint.axes.locked).filter(|(_, l)| *l) {
                arms[0] -= *axis * axis.dot(opening);
            }
        }
        let turn = one.inverse() * two;
        Self {
            directions,
            arms,
            opening,
            turn: if turn.w < 0.0 { -turn } else { turn },
        }
    }

    /// How far the second is displaced along a direction \[m\].
    pub fn displacement(&self, i: usize) -> f64 {
        self.opening.dot(self.directions[i])
    }

    /// How far locked axes are open \[m, rad\]; of turns, what is left without those about the free axes.
    pub fn opened(&self, locked: [bool; 6]) -> Vec6 {
        let DQuat { x, y, z, w } = self.turn;
        let free = |i: usize, sine: f64| if locked[i] { 0.0 } else { sine };
        let about = DQuat::from_xyzw(free(3, x), free(4, y), free(5, z), w);
        // By half a turn about what is locked it has none about what is free.
        let about = if about.length_squared() > 0.0 {
            about.normalize()
        } else {
            DQuat::IDENTITY
        };
        let turned = (self.turn * about.inverse()).to_scaled_axis();
        Vec6::from_fn(|i, _| match i {
            _ if !locked[i] => 0.0,
            0..3 => self.displacement(i),
            _ => turned[i - 3],
        })
    }

    /// Sine of half the turn about an axis, and cosine of half the turn.
    fn half_turn(&self, i: usize) -> (f64, f64) {
        let DQuat { x, y, z, w } = self.turn;
        ([x, y, z][i - 3], w)
    }

    /// How far it is from a place, the shorter way round \[m, rad\].
    pub fn off(&self, i: usize, place: f64) -> f64 {
        if i < 3 {
            return self.displacement(i) - place;
        }
        let (sine, _) = self.half_turn(i);
        wrapped(2.0 * sine.clamp(-1.0, 1.0).asin() - place)
    }

    /// How far it is to limits, down and up \[m, rad\]. A turn of a whole circle has none.
    pub fn room(&self, i: usize, [low, high]: [f64; 2]) -> [f64; 2] {
        if i < 3 {
            let at = self.displacement(i);
            return [low - at, high - at];
        }
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        if half >= PI || half.is_nan() || middle.is_nan() {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        let (sine, cosine) = self.half_turn(i);
        let at = wrapped(2.0 * sine.atan2(cosine) - middle);
        [-half - at, half - at]
    }

    /// What axis `i` sees of velocities and spins: those of the second less those of the first.
    pub fn along(&self, i: usize, motions: &Motions) -> f64 {
        let axis = self.directions[i];
        let seen = |k: usize| {
            let (v, w) = motions[k];
            let moved = if i < 3 { v + w.cross(self.arms[k]) } else { w };
            moved.dot(axis)
        };
        seen(1) - seen(0)
    }

    /// The motions that impulses give to both sides.
    pub fn motions(&self, sides: [&Shadow; 2], impulses: &Vec6) -> Motions {
        [0, 1].map(|side| {
            let mut still = Shadow {
                v: DVec3::ZERO,
                w: DVec3::ZERO,
                ..*sides[side]
            };
            self.give(&mut still, side, impulses);
            (still.v, still.w)
        })
    }

    /// Those of a unit along or about one direction.
    pub fn unit_motions(&self, sides: [&Shadow; 2], i: usize) -> Motions {
        let mut unit = Vec6::zeros();
        unit[i] = 1.0;
        self.motions(sides, &unit)
    }

    /// What velocities of locked axes impulses along these add; the rest is 0.
    pub fn response(&self, sides: [&Shadow; 2], locked: [bool; 6]) -> Mat6 {
        let mut response = Mat6::zeros();
        for i in (0..6).filter(|i| locked[*i]) {
            let moved = self.unit_motions(sides, i);
            for k in (0..6).filter(|k| locked[*k]) {
                response[(k, i)] = self.along(k, &moved);
            }
        }
        response
    }

    /// Gives one side its part of impulses along and about the directions.
    pub fn give(&self, shadow: &mut Shadow, side: usize, impulses: &Vec6) {
        let sum = |first: usize| {
            let parts = (0..3).map(|i| self.directions[first + i] * impulses[first + i]);
            parts.sum::<DVec3>() * [-1.0, 1.0][side]
        };
        let linear = sum(0);
        shadow.take(linear, self.arms[side].cross(linear) + sum(3));
    }
}

/// An angle in −π to π.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}
