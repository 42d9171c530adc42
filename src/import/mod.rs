//! Files made elsewhere, turned into what a body is made of.
//!
//! An importer ends at [`Surface`](crate::body::Surface): what is wrong with the *file* is an [`ImportError`] that names
//! the path and the line, what is wrong with the *shape* is a [`BuildError`](crate::body::BuildError) from the surface's
//! own checks, so that the same surface made in code gets the same answer.

mod hatchback;
pub mod obj;

pub use hatchback::hatchback;

use std::path::PathBuf;

/// Why a file can't be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The file can't be opened or read.
    #[error("can't read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not text.
    #[error("{}:{line}: not UTF-8 text; is it a binary file?", path.display())]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first line that is not UTF-8, counting from 1.
        line: usize,
    },
    /// A line is wrong.
    #[error("{}:{line}: {what} is {value:?}, it must be {must}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, counting from 1.
        line: usize,
        /// Name of the value.
        what: &'static str,
        /// The value as it stands in the file.
        value: String,
        /// What it must be.
        must: String,
    },
    /// The file has no faces.
    #[error("{} has no faces; a surface needs at least one", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The parser refuses the file for a reason the lines don't show.
    #[error("{}: {source}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What the parser says.
        source: tobj::LoadError,
    },
}
