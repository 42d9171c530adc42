//! Crash-grade deformable bodies for Rapier.
#![warn(missing_docs)]
#![forbid(unsafe_code)]

pub use rapier3d;

pub mod body;
pub mod contact;
pub mod coupling;
pub mod law;
pub mod math;
pub mod solve;

/// Shape functions: lattice, sheet, rope and filled surfaces.
pub use body::shape;
