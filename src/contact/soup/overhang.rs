//! Nodes that hang over the border of a surface.
//!
//! A sheet drawn over the edge of a blade rests on that edge by its own edges. Its nodes come to the blade a hair above or
//! below the border, as rounding has it, and one that a facet took for its own there would be dragged along. So a facet lets
//! a node pass at a border that an edge of the node touches, if that edge leads round it.

use super::edges::side_id;
use super::facet::{Patch, on_side, per};
use super::near::Near;
use super::slide::LIFT;
use crate::math::DVec3;

/// How far an edge must lead to the far side of a facet, as a sine, to lead round its border rather than along its face.
const ROUND: f64 = 0.1;

/// An edge of a body that touches a border of a surface, as one of its nodes has it; in the frame of the surface.
#[derive(Clone, Copy, Debug)]
pub struct Overhang {
    /// The node.
    pub node: u32,
    /// The border, by the number of the one facet's side.
    pub border: u32,
    /// Where the edge leads \[m\].
    pub end: DVec3,
    /// How long it is \[m\].
    pub length: f64,
}

/// How near counts \[m\].
#[derive(Clone, Copy, Debug)]
pub struct Margins {
    /// Beside a border a node is at it.
    pub border: f64,
    /// What touches may be as far behind a surface, without having gone round it.
    pub touching: f64,
}

impl Overhang {
    /// Whether the facet lets the node at `p` pass that was last on its side at `from`.
    fn passes(&self, patch: &Patch, p: DVec3, from: DVec3, border: f64) -> bool {
        let (sides, count) = patch.sides();
        let own = (0..).zip(&sides[..count]);
        let mut own = own.filter(|(k, _)| side_id(patch.id, *k) == self.border);
        let beside = |&(a, ab): &(DVec3, DVec3)| {
            let foot = patch.foot(p).point;
            on_side(a, ab, per(ab.length_squared()), foot).distance2 < border * border
        };
        let beyond = -patch.height(self.end) * patch.height(from).signum();
        beyond > ROUND * self.length && own.any(|(_, side)| beside(side))
    }
}

/// The facets that do not let the node at `p` pass, put into `slots`; it was last on their side at `from`. Also returns what
/// leads back to the right side of those that do, where the node has not truly left it.
pub fn bearing<'a>(
    near: Near<'a>,
    overhangs: &[Overhang],
    (p, from): (DVec3, DVec3),
    margins: Margins,
    slots: &'a mut Vec<u32>,
) -> (Near<'a>, DVec3) {
    let mut back = DVec3::ZERO;
    slots.clear();
    for (slot, patch) in near.iter() {
        let passes = |over: &Overhang| over.passes(patch, p, from, margins.border);
        if !overhangs.iter().any(passes) {
            slots.push(slot);
            continue;
        }
        let side = patch.height(from).signum();
        let behind = -patch.height(p) * side;
        if (0.0..=margins.touching).contains(&behind) {
            back += patch.normal * (side * (behind + LIFT));
        }
    }
    (Near { slots, ..near }, back)
}
