//! Where rims and straight lines of a solid are lowest over a twisted face. Over a flat one these are points for its normal, and
//! the ends of lines. The quads of a loaded sheet bend up along one diagonal and down along the other: over them a rim may be
//! lowest in two places, anywhere on it, and the side of a cylinder or the edge of a box that lies along the ridge touches
//! nothing but the middle of the face.

use super::convex::bounds;
use super::patch::Patch;
use super::sharp::FLAT;
use crate::contact::distance::{Rim, Solid};
use crate::math::DVec3;

/// How far a search goes at first, and at most, in rad round a rim.
const STEP: f64 = 0.1;
const FARTHEST: f64 = 2.0;

/// How often a first step that leaves the face is halved, and how many steps of the secant method follow.
const HALVINGS: usize = 4;
const SECANTS: usize = 6;

/// From how many places of a rim it is searched for.
const STARTS: usize = 5;

/// Nearer than this per radius, two places of a rim are one.
const ALIKE: f64 = 0.05;

/// A twisted face, and what is over it.
pub(super) struct Ridge<'a> {
    pub patch: &'a Patch,
    /// Unit normal at its middle, towards the solid.
    pub normal: DVec3,
    pub solid: &'a Solid,
    /// How far from the face a line can be and still matter \[m\].
    pub near: f64,
}

impl Ridge<'_> {
    /// Calls `found` for the lowest points, with numbers that follow those of the `features` of the solid; not for those that are
    /// among these \[m\].
    pub fn lowest(&self, features: &[DVec3], found: &mut dyn FnMut((u32, DVec3))) {
        let mut next = features.len() as u32;
        let (middle, _) = self.patch.ball();
        for rim in self.solid.rims() {
            let mut places = [DVec3::INFINITY; STARTS];
            for (k, start) in self.starts(middle).into_iter().enumerate() {
                let Some(point) = self.descend(&Curve::Ring(rim, start), 0.0) else {
                    continue;
                };
                let near = ALIKE * rim.radius;
                let mut all = features.iter().chain(&places[..k]);
                if all.all(|other| other.distance(point) >= near) {
                    places[k] = point;
                    found((next + k as u32, point));
                }
            }
            next += STARTS as u32;
        }
        let (lo, hi) = bounds(self.patch.corners().iter().copied());
        let margin = DVec3::splat(self.near + self.solid.edge_radius());
        let descend = |[a, b]: [DVec3; 2]| {
            let apart = a.max(b).cmplt(lo - margin) | a.min(b).cmpgt(hi + margin);
            if apart.any() {
                return None;
            }
            let start = (middle - a).dot(b - a) / a.distance_squared(b);
            self.descend(&Curve::Line(a, b), start)
        };
        let mut on_side = None;
        self.solid.for_each_line(self.normal, &mut |i, line| {
            if let Some(point) = descend(line) {
                on_side = Some(point);
                if !self.solid.has_rim() {
                    found((next + i, point));
                }
            }
        });
        // The side of a cylinder or a cone is lowest along another line for the normal there.
        if self.solid.has_rim()
            && let Some(normal) = on_side.and_then(|point| self.below(point))
        {
            self.solid.for_each_line(normal, &mut |i, line| {
                if let Some(point) = descend(line) {
                    found((next + i, point));
                }
            });
        }
    }

    /// Directions from the axis: to what is lowest for the normal of the middle, from there on by quarters, and to the middle.
    fn starts(&self, middle: DVec3) -> [DVec3; STARTS] {
        let flat = |v: DVec3| DVec3::new(v.x, 0.0, v.z).normalize_or(DVec3::X);
        let lowest = flat(-self.normal);
        let quarter = turned(lowest, 0.0, 1.0);
        [lowest, quarter, -lowest, -quarter, flat(middle)]
    }

    /// Normal of the face below a place; `None` beside the face.
    fn below(&self, place: DVec3) -> Option<DVec3> {
        let n = self.patch.foot(place)?.normal;
        Some(n * 1.0_f64.copysign(n.dot(self.normal)))
    }

    /// How steeply a curve rises over the face as it goes on.
    fn slope(&self, curve: &Curve, t: f64) -> Option<f64> {
        let (place, along) = curve.at(t)?;
        Some(self.below(place)?.dot(along))
    }

    /// Goes down along a curve to where it is lowest; `None` where the way leaves the face before, whose edges are there, or the
    /// curve, whose ends are.
    fn descend(&self, curve: &Curve, start: f64) -> Option<DVec3> {
        let (mut a, mut at_a) = (start, self.slope(curve, start)?);
        let mut step = -STEP.copysign(at_a);
        let mut halvings = 0;
        let (mut b, mut at_b) = loop {
            let next = a + step;
            match self.slope(curve, next) {
                None if halvings == HALVINGS => return None,
                None => {
                    halvings += 1;
                    step *= 0.5;
                }
                Some(slope) if slope * at_a <= 0.0 => break (next, slope),
                Some(_) if (next - start).abs() > FARTHEST => return None,
                Some(slope) => {
                    (a, at_a) = (next, slope);
                    if halvings == 0 {
                        step *= 2.0;
                    }
                }
            }
        };
        // The Illinois method: the end that stays counts half.
        for _ in 0..SECANTS {
            if at_a == at_b {
                break;
            }
            let c = (a * at_b - b * at_a) / (at_b - at_a);
            let at_c = self.slope(curve, c)?;
            if at_c * at_b < 0.0 {
                (a, at_a) = (b, at_b);
            } else {
                at_a *= 0.5;
            }
            (b, at_b) = (c, at_c);
        }
        let (lowest, _) = curve.at(b)?;
        Some(lowest - self.below(lowest)? * self.solid.edge_radius())
    }
}

/// A curve of a solid that is not grown.
enum Curve {
    /// Round from a direction, by angles.
    Ring(Rim, DVec3),
    /// From 0 to 1.
    Line(DVec3, DVec3),
}

impl Curve {
    /// Place \[m\] and the direction in which it goes on, of any length.
    fn at(&self, t: f64) -> Option<(DVec3, DVec3)> {
        match self {
            Self::Ring(rim, start) => {
                let out = turned(*start, t.cos(), t.sin());
                Some((rim.centre + out * rim.radius, turned(out, 0.0, 1.0)))
            }
            Self::Line(a, b) => {
                let on_it = (0.0..=1.0).contains(&t);
                on_it.then(|| (a.lerp(*b, t), *b - *a))
            }
        }
    }
}

/// A direction across the y axis, turned about it by an angle with this cosine and sine.
fn turned(out: DVec3, cos: f64, sin: f64) -> DVec3 {
    out * cos + DVec3::new(out.z, 0.0, -out.x) * sin
}

/// Whether a face is twisted so much that it matters.
pub(super) fn is_twisted(patch: &Patch) -> bool {
    patch.twist() > FLAT
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::geometry::{Shape, SharedShape};
    use rapier3d::math::Vector;

    /// A saddle h + bend·x·z + tilt·x with a side of 1 m, and the normal at its middle, upwards.
    fn saddle(h: f64, bend: f64, tilt: f64) -> (Patch, DVec3) {
        let corner = |x: f64, z: f64| DVec3::new(x, h + bend * x * z + tilt * x, z);
        let (far, near) = (0.5, -0.5);
        let corners = [
            corner(near, near),
            corner(near, far),
            corner(far, far),
            corner(far, near),
        ];
        let patch = Patch::new(corners.into_iter());
        let normal = patch.normal().unwrap();
        assert!(normal.y > 0.0);
        (patch, normal)
    }

    fn height(patch: &Patch, p: DVec3) -> Option<f64> {
        let foot = patch.foot(p)?;
        Some((p - foot.point).dot(foot.normal))
    }

    /// The least height of all points of a solid that are told \[m\].
    fn least(shape: &dyn Shape, (patch, normal): &(Patch, DVec3)) -> f64 {
        let solid = Solid::of(shape).unwrap();
        let mut points = Vec::new();
        solid.feature_points(*normal, &mut points);
        let mut found = Vec::new();
        let ridge = Ridge {
            patch,
            normal: *normal,
            solid: &solid,
            near: 0.1,
        };
        ridge.lowest(&points, &mut |p| found.push(p));
        let all = points.iter().chain(found.iter().map(|(_, p)| p));
        let heights = all.filter_map(|p| height(patch, *p));
        heights.fold(f64::INFINITY, f64::min)
    }

    /// A disc flat over a saddle touches it at both ends of the diagonal along which that rises, and over a tilted one at the
    /// lowest of all its points.
    #[test]
    fn nothing_of_a_rim_is_lower() {
        let radius = 0.4;
        let shape = SharedShape::cylinder(0.1, radius as f32);
        for tilt in [0.0, 0.01, 0.05, 0.3] {
            for bend in [0.02, 0.1, 0.3] {
                let saddle = saddle(-0.11, bend, tilt);
                let round = (0..720).map(|i| (0.5 * f64::from(i)).to_radians());
                let rim = round.map(|a| DVec3::new(radius * a.cos(), -0.1, radius * a.sin()));
                let heights = rim.filter_map(|p| height(&saddle.0, p));
                let lowest = heights.fold(f64::INFINITY, f64::min);
                let dip = least(&*shape, &saddle) - lowest;
                // Exact where it touches; here the rim is up to 11 cm deep.
                assert!(
                    dip < 5e-5,
                    "{tilt} {bend}: {dip} m deeper between the points"
                );
            }
        }
    }

    /// What lies along the diagonal of a saddle that is a ridge touches the middle of it, and neither its corners nor its edges.
    #[test]
    fn what_lies_along_a_ridge_touches_its_middle() {
        let bend = 0.2;
        let along = Vector::new(0.6, 0.0, -0.6);
        let above = Vector::new(0.2, 0.4, 0.2);
        let beside = Vector::new(-0.2, 0.4, -0.2);
        let hull = [-along, along, above, beside];
        let shapes = [
            SharedShape::capsule(-along, along, 0.05),
            SharedShape::convex_hull(&hull).unwrap(),
        ];
        for (shape, below) in shapes.iter().zip([0.05, 0.0]) {
            let found = least(&**shape, &saddle(-0.1, bend, 0.0));
            assert!((found - (0.1 - below)).abs() < 1e-6, "{found}");
        }
    }
}
