//! Work on one large body, shared out to threads.
//!
//! A pass goes over blocks of rows, nodes or elements that own what they write, so it can be cut between any two of them and
//! its parts run at once. Sums are kept by block, of a size that never changes, and added in the order of blocks: so results
//! are the same to the last bit for any number of threads, and without any.
//!
//! A pass takes some microseconds, and handing work to a pool from outside costs ten. So nothing is shared out but by a caller
//! that is within a pool of Rayon already: the world enters one once per step, and so may anyone who has a
//! [`Solver`](super::Solver) of his own.

#[cfg(feature = "parallel")]
mod team;

#[cfg(feature = "parallel")]
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Nodes, or rows of a table of springs, that are summed together. Few, so that bodies of ten thousand springs can be shared
/// out evenly.
pub(crate) const BLOCK: usize = 128;

/// Work on blocks that follow each other.
#[cfg_attr(not(feature = "parallel"), allow(dead_code))]
pub(crate) trait Work: Sized + Send {
    /// How many there are.
    fn blocks(&self) -> usize;
    /// The first so many, and the others.
    fn cut(self, at: usize) -> [Self; 2];
}

/// Does all of it, in so many parts at once.
pub(crate) fn share<W: Work>(work: W, parts: usize, each: &(impl Fn(W) + Sync)) {
    #[cfg(feature = "parallel")]
    {
        // Room for no more than need be, since it is cleared.
        match parts.min(work.blocks()) {
            0 | 1 => {}
            2 => return pieces::<2, W>(work, 2, each),
            few @ 3..=8 => return pieces::<8, W>(work, few, each),
            many => return pieces::<{ team::MOST }, W>(work, many.min(team::MOST), each),
        }
    }
    let _ = parts;
    each(work);
}

/// Cuts work in so many pieces, and has them done at once.
#[cfg(feature = "parallel")]
fn pieces<const ROOM: usize, W: Work>(work: W, parts: usize, each: &(impl Fn(W) + Sync)) {
    let blocks = work.blocks();
    let size = |part| blocks * (part + 1) / parts - blocks * part / parts;
    let [first, mut rest] = work.cut(size(0));
    let pieces = [const { Mutex::new(None) }; ROOM];
    for (part, place) in pieces.iter().enumerate().take(parts - 1).skip(1) {
        let [piece, others] = rest.cut(size(part));
        *lock(place) = Some(piece);
        rest = others;
    }
    *lock(&pieces[parts - 1]) = Some(rest);
    team::share(parts, || each(first), &|part| {
        let piece = lock(&pieces[part]).take();
        piece.into_iter().for_each(each);
    });
}

#[cfg(feature = "parallel")]
fn lock<T>(piece: &Mutex<T>) -> MutexGuard<'_, T> {
    piece.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The least springs that are worth a part. In two parts a mesh in order of 4,200 springs is moved 1.16 times as fast as alone, one of 7,900
/// 1.33 times; where it does not pay, a body finds that out ([`Gauge`](super::gauge::Gauge)).
#[cfg(feature = "parallel")]
const LEAST: usize = 2_500;

/// A node takes about as long to be moved as so many springs.
pub(crate) const NODE: usize = 5;

#[cfg(feature = "parallel")]
thread_local! {
    /// In how many parts this thread shares out the passes of what it is about.
    static PARTS: std::cell::Cell<usize> = const { std::cell::Cell::new(1) };
}

/// Does something of which every pass is shared out in so many parts: the same for all, so that threads find in their caches what
/// they wrote there in the pass before.
pub(crate) fn in_parts<R>(parts: usize, work: impl FnOnce() -> R) -> R {
    #[cfg(feature = "parallel")]
    {
        struct Before(usize);
        impl Drop for Before {
            fn drop(&mut self) {
                PARTS.set(self.0);
            }
        }
        // While a thread waits for others it may do the work of another body; and a force field may panic.
        let _before = Before(PARTS.replace(parts));
        work()
    }
    #[cfg(not(feature = "parallel"))]
    {
        let _ = parts;
        work()
    }
}

/// In how many parts a pass is to be done.
pub(crate) fn parts() -> usize {
    #[cfg(feature = "parallel")]
    return PARTS.get();
    #[cfg(not(feature = "parallel"))]
    return 1;
}

/// In how many parts passes over as much as so many springs can be done.
pub(crate) fn parts_of(springs: usize) -> usize {
    #[cfg(feature = "parallel")]
    if springs >= 2 * LEAST && rayon::current_thread_index().is_some() {
        return rayon::current_num_threads().min(springs / LEAST);
    }
    let _ = springs;
    1
}

/// Whether all threads are awake that this one has called: that takes longer than many a pass.
pub(crate) fn are_awake() -> bool {
    #[cfg(feature = "parallel")]
    return team::is_complete();
    #[cfg(not(feature = "parallel"))]
    return true;
}

/// Whether it is worth calling threads for as much as so many springs.
pub(crate) fn is_worth_sharing(springs: usize) -> bool {
    #[cfg(feature = "parallel")]
    return springs >= 2 * LEAST && rayon::current_num_threads() > 1;
    #[cfg(not(feature = "parallel"))]
    return springs == usize::MAX;
}

/// Does something within the pool of the caller, or Rayon's global one.
pub(crate) fn within(work: impl FnOnce() + Send) {
    #[cfg(feature = "parallel")]
    rayon::scope(|_| work());
    #[cfg(not(feature = "parallel"))]
    work();
}

/// Does something with each of a list at once, begun in its order.
pub(crate) fn each<T: Send>(list: Vec<T>, work: impl Fn(T) + Sync) {
    #[cfg(feature = "parallel")]
    rayon::scope_fifo(|scope| {
        let work = &work;
        for item in list {
            scope.spawn_fifo(move |_| work(item));
        }
    });
    #[cfg(not(feature = "parallel"))]
    list.into_iter().for_each(work);
}

/// Values by nodes, cut in blocks.
pub(crate) struct Nodes<'a, T> {
    /// The number of the first.
    pub first: usize,
    pub values: &'a mut [T],
}

impl<T: Send> Work for Nodes<'_, T> {
    fn blocks(&self) -> usize {
        self.values.len().div_ceil(BLOCK)
    }

    fn cut(self, at: usize) -> [Self; 2] {
        let (values, rest) = self.values.split_at_mut(BLOCK * at);
        let first = self.first;
        [
            Self { first, values },
            Self {
                first: first + BLOCK * at,
                values: rest,
            },
        ]
    }
}
