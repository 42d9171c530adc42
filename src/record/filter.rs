//! Channel frequency classes: the low-pass filters that crash laboratories state their forces and accelerations in.
//!
//! SAE J211-1 (and ISO 6487) prescribe a two-pole Butterworth filter run forward and then backward over the channel, so
//! that it delays nothing: four poles, no phase. Writing a peak force without its class says little, because raw contact
//! forces grow without bound as the time step shrinks. The recursion and its coefficients are those that
//! SAE J211-1 gives for a digital filter; they are evaluated in `f64` because b1 + b2 comes close to 1 at small steps.
//!
//! A recursion needs a past. Both passes start in the steady state of their first sample, and the signal is extended on
//! both sides by its point reflection (2·x_end − x mirrored), which keeps value and slope.

use std::f64::consts::{PI, SQRT_2};

/// A channel frequency class of SAE J211-1.
///
/// Which class a channel wants is part of the standard: 60 for barrier forces and the acceleration of a whole vehicle, 180
/// for integrating to velocity or displacement and for chest acceleration, 600 for components and femur forces, 1000 for
/// heads and raw channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cfc {
    /// −3 dB at 100 Hz.
    Cfc60,
    /// −3 dB at 300 Hz.
    Cfc180,
    /// −3 dB at 1000 Hz.
    Cfc600,
    /// −3 dB at 1650 Hz.
    Cfc1000,
}

/// The recursion y\[n\] = a0·x\[n\] + a1·x\[n−1\] + a2·x\[n−2\] + b1·y\[n−1\] + b2·y\[n−2\]; no unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Of this sample.
    pub a0: f64,
    /// Of the sample before.
    pub a1: f64,
    /// Of the sample before that.
    pub a2: f64,
    /// Of the result before.
    pub b1: f64,
    /// Of the result before that.
    pub b2: f64,
}

/// Why a channel can't be filtered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FilterError {
    /// The sample spacing is not a positive number of seconds.
    #[error("the sample spacing is {dt} s, it must be positive and finite")]
    Step {
        /// The spacing \[s\].
        dt: f64,
    },
    /// The channel is sampled too slowly for its class.
    #[error("CFC {class} needs at least {needed} samples per second, the channel has {rate}")]
    Rate {
        /// The class, as J211 numbers it.
        class: u32,
        /// 1/dt \[Hz\].
        rate: f64,
        /// Six times the class's −3 dB frequency \[Hz\].
        needed: f64,
    },
    /// A sample is NaN or infinite: the recursion would spread it over the whole channel.
    #[error("sample {index} is {value}, it must be finite")]
    Sample {
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
}

impl Cfc {
    /// Every class, from the strongest filter to the weakest.
    pub const ALL: [Cfc; 4] = [Cfc::Cfc60, Cfc::Cfc180, Cfc::Cfc600, Cfc::Cfc1000];

    /// The number in its name, from 60 to 1000.
    pub fn class(self) -> u32 {
        match self {
            Cfc::Cfc60 => 60,
            Cfc::Cfc180 => 180,
            Cfc::Cfc600 => 600,
            Cfc::Cfc1000 => 1000,
        }
    }

    /// Where forward and backward pass together let 1/√2 through \[Hz\], as J211 states it.
    pub fn cutoff(self) -> f64 {
        match self {
            Cfc::Cfc60 => 100.0,
            Cfc::Cfc180 => 300.0,
            Cfc::Cfc600 => 1000.0,
            Cfc::Cfc1000 => 1650.0,
        }
    }

    /// ω_d \[rad/s\] of one pass: 2π · class · 2.0775 (SAE J211-1).
    fn omega(self) -> f64 {
        2.0 * PI * f64::from(self.class()) * 2.0775
    }

    /// The recursion for samples `dt` seconds apart.
    ///
    /// # Errors
    /// [`FilterError::Step`] where `dt` is not positive and finite, [`FilterError::Rate`] below six samples per period of
    /// the −3 dB frequency.
    pub fn coefficients(self, dt: f64) -> Result<Coefficients, FilterError> {
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(FilterError::Step { dt });
        }
        let needed = 6.0 * self.cutoff();
        // A step computed as 1/needed must pass whatever its last bit.
        if dt * needed > 1.0 + 1.0e-9 {
            return Err(FilterError::Rate {
                class: self.class(),
                rate: 1.0 / dt,
                needed,
            });
        }
        let w = (0.5 * self.omega() * dt).tan();
        let d = 1.0 + SQRT_2 * w + w * w;
        let a0 = w * w / d;
        Ok(Coefficients {
            a0,
            a1: 2.0 * a0,
            a2: a0,
            b1: -2.0 * (w * w - 1.0) / d,
            b2: (-1.0 + SQRT_2 * w - w * w) / d,
        })
    }

    /// The channel, filtered forward and backward; as many samples as came in, in their unit.
    ///
    /// The extension by point reflection is 10 ms or ten time constants (√2/ω_d) of the filter, whichever is longer, but
    /// never longer than the signal less one sample: a signal shorter than that is mirrored as a whole and its ends carry
    /// a remnant of the start-up transient. One sample comes back as it is, none as none.
    ///
    /// # Errors
    /// Those of [`coefficients`](Self::coefficients), and [`FilterError::Sample`] for a sample that is not finite.
    pub fn filter(&self, dt: f64, samples: &[f64]) -> Result<Vec<f64>, FilterError> {
        let recursion = self.coefficients(dt)?;
        if let Some(index) = samples.iter().position(|x| !x.is_finite()) {
            let value = samples[index];
            return Err(FilterError::Sample { index, value });
        }
        let (Some(&first), Some(&last)) = (samples.first(), samples.last()) else {
            return Ok(Vec::new());
        };
        let seconds = f64::max(0.010, 10.0 * SQRT_2 / self.omega());
        let pad = ((seconds / dt).ceil() as usize).min(samples.len() - 1);
        let mut signal = Vec::with_capacity(samples.len() + 2 * pad);
        signal.extend((1..=pad).rev().map(|i| 2.0 * first - samples[i]));
        signal.extend_from_slice(samples);
        let end = samples.len() - 1;
        signal.extend((1..=pad).map(|i| 2.0 * last - samples[end - i]));
        recursion.run(signal.iter_mut());
        recursion.run(signal.iter_mut().rev());
        Ok(signal[pad..pad + samples.len()].to_vec())
    }
}

impl Coefficients {
    /// One pass in place, begun in the steady state of the first sample.
    fn run<'a>(&self, signal: impl Iterator<Item = &'a mut f64>) {
        let mut past: Option<[f64; 4]> = None;
        for value in signal {
            let x = *value;
            let [x1, x2, y1, y2] = past.unwrap_or([x; 4]);
            *value = self.a0 * x + self.a1 * x1 + self.a2 * x2 + self.b1 * y1 + self.b2 * y2;
            past = Some([x, x1, *value, y1]);
        }
    }
}
