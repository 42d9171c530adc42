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

use super::model::{Body, Mesh, Shape};
use super::{LoadError, LoadOptions, Outcome, Scenario};
use crate::math::Fnv;
use serde_json::{Map, Value, json};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
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

/// How well the workers of a sweep were used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// How many workers there were.
    pub workers: usize,
    /// How long the sweep took \[s\].
    pub wall_s: f64,
    /// How long the workers were at variants, summed over them \[s\].
    pub busy_s: f64,
}

impl Pace {
    /// Share of the workers' time that they were at variants; 1 if there was nothing to do.
    pub fn busy_share(&self) -> f64 {
        match self.busy_s > 0.0 {
            true => self.busy_s / (self.workers as f64 * self.wall_s),
            false => 1.0,
        }
    }
}

impl Sweep<'_> {
    /// Runs every variant that the log in `out` does not have yet; `progress` is told how many are done, of how many.
    /// Gives how well the workers were used.
    ///
    /// # Errors
    /// [`SweepError`]: a scene that can't be loaded with the first values, a log that can't be written or is one of another
    /// sweep. A variant that fails is not an error: its line says so.
    pub fn run(
        &self,
        out: &Path,
        progress: impl Fn(usize, usize) + Sync,
    ) -> Result<Pace, SweepError> {
        let begun = Instant::now();
        let mut variants = variants(&self.axes)?;
        let base = (self.load)(&self.of(&variants[0]))?;
        let log = Log::open(out, &self.identity(&base)?)?;
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
        let work = || -> Result<f64, SweepError> {
            let mut busy_s = 0.0;
            while let Some(variant) = missing.get(next.fetch_add(1, Ordering::Relaxed)) {
                let start = Instant::now();
                let line = self.line(variant);
                let seconds = start.elapsed().as_secs_f64();
                busy_s += seconds;
                // A poisoned lock is that of a thread that panicked while writing: the file is as good as a killed one's.
                let mut log = log.lock().unwrap_or_else(|e| e.into_inner());
                log.append(variant.index, &line, seconds)?;
                progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
            }
            Ok(busy_s)
        };
        let workers = self.jobs.clamp(1, missing.len().max(1));
        let busy_s = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
            let ended = workers.into_iter().map(|worker| worker.join());
            ended
                .map(|busy_s| busy_s.unwrap_or(Err(SweepError::Worker)))
                .sum::<Result<f64, _>>()
        })?;
        Ok(Pace {
            workers,
            wall_s: begun.elapsed().as_secs_f64(),
            busy_s,
        })
    }

    fn of(&self, variant: &Variant) -> LoadOptions {
        let mut options = self.options.clone();
        options.set.extend(variant.set.iter().cloned());
        options
    }

    /// What tells this sweep from another one: the version of the crate, the scene with the first values, and the axes.
    /// Files that the scene names count by what is in them, wherever they lie.
    fn identity(&self, base: &Scenario) -> Result<Value, SweepError> {
        let mut scene = serde_json::to_string(base).unwrap_or_default();
        for path in named(base) {
            let bytes = std::fs::read(&path).map_err(log::failed(&path))?;
            let name = serde_json::to_string(&path).unwrap_or_default();
            scene = scene.replace(&name, &format!("{:016x}", Fnv::of_bytes(&bytes)));
            if let Ok(beside) = std::fs::read(path.with_extension("ele")) {
                scene += &format!("{:016x}", Fnv::of_bytes(&beside));
            }
        }
        let hash = Fnv::of_bytes(scene.as_bytes());
        let axes: Map<String, Value> = self
            .axes
            .iter()
            .map(|a| (a.name.clone(), json!(a.values)))
            .collect();
        let order: Vec<&str> = self.axes.iter().map(|a| a.name.as_str()).collect();
        let version = env!("CARGO_PKG_VERSION");
        Ok(json!({
            "crumple": version, "scene": format!("{hash:016x}"), "axes": axes, "order": order,
        }))
    }

    /// Runs a variant. One that panics is as one that can't be run: a thousand others wait.
    fn outcome(&self, variant: &Variant) -> Result<Outcome, String> {
        let run = || {
            let scene = (self.load)(&self.of(variant)).map_err(|e| e.to_string())?;
            scene.run().map_err(|e| e.to_string())
        };
        catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|cause| {
            let text = cause.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| cause.downcast_ref::<&str>().copied());
            Err(format!("it has panicked: {}", text.unwrap_or_default()))
        })
    }

    /// Runs a variant and says what came out, without anything that another run of it would say differently.
    fn line(&self, variant: &Variant) -> Value {
        let set: Map<String, Value> = variant
            .set
            .iter()
            .map(|(name, value)| (name.clone(), json!(value)))
            .collect();
        let mut line = json!({ "variant": variant.index, "set": set });
        match self.outcome(variant) {
            Err(what) => line["error"] = what.into(),
            Ok(outcome) => {
                let checks = outcome
                    .checks
                    .iter()
                    .map(|c| json!({ "name": c.name, "measured": number(c.measured), "passed": c.passed }));
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

/// The files that a scene names.
fn named(scene: &Scenario) -> Vec<PathBuf> {
    fn of_mesh(mesh: &Mesh, found: &mut Vec<PathBuf>) {
        if let Mesh::File(path) = mesh {
            found.push(path.clone());
        }
    }
    fn of_shape(shape: &Shape, found: &mut Vec<PathBuf>) {
        match shape {
            Shape::TriMesh(mesh) | Shape::Decomposition(mesh) => of_mesh(mesh, found),
            Shape::Compound(parts) => parts.iter().for_each(|p| of_shape(&p.shape, found)),
            _ => {}
        }
    }
    let mut found = Vec::new();
    for collider in scene.rigid.iter().flat_map(|body| &body.colliders) {
        of_shape(&collider.shape, &mut found);
    }
    for body in &scene.deformables {
        match &body.body {
            Body::Filled { mesh, .. } | Body::TetFilled { mesh, .. } => of_mesh(mesh, &mut found),
            Body::TetMesh(file) => found.push(file.0.clone()),
            _ => {}
        }
        body.embed.iter().for_each(|mesh| of_mesh(mesh, &mut found));
    }
    found
}

/// A number as JSON has it; inf and NaN, which it does not have, as texts.
pub fn number(x: f64) -> Value {
    match x.is_finite() {
        true => x.into(),
        false => x.to_string().into(),
    }
}

/// What a sweep keeps of a probe.
fn digest(series: &super::Series) -> Value {
    json!({
        "peak": number(series.peak().0),
        "lowest": number(series.lowest().0),
        "mean": number(series.mean()),
        "final": number(series.last().0),
    })
}
