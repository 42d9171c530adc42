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
/// Substeps until the next one: where one way takes twice as long as the other, a trial costs a hundredth.
const TERM: u32 = 1024;

/// What is known of a body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gauge {
    /// Substeps that could be shared out since the last trial began.
    count: u32,
    /// Whether the substep under way can be.
    asked: bool,
    /// Of the substep under way.
    spent: Duration,
    /// The shortest of the trial, alone and shared out.
    least: [Option<Duration>; 2],
}

impl Gauge {
    /// Does a part of a substep over as much as so many springs, shared out to threads if that pays.
    pub fn run<R>(&mut self, springs: usize, part: impl FnOnce() -> R) -> R {
        if threads::parts(springs) < 2 {
            return part();
        }
        self.asked = true;
        let shared = self.is_shared();
        if self.count >= 2 * TRIAL {
            return threads::sharing(shared, part);
        }
        let start = Instant::now();
        let result = threads::sharing(shared, part);
        self.spent += start.elapsed();
        result
    }

    /// Ends a substep.
    pub fn end(&mut self) {
        if !std::mem::take(&mut self.asked) {
            return;
        }
        if self.spent > Duration::ZERO {
            let least = &mut self.least[usize::from(self.is_shared())];
            *least = Some(least.map_or(self.spent, |least| least.min(self.spent)));
            self.spent = Duration::ZERO;
        }
        self.count += 1;
        if self.count >= TERM {
            *self = Self::default();
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
        for i in 0..2 * TERM {
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
            let (mut gauge, mut shared) = (Gauge::default(), 0);
            pool.as_ref().unwrap().install(|| {
                for substep in 0..TERM {
                    gauge.run(1_000_000, || {
                        let is_shared = threads::parts(1_000_000) > 1;
                        if substep < 2 * TRIAL {
                            let slow = is_shared == shared_is_slow;
                            std::thread::sleep(Duration::from_micros(if slow { 900 } else { 100 }));
                        } else {
                            shared += u32::from(is_shared);
                        }
                    });
                    gauge.end();
                }
                assert_eq!(threads::parts(1_000_000), 2);
            });
            let expected = if shared_is_slow { 0 } else { TERM - 2 * TRIAL };
            assert_eq!(shared, expected);
            assert_eq!(gauge.count, 0);
        }
    }
}
