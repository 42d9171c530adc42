//! What is kept of a run, and what happens to it afterwards.
//!
//! A [`Recorder`] watches every substep through the world's observer and never changes a result. A deformable body's
//! contact force is known once per substep, the substeps may change their length, and the raw values ring with every
//! spring. [`resample()`] makes the spacing even without losing impulse, [`Cfc`] filters the way crash laboratories do,
//! and [`write_csv`] writes columns that say their units. Everything here is `f64`.

pub mod body;
pub mod channel;
pub mod csv;
pub mod export;
pub mod filter;
pub mod frame;
pub mod history;
pub mod recorder;
pub mod resample;
pub mod signal;
pub mod stress;

pub use body::{BodyRecord, Closure, LedgerSample};
pub use channel::{Channel, Interface};
pub use csv::{CsvError, write_csv};
pub use filter::{Cfc, Coefficients, FilterError};
pub use frame::Frame;
pub use history::{Moments, NodeSet};
pub use recorder::{RecordError, Recorder, Sampling};
pub use resample::{ResampleError, Resampled, resample};
pub use signal::SignalError;
pub use stress::TetSet;

/// The larger of two numbers; NaN if one is, which must not pass for calm.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

#[cfg(test)]
mod tests;
