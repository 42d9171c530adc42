//! Worlds with a recorder and figures, ready to run.
//!
//! A scene is defined once and used by tests, examples, benches and the command line, so that the picture in the
//! documentation, the number in a test and what a user sees are the same run. What may vary without its being another
//! scene (step, substeps, cells, duration) is in [`Options`]; everything else is the scene.

pub mod cantilever;
pub mod car;
pub mod catalog;
pub mod cradle;
pub mod drop;
pub mod figures;
pub mod file;
pub mod gripper;
pub mod pile;
pub mod pole;
pub mod rubber_drop;
pub mod run;
pub mod slalom;
pub mod speed;
pub mod survey;
pub mod terrain;
pub mod thin_plate;
pub mod trampoline;
pub mod wall;

pub use catalog::{UnknownScene, all, find};
pub use figures::{Figure, Figures};
pub use run::{Cast, Run};

use crate::body::BuildError;
use crate::import::ImportError;
use crate::record::{RecordError, SignalError};
use crate::world::AttachError;
use file::{LoadError, LoadOptions, RunError, Scenario};

/// What may vary in a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Step of the world \[s\].
    pub dt: f64,
    /// Simulated time \[s\].
    pub duration: f64,
    /// Fraction of the longest stable substep that is used, in (0, 1].
    pub safety: f64,
    /// Cell of the lattices \[m\].
    pub cell: f64,
}

/// A scene of the catalog.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Its name on the command line.
    pub name: &'static str,
    /// What happens in it, in one line.
    pub about: &'static str,
    /// Its usual options.
    pub options: Options,
    /// Builds it.
    build: fn(&Options) -> Result<Run, SceneError>,
    /// Evaluates a finished run.
    figures: fn(&Run) -> Result<Figures, SceneError>,
}

/// Why a scene can't be built or evaluated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// An option is out of range.
    #[error("{what} is {value}, it must be {must}")]
    Option {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A mesh can't be read.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A body can't be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// Something can't be attached.
    #[error(transparent)]
    Attach(#[from] AttachError),
    /// Something can't be recorded.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A recording gives no signal.
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// The file of the scene can't be read.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// What the file says can't be built.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The run lacks something its figures are about.
    #[error("the run has no {0}")]
    Missing(&'static str),
}

impl Scene {
    /// Builds the scene, ready to be stepped.
    ///
    /// # Errors
    /// [`SceneError::Option`] for an option out of range, and whatever building can fail with.
    pub fn build(&self, options: &Options) -> Result<Run, SceneError> {
        let unit = "above 0 and at most 1";
        for (what, value, most, must) in [
            ("the step dt", options.dt, 0.1, "above 0 and at most 0.1 s"),
            (
                "the duration",
                options.duration,
                60.0,
                "above 0 and at most 60 s",
            ),
            (
                "the safety factor of the substep",
                options.safety,
                1.0,
                unit,
            ),
            ("the cell", options.cell, 1.0, "above 0 and at most 1 m"),
        ] {
            if !(value > 0.0 && value <= most) {
                return Err(SceneError::Option { what, value, must });
            }
        }
        (self.build)(options)
    }

    /// The figures of a run of this scene.
    ///
    /// # Errors
    /// [`SceneError`] where a channel can't be evaluated.
    pub fn figures(&self, run: &Run) -> Result<Figures, SceneError> {
        (self.figures)(run)
    }
}

/// The scene of a file that comes with the crate, its variables set to these options.
fn file(name: &str, options: &Options) -> Result<Scenario, SceneError> {
    let set = [
        ("dt", options.dt),
        ("duration", options.duration),
        ("safety", options.safety),
        ("cell", options.cell),
    ];
    let options = LoadOptions {
        set: set.map(|(name, value)| (name.into(), value)).into(),
        ..LoadOptions::default()
    };
    Ok(Scenario::embedded(name, &options)?)
}

/// Builds the scene of a file.
fn from_file(name: &str, options: &Options) -> Result<Run, SceneError> {
    Ok(file(name, options)?.build()?)
}
