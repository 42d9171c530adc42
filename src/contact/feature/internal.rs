//! Edges and corners of a compound's parts that are none of the whole, because other parts go on beside them.
//!
//! The nodes of a body lie on such a seam as on a plane. Rows of its edges and faces would hold it a second time: where contacts
//! give, it would sink in by less.

use super::making::Making;
use super::part::Convex;
use super::sharp::GENTLE;
use crate::contact::distance::Solid;
use crate::contact::form::Form;
use crate::math::DVec3;

/// How far beside a place is looked, in distances that count as touching, to find what lies one of them lower: two sides that
/// fall by as much meet in the sharpest bend that is left to the nodes.
const BESIDE: f64 = 2.0 / GENTLE;

/// How far from a part of which it is a side a seam may be by rounding, in distances that count as touching.
const SEAM: f64 = 1e-3;

impl Making<'_, '_> {
    /// Whether a place on an edge of the part is on no edge of the whole: beside it, along what crosses it there, another part goes on
    /// at the same height or rises.
    pub(super) fn is_internal_edge(
        &self,
        part: &Convex,
        place: DVec3,
        across: DVec3,
        normal: DVec3,
    ) -> bool {
        let whole = self.compound();
        whole.is_some_and(|whole| {
            let mut sides = [across, -across].into_iter();
            sides.any(|to| matches!(self.beside(whole, part, place, [to, normal]), Some(false)))
        })
    }

    /// Whether a corner of the part is none of the whole: other parts go on where its own does not, all around.
    pub(super) fn is_internal_corner(&self, part: &Convex, corner: DVec3, normal: DVec3) -> bool {
        let (u, v) = normal.any_orthonormal_pair();
        let whole = self.compound();
        whole.is_some_and(|whole| {
            let mut others = false;
            let mut around = (0..8).map(|i| {
                let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_4).sin_cos();
                cos * u + sin * v
            });
            let filled = around.all(|to| {
                let found = self.beside(whole, part, corner, [to, normal]);
                others |= found == Some(false);
                found.is_some()
            });
            filled && others
        })
    }

    /// Whether it is the part itself that goes on beside a place in some direction; `None` if nothing does.
    fn beside(
        &self,
        whole: &Solid,
        part: &Convex,
        place: DVec3,
        [to, normal]: [DVec3; 2],
    ) -> Option<bool> {
        let beside = place + self.site.reach.touching * (BESIDE * to - normal);
        // What lies in a seam, to rounding, is on the side of both parts, and not beside both.
        let (distance, _) = part.solid.signed_distance(beside);
        if distance < SEAM * self.site.reach.touching {
            return Some(true);
        }
        let (distance, _) = whole.signed_distance(part.to_collider(beside));
        (distance < 0.0).then_some(false)
    }

    /// The whole of which the part is one of several.
    fn compound(&self) -> Option<&Solid> {
        match &self.target.form {
            Form::Solid(whole) if whole.is_compound() => Some(whole),
            _ => None,
        }
    }
}
