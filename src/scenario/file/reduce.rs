//! One number of a series: its peak, its mean, its value at a time.

use super::run::Series;
use crate::record::ResampleError;

/// A number with the time it belongs to \[s\], if it belongs to one.
pub(super) type Measured = (f64, Option<f64>);

/// Most samples of one channel.
const MOST: f64 = 1.0e8;

/// Times are sums of steps in `f32`, a ten-millionth off at the most.
pub(super) fn rounding(time: f64) -> f64 {
    1.0e-9 + 1.0e-7 * time.abs()
}

const NONE: Measured = (f64::NAN, None);

impl Series {
    /// What of it lies in a span of time \[s\]; nothing where the series does not reach the ends of the span, since
    /// then it says of another span what was asked of this one.
    pub fn between(&self, span: Option<[f64; 2]>) -> Self {
        let Some([from, to]) = span else {
            return self.clone();
        };
        let (first, last) = (self.times.first(), self.times.last());
        let slack = self.bins.or(self.interval()).unwrap_or(0.0).max(1.0e-9);
        let reached = first.is_some_and(|t| *t <= from.max(0.0) + 2.0 * slack)
            && last.is_some_and(|t| *t >= to - 2.0 * slack);
        if !reached {
            return Self::default();
        }
        let pairs = self.times.iter().zip(&self.values);
        let (from, to) = (from - rounding(from), to + rounding(to));
        let inside = pairs.filter(|(t, _)| (from..=to).contains(*t));
        let (times, values) = inside.map(|(t, v)| (*t, *v)).unzip();
        Self {
            times,
            values,
            bins: self.bins,
        }
    }

    /// Mean time between samples \[s\]; `None` for fewer than two.
    pub(super) fn interval(&self) -> Option<f64> {
        let gaps = self.times.len().checked_sub(1).filter(|n| *n > 0)?;
        let mean = (self.times.last()? - self.times.first()?) / gaps as f64;
        (mean > 0.0).then_some(mean)
    }

    /// Values every `dt` s from the first sample on, straight between samples.
    pub(super) fn spaced(&self, dt: f64) -> Result<Self, ResampleError> {
        let (Some(first), Some(last)) = (self.times.first(), self.times.last()) else {
            return Ok(self.clone());
        };
        // A hair more, so that an end which is a whole number of intervals off is reached.
        let count = ((last - first) / dt + 1.0e-6).floor() + 1.0;
        if count > MOST {
            return Err(ResampleError::Bins { bins: count, dt });
        }
        let times: Vec<f64> = (0..count as usize).map(|i| first + i as f64 * dt).collect();
        Ok(Self {
            values: times.iter().map(|t| self.at(*t)).collect(),
            times,
            bins: None,
        })
    }

    fn pairs(&self) -> impl DoubleEndedIterator<Item = (f64, f64)> {
        self.values.iter().copied().zip(self.times.iter().copied())
    }

    /// The pair whose `key` is largest, the first of equals.
    fn most(&self, key: fn(f64) -> f64) -> Measured {
        let better = |best: Option<(f64, f64)>, next: (f64, f64)| match best {
            // NaN is never passed over.
            Some(best) if best.0.is_nan() || key(best.0) >= key(next.0) => Some(best),
            _ => Some(next),
        };
        let best = self.pairs().fold(None, better);
        best.map_or(NONE, |(value, time)| (value, Some(time)))
    }

    /// Largest value.
    pub(super) fn peak(&self) -> Measured {
        self.most(|v| v)
    }

    /// Smallest value.
    pub(super) fn lowest(&self) -> Measured {
        self.most(|v| -v)
    }

    /// Largest distance from 0.
    pub(super) fn peak_size(&self) -> Measured {
        let (value, time) = self.most(f64::abs);
        (value.abs(), time)
    }

    /// First value.
    pub(super) fn first(&self) -> Measured {
        self.pairs().next().map_or(NONE, |(v, t)| (v, Some(t)))
    }

    /// Last value.
    pub(super) fn last(&self) -> Measured {
        self.pairs().next_back().map_or(NONE, |(v, t)| (v, Some(t)))
    }

    /// Integral over time: of bins their sum, of samples that of the straight lines between them.
    pub(super) fn integral(&self) -> f64 {
        if let Some(dt) = self.bins {
            return self.values.iter().sum::<f64>() * dt;
        }
        let steps = self.times.windows(2).zip(self.values.windows(2));
        steps
            .map(|(t, v)| 0.5 * (v[0] + v[1]) * (t[1] - t[0]))
            .sum()
    }

    /// Mean over time.
    pub(super) fn mean(&self) -> f64 {
        let span = match (self.bins, self.times.first(), self.times.last()) {
            (Some(dt), ..) => dt * self.values.len() as f64,
            (None, Some(first), Some(last)) => last - first,
            _ => 0.0,
        };
        match (span > 0.0, self.values.as_slice()) {
            (true, _) => self.integral() / span,
            (false, [one]) => *one,
            (false, _) => f64::NAN,
        }
    }

    /// Value at a time, straight between samples; NaN outside.
    pub(super) fn at(&self, time: f64) -> f64 {
        let after = self.times.partition_point(|t| *t < time);
        if let (Some(t), Some(v)) = (self.times.get(after), self.values.get(after))
            && *t == time
        {
            return *v;
        }
        // Steps that end a hair before the duration are not followed by one more.
        let hair = 1.0e-3 * self.interval().unwrap_or(0.0);
        let slack = self.bins.unwrap_or(hair).max(rounding(time));
        let ends = |i: usize| (self.times.get(i), self.values.get(i));
        match (ends(after.wrapping_sub(1)), ends(after)) {
            ((Some(a), Some(x)), (Some(b), Some(y))) => x + (y - x) * (time - a) / (b - a),
            // Half a bin, or rounding, beyond the ends.
            ((Some(a), Some(x)), _) if time - a <= slack => *x,
            (_, (Some(b), Some(y))) if b - time <= slack => *y,
            _ => f64::NAN,
        }
    }

    /// Mean time from one rise through the mean to the next; NaN with fewer than two.
    pub(super) fn period(&self) -> f64 {
        let mean = self.mean();
        let steps = self.times.windows(2).zip(self.values.windows(2));
        let rises: Vec<f64> = steps
            .filter(|(_, v)| v[0] < mean && v[1] >= mean)
            .map(|(t, v)| t[0] + (t[1] - t[0]) * (mean - v[0]) / (v[1] - v[0]))
            .collect();
        match rises.as_slice() {
            [first, .., last] => (last - first) / (rises.len() - 1) as f64,
            _ => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(values: &[f64]) -> Series {
        Series {
            times: (0..values.len()).map(|i| i as f64).collect(),
            values: values.to_vec(),
            bins: None,
        }
    }

    #[test]
    fn numbers_of_a_series() {
        let s = series(&[1.0, 3.0, -4.0, 3.0]);
        assert_eq!(s.peak(), (3.0, Some(1.0)));
        assert_eq!(s.lowest(), (-4.0, Some(2.0)));
        assert_eq!(s.peak_size(), (4.0, Some(2.0)));
        assert_eq!((s.first().0, s.last().0), (1.0, 3.0));
        assert_eq!(s.integral(), 2.0 - 0.5 - 0.5);
        assert_eq!(s.mean(), 1.0 / 3.0);
        assert_eq!((s.at(1.5), s.at(0.0), s.at(3.0)), (-0.5, 1.0, 3.0));
        assert!(s.at(3.1).is_nan() && s.at(-0.1).is_nan());
        assert_eq!(s.between(Some([1.0, 2.0])).values, [3.0, -4.0]);
        // The end of a run, as steps in `f32` sum up to it.
        let mut late = s.clone();
        late.times[3] += 1.0e-7;
        assert_eq!(late.between(Some([1.0, 3.0])).values, [3.0, -4.0, 3.0]);
        late.times[3] -= 2.0e-7;
        assert_eq!(late.at(3.0), 3.0);
        let bins = Series {
            bins: Some(0.5),
            ..series(&[2.0, 4.0])
        };
        assert_eq!((bins.integral(), bins.mean()), (3.0, 3.0));
        assert!(series(&[]).mean().is_nan() && series(&[]).peak().0.is_nan());
    }

    #[test]
    fn samples_are_spaced_anew() {
        let s = series(&[0.0, 2.0, 4.0]);
        assert_eq!(s.interval(), Some(1.0));
        let fine = s.spaced(0.25).unwrap();
        assert_eq!(fine.times.len(), 9);
        assert!(
            fine.times
                .iter()
                .zip(&fine.values)
                .all(|(t, v)| *v == 2.0 * t)
        );
        assert_eq!(s.spaced(0.8).unwrap().times, [0.0, 0.8, 1.6]);
        assert!(matches!(s.spaced(1.0e-9), Err(ResampleError::Bins { .. })));
        assert_eq!(series(&[1.0]).interval(), None);
    }

    #[test]
    fn the_period_of_a_sine() {
        let n = 1000;
        let s = Series {
            times: (0..n).map(|i| f64::from(i) * 0.01).collect(),
            values: (0..n)
                .map(|i| 5.0 + (f64::from(i) * 0.01 * 7.0).sin())
                .collect(),
            bins: None,
        };
        let period = std::f64::consts::TAU / 7.0;
        assert!((s.period() / period - 1.0).abs() < 1e-3, "{}", s.period());
    }
}
