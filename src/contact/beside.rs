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
    /// Where they are.
    pub shadows: &'a [Shadow],
}

impl Beside<'_> {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.others.iter().all(|list| list.is_empty())
    }

    /// Whether a point of a frame is in another solid, or less than `margin` m outside.
    pub fn covers(&self, frame: &Frame, point: DVec3, margin: f64) -> bool {
        let point = frame.position + frame.axes * point;
        self.others.into_iter().flatten().any(|other| {
            let Form::Solid(solid) = &other.target.form else {
                return false;
            };
            let frame = other
                .target
                .frame(&self.shadows[other.target.shadow as usize]);
            let local = frame.axes.transpose() * (point - frame.position);
            let (lo, hi) = solid.bounds();
            let outside = (lo - local).max(local - hi).max_element();
            outside < margin && solid.signed_distance(local).0 < margin
        })
    }
}
