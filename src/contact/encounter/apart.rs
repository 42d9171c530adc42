//! How far apart what is listed was when it was last looked at.
//!
//! As [`Watch`](crate::contact::watch::Watch) does for elements and colliders: what was measured once cannot come nearer
//! than things have moved since. A list of pairs is short, but in a heap only a few of them are within reach.

/// Per place of a list, the way at which what stands there may touch \[m\].
#[derive(Clone, Debug, Default)]
pub struct Apart {
    due: Vec<f64>,
}

impl Apart {
    /// Forgets all distances: the list is another one.
    pub fn clear(&mut self) {
        self.due.clear();
    }

    /// Gets ready for a list of this length.
    pub fn fit(&mut self, count: usize) {
        if self.due.len() != count {
            self.due.clear();
            self.due.resize(count, f64::NEG_INFINITY);
        }
    }

    /// How far off what stands at a place is at least, after a way of `way` m \[m\]: below zero where that is not known.
    #[inline(always)]
    pub fn at_least(&self, place: usize, way: f64) -> f64 {
        self.due[place] - way
    }

    /// Notes that it is `distance` m off, or more.
    #[inline(always)]
    pub fn note(&mut self, place: usize, way: f64, distance: f64) {
        self.due[place] = way + distance;
    }
}
