//! Which values variables take, and the variants that makes.

use std::str::FromStr;

/// Most variants of a sweep.
const MOST: usize = 1_000_000;

/// A variable and its values: `speed=5..30:26` is 26 values from 5 to 30, both included; `angle=0,15,30` is these three.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepAxis {
    /// The variable.
    pub name: String,
    /// Its values.
    pub values: Vec<f64>,
}

/// Why an axis, or all of them, can't be meant.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AxisError {
    /// It is not written as an axis is.
    #[error(
        "`{0}` is no variable with values; write speed=5..30:26 (two values or more) or angle=0,15,30"
    )]
    Form(String),
    /// A value of a variable is no number.
    #[error("`{1}`, a value of `{0}`, is no finite number")]
    Number(String, String),
    /// A variable has no values.
    #[error("the variable `{0}` has no values")]
    Empty(String),
    /// One variable has two axes.
    #[error("the variable `{0}` is set twice")]
    Twice(String),
    /// There would be too many variants.
    #[error("{0} variants are too many, at most 1000000 are possible")]
    TooMany(usize),
}

impl FromStr for SweepAxis {
    type Err = AxisError;

    fn from_str(text: &str) -> Result<Self, AxisError> {
        let form = || AxisError::Form(text.into());
        let (name, values) = text.split_once('=').ok_or_else(form)?;
        let number = |text: &str| {
            let x = text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
            x.ok_or_else(|| AxisError::Number(name.trim().into(), text.into()))
        };
        let values = match values.split_once("..") {
            None => values
                .split(',')
                .map(number)
                .collect::<Result<Vec<_>, _>>()?,
            Some((from, rest)) => {
                let (to, count) = rest.split_once(':').ok_or_else(form)?;
                let (from, to) = (number(from)?, number(to)?);
                let count: usize = count.trim().parse().map_err(|_| form())?;
                if count < 2 {
                    return Err(form());
                }
                if count > MOST {
                    return Err(AxisError::TooMany(count));
                }
                let share = |i: usize| i as f64 / (count - 1) as f64;
                // Weighted, so that both ends are what was written.
                let value = |i| from * (1.0 - share(i)) + to * share(i);
                (0..count).map(value).collect()
            }
        };
        match name.trim() {
            "" => Err(form()),
            name => Ok(Self {
                name: name.into(),
                values,
            }),
        }
    }
}

/// One run of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Its number, from 0.
    pub index: usize,
    /// The values of the variables.
    pub set: Vec<(String, f64)>,
}

/// Every combination of the values, those of the last axis changing first.
///
/// # Errors
/// [`AxisError`]: a variable twice or without values, or more than a million variants.
pub fn variants(axes: &[SweepAxis]) -> Result<Vec<Variant>, AxisError> {
    for (i, axis) in axes.iter().enumerate() {
        if axis.values.is_empty() {
            return Err(AxisError::Empty(axis.name.clone()));
        }
        if axes[..i].iter().any(|a| a.name == axis.name) {
            return Err(AxisError::Twice(axis.name.clone()));
        }
    }
    let sizes = axes.iter().map(|a| a.values.len());
    let total = sizes.fold(1_usize, usize::saturating_mul);
    if total > MOST {
        return Err(AxisError::TooMany(total));
    }
    let variant = |index: usize| {
        let mut rest = index;
        let mut set: Vec<(String, f64)> = Vec::new();
        for axis in axes.iter().rev() {
            let n = axis.values.len().max(1);
            set.push((axis.name.clone(), axis.values[rest % n]));
            rest /= n;
        }
        set.reverse();
        Variant { index, set }
    };
    Ok((0..total).map(variant).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_read() {
        let axis: SweepAxis = "speed=5..30:26".parse().unwrap();
        assert_eq!(axis.values.len(), 26);
        assert_eq!(
            (axis.values[0], axis.values[1], axis.values[25]),
            (5.0, 6.0, 30.0)
        );
        let axis: SweepAxis = "angle=0, 15,-3e1".parse().unwrap();
        assert_eq!(
            (axis.name.as_str(), axis.values),
            ("angle", vec![0.0, 15.0, -30.0])
        );
        for bad in [
            "speed",
            "speed=",
            "=1",
            "a=1..2",
            "a=1..2:1",
            "a=x",
            "a=1,NaN",
            "a=1..2:9e9",
        ] {
            assert!(bad.parse::<SweepAxis>().is_err(), "{bad}");
        }
        let named = "speed=1,x".parse::<SweepAxis>().unwrap_err();
        assert_eq!(named, AxisError::Number("speed".into(), "x".into()));
    }

    #[test]
    fn every_combination_is_a_variant() {
        let axes = ["a=1,2", "b=3,4,5"].map(|t| t.parse().unwrap());
        let all = variants(&axes).unwrap();
        assert_eq!(all.len(), 6);
        assert_eq!(all[4].set, [("a".into(), 2.0), ("b".into(), 4.0)]);
        assert!(matches!(
            variants(&[axes[0].clone(), axes[0].clone()]),
            Err(AxisError::Twice(_))
        ));
        let empty = SweepAxis {
            name: "x".into(),
            values: Vec::new(),
        };
        assert!(matches!(variants(&[empty]), Err(AxisError::Empty(_))));
        let large = SweepAxis {
            name: "x".into(),
            values: vec![0.0; 2000],
        };
        let more = SweepAxis {
            name: "y".into(),
            ..large.clone()
        };
        assert!(matches!(
            variants(&[large, more]),
            Err(AxisError::TooMany(4_000_000))
        ));
    }
}
