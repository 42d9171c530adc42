//! Work on one large body, shared out to threads.
//!
//! A pass goes over blocks of rows, nodes or elements that own what they write, so it can be cut between any two of them and
//! its parts run at once. Sums are kept by block, of a size that never changes, and added in the order of blocks: so results
//! are the same to the last bit for any number of threads, and without any.
//!
//! A pass takes tens of microseconds, and handing work to a pool from outside costs ten. So nothing is shared out but by a
//! caller that is within a pool of Rayon already: the world enters one once per step, and so may anyone who has a
//! [`Solver`](super::Solver) of his own.

/// Nodes, or rows of a table of springs, that are summed together. Few, so that bodies of ten thousand springs can be shared
/// out evenly.
pub(crate) const BLOCK: usize = 256;

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
    if parts.min(work.blocks()) > 1 {
        let parts = parts.min(work.blocks());
        let first = parts / 2;
        let at = work.blocks() * first / parts;
        let [work, rest] = work.cut(at);
        rayon::join(
            || share(work, first, each),
            || share(rest, parts - first, each),
        );
        return;
    }
    let _ = parts;
    each(work);
}

/// The least springs that are worth a part. In two parts, bodies of 10,000 springs take 0.84 (a mesh that yields) to 1.2 times as
/// long alone, those of 60,000 0.98 to 1.76 times (`benches/threads.rs`): a guess on the generous side.
#[cfg(feature = "parallel")]
const LEAST: usize = 4_000;

/// A node takes about as long to be moved as so many springs.
pub(crate) const NODE: usize = 5;

#[cfg(feature = "parallel")]
thread_local! {
    /// Whether what this thread is about may be shared out.
    static SHARING: std::cell::Cell<bool> = const { std::cell::Cell::new(true) };
}

/// Does something of which passes are shared out, or are not.
pub(crate) fn sharing<R>(shared: bool, work: impl FnOnce() -> R) -> R {
    #[cfg(feature = "parallel")]
    {
        // While a thread waits for others it may do the work of another body.
        let before = SHARING.replace(shared);
        let result = work();
        SHARING.set(before);
        result
    }
    #[cfg(not(feature = "parallel"))]
    {
        let _ = shared;
        work()
    }
}

/// In how many parts a pass over as much as so many springs is to be done.
#[cfg(feature = "parallel")]
pub(crate) fn parts(springs: usize) -> usize {
    if springs < 2 * LEAST || rayon::current_thread_index().is_none() || !SHARING.get() {
        return 1;
    }
    rayon::current_num_threads().min(springs / LEAST)
}

/// In how many parts a pass over as much as so many springs is to be done: there are no threads.
#[cfg(not(feature = "parallel"))]
pub(crate) fn parts(_springs: usize) -> usize {
    1
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
