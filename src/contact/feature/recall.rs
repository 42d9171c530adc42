//! What has been found of faces and edges that have hardly moved since.
//!
//! Which corners and edges of a part meet an element of the body, and from which side, changes only as the two move against
//! each other. So while an element stays where it was in the frame of the part, it is taken to meet the same things; how deep
//! they are is measured anew, exactly, in every substep. What it did not meet is found later by what it may have moved, a
//! part of what is looked ahead for anyway.

use crate::contact::site::Reach;
use crate::math::DVec3;

/// Every so manieth substep an element is looked at anew even at rest: what else the body can touch may have moved.
const MOST: u32 = 16;

/// Of what counts as shallow, how far the corners of an element may have moved.
const STILL: f64 = 0.5;

/// What was found of the elements of a body near the parts of a target, in their order; `W` is what is kept of a point.
#[derive(Clone, Debug)]
pub(super) struct Recall<W> {
    last: List<W>,
    next: List<W>,
    /// How many of the last ones have been passed by.
    passed: usize,
    /// How far corners may have moved \[m\].
    still: f64,
    /// The substep for which it was found \[s\].
    h: f64,
}

#[derive(Clone, Debug)]
struct List<W> {
    elements: Vec<Element>,
    points: Vec<W>,
}

/// An element that was looked at.
#[derive(Clone, Copy, Debug)]
struct Element {
    /// Of part and element.
    key: [u32; 2],
    corners: [DVec3; 4],
    /// How far it is from the part at least \[m\].
    apart: f64,
    /// Substeps since.
    age: u32,
    points: [u32; 2],
}

impl<W> Default for Recall<W> {
    fn default() -> Self {
        Self {
            last: List::default(),
            next: List::default(),
            passed: 0,
            still: 0.0,
            h: 0.0,
        }
    }
}

impl<W> Default for List<W> {
    fn default() -> Self {
        Self {
            elements: Vec::new(),
            points: Vec::new(),
        }
    }
}

impl<W> List<W> {
    fn clear(&mut self) {
        self.elements.clear();
        self.points.clear();
    }
}

impl<W: Copy> Recall<W> {
    /// Forgets all.
    pub fn forget(&mut self) {
        self.last.clear();
        self.next.clear();
    }

    /// Begins a substep.
    pub fn begin(&mut self, reach: &Reach) {
        std::mem::swap(&mut self.last, &mut self.next);
        self.next.clear();
        self.passed = 0;
        self.still = STILL * reach.shallow();
        // What is near enough is another thing in another substep.
        if std::mem::replace(&mut self.h, reach.h) != reach.h {
            self.last.clear();
        }
    }

    /// What was found of an element if that has not moved since: how far it is from the part at least \[m\], and its points.
    /// Elements come in ascending order.
    pub fn of(&mut self, key: [u32; 2], corners: &[DVec3]) -> Option<(f64, &[W])> {
        let elements = &self.last.elements;
        while elements.get(self.passed).is_some_and(|e| e.key < key) {
            self.passed += 1;
        }
        let element = elements.get(self.passed).filter(|e| e.key == key)?;
        let far = self.still * self.still;
        let mut both = corners.iter().zip(&element.corners);
        let rests = both.all(|(now, start)| now.distance_squared(*start) <= far);
        if !rests || element.age >= MOST {
            return None;
        }
        let [first, end] = element.points;
        let points = &self.last.points[first as usize..end as usize];
        Some(((element.apart - 2.0 * self.still).max(0.0), points))
    }

    /// Goes on with the element that was asked for last.
    pub fn go_on(&mut self) {
        let mut element = self.last.elements[self.passed];
        let [first, end] = element.points;
        let from = self.next.points.len() as u32;
        let points = &self.last.points[first as usize..end as usize];
        self.next.points.extend_from_slice(points);
        element.points = [from, from + (end - first)];
        element.age += 1;
        self.next.elements.push(element);
    }

    /// Notes what was found of an element, if it is within `near` m.
    pub fn note(
        &mut self,
        key: [u32; 2],
        corners: &[DVec3],
        (apart, near): (f64, f64),
        points: impl IntoIterator<Item = W>,
    ) {
        // At first all elements of a body are looked at, and most of them once.
        if apart > near + 2.0 * self.still {
            return;
        }
        let first = self.next.points.len() as u32;
        self.next.points.extend(points);
        let mut element = Element {
            key,
            corners: [DVec3::ZERO; 4],
            apart,
            age: 1,
            points: [first, self.next.points.len() as u32],
        };
        for (place, corner) in element.corners.iter_mut().zip(corners) {
            *place = *corner;
        }
        self.next.elements.push(element);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REACH: Reach = Reach {
        h: 1e-4,
        touching: 1e-5,
        farthest: 0.1,
        slack: 1e-4,
    };

    /// What is found of two edges that move by `way` m in each of some substeps: in how many they are looked at anew.
    fn looks(way: f64, substeps: usize) -> usize {
        let (mut recall, mut looks) = (Recall::default(), 0);
        for i in 0..substeps {
            recall.begin(&REACH);
            let at = DVec3::X * way * i as f64;
            for e in [3, 7] {
                let corners = [at, at + DVec3::Y];
                match recall.of([0, e], &corners) {
                    Some((apart, points)) => {
                        assert_eq!(points, [e, e + 1]);
                        assert!(apart <= 0.2 && apart > 0.199);
                        recall.go_on();
                    }
                    None => {
                        recall.note([0, e], &corners, (0.2, 0.2), [e, e + 1]);
                        looks += 1;
                    }
                }
            }
        }
        looks
    }

    #[test]
    fn what_moves_is_looked_at_as_often_as_it_has_moved() {
        assert_eq!(looks(0.0, 32), 4);
        // Half of what counts as shallow is 50 µm.
        assert_eq!(looks(2e-5, 32), 22);
        assert_eq!(looks(6e-5, 32), 64);
    }

    #[test]
    fn what_is_far_is_not_kept() {
        let mut recall = Recall::default();
        recall.begin(&REACH);
        recall.note([0, 1], &[DVec3::ZERO], (0.3, 0.2), [1]);
        recall.begin(&REACH);
        assert!(recall.of([0, 1], &[DVec3::ZERO]).is_none());
    }

    #[test]
    fn nothing_is_known_of_what_was_not_looked_at() {
        let mut recall = Recall::default();
        recall.begin(&REACH);
        recall.note([0, 1], &[DVec3::ZERO], (0.0, 0.1), [1]);
        recall.begin(&REACH);
        assert!(recall.of([0, 0], &[DVec3::ZERO]).is_none());
        assert!(recall.of([1, 0], &[DVec3::ZERO]).is_none());
        // It has not been asked for in the substep before.
        recall.begin(&REACH);
        assert!(recall.of([0, 1], &[DVec3::ZERO]).is_none());
        recall.note([0, 1], &[DVec3::ZERO], (0.0, 0.1), [1]);
        recall.begin(&Reach { h: 2e-4, ..REACH });
        assert!(recall.of([0, 1], &[DVec3::ZERO]).is_none());
        // What is no number has moved.
        recall.note([0, 1], &[DVec3::NAN], (0.0, 0.1), [1]);
        recall.begin(&Reach { h: 2e-4, ..REACH });
        assert!(recall.of([0, 1], &[DVec3::NAN]).is_none());
    }
}
