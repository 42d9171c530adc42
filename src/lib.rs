//! Crash-grade deformable bodies for Rapier.
#![warn(missing_docs)]
#![forbid(unsafe_code)]

pub use rapier3d;

pub mod body;
#[cfg(feature = "import")]
pub mod import;
pub mod math;

/// Shape functions: lattice, sheet, rope and filled surfaces.
pub use body::shape;
