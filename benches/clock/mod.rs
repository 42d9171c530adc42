//! Time that this thread has run, which other programs on the machine do not lengthen.

use std::time::{Duration, Instant};

/// What has been measured since the clock was started.
pub struct Clock {
    wall: Instant,
    cpu: Option<u64>,
}

impl Clock {
    pub fn start() -> Self {
        Self {
            wall: Instant::now(),
            cpu: cpu(),
        }
    }

    /// Time on the processor where the system tells it (Linux), else the time that has passed.
    pub fn spent(&self) -> Duration {
        match (self.cpu, cpu()) {
            (Some(start), Some(now)) => Duration::from_nanos(now - start),
            _ => self.wall.elapsed(),
        }
    }
}

/// Nanoseconds on the processor, the first number of the scheduler's statistics.
fn cpu() -> Option<u64> {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    stat.split_whitespace().next()?.parse().ok()
}
