//! Why a figure can't be made; every error names the file, because a run writes many.

use std::path::{Path, PathBuf};

/// Why a plot or a picture can't be saved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// The file can't be written.
    #[error("can't write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The picture can't be encoded.
    #[error("can't encode {}", path.display())]
    Encode {
        /// The file that was not written.
        path: PathBuf,
        /// What the encoder says.
        source: image::ImageError,
    },
    /// The plot can't be drawn.
    #[error("can't draw {}: {reason}", path.display())]
    Draw {
        /// The file that was not written.
        path: PathBuf,
        /// What the plotting library says.
        reason: String,
    },
    /// A series has more values of one coordinate than of the other.
    #[error("{}: series `{series}` has {x} x and {y} y values", path.display())]
    Lengths {
        /// The file that was not written.
        path: PathBuf,
        /// Name of the series.
        series: String,
        /// Length of its x.
        x: usize,
        /// Length of its y.
        y: usize,
    },
}

impl ReportError {
    /// The file it is about.
    pub fn path(&self) -> &Path {
        match self {
            Self::Write { path, .. }
            | Self::Encode { path, .. }
            | Self::Draw { path, .. }
            | Self::Lengths { path, .. } => path,
        }
    }
}
