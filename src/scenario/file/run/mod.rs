//! A scene that runs: what is built, what acts on it, and what is watched.

mod channels;
mod trace;

use super::super::Run;
use super::build::RunError;
use super::model::{Quantity, Scenario, Stop};
use super::outcome::Outcome;
use super::reduce::rounding;
use channels::Follows;
pub use channels::Series;
use trace::Trace;

/// A scene of a file on its way.
pub struct ScenarioRun {
    /// The worlds, the recorder, who is who.
    pub run: Run,
    /// What is run.
    pub scenario: Scenario,
    trace: Trace,
    follows: Follows,
    calm_since: Option<f64>,
    stopped: bool,
}

impl Scenario {
    /// Builds the scene and watches what its probes and expectations need.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn start(&self) -> Result<ScenarioRun, RunError> {
        let mut run = self.build()?;
        self.nothing_late(run.total_steps() as f64 * self.world.dt)?;
        let follows = Follows::begin(self, &mut run)?;
        let trace = Trace::begin(&run);
        Ok(ScenarioRun {
            run,
            scenario: self.clone(),
            trace,
            follows,
            calm_since: None,
            stopped: false,
        })
    }

    /// Complains of what would have to be looked at after the end of the run \[s\].
    fn nothing_late(&self, end: f64) -> Result<(), RunError> {
        let end = end.max(self.world.duration);
        let frames = self.frames.iter().map(|time| ("frames".to_owned(), *time));
        let looks = self.expect.iter().enumerate().filter_map(|(i, e)| {
            let time = match (&e.that, e.over) {
                (Quantity::At { time, .. }, _) => *time,
                (_, over) => over?[1],
            };
            Some((format!("expect[{i}]"), time))
        });
        let late = |(_, time): &(String, f64)| *time > end + rounding(end);
        match frames.chain(looks).find(late) {
            Some((what, time)) => Err(RunError::Late { what, time, end }),
            None => Ok(()),
        }
    }

    /// Runs the scene to its end and looks at what was expected.
    ///
    /// # Errors
    /// [`RunError`]. An expectation that is not met is no error, see [`Outcome::passed`].
    ///
    /// ```
    /// use crumple::scenario::file::{LoadOptions, Scenario};
    /// let text = r#"(
    ///     world: (duration: 0.5),
    ///     deformables: [(name: "stone", body: Net(nodes: [(at: (0, 0, 0), mass: 2)]))],
    ///     expect: [(that: Final(Velocity(of: "stone", axis: Y)), equals: "-9.81 * 0.5", within: 1e-3)],
    /// )"#;
    /// let scene = Scenario::parse(text, "stone.ron".as_ref(), &LoadOptions::default())?;
    /// let outcome = scene.run()?;
    /// assert!(outcome.passed(), "{outcome}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn run(&self) -> Result<Outcome, RunError> {
        let mut run = self.start()?;
        run.finish(|_| {});
        run.outcome()
    }
}

impl ScenarioRun {
    /// Makes a step; `false` once the run is over.
    pub fn step(&mut self) -> bool {
        if self.stopped {
            return false;
        }
        if !self.run.step() {
            return false;
        }
        self.trace.sample(&self.run);
        if self.is_over() {
            self.stopped = true;
            self.run.take_last_frame();
        }
        true
    }

    /// Steps to the end; `progress` is told the steps made.
    pub fn finish(&mut self, mut progress: impl FnMut(u64)) {
        while self.step() {
            progress(self.run.steps);
        }
    }

    /// What came out.
    ///
    /// # Errors
    /// [`RunError::Signal`] for a channel that can't be evaluated.
    pub fn outcome(self) -> Result<Outcome, RunError> {
        Outcome::of(self)
    }

    fn is_over(&mut self) -> bool {
        let now = self.run.deformables.time();
        match self.scenario.world.stop {
            None => false,
            Some(Stop::Broken) => self.run.recorder.broken > 0 || self.trace.attachments_broken > 0,
            Some(Stop::AtRest { speed, during }) => {
                let calm = self.trace.fastest.last().is_some_and(|v| *v <= speed);
                if !calm {
                    self.calm_since = None;
                    return false;
                }
                let since = *self.calm_since.get_or_insert(now);
                now - since >= during - 1.0e-9
            }
        }
    }

    /// Events that were counted, for quantities.
    pub(super) fn count(&self, quantity: &Quantity) -> Option<f64> {
        Some(match quantity {
            Quantity::AttachmentsBroken => self.trace.attachments_broken as f64,
            Quantity::ContactsBegun => self.trace.contacts_begun as f64,
            Quantity::Yielded => self.run.recorder.yielded as f64,
            Quantity::Broken => self.run.recorder.broken as f64,
            _ => return None,
        })
    }

    /// From when on nothing was faster than `speed` \[s\]; infinite if something is at the end.
    pub(super) fn rest_time(&self, speed: f64) -> f64 {
        let fast = self.trace.fastest.iter().rposition(|v| *v > speed);
        let rest = fast.map_or(Some(0), |i| Some(i + 1));
        let time = rest.and_then(|i| self.trace.times.get(i));
        time.copied().unwrap_or(f64::INFINITY)
    }
}
