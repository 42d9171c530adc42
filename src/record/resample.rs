//! Even spacing for channels sampled once per substep.
//!
//! A filter needs evenly spaced samples, but a solver may change the length of its substeps. A contact force is only
//! meaningful together with the time it acted for (force × substep = impulse), so samples are intervals here, not points,
//! and each even bin gets the mean over what it covers. Interpolating points would lose or invent impulse wherever one
//! substep rings against the next; averaging intervals keeps ∫F dt to round-off.

/// An evenly spaced channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resampled {
    /// Middle of each bin \[s\].
    pub times: Vec<f64>,
    /// Mean over each bin, in the channel's unit.
    pub values: Vec<f64>,
    /// Width of every bin \[s\]: the one asked for, shortened so that bins fill the recording exactly.
    pub dt: f64,
}

/// Why a channel can't be resampled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResampleError {
    /// The bin width is not a positive number of seconds.
    #[error("the bin width is {dt} s, it must be positive and finite")]
    Step {
        /// The width \[s\].
        dt: f64,
    },
    /// There is not one more edge than values.
    #[error(
        "{edges} times for {values} values; the times are edges, one more than there are values"
    )]
    Lengths {
        /// Length of the times.
        edges: usize,
        /// Length of the values.
        values: usize,
    },
    /// An edge is not finite or not after the one before it.
    #[error("time {index} is {time} s, it must be finite and later than the one before")]
    Time {
        /// Index of the edge.
        index: usize,
        /// The edge \[s\].
        time: f64,
    },
    /// A value is NaN or infinite.
    #[error("value {index} is {value}, it must be finite")]
    Value {
        /// Its index.
        index: usize,
        /// The value.
        value: f64,
    },
    /// The recording would become more bins than memory is meant for.
    #[error("{bins:.0} bins of {dt} s are too many (at most {})", MOST)]
    Bins {
        /// How many.
        bins: f64,
        /// The width asked for \[s\].
        dt: f64,
    },
}

/// Most bins of one channel: 800 MB of values.
const MOST: usize = 100_000_000;

/// Means over even bins of at most `dt` seconds, where `values[i]` held from `times[i]` to `times[i + 1]`.
///
/// The sum of `values · dt` of the result is the integral of the channel, to round-off. The bins fill the recording: their
/// width is its length over the next whole number of `dt`s (to within a millionth), which [`Resampled::dt`] says, so that no
/// bin at the end is half empty. No values give no bins.
///
/// # Errors
/// [`ResampleError`]: `dt` not positive, lengths that don't fit, times that don't increase, values that are not finite.
pub fn resample(times: &[f64], values: &[f64], dt: f64) -> Result<Resampled, ResampleError> {
    if !(dt > 0.0 && dt.is_finite()) {
        return Err(ResampleError::Step { dt });
    }
    if values.is_empty() && times.len() <= 1 {
        let dt_only = Resampled {
            dt,
            ..Default::default()
        };
        return Ok(dt_only);
    }
    if times.len() != values.len() + 1 {
        return Err(ResampleError::Lengths {
            edges: times.len(),
            values: values.len(),
        });
    }
    for (index, &time) in times.iter().enumerate() {
        if !time.is_finite() || (index > 0 && time <= times[index - 1]) {
            return Err(ResampleError::Time { index, time });
        }
    }
    if let Some(index) = values.iter().position(|v| !v.is_finite()) {
        let value = values[index];
        return Err(ResampleError::Value { index, value });
    }
    let start = times[0];
    let length = times[values.len()] - start;
    let bins = (length / dt - 1.0e-6).ceil().max(1.0);
    if bins > MOST as f64 {
        return Err(ResampleError::Bins { bins, dt });
    }
    let count = bins as usize;
    let width = length / bins;
    let mut impulse = vec![0.0; count];
    for (i, &value) in values.iter().enumerate() {
        // Positions in bins; an interval adds its share to every bin that it touches.
        let [from, to] = [times[i], times[i + 1]].map(|t| ((t - start) / width).clamp(0.0, bins));
        let last = ((to.ceil() as usize).max(1) - 1).min(count - 1);
        let mut at = from;
        for (bin, sum) in impulse
            .iter_mut()
            .enumerate()
            .take(last + 1)
            .skip(from as usize)
        {
            let next = if bin == last { to } else { (bin + 1) as f64 };
            *sum += value * (next - at);
            at = next;
        }
    }
    Ok(Resampled {
        times: (0..count)
            .map(|i| start + (i as f64 + 0.5) * width)
            .collect(),
        values: impulse,
        dt: width,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    #[test]
    fn bins_are_means() {
        let r = resample(&[0.0, 1.0, 1.5, 2.0], &[4.0, 2.0, 6.0], 1.0).unwrap();
        assert_eq!(
            (r.times, r.values, r.dt),
            (vec![0.5, 1.5], vec![4.0, 4.0], 1.0)
        );
        let r = resample(&[0.0, 2.0], &[3.0], 0.75).unwrap();
        assert_eq!(
            (r.values.len(), r.dt),
            (3, 2.0 / 3.0),
            "bins fill the recording"
        );
        assert_eq!(resample(&[], &[], 1.0).unwrap().values.len(), 0);
        assert_eq!(resample(&[7.0], &[], 1.0).unwrap().values.len(), 0);
    }

    #[test]
    fn what_is_wrong_is_named() {
        assert!(matches!(
            resample(&[0.0, 1.0], &[1.0], 0.0),
            Err(ResampleError::Step { .. })
        ));
        assert!(matches!(
            resample(&[0.0], &[1.0], 1.0),
            Err(ResampleError::Lengths { .. })
        ));
        let error = resample(&[0.0, 1.0, 1.0], &[1.0, 1.0], 1.0).unwrap_err();
        assert!(
            matches!(error, ResampleError::Time { index: 2, .. }),
            "{error}"
        );
        let error = resample(&[0.0, 1.0], &[f64::NAN], 1.0).unwrap_err();
        assert!(
            matches!(error, ResampleError::Value { index: 0, .. }),
            "{error}"
        );
        assert!(matches!(
            resample(&[0.0, 1.0], &[1.0], 1.0e-12),
            Err(ResampleError::Bins { .. })
        ));
    }

    proptest! {
        #[test]
        fn the_integral_stays(
            steps in prop::collection::vec((1.0e-5..1.0e-3_f64, -1.0e6..1.0e6_f64), 1..300),
            start in -1.0..1.0_f64,
            dt in 1.0e-5..1.0e-2_f64,
        ) {
            let mut times = vec![start];
            for (step, _) in &steps {
                times.push(times[times.len() - 1] + step);
            }
            let values: Vec<f64> = steps.iter().map(|s| s.1).collect();
            let integral: f64 = values.iter().zip(times.windows(2)).map(|(v, t)| v * (t[1] - t[0])).sum();
            let size: f64 = values.iter().zip(times.windows(2)).map(|(v, t)| v.abs() * (t[1] - t[0])).sum();
            let r = resample(&times, &values, dt).unwrap();
            let sum: f64 = r.values.iter().sum::<f64>() * r.dt;
            prop_assert!((sum - integral).abs() <= 1.0e-11 * size, "{sum} for {integral}");
            prop_assert!(r.dt <= dt * (1.0 + 1.0e-5) || r.values.len() == 1);
            let [low, high] = [f64::min as fn(f64, f64) -> f64, f64::max].map(|f| values.iter().copied().fold(values[0], f));
            let slack = 1.0e-9 * (low.abs() + high.abs());
            prop_assert!(r.values.iter().all(|v| *v >= low - slack && *v <= high + slack));
        }
    }

    #[test]
    fn an_even_channel_stays_as_it_is() {
        let times: Vec<f64> = (0..=50).map(|i| f64::from(i) * 1.0e-3).collect();
        let values: Vec<f64> = (0..50).map(|i| f64::from(i * i)).collect();
        let r = resample(&times, &values, 1.0e-3).unwrap();
        assert_eq!(r.values.len(), 50);
        for (a, b) in r.values.iter().zip(&values) {
            assert_relative_eq!(a, b, epsilon = 1.0e-9, max_relative = 1.0e-9);
        }
    }
}
