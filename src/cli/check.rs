//! `check` and `test`: scene files held against the format, and against what they expect.

use super::Failure;
use crumple::scenario::file::{
    LoadError, LoadOptions, Scenario, embedded_names, nearest_embedded, scenes_in,
};
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(clap::Args)]
pub struct CheckArguments {
    /// Scene files, folders of them, and names of scenes; see `crumple list`.
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
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
    for scene in &arguments.scenes {
        // Names before folders, as `run` has it.
        if let Some(name) = embedded_names().find(|n| scene == Path::new(n)) {
            problems.extend(problem(scene, Scenario::embedded(name, &options)));
        } else if scene.is_dir() {
            match scenes_of(scene) {
                Ok(files) => problems.extend(
                    files
                        .iter()
                        .filter_map(|(_, file)| problem(file, Scenario::load(file, &options))),
                ),
                Err(failure) => problems.push(super::chain(&failure)),
            }
        } else if scene.exists() {
            problems.extend(problem(scene, Scenario::load(scene, &options)));
        } else {
            problems.push(unknown(scene));
        }
    }
    match problems.is_empty() {
        true => Ok(()),
        false => Err(Failure::Wrong(problems.join("\n"))),
    }
}

/// What is wrong with a scene, and be it what only its bodies know of; says so where nothing is.
fn problem(name: &Path, loaded: Result<Scenario, LoadError>) -> Option<String> {
    let started = loaded.map_err(|e| e.to_string()).and_then(|scene| {
        let started = scene.start().map(|_| ());
        started.map_err(|e| format!("{}: {e}", name.display()))
    });
    match started {
        Ok(()) => {
            say_line!("{}: ok", name.display());
            None
        }
        Err(problem) => Some(problem),
    }
}

/// What to say of what is neither a file nor a scene.
fn unknown(scene: &Path) -> String {
    let name = scene.display().to_string();
    let near = nearest_embedded(&name).map(|n| format!("; did you mean `{n}`?"));
    format!(
        "there is no scene and no file `{name}`{}",
        near.unwrap_or_default()
    )
}

/// The scene files of a folder, of which there must be one.
fn scenes_of(folder: &Path) -> Result<Vec<(String, PathBuf)>, Failure> {
    let scenes = scenes_in(folder).map_err(|source| Failure::Read {
        path: folder.to_owned(),
        source,
    })?;
    if scenes.is_empty() {
        let what = format!("{} has no scene files (.ron, .json)", folder.display());
        return Err(Failure::Wrong(what));
    }
    Ok(scenes)
}

pub fn test(arguments: &TestArguments) -> Result<(), Failure> {
    let options = LoadOptions {
        allow_outside: arguments.allow_outside,
        ..LoadOptions::default()
    };
    let scenes = scenes_of(&arguments.folder)?;
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
