//! The commands.

#[macro_use]
mod say;
pub mod check;
pub mod keys;
pub mod run;
mod scene;
pub mod speed;
pub mod sweep;
mod write;

use crumple::record::{CsvError, FilterError};
use crumple::report::ReportError;
use crumple::scenario::file::sweep::{AxisError, SweepError};
use crumple::scenario::file::{LoadError, LoadOptions, RunError, Scenario, embedded_names};
use crumple::scenario::{self, SceneError, UnknownScene};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};

#[derive(Debug, thiserror::Error)]
pub enum Failure {
    #[error(transparent)]
    Unknown(#[from] UnknownScene),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Load(#[from] LoadError),
    #[error(transparent)]
    Run(#[from] RunError),
    #[error(transparent)]
    Sweep(#[from] SweepError),
    #[error(transparent)]
    Csv(#[from] CsvError),
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error(transparent)]
    Filter(#[from] FilterError),
    #[error("can't write {}", path.display())]
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("can't read {}", path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{0}")]
    Wrong(String),
    /// Something did not come to what was expected, which has been said already.
    #[error("not what was expected")]
    Expectation,
}

/// An error with its causes, in one line.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        let cause_text = cause.to_string();
        if !text.contains(&cause_text) {
            text = format!("{text}: {cause_text}");
        }
        source = cause.source();
    }
    text
}

pub fn list() {
    for scene in scenario::all() {
        say_line!("{:18} {}", scene.name, scene.about);
    }
    for name in embedded_names().filter(|n| scenario::find(n).is_err()) {
        if let Ok(scene) = Scenario::embedded(name, &LoadOptions::default()) {
            say_line!("{name:18} {}", scene.about);
        }
    }
}

/// How a scene file is found, and what is said of it.
#[derive(clap::Args)]
pub struct SceneArguments {
    /// A scene file, or the name of a scene; see `crumple list`.
    name: String,
    /// Another value of a variable of the scene; may be given several times.
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    set: Vec<(String, f64)>,
    /// Another seed.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Files outside of the scene's folder may be read.
    #[arg(long)]
    allow_outside: bool,
}

fn assignment(text: &str) -> Result<(String, f64), String> {
    let form = || format!("`{text}` must be written name=value");
    let (name, value) = text.split_once('=').ok_or_else(form)?;
    let value: Option<f64> = value.trim().parse().ok();
    let value = value.filter(|x| x.is_finite());
    let value = value.ok_or_else(|| format!("the value of `{name}` is no finite number"))?;
    Ok((name.trim().into(), value))
}

impl SceneArguments {
    fn options(&self) -> LoadOptions {
        LoadOptions {
            set: self.set.clone(),
            seed: self.seed,
            allow_outside: self.allow_outside,
        }
    }

    /// Whether a file is meant and not a name.
    fn is_file(&self) -> bool {
        let path = Path::new(&self.name);
        path.extension().is_some_and(|e| e == "ron" || e == "json")
    }

    /// Loads the scene of a file, on disk or in the crate; `None` for a name that no file has.
    fn load(&self, options: &LoadOptions) -> Option<Result<Scenario, LoadError>> {
        if self.is_file() {
            return Some(Scenario::load(&self.name, options));
        }
        let known = embedded_names().any(|n| n == self.name);
        known.then(|| Scenario::embedded(&self.name, options))
    }

    /// What outputs are called after.
    fn stem(&self) -> &str {
        let stem = Path::new(&self.name).file_stem().and_then(|s| s.to_str());
        stem.unwrap_or(&self.name)
    }
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> Failure {
    let path = path.to_owned();
    move |source| Failure::Write { path, source }
}

fn make_writable(out: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(out).map_err(failed(out))?;
    let probe = out.join("summary.json");
    std::fs::write(&probe, "{}\n").map_err(failed(&probe))
}

fn progress(steps: u64, quiet: bool, unit: &str) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(steps);
    let template = format!("{{bar:40}} {{pos}}/{{len}} {unit}, {{eta}} left");
    bar.set_style(
        ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    bar
}

impl From<AxisError> for Failure {
    fn from(error: AxisError) -> Self {
        Self::Sweep(error.into())
    }
}
