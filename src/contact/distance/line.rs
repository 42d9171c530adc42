//! A solid along a line: where a moving point enters it, and where a segment comes nearest to it. Both rest on the distance
//! to a convex solid being convex along any line, so its tangents bound it from below.

use super::{Core, Solid};
use crate::math::DVec3;

impl Solid {
    /// The first part t of the way from `a` to `b` \[m\] at which a point enters the solid, and the outward normal there;
    /// `None` if it never does or starts inside. No solid is too thin to be seen.
    pub fn cast(&self, a: DVec3, b: DVec3) -> Option<(f64, DVec3)> {
        match &self.core {
            Core::Compound(compound) => compound.cast(a, b),
            Core::Voxels(grid) => grid.cast(a, b),
            // Over its planes a hull is as convex and has the same surface, and needs no search for edges.
            Core::Hull(hull) if self.radius == 0.0 && !hull.is_sheet() => {
                enter(|p| hull.highest(p), a, b)
            }
            _ => enter(|p| self.signed_distance(p), a, b),
        }
    }

    /// The least signed distance of a point that moves from `a` to `b` \[m\] and the normal there; for compounds and voxels
    /// those of the place of entry, or of `a` if that is inside, or of `b`.
    pub fn nearest_on_path(&self, a: DVec3, b: DVec3) -> (f64, DVec3) {
        match &self.core {
            Core::Compound(_) | Core::Voxels(_) => match self.cast(a, b) {
                Some((_, normal)) => (0.0, normal),
                None => {
                    let start = self.signed_distance(a);
                    if start.0 <= 0.0 {
                        start
                    } else {
                        self.signed_distance(b)
                    }
                }
            },
            _ => {
                let (_, distance, normal) = self.nearest_on_segment(a, b);
                (distance, normal)
            }
        }
    }

    /// Whether all of the segment `a`–`b` \[m\] is farther off than `least` m, which may be negative; of voxels it is enough
    /// that it goes into any.
    pub fn is_off(&self, a: DVec3, b: DVec3, least: f64) -> bool {
        match &self.core {
            Core::Compound(compound) => compound.is_off(a, b, least),
            Core::Voxels(_) => least <= 0.0 && self.cast(a, b).is_none(),
            _ => self.nearest_on_segment(a, b).1 > least,
        }
    }

    /// Where on the segment `a`–`b` \[m\] the signed distance to a convex solid is least: the part t of the way, that
    /// distance \[m\] and the outward unit normal. Between the ends the normal is perpendicular to the segment, so across an
    /// edge of the solid it is perpendicular to both, and the distance of a segment that has entered is measured along
    /// it. Only where the segment pierces a thin solid is there no such normal: then it is that of the nearest face. For a
    /// compound or voxels it is one of the places where the distance has a minimum: go through the parts instead.
    pub fn nearest_on_segment(&self, a: DVec3, b: DVec3) -> (f64, f64, DVec3) {
        let path = b - a;
        let at = |t: f64| {
            let (distance, normal) = self.signed_distance(a + path * t);
            Sample {
                t,
                distance,
                normal,
                slope: normal.dot(path),
            }
        };
        // A segment parallel to a face is nearest everywhere.
        let flat = 1e-12 * path.length();
        let mut low = at(0.0);
        if low.slope >= -flat || low.slope.is_nan() {
            return low.answer();
        }
        let mut high = at(1.0);
        if high.slope <= flat || high.slope.is_nan() {
            return high.answer();
        }
        for i in 0..MOST_STEPS {
            let (meet, bound) = low.tangents_meet(&high);
            let width = high.t - low.t;
            if low.distance.min(high.distance) - bound <= flat || width < 1e-9 {
                break;
            }
            // In turn where the tangents meet (ends at a kink in one step), where the slope would vanish were it linear
            // (soon ends where the distance is smooth), and the middle (always ends).
            let t = match i % 3 {
                0 => meet,
                1 => low.t - low.slope * width / (high.slope - low.slope),
                _ => low.t + 0.5 * width,
            };
            let new = at(t.clamp(low.t + 1e-3 * width, high.t - 1e-3 * width));
            if new.slope.abs() <= flat {
                return new.answer();
            }
            if new.slope < 0.0 {
                low = new;
            } else {
                high = new;
            }
        }
        low.between(&high)
    }
}

/// Every third step halves the bracket at least, so this many end at any width that counts.
const MOST_STEPS: usize = 90;

/// The distance at one place of a segment.
#[derive(Clone, Copy)]
struct Sample {
    t: f64,
    distance: f64,
    normal: DVec3,
    /// Change of the distance from end to end were it to go on like this \[m\].
    slope: f64,
}

impl Sample {
    fn answer(&self) -> (f64, f64, DVec3) {
        (self.t, self.distance, self.normal)
    }

    /// Where the tangents of two samples meet, and at what distance: the least there can be between them.
    fn tangents_meet(&self, high: &Self) -> (f64, f64) {
        let fall = high.distance - self.distance - high.slope * (high.t - self.t);
        let t = self.t + fall / (self.slope - high.slope);
        (t, self.distance + self.slope * (t - self.t))
    }

    /// The answer from samples close to both sides of the minimum: of the normals between theirs, the one perpendicular to
    /// the segment.
    fn between(&self, high: &Self) -> (f64, f64, DVec3) {
        let weight = high.slope / (high.slope - self.slope);
        let normal = self.normal * weight + high.normal * (1.0 - weight);
        let length = normal.length();
        let nearest = if self.distance < high.distance {
            self
        } else {
            high
        };
        // Also where the length is no number.
        if length <= 0.1 || length.is_nan() {
            return nearest.answer();
        }
        let distance = if nearest.distance < 0.0 {
            nearest.distance / length
        } else {
            nearest.distance
        };
        (nearest.t, distance, normal / length)
    }
}

/// Newton's method from outside. The tangent of a convex distance lies below it, so a step never goes past the entry, a
/// face is reached in one, and a slope that has turned upwards proves a miss.
pub fn enter(distance: impl Fn(DVec3) -> (f64, DVec3), a: DVec3, b: DVec3) -> Option<(f64, DVec3)> {
    let path = b - a;
    let length = path.length();
    let close = 1e-13 * (a.length() + length);
    let (mut d, mut n) = distance(a);
    // Inside, out of reach, or no number.
    if !(0.0..=length).contains(&d) {
        return None;
    }
    let mut t = 0.0;
    // A path that only grazes halves its distance with every step.
    for _ in 0..64 {
        let slope = n.dot(path);
        if slope >= 0.0 || slope.is_nan() {
            return None;
        }
        if d <= close {
            return Some((t, n));
        }
        t -= d / slope;
        if t > 1.0 || t.is_nan() {
            return None;
        }
        (d, n) = distance(a + path * t);
    }
    (d <= 1e-9 * length).then_some((t, n))
}
