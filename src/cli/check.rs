//! `check` and `test`: scene files held against the format, and against what they expect.

use super::Failure;
use crumple::scenario::file::{LoadOptions, Scenario, scenes_in};
use std::path::PathBuf;
use std::time::Instant;

#[derive(clap::Args)]
pub struct CheckArguments {
    /// Scene files.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Files outside of the scenes' folders may be read.
    #[arg(long)]
    allow_outside: bool,
}

#[derive(clap::Args)]
pub struct TestArguments {
    /// A folder with scene files.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// The scenes that take long as well.
    #[arg(long)]
    slow: bool,
    /// Files outside of the folder may be read.
    #[arg(long)]
    allow_outside: bool,
}

pub fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    let options = LoadOptions {
        allow_outside: arguments.allow_outside,
        ..LoadOptions::default()
    };
    let mut problems = Vec::new();
    for file in &arguments.files {
        match Scenario::load(file, &options) {
            Ok(_) => say_line!("{}: ok", file.display()),
            Err(error) => problems.push(error.to_string()),
        }
    }
    match problems.is_empty() {
        true => Ok(()),
        false => Err(Failure::Wrong(problems.join("\n"))),
    }
}

pub fn test(arguments: &TestArguments) -> Result<(), Failure> {
    let options = LoadOptions {
        allow_outside: arguments.allow_outside,
        ..LoadOptions::default()
    };
    let folder = &arguments.folder;
    let scenes = scenes_in(folder).map_err(|source| Failure::Read {
        path: folder.clone(),
        source,
    })?;
    if scenes.is_empty() {
        let what = format!("{} has no scene files (.ron, .json)", folder.display());
        return Err(Failure::Wrong(what));
    }
    let (mut passed, mut failed, mut wrong) = (0, 0, 0);
    for (name, path) in &scenes {
        let start = Instant::now();
        let outcome = match Scenario::load(path, &options) {
            Ok(scene) if scene.slow && !arguments.slow => {
                say_line!("{name}: left out, it is slow");
                continue;
            }
            Ok(scene) => scene.run().map_err(|e| e.to_string()),
            Err(error) => Err(error.to_string()),
        };
        match outcome {
            Ok(outcome) if outcome.passed() => {
                passed += 1;
                say_line!("{name}: ok, {:.1} s", start.elapsed().as_secs_f64());
            }
            Ok(outcome) => {
                failed += 1;
                say_line!("{name}: FAILED\n{outcome}");
            }
            Err(what) => {
                wrong += 1;
                say_line!("{name}: FAILED\n{what}\n");
            }
        }
    }
    say_line!("{passed} passed, {failed} failed, {wrong} can't be run");
    match (failed, wrong) {
        (0, 0) => Ok(()),
        _ => Err(Failure::Expectation),
    }
}
