//! What else a body can touch beside a target. Colliders that lie flush, as the tiles of a floor do, hide faces of each other:
//! a way out of one that ends in the next is none.

use super::candidates::Candidates;
use super::distance::Solid;
use super::form::Form;
use super::target::Frame;
use crate::math::DVec3;

/// The other targets of a body.
#[derive(Clone, Copy)]
pub struct Beside<'a> {
    /// Those before and behind the one in question.
    pub others: [&'a [Candidates]; 2],
    /// Distance that counts as touching \[m\].
    pub touching: f64,
}

impl Beside<'_> {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.others.iter().all(|list| list.is_empty())
    }

    /// How far a point of a frame is from the nearest other solid, negative inside, or `most` if that is less \[m\].
    pub fn distance(&self, frame: &Frame, point: DVec3, most: f64) -> f64 {
        let point = frame.position + frame.axes * point;
        let others = self.others.into_iter().flatten();
        others.fold(most, |nearest, other| {
            let (Form::Solid(solid), Some(frame)) = (&other.target.form, other.frame()) else {
                return nearest;
            };
            let offset = point - frame.position;
            if offset.length() - other.target.extent >= nearest {
                return nearest;
            }
            let local = frame.axes.transpose() * offset;
            nearest.min(solid.signed_distance(local).0)
        })
    }

    /// How far off all others a way out of a solid ends, from a place at this height over a face with this normal \[m\]. It ends as much
    /// outside as counts as touching, and more than that is not told.
    pub fn room(&self, frame: &Frame, place: DVec3, (height, normal): (f64, DVec3)) -> f64 {
        let end = place + normal * (self.touching - height);
        self.distance(frame, end, self.touching)
    }

    /// Whether that way ends in another solid, or on its surface: what lies there is no face of both together.
    pub fn hides(&self, frame: &Frame, place: DVec3, way: (f64, DVec3)) -> bool {
        self.room(frame, place, way) < 0.5 * self.touching
    }

    /// Whether a place on an edge or a corner of a solid can't be touched along a normal: others go on there, flush with a face
    /// beside it, which can.
    pub fn goes_on(&self, solid: &Solid, frame: &Frame, place: DVec3, normal: DVec3) -> bool {
        if !self.hides(frame, place, (0.0, normal)) {
            return false;
        }
        let mut is_face = false;
        solid.exits(place, &mut |height, face| {
            is_face |= height > -self.touching
                && face.dot(normal) < SAME
                && !self.hides(frame, place, (height, face));
        });
        is_face
    }
}

/// Cosine of an angle within which two normals are of one face.
pub const SAME: f64 = 0.7;
