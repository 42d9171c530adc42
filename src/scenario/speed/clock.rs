//! Time of this thread, medians, and subjects measured in turn.

use std::time::{Duration, Instant};

/// Time that this thread has run, which other programs on the machine do not lengthen.
#[derive(Debug)]
pub struct Clock {
    wall: Instant,
    cpu: Option<u64>,
}

impl Clock {
    /// A clock that runs from now on.
    pub fn start() -> Self {
        Self {
            wall: Instant::now(),
            cpu: cpu(),
        }
    }

    /// Time on the processor where the system tells it (Linux), in grains of milliseconds, else the time that has passed.
    pub fn spent(&self) -> Duration {
        match (self.cpu, cpu()) {
            (Some(start), Some(now)) if now > start => Duration::from_nanos(now - start),
            _ => self.wall.elapsed(),
        }
    }
}

/// Does something on one thread: a [`Clock`] knows nothing of the others that a world would call for help.
pub fn alone<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    #[cfg(feature = "parallel")]
    return super::threads::Pool::new(1).install(work);
    #[cfg(not(feature = "parallel"))]
    return work();
}

/// Nanoseconds on the processor, the first number of the scheduler's statistics.
fn cpu() -> Option<u64> {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    stat.split_whitespace().next()?.parse().ok()
}

/// Seconds of the thread per call: `count` calls at a time, for at least `least` s. What the system tells of a thread's
/// time has grains of milliseconds.
pub fn per_call(least: f64, count: usize, mut call: impl FnMut()) -> f64 {
    let (clock, wall) = (Clock::start(), Instant::now());
    let mut calls = 0;
    loop {
        for _ in 0..count {
            call();
        }
        calls += count;
        // Asking the system costs a microsecond or two.
        if wall.elapsed().as_secs_f64() > least {
            let spent = clock.spent().as_secs_f64();
            if spent > least {
                return spent / calls as f64;
            }
        }
    }
}

/// The middle one; NaN of none.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_median_is_the_middle_one() {
        assert_eq!(median([3.0, 1.0, 2.0]), 2.0);
        assert!(median([]).is_nan());
    }

    #[test]
    fn a_call_takes_time() {
        let mut sum = 0.0_f64;
        let each = per_call(2e-3, 10, || {
            for i in 0..1000 {
                sum += f64::from(std::hint::black_box(i));
            }
        });
        assert!(sum > 0.0 && each > 1e-8 && each < 1e-2, "{each}");
    }
}
