//! Pairs that may touch, and when they must be looked at.
//!
//! As [`Watch`](crate::contact::watch::Watch) does for elements and colliders: what was measured once cannot come nearer
//! than things have moved since. A list of pairs is short, but in a heap only a few of them are within reach.

/// A node, or an edge, of one body and an element, or an edge, of another.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Near {
    /// Of the one.
    pub own: u32,
    /// Of the other.
    pub other: u32,
    /// The way of both at which they may touch \[m\], found anew after a restart.
    #[cfg_attr(feature = "serde-serialize", serde(skip))]
    due: f64,
}

impl Near {
    /// A pair that is `distance` m apart, or more, before any way is made.
    pub fn new(own: u32, other: u32, distance: f64) -> Self {
        Self {
            own,
            other,
            due: distance,
        }
    }

    /// How far they are apart at least after a way of `way` m \[m\]: not above zero where that is not known.
    #[inline(always)]
    pub fn at_least(&self, way: f64) -> f64 {
        self.due - way
    }

    /// Notes that they are `distance` m apart, or more.
    #[inline(always)]
    pub fn note(&mut self, way: f64, distance: f64) {
        self.due = way + distance;
    }
}

/// Those at the start of a list of pairs that have the same first.
#[inline(always)]
pub fn of_the_same(list: &mut [Near]) -> Option<(&mut [Near], &mut [Near])> {
    let own = list.first()?.own;
    let count = list.iter().take_while(|near| near.own == own).count();
    Some(list.split_at_mut(count))
}
