//! What threads gain on one large body.

use super::{SceneError, Sizes};

/// A mesh whose nodes follow each other, see [`crate::body::Net::in_order`].
pub const ORDERED: &str = "mesh in order";

/// All threads against one.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Threads {
    /// What body.
    pub body: &'static str,
    /// How many.
    pub threads: usize,
    /// Springs of the body.
    pub springs: usize,
    /// Time of one over time of all by the clock on the wall, median of pairs measured in turn: on a busy machine it is less
    /// \[1\].
    pub speedup: f64,
    /// Why nothing was gained.
    pub note: Option<&'static str>,
}

#[cfg(not(feature = "parallel"))]
pub(super) fn threads(_: &Sizes) -> Result<Vec<Threads>, SceneError> {
    Ok(vec![Threads {
        body: ORDERED,
        threads: 1,
        springs: 0,
        speedup: 1.0,
        note: Some("built without the feature `parallel`"),
    }])
}

#[cfg(feature = "parallel")]
pub(super) fn threads(sizes: &Sizes) -> Result<Vec<Threads>, SceneError> {
    let [mesh, lattice] = super::kernels::bodies_of(sizes.thread_cells)?;
    let ordered = mesh.1.clone().in_order()?.0;
    let bodies = [(ORDERED, ordered), mesh, lattice].into_iter();
    bodies.map(|(body, net)| on(body, net, sizes)).collect()
}

#[cfg(feature = "parallel")]
fn on(body: &'static str, net: crate::body::Net, sizes: &Sizes) -> Result<Threads, SceneError> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let [one, many] = [1, all].map(Pool::new);
    let springs = net.springs.len();
    let mut subject = plain(net)?;
    let count = 200_000 / springs + 1;
    // The first substep makes the tables.
    for pool in [&one, &many] {
        pool.install(|| subject.substep());
    }
    let mut pair = || {
        let mut time = |pool: &Pool| pool.per_call(sizes.long, count, || subject.substep());
        time(&one) / time(&many)
    };
    let pairs = (0..3 * sizes.rounds).map(|_| pair());
    Ok(Threads {
        body,
        threads: all,
        springs,
        speedup: super::clock::median(pairs),
        note: (all == 1).then_some("the machine has one"),
    })
}

/// A body of springs that neither yield nor are damped.
#[cfg(feature = "parallel")]
fn plain(net: crate::body::Net) -> Result<super::subject::Subject, SceneError> {
    let material = crate::body::Material::elastic(1e6, 100.0);
    let blueprint = crate::body::Blueprint::resolve(net, |_| Some(material), None)?;
    let kernel = crate::solve::Kernel::Auto;
    Ok(super::subject::Subject::new(&blueprint, kernel, 0.0))
}

/// So many threads; the calling one where there can be no others.
#[cfg(feature = "parallel")]
#[derive(Debug)]
pub struct Pool(Option<rayon::ThreadPool>);

#[cfg(feature = "parallel")]
impl Pool {
    /// Of so many.
    pub fn new(threads: usize) -> Self {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        Self(pool.build().ok())
    }

    /// Does something in it.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Seconds per call in it by the clock on the wall: `count` calls at a time, for at least `least` s.
    pub fn per_call(&self, least: f64, count: usize, mut call: impl FnMut() + Send) -> f64 {
        self.install(|| {
            let start = std::time::Instant::now();
            for calls in 1.. {
                (0..count).for_each(|_| call());
                let spent = start.elapsed().as_secs_f64();
                if spent > least {
                    return spent / (calls * count) as f64;
                }
            }
            f64::NAN
        })
    }
}
