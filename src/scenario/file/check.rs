//! What numbers and names must satisfy, named for what they are in the scene's own reference.

use super::decode::{Check, Decoder, Kind};
use super::problem::unknown;

/// A range of numbers.
pub(crate) struct Range {
    good: fn(f64) -> bool,
    must: &'static str,
}

/// Numbers that `f32` holds, which Rapier and the nodes are stored in.
pub(crate) const FINITE: Range = Range {
    good: |x| (x as f32).is_finite(),
    must: "finite",
};
/// Lengths, masses, stiffnesses.
pub(crate) const POSITIVE: Range = Range {
    good: |x| (x as f32).is_normal() && x > 0.0,
    must: "positive and finite",
};
/// How far out things may be, and how large \[m\]: `f32` tells no more than centimetres apart there, and Parry's searches overflow
/// farther on.
pub(crate) const FARTHEST: f64 = 1e6;
/// Places, and corners of shapes \[m\].
pub(crate) const POINT: Range = Range {
    good: |x| x.abs() <= FARTHEST,
    must: "at most 1e6 m from 0",
};
/// Sizes of shapes \[m\].
pub(crate) const SIZE: Range = Range {
    good: |x| (x as f32).is_normal() && x > 0.0 && x <= FARTHEST,
    must: "positive and at most 1e6 m",
};
/// Widths that may be none \[m\].
pub(crate) const WIDTH: Range = Range {
    good: |x| (0.0..=FARTHEST).contains(&x),
    must: "0 or positive, and at most 1e6 m",
};
/// Dampings, coefficients.
pub(crate) const NOT_NEGATIVE: Range = Range {
    good: |x| x >= 0.0 && (x as f32).is_finite(),
    must: "0 or positive, and finite",
};
/// Strengths, which may be infinite.
pub(crate) const STRENGTH: Range = Range {
    good: |x| x > 0.0 && (x as f32) > 0.0,
    must: "positive or inf",
};
/// Fractions above nothing.
pub(crate) const SHARE: Range = Range {
    good: |x| x > 0.0 && x <= 1.0,
    must: "above 0 and at most 1",
};
/// Fractions below the whole.
pub(crate) const LESS_THAN_ALL: Range = Range {
    good: |x| (0.0..1.0).contains(&x),
    must: "0 or more and less than 1",
};
/// Poisson's ratio.
pub(crate) const POISSON: Range = Range {
    good: |x| x > -1.0 && x < 0.5,
    must: "greater than -1 and less than 0.5",
};
/// Steps of the world \[s\].
pub(crate) const STEP: Range = Range {
    good: |x| (1.0e-7..=0.1).contains(&x),
    must: "from 1e-7 to 0.1 s",
};
/// Durations \[s\].
pub(crate) const DURATION: Range = Range {
    good: |x| x > 0.0 && x <= 3600.0,
    must: "above 0 and at most 3600 s",
};
/// Intervals between samples \[s\].
pub(crate) const INTERVAL: Range = Range {
    good: |x| (1.0e-7..=3600.0).contains(&x),
    must: "from 1e-7 to 3600 s",
};
/// Samples per second \[Hz\].
pub(crate) const RATE: Range = Range {
    good: |x| (1.0e-2..=1.0e7).contains(&x),
    must: "from 0.01 to 1e7 Hz",
};
/// Shortest substep that is allowed \[s\].
pub(crate) const SHORTEST: Range = Range {
    good: |x| (1.0e-9..=0.1).contains(&x),
    must: "from 1e-9 to 0.1 s",
};
/// Passes of an iteration.
pub(crate) const PASSES: Range = Range {
    good: |x| (1.0..=1000.0).contains(&x),
    must: "from 1 to 1000",
};
/// How many of something.
pub(crate) const COUNT: Range = Range {
    good: |x| (1.0..=1.0e6).contains(&x),
    must: "from 1 to 1000000",
};

impl Range {
    fn of(&self, x: f64) -> Option<String> {
        (!(self.good)(x)).then(|| format!("is {x}, it must be {}", self.must))
    }
}

/// A value made of numbers.
pub(crate) trait Numbers {
    /// Each of them.
    fn each(&self, visit: &mut dyn FnMut(f64));
}

impl Numbers for f64 {
    fn each(&self, visit: &mut dyn FnMut(f64)) {
        visit(*self);
    }
}

macro_rules! counts {
    ($($type:ty),*) => {$(
        impl Numbers for $type {
            fn each(&self, visit: &mut dyn FnMut(f64)) {
                visit(*self as f64);
            }
        }
    )*};
}
counts!(usize, u32, u64);

impl<T: Numbers> Numbers for Option<T> {
    fn each(&self, visit: &mut dyn FnMut(f64)) {
        self.iter().for_each(|x| x.each(visit));
    }
}

impl<T: Numbers> Numbers for Vec<T> {
    fn each(&self, visit: &mut dyn FnMut(f64)) {
        self.iter().for_each(|x| x.each(visit));
    }
}

impl<T: Numbers, const N: usize> Numbers for [T; N] {
    fn each(&self, visit: &mut dyn FnMut(f64)) {
        self.iter().for_each(|x| x.each(visit));
    }
}

impl<T: Numbers> Numbers for std::collections::BTreeMap<String, T> {
    fn each(&self, visit: &mut dyn FnMut(f64)) {
        self.values().for_each(|x| x.each(visit));
    }
}

impl<T: Numbers> Check<T> for Range {
    fn complaint(&self, value: &T, _: &Decoder) -> Option<String> {
        let mut first = None;
        value.each(&mut |x| {
            if first.is_none() {
                first = self.of(x);
            }
        });
        first
    }
}

/// A name must be that of one of these kinds of things.
pub(crate) struct Names(pub &'static [Kind]);

/// A rigid body.
pub(crate) const RIGID: Names = Names(&[Kind::Rigid]);
/// A deformable.
pub(crate) const DEFORMABLE: Names = Names(&[Kind::Deformable]);
/// A rigid body or a deformable.
pub(crate) const BODY: Names = Names(&[Kind::Rigid, Kind::Deformable]);
/// A joint.
pub(crate) const JOINT: Names = Names(&[Kind::Joint]);
/// What can exert a force on a deformable.
pub(crate) const PARTNER: Names = Names(&[
    Kind::Rigid,
    Kind::Collider,
    Kind::Deformable,
    Kind::Attachment,
]);
/// A probe.
pub(crate) const PROBE: Names = Names(&[Kind::Probe]);

impl Names {
    fn of(&self, name: &str, d: &Decoder) -> Option<String> {
        let known = || self.0.iter().filter_map(|kind| d.names.get(kind));
        if known().any(|names| names.contains(name)) {
            return None;
        }
        if d.is_full() {
            return Some(String::new());
        }
        let called = Kind::ALL.iter().filter(|(kind, _)| self.0.contains(kind));
        let things: Vec<&str> = called.map(|(_, thing)| *thing).collect();
        let known = known().flatten().map(String::as_str);
        Some(unknown(&things.join(" or "), name, known))
    }
}

impl Check<String> for Names {
    fn complaint(&self, name: &String, d: &Decoder) -> Option<String> {
        self.of(name, d)
    }
}

impl Check<Option<String>> for Names {
    fn complaint(&self, name: &Option<String>, d: &Decoder) -> Option<String> {
        name.as_ref().and_then(|name| self.of(name, d))
    }
}

impl Check<[String; 2]> for Names {
    fn complaint(&self, [a, b]: &[String; 2], d: &Decoder) -> Option<String> {
        self.of(a, d).or_else(|| self.of(b, d))
    }
}

/// A list must not be longer or shorter than makes sense.
pub(crate) struct Length {
    pub from: usize,
    pub to: usize,
}

impl<T> Check<Vec<T>> for Length {
    fn complaint(&self, list: &Vec<T>, _: &Decoder) -> Option<String> {
        let Self { from, to } = self;
        let n = list.len();
        (!(*from..=*to).contains(&n)).then(|| format!("has {n} items, it must have {from} to {to}"))
    }
}
