//! What else a body can touch beside a target. Colliders that lie flush, as the tiles of a floor do, hide faces of each other:
//! a way out of one that ends in the next is none.

use super::candidates::Candidates;
use super::form::Form;
use super::site::Reach;
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
    /// What is near enough.
    pub reach: Reach,
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
        self.nearest(frame, point, most)
            .map_or(most, |(distance, _)| distance)
    }

    /// That of the nearest other solid, if it is nearer than `most` m, and its normal there, in the frame.
    pub fn nearest(&self, frame: &Frame, point: DVec3, most: f64) -> Option<(f64, DVec3)> {
        let point = frame.position + frame.axes * point;
        let others = self.others.into_iter().flatten();
        let (distance, normal) = others.fold((most, None), |nearest, other| {
            let (Form::Solid(solid), Some(its)) = (&other.target.form, other.frame()) else {
                return nearest;
            };
            let offset = point - its.position;
            if offset.length() - other.target.extent >= nearest.0 {
                return nearest;
            }
            let (distance, normal) = solid.signed_distance(its.axes.transpose() * offset);
            if distance < nearest.0 {
                (distance, Some(its.axes * normal))
            } else {
                nearest
            }
        });
        Some((distance, frame.axes.transpose() * normal?))
    }

    /// The normals with which a node touched other solids last, in a frame.
    pub fn touched(&self, frame: &Frame, node: u32) -> impl Iterator<Item = DVec3> {
        let others = self.others.into_iter().flatten();
        let normals = others.filter_map(move |other| {
            let axes = other.frame()?.axes;
            Some(axes * other.touched(node)?)
        });
        let axes = frame.axes.transpose();
        normals.map(move |normal| axes * normal)
    }

    /// From where to where a point in a frame that moves with `shadow` goes on its way over `time` s where other solids hold
    /// it: those nearer than `most` m, less what is kept from them, on which it lies or to which it comes. It is lifted to a
    /// little above them \[m\]. `None` if none do.
    pub fn held(
        &self,
        (frame, shadow): (&Frame, &Shadow),
        point: DVec3,
        (mut way, time): (DVec3, f64),
        most: f64,
    ) -> Option<[DVec3; 2]> {
        let Reach {
            touching, slack, ..
        } = self.reach;
        let mut held = None;
        let place = frame.position + frame.axes * point;
        let velocity = |of: &Shadow| of.velocity_at(place - of.com);
        for other in self.others.into_iter().flatten() {
            let Candidates { target, .. } = other;
            let (Form::Solid(solid), Some(its)) = (&target.form, other.frame()) else {
                continue;
            };
            let (offset, skin) = (place - its.position, target.skin);
            let is_far = offset.length() - target.extent - skin >= most;
            if is_far || target.node_share == 0.0 {
                continue;
            }
            let start = its.axes.transpose() * offset;
            let (distance, normal) = solid.signed_distance(start);
            let gap = distance - skin;
            if gap >= most {
                continue;
            }
            let comes = velocity(&self.shadows[target.shadow as usize]) - velocity(shadow);
            let path = its.axes.transpose() * (frame.axes * way - comes * time);
            let along = path.dot(normal);
            let lies = gap <= touching && along.abs() <= slack;
            // A plane has no end, but a plate has: what goes past its edge is not held by it.
            let meets = || {
                let (nearest, there) = solid.nearest_on_path(start, start + path);
                let deep = nearest - skin;
                deep <= -touching || deep <= touching && there.dot(normal) >= SAME
            };
            if lies || meets() {
                let outward = frame.axes.transpose() * (its.axes * normal);
                way -= outward * (along + gap.max(0.0)).min(0.0);
                let from = held.unwrap_or(point);
                held = Some(from + outward * (touching - gap).max(0.0));
            }
        }
        held.map(|from| [from, from + way])
    }

    /// How far off all others a way out of a solid ends, from a place at this height over a face with this normal \[m\]. It ends as much
    /// outside as counts as touching, and more than that is not told.
    pub fn room(&self, frame: &Frame, place: DVec3, (height, normal): (f64, DVec3)) -> f64 {
        let end = place + normal * (self.reach.touching - height);
        self.distance(frame, end, self.reach.touching)
    }
}

/// Cosine of an angle within which two normals are of one face.
pub const SAME: f64 = 0.7;
