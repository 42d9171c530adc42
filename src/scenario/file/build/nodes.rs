//! Which nodes a formula means.

use super::super::formula::Formula;
use super::super::model::Region;
use super::RunError;
use crate::body::NodeId;
use crate::math::Vector;
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
        let wide = |v: Vector| v.to_array().map(f64::from);
        Self {
            low: wide(low),
            high: wide(high),
        }
    }

    /// The corners of a body at rest.
    pub fn of(body: &Deformable) -> Self {
        Self::around(body.blueprint().nodes.iter().map(|n| n.position))
    }

    /// Whether a formula holds at a place.
    pub fn holds(&self, formula: &Formula, at: Vector) -> bool {
        let [x, y, z] = at.to_array().map(f64::from);
        let ([a, b, c], [d, e, f]) = (self.low, self.high);
        let value = formula.value(&[x, y, z, a, b, c, d, e, f]);
        value != 0.0 && !value.is_nan()
    }
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
