//! Which nodes a formula means.
//!
//! A node stands at 0.6 m as `f32` has it, which is more than 0.6; nobody who writes `z > 0.6` means that one. So places
//! are taken for the shortest decimal number that they are read back from.

use super::super::formula::Formula;
use super::super::model::Region;
use super::RunError;
use crate::body::NodeId;
use crate::math::{Real, Vector};
use crate::world::Deformable;

/// Places in a body's own frame, and the corners of the body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Places {
    low: [f64; 3],
    high: [f64; 3],
}

impl Places {
    /// The corners of these places.
    pub fn around(places: impl Iterator<Item = Vector>) -> Self {
        let start = (Vector::INFINITY, Vector::NEG_INFINITY);
        let (low, high) = places.fold(start, |(lo, hi), p| (lo.min(p), hi.max(p)));
        Self {
            low: low.to_array().map(decimal),
            high: high.to_array().map(decimal),
        }
    }

    /// The corners of a body at rest.
    pub fn of(body: &Deformable) -> Self {
        Self::around(body.blueprint().nodes.iter().map(|n| n.position))
    }

    /// Whether a formula holds at a place.
    pub fn holds(&self, formula: &Formula, at: Vector) -> bool {
        let [x, y, z] = at.to_array().map(decimal);
        let ([a, b, c], [d, e, f]) = (self.low, self.high);
        let value = formula.value(&[x, y, z, a, b, c, d, e, f]);
        value != 0.0 && !value.is_nan()
    }
}

/// The shortest decimal number that is read back as `x`.
fn decimal(x: Real) -> f64 {
    let written = x.to_string();
    written.parse().unwrap_or_else(|_| x.into())
}

/// The nodes of a body that a region selects, all without one.
pub(crate) fn selected(
    body: &Deformable,
    region: Option<&Region>,
    what: &'static str,
    name: &str,
) -> Result<Vec<NodeId>, RunError> {
    let places = Places::of(body);
    let holds = |at| region.is_none_or(|r| places.holds(&r.0, at));
    let nodes = (0..).zip(&body.blueprint().nodes);
    let nodes: Vec<NodeId> = nodes
        .filter(|(_, n)| holds(n.position))
        .map(|(i, _)| NodeId(i))
        .collect();
    match region {
        Some(region) if nodes.is_empty() => Err(RunError::Nothing {
            what,
            formula: region.0.text().into(),
            body: name.into(),
        }),
        _ => Ok(nodes),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::model::deformable::PLACE;
    use super::*;

    #[test]
    fn a_node_at_a_decimal_number_is_there() {
        let places = Places::around([Vector::splat(-0.3), Vector::splat(0.6)].into_iter());
        let holds = |text: &str, at: Vector| {
            let formula = Formula::new(text, &Default::default(), &PLACE).unwrap();
            places.holds(&formula, at)
        };
        let at = Vector::new(0.6, -0.3, 0.1);
        for yes in ["x == 0.6", "x >= max_x", "y == min_y", "x + y > 0.29", "z"] {
            assert!(holds(yes, at), "{yes}");
        }
        for no in ["x > 0.6", "x < 0.6", "y < min_y", "0", "0 / 0"] {
            assert!(!holds(no, at), "{no}");
        }
    }
}
