//! What is remembered of each touched rigid body between steps: its response ratio, and what lay on it when it fell
//! asleep.

use super::flight::rotation_vector;
use crate::math::{DQuat, DVec3};

/// Memory of one rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct BodyMemory {
    /// Response ratio ρ in [0, 1]: 1 for a body that answers like a free one. `None` until first guessed.
    pub response: Option<Response>,
    /// Moving average of the impulse per second it receives \[N\].
    pub load: DVec3,
    /// How long it has been asleep \[s\].
    pub asleep: f64,
    /// That average a quarter of a second after it fell asleep \[N\].
    pub baseline: Option<DVec3>,
    /// Whether nodes lay on it when it fell asleep.
    pub supported: bool,
    /// Whether any node lay within 2 mm of it when last looked.
    pub near: bool,
    /// By how much its shadow is off, of what rests on rigid bodies or bears a stiff deformable: its centre of mass \[m\], and its
    /// orientation as an angle times an axis \[rad\].
    pub offset: (DVec3, DVec3),
    /// Whether it was put where its shadow was in the last step, because of the nodes that it holds.
    pub was_put: bool,
    /// Where it was when it had last moved on: its centre of mass \[m\] and its orientation.
    pub stayed: (DVec3, DQuat),
    /// The last step in which a deformable could touch it.
    pub seen: u64,
}

/// How much of the answer that was computed for it a constrained body gives: for
/// bodies in joints, of multibodies or others, that shadows can't keep.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Response {
    /// Along each axis of the world.
    pub along: DVec3,
    /// About each axis of the world.
    pub about: DVec3,
}

impl Response {
    /// The same for everything.
    pub fn all(ratio: f64) -> Self {
        Self {
            along: DVec3::splat(ratio),
            about: DVec3::splat(ratio),
        }
    }
}

impl Default for BodyMemory {
    fn default() -> Self {
        Self {
            response: None,
            load: DVec3::ZERO,
            asleep: 0.0,
            baseline: None,
            supported: false,
            near: false,
            offset: Default::default(),
            was_put: false,
            stayed: (DVec3::INFINITY, DQuat::IDENTITY),
            seen: 0,
        }
    }
}

/// How fast a shadow goes to where its body is \[1/s\]: as fast as Rapier parts what overlaps.
const REUNION: f64 = 10.0;
/// How far off it can be, in length units and as an angle \[rad\].
const APART: (f64, f64) = (5e-4, 5e-3);

/// How far from where it stays a body that touches a deformable may be and fall asleep, in length units. Rapier lets sleep what has
/// been slower than 0.1 m/s for half a second (by default), and holds it then like a fixed one: in that time it may have been pushed
/// by 5 cm.
const STAYS: f64 = 1e-3;

/// Averaging time of the load \[s\].
const LOAD_TIME: f64 = 0.05;
/// How long after falling asleep the baseline is taken \[s\].
const BASELINE_AFTER: f64 = 0.25;

impl BodyMemory {
    /// The memory of a body that no deformable has been near before. If it sleeps, nothing lay on it when it fell asleep.
    pub fn first_seen(sleeping: bool) -> Self {
        Self {
            baseline: sleeping.then_some(DVec3::ZERO),
            asleep: if sleeping { BASELINE_AFTER } else { 0.0 },
            ..Self::default()
        }
    }

    /// Mixes the impulse of a step of `dt` s into the average.
    pub fn feel(&mut self, impulse: DVec3, dt: f64) {
        let mix = 1.0 - (-dt / LOAD_TIME).exp();
        self.load += (impulse / dt - self.load) * mix;
    }

    /// Takes the response of a constrained body: it was given enough to change its velocity by `free`, and changed by
    /// `actual` \[m/s\], and its spin by `turned` where it would have been by `free_turn` \[rad/s\].
    pub fn answer(&mut self, actual: DVec3, free: DVec3, turned: DVec3, free_turn: DVec3) {
        let squared = free.length_squared();
        if squared > 0.0 {
            let mean = (actual.dot(free) / squared).clamp(0.0, 1.0);
            let mut response = self.response.unwrap_or(Response::all(mean));
            response.along = learn(response.along, actual, free);
            response.about = learn(response.about, turned, free_turn);
            self.response = Some(response);
        }
    }

    /// A body that rests on others has come to lie elsewhere than its shadow, which lies by `miss` m and a `turn` from it now and goes
    /// to it in its own time. For Rapier's contacts give way to what presses harder than in the step before, shadows' do not, and
    /// what a deformable is pressed by because of that presses back in the next step. Where it is so stiff that a body would swing
    /// on it within a step or two, that is the more the longer it goes on: a stack of boxes dances, and creeps. Likewise what Rapier's
    /// iterations leave of the errors of joints that bear a stiff deformable: a parked car heats up.
    pub fn keep_apart(&mut self, miss: DVec3, turn: DVec3, length_unit: f64, dt: f64) {
        let keep = (-REUNION * dt).exp();
        let (far, turned) = APART;
        self.offset = (
            miss.clamp_length_max(far * length_unit) * keep,
            turn.clamp_length_max(turned) * keep,
        );
    }

    /// Puts its shadow where it was left, `com` and `rot` being those of the body.
    pub fn apart(&self, com: DVec3, rot: DQuat) -> (DVec3, DQuat) {
        let (miss, turn) = self.offset;
        if self.offset == Default::default() {
            return (com, rot);
        }
        let turn = DQuat::from_scaled_axis(turn);
        (com + miss, (turn * rot).normalize())
    }

    /// Whether a body has moved on from where it stayed, its centre of mass being at `com` m now: that, or what lies `arm` m from it.
    pub fn moves_on(&mut self, (com, rot): (DVec3, DQuat), arm: f64, length_unit: f64) -> bool {
        let (place, orientation) = self.stayed;
        let turn = rotation_vector(rot * orientation.inverse()).length();
        // From nowhere it has come a long way.
        let moves = com.distance(place) + arm * turn > STAYS * length_unit;
        if moves {
            self.stayed = (com, rot);
        }
        moves
    }

    /// Follows the body through a step of `dt` s, and says whether it must wake: the load on it has changed by more than
    /// 30 %, or what it lay on is gone. `near` is whether any node lies within 2 mm now.
    pub fn watch_sleep(&mut self, sleeping: bool, near: bool, weight: f64, dt: f64) -> bool {
        if !sleeping {
            self.asleep = 0.0;
            self.baseline = None;
            return false;
        }
        if self.asleep == 0.0 {
            self.supported = near;
        }
        self.asleep += dt;
        if self.supported && !near {
            return true;
        }
        match self.baseline {
            None => {
                if self.asleep >= BASELINE_AFTER {
                    self.baseline = Some(self.load);
                }
                false
            }
            Some(baseline) => (self.load - baseline).length() > 0.3 * weight.max(baseline.length()),
        }
    }
}

/// Mixes what was measured along each axis into what was known. An axis along which next to nothing was given tells next
/// to nothing; none answers less than the whole does along what it was given, for a guess too low makes it overshoot.
fn learn(old: DVec3, actual: DVec3, free: DVec3) -> DVec3 {
    let squared = free.length_squared();
    if !(squared.is_finite() && actual.is_finite()) {
        return old;
    }
    let mean = (actual.dot(free) / squared).clamp(0.0, 1.0);
    let along = |old: f64, v: f64, f: f64| {
        if f == 0.0 {
            return old;
        }
        let trust = f * f / (f * f + 0.01 * squared);
        old + 0.5 * trust * ((v / f).max(mean).min(1.0) - old)
    };
    DVec3::new(
        along(old.x, actual.x, free.x),
        along(old.y, actual.y, free.y),
        along(old.z, actual.z, free.z),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shadow_goes_to_its_body_and_is_never_far_off() {
        let mut memory = BodyMemory::default();
        let (com, rot) = (DVec3::new(1.0, 2.0, 3.0), DQuat::from_rotation_x(0.3));
        assert_eq!(memory.apart(com, rot), (com, rot));
        memory.keep_apart(DVec3::X, DVec3::Y, 1.0, 0.0);
        let (off, turned) = memory.apart(com, rot);
        assert!((off - com).distance(DVec3::X * APART.0) < 1e-12);
        let turn = (turned * rot.inverse()).to_scaled_axis();
        assert!(turn.distance(DVec3::Y * APART.1) < 1e-9, "{turn}");
        for _ in 0..100 {
            let (miss, turn) = memory.offset;
            memory.keep_apart(miss, turn, 1.0, 1e-3);
        }
        let left = APART.0 * (-1.0_f64).exp();
        assert!((memory.offset.0.length() - left).abs() < 1e-9 * left);
    }

    #[test]
    fn what_creeps_moves_on_and_what_trembles_stays() {
        let mut memory = BodyMemory::default();
        let at = |x: f64, turn: f64| (DVec3::X * x, DQuat::from_rotation_y(turn));
        assert!(memory.moves_on(at(0.0, 0.0), 0.5, 1.0), "it was nowhere");
        for i in 1..1000 {
            let there = f64::from(i).sin();
            assert!(!memory.moves_on(at(4e-4 * there, 1e-3 * there), 0.5, 1.0));
        }
        assert!(memory.moves_on(at(0.0, 3e-3), 0.5, 1.0), "it has turned");
        let moves = (1..=100).filter(|i| memory.moves_on(at(1e-4 * f64::from(*i), 3e-3), 0.5, 1.0));
        assert_eq!(moves.count(), 9, "a millimetre and a bit each");
    }

    #[test]
    fn what_a_floor_holds_up_can_still_be_pushed_along() {
        let mut memory = BodyMemory {
            response: Some(Response::all(0.2)),
            ..BodyMemory::default()
        };
        for _ in 0..40 {
            let (given, got) = (DVec3::new(0.4, -1.0, 0.0), DVec3::new(0.2, 0.0, 0.0));
            memory.answer(got, given, DVec3::ZERO, DVec3::ZERO);
        }
        let along = memory.response.unwrap().along;
        assert!((along.x - 0.5).abs() < 1e-3, "{along}");
        assert!(along.y < 0.1, "{along}");
        assert_eq!(
            (along.z, memory.response.unwrap().about.x),
            (0.2, 0.2),
            "nothing was tried"
        );
    }
}
