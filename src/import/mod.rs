//! Files made elsewhere, turned into what a body is made of.
//!
//! An importer ends at [`Surface`](crate::body::Surface) or at [`TetMesh`](crate::body::TetMesh): what is wrong with the *file* is an [`ImportError`] that names
//! the path and the line, what is wrong with the *shape* is a [`BuildError`](crate::body::BuildError) from the surface's
//! own checks, so that the same surface made in code gets the same answer.

mod hatchback;
pub mod msh;
pub mod obj;
mod scan;
pub mod tetgen;
mod tets;

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
    /// The file has no faces, or no tetrahedra where a solid is asked for.
    #[error("{} has no faces (or, for a solid, no tetrahedra); a mesh needs at least one", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A place in a binary file is wrong.
    #[error("{}, byte {byte}: {what} is {value:?}, it must be {must}", path.display())]
    Byte {
        /// The file.
        path: PathBuf,
        /// The place, counting from 0.
        byte: usize,
        /// Name of the value.
        what: &'static str,
        /// The value.
        value: String,
        /// What it must be.
        must: String,
    },
    /// A value does not fit another one elsewhere in the file.
    #[error("{}: {what} is {value:?}, it must be {must}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Name of the value.
        what: &'static str,
        /// The value.
        value: String,
        /// What it must be.
        must: String,
    },
    /// The file is in order, the shape in it is not.
    #[error("{}: {source}", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: crate::body::BuildError,
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
