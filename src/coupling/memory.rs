//! What is remembered of each touched rigid body between steps: its response ratio, and what lay on it when it fell
//! asleep.

use crate::math::DVec3;

/// Memory of one rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMemory {
    /// Response ratio ρ in [0, 1]: 1 for a body that answers like a free one. `None` until first guessed.
    pub response: Option<f64>,
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
    /// The last step in which a deformable could touch it.
    pub seen: u64,
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
            seen: 0,
        }
    }
}

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
    /// `actual` \[m/s\].
    pub fn answer(&mut self, actual: DVec3, free: DVec3) {
        let squared = free.length_squared();
        if squared > 0.0 {
            let measured = (actual.dot(free) / squared).clamp(0.0, 1.0);
            let old = self.response.unwrap_or(measured);
            self.response = Some(0.5 * (old + measured));
        }
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
