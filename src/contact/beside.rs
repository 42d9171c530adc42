//! What else a body can touch beside a target. Colliders that lie flush, as the tiles of a floor do, hide faces of each other:
//! a way out of one that ends in the next is none.

use super::candidates::Candidates;
use super::form::Form;
use super::target::Frame;
use crate::math::DVec3;
use crate::solve::shadow::Shadow;

/// The other targets of a body.
#[derive(Clone, Copy)]
pub struct Beside<'a> {
    /// Those before and behind the one in question.
    pub others: [&'a [Candidates]; 2],
    /// The shadows of the group.
    pub shadows: &'a [Shadow],
    /// Distance that counts as touching \[m\].
    pub touching: f64,
}

impl Beside<'_> {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.others.iter().all(|list| list.is_empty())
    }

    /// Whether they are all farther than `far` m from a point of a frame, as far as balls around them tell.
    pub fn is_far(&self, frame: &Frame, point: DVec3, far: f64) -> bool {
        let point = frame.position + frame.axes * point;
        let mut others = self.others.into_iter().flatten();
        others.all(|other| {
            let middle = other.frame().map(|frame| frame.position);
            middle.is_none_or(|middle| middle.distance(point) > other.target.extent + far)
        })
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

    /// What is left of a way of a point of a frame over `time` s \[m\] where others hold it that it comes to and that are nearer than `most` m,
    /// less what is kept from them; `None` if there are none. The frame moves with `shadow`.
    pub fn held(
        &self,
        (frame, shadow): (&Frame, &Shadow),
        point: DVec3,
        (mut way, time): (DVec3, f64),
        most: f64,
    ) -> Option<DVec3> {
        let mut is_held = false;
        let place = frame.position + frame.axes * point;
        let velocity = |of: &Shadow| of.velocity_at(place - of.com);
        for other in self.others.into_iter().flatten() {
            let (Form::Solid(solid), Some(its)) = (&other.target.form, other.frame()) else {
                continue;
            };
            let (offset, skin) = (place - its.position, other.target.skin);
            if offset.length() - other.target.extent - skin >= most {
                continue;
            }
            let (distance, normal) = solid.signed_distance(its.axes.transpose() * offset);
            let normal = its.axes * normal;
            let comes = velocity(&self.shadows[other.target.shadow as usize]) - velocity(shadow);
            let comes = comes.dot(normal) * time;
            let normal = frame.axes.transpose() * normal;
            let (gap, along) = (distance - skin, way.dot(normal) - comes);
            if gap < most && gap + along <= self.touching {
                way -= normal * (along + gap.max(0.0)).min(0.0);
                is_held = true;
            }
        }
        is_held.then_some(way)
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
}

/// Cosine of an angle within which two normals are of one face.
pub const SAME: f64 = 0.7;
