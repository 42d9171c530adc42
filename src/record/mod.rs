//! What happens to samples after a run: even spacing, channel filters and files.
//!
//! A deformable body's contact force is known once per substep, the substeps may change their length, and the raw values
//! ring with every spring. [`resample()`] makes the spacing even without losing impulse, [`Cfc`] filters the way crash
//! laboratories do, and [`write_csv`] writes columns that say their units. Everything here is `f64` and needs nothing
//! but the standard library.

pub mod csv;
pub mod filter;
pub mod resample;

pub use csv::{CsvError, write_csv};
pub use filter::{Cfc, Coefficients, FilterError};
pub use resample::{ResampleError, Resampled, resample};

#[cfg(test)]
mod tests;
