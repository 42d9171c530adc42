//! What happens over time: forces, led motions, motors.

use super::super::check::{BODY, JOINT};
use super::super::decode::{Decode, Decoder};
use super::super::formula::Formula;
use super::super::schema::choice;
use super::super::tree::{Node, Value};
use super::deformable::Region;

choice! {
    /// What acts on a body or a joint over time.
    pub enum Act {
        /// A force on a rigid body or, shared among its nodes by mass, on a deformable.
        Force {
            /// The body.
            on: String, BODY;
            /// Which nodes of a deformable: a formula of x, y, z; all if it is left out.
            nodes: Option<Region> = None;
            /// The force \[N\], each component a number, a formula of t \[s\], or a table of \[t, value\].
            force: [Signal; 3] = Signal::none();
            /// A torque on a rigid body \[N·m\].
            torque: [Signal; 3] = Signal::none();
        };
        /// Leads a kinematic body, or the pinned nodes of a deformable, away from where they began.
        Move {
            /// The body.
            of: String, BODY;
            /// Which pinned nodes of a deformable: a formula of x, y, z; all if it is left out.
            nodes: Option<Region> = None;
            /// How far \[m\], each component a number, a formula of t \[s\], or a table of \[t, value\].
            by: [Signal; 3] = Signal::none();
            /// How far it is turned about its own origin, of a rigid body: an axis, as long as the angle \[rad\].
            turn: [Signal; 3] = Signal::none();
        };
        /// Changes what a motor aims at.
        Drive {
            /// The joint; it must have a motor.
            joint: String, JOINT;
            /// Place \[m\] or \[rad\].
            position: Option<Signal> = None;
            /// Velocity \[m/s\] or \[rad/s\].
            velocity: Option<Signal> = None;
        };
    }
}

/// A number over time.
#[derive(Clone, Debug, PartialEq)]
pub enum Signal {
    /// Always the same.
    Constant(f64),
    /// A formula of t \[s\].
    Formula(Formula),
    /// Straight lines from point to point \[s, value\]; before the first and after the last it keeps their values.
    Table(Vec<[f64; 2]>),
}

impl Signal {
    /// Nothing at all, along three axes.
    pub fn none() -> [Self; 3] {
        [0.0; 3].map(Self::Constant)
    }

    /// Its value at a time \[s\].
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Constant(x) => *x,
            Self::Formula(formula) => formula.value(&[time]),
            Self::Table(points) => {
                let after = points.partition_point(|p| p[0] <= time);
                match (points.get(after.wrapping_sub(1)), points.get(after)) {
                    (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (time - a[0]) / (b[0] - a[0]),
                    (Some(last), None) => last[1],
                    (None, Some(first)) => first[1],
                    (None, None) => 0.0,
                }
            }
        }
    }
}

impl Decode for Signal {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        match &node.value {
            Value::Number(x) if (*x as f32).is_finite() => Some(Self::Constant(*x)),
            Value::Text(_) => d.formula_of(node, &["t"]).map(Self::Formula),
            Value::List(_) => {
                let points = Vec::<[f64; 2]>::decode(node, d)?;
                let rising = points.windows(2).all(|p| p[0][0] < p[1][0]);
                if points.is_empty()
                    || !rising
                    || !points.iter().flatten().all(|x| (*x as f32).is_finite())
                {
                    let what = "a table needs points [t, value] with finite numbers and rising t";
                    d.wrong(node.at, |_| what.into());
                    return None;
                }
                Some(Self::Table(points))
            }
            _ => d.expected(
                node,
                "a finite number, a formula of t in quotes, or a table",
            ),
        }
    }
}

impl serde::Serialize for Signal {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Constant(x) => serializer.serialize_f64(*x),
            Self::Formula(formula) => serializer.serialize_str(formula.text()),
            Self::Table(points) => serializer.collect_seq(points),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_straight_between_its_points() {
        let table = Signal::Table(vec![[1.0, 10.0], [2.0, 20.0], [4.0, 0.0]]);
        for (time, value) in [
            (0.0, 10.0),
            (1.0, 10.0),
            (1.5, 15.0),
            (3.0, 10.0),
            (9.0, 0.0),
        ] {
            assert_eq!(table.at(time), value, "at {time}");
        }
    }
}
