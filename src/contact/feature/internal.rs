//! Edges and corners of a compound's parts that are none of the whole, because other parts go on beside them, and those of colliders
//! that lie flush, as the tiles of a floor do.
//!
//! The nodes of a body lie on such a seam as on a plane. Rows of its edges and faces would hold it a second time: where contacts
//! give, it would sink in by less.

use super::making::Making;
use super::part::Convex;
use super::sharp::GENTLE;
use crate::contact::beside::SAME;
use crate::contact::distance::{Crossing, Solid};
use crate::contact::form::Form;
use crate::math::DVec3;

/// How far beside a place is looked, in distances that count as touching, to find what lies one of them lower: two sides that
/// fall by as much meet in the sharpest bend that is left to the nodes.
const BESIDE: f64 = 2.0 / GENTLE;

/// How far from a part of which it is a side a seam may be by rounding, in distances that count as touching.
const SEAM: f64 = 1e-3;

impl Making<'_, '_> {
    /// Whether the place where an edge crosses one of the part is on no edge of the whole: beside it, along what crosses it there,
    /// another part goes on at the same height or rises.
    pub(super) fn is_internal_edge(&self, part: &Convex, [a, b]: [DVec3; 2], c: &Crossing) -> bool {
        let place = a.lerp(b, c.t) - c.normal * c.distance;
        if self.is_alone(place) {
            return false;
        }
        let across = (b - a).normalize_or_zero();
        let goes_on = |to| self.beside(part, place, [to, c.normal]) == Some(false);
        [across, -across].into_iter().any(goes_on) || self.is_joint(part, place, c.normal)
    }

    /// Whether a corner of the part is none of the whole: other parts go on where its own does not, all around.
    pub(super) fn is_internal_corner(&self, part: &Convex, corner: DVec3, normal: DVec3) -> bool {
        if self.is_alone(corner) {
            return false;
        }
        if self.is_joint(part, corner, normal) {
            return true;
        }
        let (u, v) = normal.any_orthonormal_pair();
        let mut others = false;
        let mut around = (0..8).map(|i| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_4).sin_cos();
            cos * u + sin * v
        });
        let filled = around.all(|to| {
            let found = self.beside(part, corner, [to, normal]);
            others |= found == Some(false);
            found.is_some()
        });
        filled && others
    }

    /// Whether it is the part itself that goes on beside a place in some direction; `None` if nothing does.
    fn beside(&self, part: &Convex, place: DVec3, [to, normal]: [DVec3; 2]) -> Option<bool> {
        let beside = place + self.site.reach.touching * (BESIDE * to - normal);
        // What lies in a seam, to rounding, is on the side of both parts, and not beside both.
        let (distance, _) = part.solid.signed_distance(beside);
        if distance < SEAM * self.site.reach.touching {
            return Some(true);
        }
        let whole = self.compound();
        let is_whole = whole.is_some_and(|w| w.signed_distance(part.to_collider(beside)).0 < 0.0);
        let goes_on = is_whole || self.is_inside_another(beside);
        goes_on.then_some(false)
    }

    /// Whether a place on an edge or a corner of the part can't be touched along a normal: another part or collider goes on
    /// there, flush with a face beside it, which can.
    fn is_joint(&self, part: &Convex, place: DVec3, normal: DVec3) -> bool {
        let touching = self.site.reach.touching;
        let is_open = |height: f64, normal: DVec3| {
            let end = place + normal * (touching - height);
            let room = self.site.beside.room(&self.frame, place, (height, normal));
            // Another part than its own.
            let whole = self.compound();
            let whole = whole.filter(|_| part.solid.signed_distance(end).0 >= 0.5 * touching);
            let whole = whole.map_or(touching, |w| w.signed_distance(part.to_collider(end)).0);
            room.min(whole) >= 0.5 * touching
        };
        let mut is_face = false;
        if !is_open(0.0, normal) {
            part.solid.exits(place, &mut |height, face| {
                is_face |= height > -touching && face.dot(normal) < SAME && is_open(height, face);
            });
        }
        is_face
    }

    /// Whether a place is inside another collider.
    fn is_inside_another(&self, place: DVec3) -> bool {
        self.site.beside.distance(&self.frame, place, 0.0) < 0.0
    }

    /// Whether the part is no part of a compound, and nothing else is near a place, so that no seam is.
    fn is_alone(&self, place: DVec3) -> bool {
        let far = (BESIDE + 2.0) * self.site.reach.touching;
        self.compound().is_none() && self.site.beside.is_far(&self.frame, place, far)
    }

    /// The whole of which the part is one of several.
    fn compound(&self) -> Option<&Solid> {
        match &self.target.form {
            Form::Solid(whole) if whole.is_compound() => Some(whole),
            _ => None,
        }
    }
}
