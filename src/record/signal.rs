//! Evenly spaced channels as signals: filtered, scaled, their peaks.
//!
//! Resampling and filtering know nothing of each other; a laboratory always does one after the other, so the steps between
//! a recording and a number in a table stand here.

use super::filter::{Cfc, FilterError};
use super::resample::{ResampleError, Resampled};

/// Why a recording gives no signal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SignalError {
    /// It can't be brought to even spacing.
    #[error(transparent)]
    Resample(#[from] ResampleError),
    /// It can't be filtered.
    #[error(transparent)]
    Filter(#[from] FilterError),
}

impl Resampled {
    /// The same channel, filtered.
    ///
    /// # Errors
    /// [`FilterError`].
    pub fn filtered(&self, class: Cfc) -> Result<Resampled, FilterError> {
        Ok(Resampled {
            times: self.times.clone(),
            values: class.filter(self.dt, &self.values)?,
            dt: self.dt,
        })
    }

    /// Time and value of the largest value; zeros for an empty channel.
    pub fn peak(&self) -> (f64, f64) {
        let pairs = self.times.iter().copied().zip(self.values.iter().copied());
        pairs.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
    }

    /// Every value times `factor`.
    pub fn scaled(mut self, factor: f64) -> Resampled {
        for value in &mut self.values {
            *value *= factor;
        }
        self
    }
}
