//! The log of a sweep: one JSON line per finished variant, safe against being killed at any moment.
//!
//! A line is written in one call with its end. What a killed writer left of a line has no end and is cut off when the log is
//! opened again; everything before it is whole.

use super::axis::AxisError;
use crate::scenario::file::LoadError;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The files of a sweep.
pub(super) const IDENTITY: &str = "sweep.json";
pub(super) const RESULTS: &str = "results.jsonl";
const TIMINGS: &str = "timings.jsonl";
const LOCK: &str = "sweep.lock";

/// Why a sweep can't be run or merged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The axes can't be meant.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// The scene can't be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A file can't be read or written.
    #[error("can't read or write {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A folder has the log of another sweep.
    #[error(
        "{} has another sweep: another scene, other variables or other values; take another folder",
        path.display()
    )]
    Other {
        /// The folder.
        path: PathBuf,
    },
    /// Two logs have one variant with different results.
    #[error("variant {variant} has different results in {} than elsewhere", path.display())]
    Differs {
        /// Which.
        variant: usize,
        /// The folder of the second.
        path: PathBuf,
    },
    /// Another sweep is writing into the folder.
    #[error("{} is being written by another sweep; wait for it, or take another folder", path.display())]
    Busy {
        /// The folder.
        path: PathBuf,
    },
    /// There is no log.
    #[error("{} has no sweep", path.display())]
    NoSweep {
        /// The folder.
        path: PathBuf,
    },
    /// A worker has panicked.
    #[error("a worker has ended before its work")]
    Worker,
}

pub(super) fn failed(path: &Path) -> impl FnOnce(io::Error) -> SweepError {
    let path = path.to_owned();
    move |source| SweepError::File { path, source }
}

/// The log of a sweep, open for more.
pub struct Log {
    results: File,
    timings: File,
    folder: PathBuf,
    done: BTreeSet<usize>,
    /// Held as long as the log is open; the system lets it go with the process, however that ends.
    _lock: File,
}

impl Log {
    /// Opens the log in a folder, or begins one.
    ///
    /// # Errors
    /// [`SweepError::Busy`] if another process has it open, [`SweepError::Other`] for the log of a sweep with another
    /// `identity`, [`SweepError::File`].
    pub fn open(folder: &Path, identity: &Value) -> Result<Self, SweepError> {
        std::fs::create_dir_all(folder).map_err(failed(folder))?;
        let lock = locked(folder)?;
        let path = folder.join(IDENTITY);
        let identity = format!("{identity:#}\n");
        match std::fs::read_to_string(&path) {
            Ok(before) if before == identity => {}
            Ok(_) => {
                return Err(SweepError::Other {
                    path: folder.into(),
                });
            }
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                // Whole or not at all.
                let draft = folder.join("sweep.json.part");
                std::fs::write(&draft, &identity).map_err(failed(&draft))?;
                std::fs::rename(&draft, &path).map_err(failed(&path))?;
            }
            Err(e) => return Err(failed(&path)(e)),
        }
        let mut log = Self {
            results: whole_lines(&folder.join(RESULTS))?,
            timings: whole_lines(&folder.join(TIMINGS))?,
            folder: folder.into(),
            done: BTreeSet::new(),
            _lock: lock,
        };
        log.done = read(folder)?
            .into_iter()
            .map(|(variant, _)| variant)
            .collect();
        Ok(log)
    }

    /// Whether a variant is finished.
    pub fn has(&self, variant: usize) -> bool {
        self.done.contains(&variant)
    }

    /// Adds a finished variant, and how long it took \[s\].
    ///
    /// # Errors
    /// [`SweepError::File`].
    pub fn append(&mut self, variant: usize, line: &Value, seconds: f64) -> Result<(), SweepError> {
        let timing = json!({ "variant": variant, "wall_s": seconds });
        let write = |file: &mut File, value: &Value, name: &str| {
            let line = format!("{value}\n");
            let written = file.write_all(line.as_bytes()).and_then(|()| file.flush());
            written.map_err(failed(&self.folder.join(name)))
        };
        write(&mut self.results, line, RESULTS)?;
        write(&mut self.timings, &timing, TIMINGS)?;
        self.done.insert(variant);
        Ok(())
    }
}

/// Takes the lock of a folder.
fn locked(folder: &Path) -> Result<File, SweepError> {
    let path = folder.join(LOCK);
    let file = File::create(&path).map_err(failed(&path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(SweepError::Busy {
            path: folder.into(),
        }),
        // Some file systems have no locks.
        Err(TryLockError::Error(e)) if e.kind() == io::ErrorKind::Unsupported => Ok(file),
        Err(TryLockError::Error(source)) => Err(failed(&path)(source)),
    }
}

/// Opens a file at the end of its last whole line.
fn whole_lines(path: &Path) -> Result<File, SweepError> {
    let mut options = OpenOptions::new();
    let options = options.read(true).append(true).create(true);
    let file = options.open(path).map_err(failed(path))?;
    let text = std::fs::read(path).map_err(failed(path))?;
    let end = text.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
    if end < text.len() {
        file.set_len(end as u64).map_err(failed(path))?;
    }
    Ok(file)
}

/// The finished variants of a folder with their lines, in the order of the log.
pub(super) fn read(folder: &Path) -> Result<Vec<(usize, String)>, SweepError> {
    let path = folder.join(RESULTS);
    // A line cut short may end within a character.
    let bytes = std::fs::read(&path).map_err(failed(&path))?;
    let text = String::from_utf8_lossy(&bytes);
    let whole = text.split_inclusive('\n').filter(|l| l.ends_with('\n'));
    let lines = whole.filter_map(|line| {
        let value: Value = serde_json::from_str(line).ok()?;
        let variant = value.get("variant")?.as_u64()?;
        Some((variant as usize, line.to_owned()))
    });
    Ok(lines.collect())
}
