//! Crash-grade deformable bodies for Rapier.
#![warn(missing_docs)]
#![forbid(unsafe_code)]

pub use rapier3d;

pub mod body;
pub mod math;
pub mod record;
#[cfg(feature = "report")]
pub mod report;

/// Shape functions: lattice, sheet, rope and filled surfaces.
pub use body::shape;
