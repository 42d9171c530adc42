//! Threads of Rayon's pool that look out for the parts of passes, so that a pass of some microseconds can be shared out: a job of
//! Rayon's own reaches a thread that is awake after half a microsecond, and one that sleeps too late.
//!
//! A thread that shares out a pass has a [`Team`]. Its helpers are jobs of the pool: each takes parts as soon as there are any,
//! does other jobs of the pool meanwhile, and leaves when nothing was shared out for [`PATIENCE`]. Nobody waits for a helper that has not
//! taken a part: what helpers leave, the thread does itself.

#![allow(unsafe_code)]

use std::any::Any;
use std::cell::UnsafeCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The most parts of a pass.
pub(super) const MOST: usize = u64::BITS as usize;

/// How long a helper stays where nothing is shared out: longer than what is done between two passes of a substep takes.
const PATIENCE: Duration = Duration::from_micros(100);

/// How long a helper is a job of the pool at a time. A thread may have been called to it while it waits for others, and must see
/// whether they have come.
const TURN: Duration = Duration::from_micros(50);

/// How often a helper looks for parts before it looks for other jobs.
const LOOKS: usize = 500;

/// What does a part, told which.
type Job<'a> = dyn Fn(usize) + Sync + 'a;

/// What a thread shares with its helpers.
pub(super) struct Team {
    offer: Alone<Offer>,
    /// Parts of the pass under way that are not done.
    left: Alone<AtomicUsize>,
    /// A bit for each helper that was called, and for each that has come. The first bit is the thread's own.
    called: Alone<AtomicU64>,
    present: Alone<AtomicU64>,
    /// Of a part that went wrong.
    panic: Mutex<Option<Box<dyn Any + Send>>>,
}

/// What is read together.
struct Offer {
    /// A bit for each part that is not to be taken (any more): all but while a pass is under way.
    taken: AtomicU64,
    /// Written by the thread of the team while all parts are taken and done, read by whoever has taken a part.
    job: UnsafeCell<Option<&'static Job<'static>>>,
}

/// On a cache line of its own, and on none that is fetched along with another.
#[repr(align(128))]
struct Alone<T>(T);

// SAFETY: `job` is the only field that is not `Sync` by itself, and what it refers to is. It is written by `share` alone, which only the
// thread of a team calls and which does not get there from within itself, as parts are left then, before parts are offered by a release of `taken` and after all parts of the job before were counted off by releases of `left` that it
// acquired. It is read after a part was taken by an acquire of `taken`, and before that part is counted off.
unsafe impl Sync for Team {}
// SAFETY: as above; a reference to something `Sync` may be sent.
unsafe impl Send for Team {}

thread_local! {
    /// The team of this thread.
    static TEAM: Arc<Team> = Arc::new(Team::new());
}

/// Does so many parts at once, the first one here and the others here or by whoever comes to help.
pub(super) fn share(parts: usize, first: impl FnOnce(), others: &Job<'_>) {
    TEAM.with(|team| team.share(parts, first, others));
}

/// Whether all helpers are there that this thread has called.
pub(super) fn is_complete() -> bool {
    let of = |bits: &Alone<AtomicU64>| bits.0.load(Ordering::Relaxed);
    TEAM.with(|team| of(&team.called) == of(&team.present))
}

impl Team {
    fn new() -> Self {
        Self {
            offer: Alone(Offer {
                taken: AtomicU64::new(u64::MAX),
                job: UnsafeCell::new(None),
            }),
            left: Alone(AtomicUsize::new(0)),
            called: Alone(AtomicU64::new(1)),
            present: Alone(AtomicU64::new(1)),
            panic: Mutex::new(None),
        }
    }

    fn share(self: &Arc<Self>, parts: usize, first: impl FnOnce(), others: &Job<'_>) {
        assert!((1..=MOST).contains(&parts), "{parts} parts");
        if self.left.0.load(Ordering::Relaxed) > 0 {
            // From within a part of a pass of this thread.
            first();
            return (1..parts).for_each(others);
        }
        let bits = u64::MAX >> (MOST - parts);
        self.call(bits);
        // SAFETY: all parts of the pass before are taken and done, so nobody reads. The reference outlives its uses: it is used by those who
        // have taken a part, and this function returns after all have counted theirs off.
        unsafe {
            *self.offer.0.job.get() = Some(std::mem::transmute::<&Job<'_>, &'static Job<'static>>(
                others,
            ));
        }
        self.left.0.store(parts, Ordering::Relaxed);
        self.offer.0.taken.store(!bits | 1, Ordering::Release);
        self.run(first);
        while let Some(part) = self.take(0) {
            self.run(|| self.part(part));
        }
        while (0..LOOKS).all(|_| {
            std::hint::spin_loop();
            self.left.0.load(Ordering::Acquire) > 0
        }) {
            std::thread::yield_now();
        }
        if let Some(panic) = self
            .panic
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take()
        {
            resume_unwind(panic);
        }
    }

    /// Takes a part: this one if it is free, so that threads find in their caches what they left there.
    fn take(&self, part: usize) -> Option<usize> {
        loop {
            let free = !self.offer.0.taken.load(Ordering::Relaxed);
            let bit = match free & 1 << part {
                0 => free & free.wrapping_neg(),
                bit => bit,
            };
            if bit == 0 {
                return None;
            }
            if self.offer.0.taken.fetch_or(bit, Ordering::AcqRel) & bit == 0 {
                return Some(bit.trailing_zeros() as usize);
            }
        }
    }

    /// Does a part that was taken.
    fn part(&self, part: usize) {
        // SAFETY: the part was taken and is not counted off, see above.
        let job = unsafe { *self.offer.0.job.get() };
        job.into_iter().for_each(|job| job(part));
    }

    /// Does a part that was taken, and counts it off whatever comes of it.
    fn run(&self, part: impl FnOnce()) {
        let done = catch_unwind(AssertUnwindSafe(|| super::in_parts(1, part)));
        if let Err(panic) = done {
            let mut first = self.panic.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert(panic);
        }
        self.left.0.fetch_sub(1, Ordering::Release);
    }

    /// Calls the helpers of these numbers that are not there.
    fn call(self: &Arc<Self>, numbers: u64) {
        let mut missing = numbers & !self.called.0.load(Ordering::Relaxed);
        if missing != 0 {
            self.called.0.fetch_or(missing, Ordering::Relaxed);
        }
        while missing != 0 {
            self.send(missing.trailing_zeros() as usize, None);
            missing &= missing - 1;
        }
    }

    /// Has some thread of the pool help, who had something to do at last then.
    fn send(self: &Arc<Self>, number: usize, last: Option<Instant>) {
        let team = self.clone();
        rayon::spawn(move || team.help(number, last));
    }

    fn help(self: Arc<Self>, number: usize, last: Option<Instant>) {
        let start = Instant::now();
        let mut last = last.unwrap_or(start);
        let bit = 1 << number;
        self.present.0.fetch_or(bit, Ordering::Relaxed);
        // The thread of the team, which has other things to do.
        let mut leaves = TEAM.with(|own| Arc::ptr_eq(own, &self));
        while !leaves {
            for _ in 0..LOOKS {
                while let Some(part) = self.take(number) {
                    self.run(|| self.part(part));
                    last = Instant::now();
                }
                std::hint::spin_loop();
            }
            if rayon::yield_now() != Some(rayon::Yield::Executed) {
                std::thread::yield_now();
            }
            leaves = last.elapsed() > PATIENCE;
            if !leaves && start.elapsed() > TURN {
                self.send(number, Some(last));
                return;
            }
        }
        for bits in [&self.present, &self.called] {
            bits.0.fetch_and(!bit, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;

    fn pool(threads: usize) -> rayon::ThreadPool {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("a pool")
    }

    /// Passes of so many parts: every part is done once, and all when `share` returns.
    fn passes(count: usize, parts: usize, during: impl Fn() + Sync) {
        let done: Vec<AtomicUsize> = (0..parts).map(|_| AtomicUsize::new(0)).collect();
        let add = |part: usize| {
            during();
            done[part].fetch_add(1, Ordering::Relaxed);
        };
        for pass in 1..=count {
            share(parts, || add(0), &add);
            assert!(done.iter().all(|d| d.load(Ordering::Relaxed) == pass));
        }
    }

    #[test]
    fn a_panic_leaves_the_number_of_parts_as_it_was() {
        let panics = || super::super::in_parts(7, || panic!("on purpose"));
        assert!(catch_unwind(panics).is_err());
        assert_eq!(super::super::parts(), 1);
    }

    #[test]
    fn every_part_is_done_once() {
        for threads in [1, 2, 3, 8] {
            pool(threads).install(|| {
                for parts in [1, 2, 3, 7, MOST] {
                    passes(2_000, parts, || {});
                }
            });
        }
    }

    #[test]
    fn others_help() {
        pool(3).install(|| {
            let here = std::thread::current().id();
            let (start, helped) = (Instant::now(), AtomicBool::new(false));
            while !helped.load(Ordering::Relaxed) {
                assert!(start.elapsed() < Duration::from_secs(60), "nobody came");
                passes(1, 3, || {
                    if std::thread::current().id() != here {
                        helped.store(true, Ordering::Relaxed);
                    }
                });
            }
        });
    }

    /// Helpers of one team may be the threads of others, and what they are called to while these wait may be help.
    #[test]
    fn teams_may_share_a_pool() {
        pool(3).install(|| {
            rayon::scope(|scope| {
                for parts in [2, 3, 5, 9] {
                    scope.spawn(move |_| {
                        passes(500, parts, || {
                            let both = rayon::join(|| 1, || 2);
                            assert_eq!(both, (1, 2));
                        });
                    });
                }
            });
        });
    }

    #[test]
    fn a_part_may_have_parts() {
        pool(4).install(|| passes(50, 4, || passes(3, 3, || {})));
    }

    /// Other jobs of the pool get their turn while passes are shared out.
    #[test]
    fn helpers_hold_nothing_up() {
        pool(2).install(|| {
            let (start, done) = (Instant::now(), Arc::new(AtomicBool::new(false)));
            passes(100, 2, || {});
            let job = done.clone();
            rayon::spawn(move || job.store(true, Ordering::Relaxed));
            while !done.load(Ordering::Relaxed) {
                assert!(start.elapsed() < Duration::from_secs(60), "the job waits");
                passes(10, 2, || {});
            }
        });
    }

    /// A panic in any part comes out of `share` after all others are done, and the team goes on.
    #[test]
    fn panics_come_back() {
        pool(3).install(|| {
            for wrong in [0, 1, 2, 3] {
                let done = AtomicUsize::new(0);
                let part = |part: usize| {
                    assert_ne!(part, wrong, "as it should");
                    done.fetch_add(1, Ordering::Relaxed);
                };
                let all = AssertUnwindSafe(|| share(4, || part(0), &part));
                assert!(catch_unwind(all).is_err());
                assert_eq!(done.into_inner(), 3);
                passes(10, 4, || {});
            }
        });
    }

    /// Where nothing is shared out any more, helpers leave.
    #[test]
    fn helpers_leave() {
        pool(2).install(|| {
            passes(100, 2, || {});
            let start = Instant::now();
            while TEAM.with(|team| team.called.0.load(Ordering::Relaxed)) != 1 {
                assert!(start.elapsed() < Duration::from_secs(60), "a helper stays");
                std::thread::yield_now();
            }
        });
    }
}
