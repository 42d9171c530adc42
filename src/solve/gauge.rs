//! Whether threads pay for a body, by trying.
//!
//! What two threads hand to each other costs some nanoseconds where they share a cache, and ten times that where they do not, as
//! on a virtual machine with its processors on different parts of a chip: a mesh without order then takes half as long again on
//! two threads as on one. Nothing tells beforehand. As results are the same to the last bit for any number of threads, a body
//! tries both now and then and goes on with what took less time.

use super::threads;
use std::time::{Duration, Instant};

/// Substeps of each kind in a trial: the shortest counts, since whatever else a machine does can only add to them.
const TRIAL: u32 = 8;
/// Substeps until the second one, and at most until any. Threads that were just woken may run on one core for some milliseconds, so
/// that the first trials can be wrong; where the last two agree, the next is twice as far away. In the end a trial costs a
/// hundredth where one way takes twice as long as the other.
const TERMS: [u32; 2] = [128, 1024];

/// What is known of a body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gauge {
    /// Substeps that could be shared out since the last trial began.
    count: u32,
    /// Those before it that threads were called for and had not come to.
    waited: u32,
    /// Whether the substep under way can be.
    asked: bool,
    /// Of the substep under way.
    spent: Duration,
    /// The shortest of the trial, alone and shared out.
    least: [Option<Duration>; 2],
    /// What the trial before found, and from it until this one began.
    before: Option<(bool, u32)>,
}

impl Gauge {
    /// Does a part of a substep over as much as so many springs, shared out to threads if that pays.
    pub fn run<R>(&mut self, springs: usize, part: impl FnOnce() -> R) -> R {
        let most = threads::parts_of(springs);
        if most < 2 {
            return part();
        }
        self.asked = true;
        let parts = if self.is_shared() { most } else { 1 };
        if self.count >= 2 * TRIAL {
            return threads::in_parts(parts, part);
        }
        let start = Instant::now();
        let result = threads::in_parts(parts, part);
        self.spent += start.elapsed();
        result
    }

    /// Ends a substep.
    pub fn end(&mut self) {
        if !std::mem::take(&mut self.asked) {
            return;
        }
        if self.count == 0 && self.waited < TERMS[0] && !threads::are_awake() {
            self.waited += 1;
            self.spent = Duration::ZERO;
            return;
        }
        if self.spent > Duration::ZERO {
            let least = &mut self.least[usize::from(self.is_shared())];
            *least = Some(least.map_or(self.spent, |least| least.min(self.spent)));
            self.spent = Duration::ZERO;
        }
        self.count += 1;
        if self.count >= self.term() {
            *self = Self {
                before: Some((self.is_shared(), self.term())),
                ..Self::default()
            };
        }
    }

    /// Substeps from this trial until the next one.
    fn term(&self) -> u32 {
        match self.before {
            Some((found, term)) if found == self.is_shared() => TERMS[1].min(2 * term),
            _ => TERMS[0],
        }
    }

    /// Whether the substep under way is shared out: the first ones are, then as many are not.
    fn is_shared(&self) -> bool {
        match (self.count / TRIAL, self.least) {
            (0, _) => true,
            (1, _) => false,
            (_, [Some(alone), Some(shared)]) => shared < alone,
            _ => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing to try where there are no threads, and nothing changes by it.
    #[test]
    fn what_is_not_shared_is_not_tried() {
        let mut gauge = Gauge::default();
        for i in 0..2 * TERMS[1] {
            assert_eq!(gauge.run(1_000_000, || i), i);
            gauge.end();
            assert!(gauge.least.iter().all(Option::is_none) && gauge.count == 0);
        }
    }

    #[cfg(feature = "parallel")]
    #[test]
    fn what_takes_longer_by_threads_is_done_by_one() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build();
        for shared_is_slow in [true, false] {
            let mut gauge = Gauge::default();
            let substep = |gauge: &mut Gauge| {
                let (shared, trying) = (gauge.is_shared(), gauge.count < 2 * TRIAL);
                gauge.run(1_000_000, || {
                    assert_eq!(threads::parts(), if shared { 2 } else { 1 });
                    if trying {
                        let slow = shared == shared_is_slow;
                        std::thread::sleep(Duration::from_micros(if slow { 900 } else { 100 }));
                    }
                });
                gauge.end();
                shared
            };
            pool.as_ref().unwrap().install(|| {
                // Terms twice as long each, up to the longest.
                for term in [128, 256, 512, 1024, 1024] {
                    assert_eq!(gauge.count, 0);
                    let shared = (0..term).filter(|_| substep(&mut gauge)).count() as u32;
                    let rest = if shared_is_slow { 0 } else { term - 2 * TRIAL };
                    assert_eq!(shared, TRIAL + rest);
                }
                assert_eq!(threads::parts_of(1_000_000), 2);
            });
        }
    }
}
