//! Many runs of one scene with other values of its variables.
//!
//! Each variant is a deterministic run of its own, so a sweep is a list of numbered variants and a log of finished ones. The
//! log gets one line per variant as it finishes; whoever was killed reads it and goes on with what is missing. Merging sorts
//! the lines and drops nothing else, so what is merged does not depend on who finished when. What does, the wall clock, is
//! in a log of its own.

mod axis;
mod log;
mod merge;

pub use axis::{AxisError, SweepAxis, Variant, variants};
pub use log::{Log, SweepError};
pub use merge::{Merged, merge};

use super::{LoadError, LoadOptions, Scenario};
use serde_json::{Map, Value, json};
use std::ops::Range;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// A scene with the values its variables take.
pub struct Sweep<'a> {
    /// Gives the scene for some values of its variables.
    pub load: &'a (dyn Fn(&LoadOptions) -> Result<Scenario, LoadError> + Sync),
    /// What is the same in all variants; the values of the axes win.
    pub options: LoadOptions,
    /// The variables that change.
    pub axes: Vec<SweepAxis>,
    /// How many run at once.
    pub jobs: usize,
    /// Which variants are run, by their numbers from 0; all without it.
    pub only: Option<Range<usize>>,
}

impl Sweep<'_> {
    /// Runs every variant that the log in `out` does not have yet; `progress` is told how many are done, of how many.
    ///
    /// # Errors
    /// [`SweepError`]: a scene that can't be loaded with the first values, a log that can't be written or is one of another
    /// sweep. A variant that fails is not an error: its line says so.
    pub fn run(
        &self,
        out: &Path,
        progress: impl Fn(usize, usize) + Sync,
    ) -> Result<(), SweepError> {
        let mut variants = variants(&self.axes)?;
        let base = (self.load)(&self.of(&variants[0]))?;
        let log = Log::open(out, &self.identity(&base))?;
        variants.retain(|v| {
            self.only
                .as_ref()
                .is_none_or(|only| only.contains(&v.index))
        });
        let total = variants.len();
        let missing: Vec<&Variant> = variants.iter().filter(|v| !log.has(v.index)).collect();
        let done = AtomicUsize::new(total - missing.len());
        progress(done.load(Ordering::Relaxed), total);
        let (next, log) = (AtomicUsize::new(0), Mutex::new(log));
        let work = || -> Result<(), SweepError> {
            while let Some(variant) = missing.get(next.fetch_add(1, Ordering::Relaxed)) {
                let start = Instant::now();
                let line = self.line(variant);
                let seconds = start.elapsed().as_secs_f64();
                // A poisoned lock is that of a thread that panicked while writing: the file is as good as a killed one's.
                let mut log = log.lock().unwrap_or_else(|e| e.into_inner());
                log.append(variant.index, &line, seconds)?;
                progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
            }
            Ok(())
        };
        std::thread::scope(|scope| {
            let jobs = self.jobs.clamp(1, total.max(1));
            let workers: Vec<_> = (0..jobs).map(|_| scope.spawn(work)).collect();
            for worker in workers {
                worker.join().unwrap_or(Err(SweepError::Worker))?;
            }
            Ok(())
        })
    }

    fn of(&self, variant: &Variant) -> LoadOptions {
        let mut options = self.options.clone();
        options.set.extend(variant.set.iter().cloned());
        options
    }

    /// What tells this sweep from another one: the scene with the first values, and the axes.
    fn identity(&self, base: &Scenario) -> Value {
        let scene = serde_json::to_string(base).unwrap_or_default();
        let hash = scene.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        let axes: Map<String, Value> = self
            .axes
            .iter()
            .map(|a| (a.name.clone(), json!(a.values)))
            .collect();
        let order: Vec<&str> = self.axes.iter().map(|a| a.name.as_str()).collect();
        json!({ "scene": format!("{hash:016x}"), "axes": axes, "order": order })
    }

    /// Runs a variant and says what came out, without anything that another run of it would say differently.
    fn line(&self, variant: &Variant) -> Value {
        let set: Map<String, Value> = variant
            .set
            .iter()
            .map(|(name, value)| (name.clone(), json!(value)))
            .collect();
        let mut line = json!({ "variant": variant.index, "set": set });
        let result = (self.load)(&self.of(variant)).map_err(|e| e.to_string());
        let outcome = result.and_then(|scene| scene.run().map_err(|e| e.to_string()));
        match outcome {
            Err(what) => line["error"] = what.into(),
            Ok(outcome) => {
                let checks = outcome
                    .checks
                    .iter()
                    .map(|c| json!({ "name": c.name, "measured": c.measured, "passed": c.passed }));
                line["checks"] = checks.collect();
                line["passed"] = outcome.passed().into();
                line["state_hash"] = outcome.state_hash.as_str().into();
                line["simulated_s"] = json!(outcome.run.run.deformables.time());
                let probes: Map<String, Value> = outcome
                    .probes
                    .iter()
                    .map(|(name, series)| (name.clone(), digest(series)))
                    .collect();
                line["probes"] = probes.into();
            }
        }
        line
    }
}

/// What a sweep keeps of a probe.
fn digest(series: &super::Series) -> Value {
    json!({
        "peak": series.peak().0,
        "lowest": series.lowest().0,
        "mean": series.mean(),
        "final": series.last().0,
    })
}
