//! Where rims and straight lines of a solid are lowest over a twisted face. Over a flat one these are points for its normal, and
//! the ends of lines. The quads of a loaded sheet bend up along one diagonal and down along the other: over them a rim may be
//! lowest in two places, anywhere on it, and the side of a cylinder or the edge of a mesh that lies along the ridge touches
//! nothing but the middle of the face.

use super::patch::Patch;
use crate::contact::closest::bounds;
use crate::contact::distance::{Rim, Solid};
use crate::math::DVec3;

/// How far a search goes at first, and at most, in rad round a rim.
const STEP: f64 = 0.1;
const FARTHEST: f64 = 2.0;

/// How often a first step that leaves the face is halved, and how many steps of the secant method follow.
const HALVINGS: usize = 4;
const SECANTS: usize = 6;

/// A slope that counts as level.
const FLAT: f64 = 1e-6;

/// From how many places of a rim it is searched for.
const STARTS: usize = 5;

/// How high a face must bulge, per spacing of its body, to matter.
const NEGLIGIBLE: f64 = 1e-3;

/// The same for the edges of boxes: less than that their corners and the edges of the face hold, and to look for more costs a sheet
/// full of boxes a third of its time.
const NEGLIGIBLE_TO_BOXES: f64 = 0.1;

/// Nearer than this per radius, two places of a rim are one.
const ALIKE: f64 = 0.05;

/// How far the nodes of a face of a body with this spacing must move before it bulges so much that it matters to a solid, at
/// least \[m\].
pub(super) fn flat_for(solid: &Solid, patch: &Patch, spacing: f64) -> f64 {
    if patch.corners().len() == 3 || !solid.has_lines() {
        return f64::INFINITY;
    }
    negligible(solid) * spacing - patch.highest_rise().length()
}

/// How high a face must bulge, per spacing of its body, to matter to a solid.
fn negligible(solid: &Solid) -> f64 {
    if solid.is_box() {
        NEGLIGIBLE_TO_BOXES
    } else {
        NEGLIGIBLE
    }
}

/// A twisted face.
pub(super) struct Ridge<'a> {
    pub patch: &'a Patch,
    /// Unit normal at its middle, towards what is over it.
    pub normal: DVec3,
    /// How much lower a place must be to matter \[m\].
    negligible: f64,
}

impl<'a> Ridge<'a> {
    /// A face of a body with this spacing \[m\], if it is twisted so much that it matters.
    pub fn of(patch: &'a Patch, normal: DVec3, spacing: f64) -> Option<Self> {
        let negligible = NEGLIGIBLE * spacing;
        (patch.highest_rise().dot(normal).abs() > negligible).then_some(Self {
            patch,
            normal,
            negligible,
        })
    }

    /// Calls `found` for the lowest points of rims and lines of a solid that are within `near` m, with numbers that follow those of
    /// its `features`, and with the places that they have grown from; not for those that are among these \[m\].
    pub fn lowest_of(
        &self,
        solid: &Solid,
        near: f64,
        features: &[DVec3],
        found: &mut dyn FnMut((u32, DVec3), DVec3),
    ) {
        let grown = solid.edge_radius();
        let mut next = features.len() as u32;
        let (middle, radius) = self.patch.ball();
        let tilt = DVec3::new(self.normal.x, 0.0, self.normal.z).length();
        for rim in solid.rims() {
            let number = next;
            next += STARTS as u32;
            if rim.away(middle) > radius + near + grown {
                continue;
            }
            let mut places = [DVec3::INFINITY; STARTS];
            // One that is steeper than any normal leans has one lowest place on all the surface.
            let steeper = tilt - self.patch.twist();
            let count = if steeper > 0.0 { 2 } else { STARTS };
            let starts = self.starts(middle).into_iter().take(count);
            for (k, start) in starts.enumerate() {
                let ring = Curve::Ring(rim, start);
                let Some((slope, _)) = self.slope(&ring, 0.0, &mut [0.5; 2]) else {
                    continue;
                };
                // By no more than this does the lowest place lie lower.
                if 0.5 * slope * slope * rim.radius < self.negligible * steeper {
                    continue;
                }
                let Some((place, n)) = self.descend(&ring, 0.0) else {
                    continue;
                };
                let point = place - n * grown;
                let near = ALIKE * rim.radius;
                let mut all = features.iter().chain(&places[..k]);
                if all.all(|other| other.distance(point) >= near) {
                    places[k] = point;
                    found((number + k as u32, point), place);
                }
            }
        }
        let margin = near + grown;
        let mut on_side = None;
        solid.for_each_line(self.normal, &mut |i, line| {
            let lowest = self.lowest_on(line, margin);
            on_side = lowest.or(on_side);
            if let Some((place, n)) = lowest
                && !solid.has_rim()
            {
                found((next + i, place - n * grown), place);
            }
        });
        // The side of a cylinder or a cone is lowest along another line for the normal there.
        if solid.has_rim()
            && let Some((_, normal)) = on_side
        {
            solid.for_each_line(normal, &mut |i, line| {
                if let Some((place, n)) = self.lowest_on(line, margin) {
                    found((next + i, place - n * grown), place);
                }
            });
        }
    }

    /// Whether a line may be within `near` m.
    fn is_near(&self, [a, b]: [DVec3; 2], near: f64) -> bool {
        let (lo, hi) = bounds(self.patch.corners().iter().copied());
        let apart = a.max(b).cmplt(lo - near) | a.min(b).cmpgt(hi + near);
        !apart.any()
    }

    /// The lowest place of a line, unless that is one of its ends, with the normal of the face there; may be none for a line
    /// that is more than `near` m away.
    pub fn lowest_on(&self, [a, b]: [DVec3; 2], near: f64) -> Option<(DVec3, DVec3)> {
        let along = b - a;
        if !self.is_near([a, b], near) || !self.bulges(along) {
            return None;
        }
        let (middle, _) = self.patch.ball();
        let start = (middle - a).dot(along) / along.length_squared();
        self.descend(&Curve::Line(a, b), start)
    }

    /// Whether a line that goes in this direction may be lowest somewhere over the face: where it is steeper than any normal leans it
    /// goes down all the way, and along a valley it is lowest at its ends.
    fn bulges(&self, along: DVec3) -> bool {
        let is_steep = along.dot(self.normal).abs() > self.patch.twist() * along.length();
        !is_steep && self.patch.rise(along).dot(self.normal) > self.negligible
    }

    /// Directions from the axis: to what is lowest for the normal of the middle, to the middle, and from the first on by quarters.
    fn starts(&self, middle: DVec3) -> [DVec3; STARTS] {
        let flat = |v: DVec3| DVec3::new(v.x, 0.0, v.z).normalize_or(DVec3::X);
        let lowest = flat(-self.normal);
        let quarter = turned(lowest, 0.0, 1.0);
        [lowest, flat(middle), quarter, -lowest, -quarter]
    }

    /// How steeply a curve rises over the face as it goes on, and the normal of the face there; `None` beside the face. Looked for
    /// from the place \[u, v\] on it of one nearby.
    fn slope(&self, curve: &Curve, t: f64, near: &mut [f64; 2]) -> Option<(f64, DVec3)> {
        let (place, along) = curve.at(t)?;
        let n = self.patch.normal_below(place, self.normal, near)?;
        Some((n.dot(along), n))
    }

    /// Goes down along a curve to where it is lowest, and the normal there; `None` where the way leaves the face before, whose
    /// edges are there, or the curve, whose ends are.
    fn descend(&self, curve: &Curve, start: f64) -> Option<(DVec3, DVec3)> {
        let mut near = [0.5; 2];
        let (mut a, (mut at_a, _)) = (start, self.slope(curve, start, &mut near)?);
        let mut step = -STEP.copysign(at_a);
        let mut halvings = 0;
        let (mut b, (mut at_b, mut normal)) = loop {
            let next = a + step;
            let mut there = near;
            match self.slope(curve, next, &mut there) {
                None if halvings == HALVINGS => return None,
                None => {
                    halvings += 1;
                    step *= 0.5;
                }
                Some(found) if found.0 * at_a <= 0.0 => break (next, found),
                Some(_) if (next - start).abs() > FARTHEST => return None,
                Some((slope, _)) => {
                    (a, at_a, near) = (next, slope, there);
                    if halvings == 0 {
                        step *= 2.0;
                    }
                }
            }
        };
        // The Illinois method: the end that stays counts half.
        for _ in 0..SECANTS {
            if at_a == at_b || at_b.abs() < FLAT {
                break;
            }
            let c = (a * at_b - b * at_a) / (at_b - at_a);
            let at_c;
            (at_c, normal) = self.slope(curve, c, &mut near)?;
            if at_c * at_b < 0.0 {
                (a, at_a) = (b, at_b);
            } else {
                at_a *= 0.5;
            }
            (b, at_b) = (c, at_c);
        }
        let (lowest, _) = curve.at(b)?;
        Some((lowest, normal))
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
        let ridge = Ridge::of(patch, *normal, 1e-3).unwrap();
        ridge.lowest_of(&solid, 0.1, &points, &mut |p, _| found.push(p));
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
        // The lower edges of a box lie along x, 0.1 m beside the ridge of a saddle, which is 0.098 m below there and slants by 0.04.
        let corner = |x: f64, z: f64| DVec3::new(x, -0.2 - 0.2 * (x * x - z * z), z);
        let r = std::f64::consts::FRAC_1_SQRT_2;
        let corners = [
            corner(-r, 0.0),
            corner(0.0, r),
            corner(r, 0.0),
            corner(0.0, -r),
        ];
        let patch = Patch::new(corners.into_iter());
        let normal = patch.normal().unwrap();
        let found = least(&*SharedShape::cuboid(0.6, 0.1, 0.1), &(patch, normal));
        let expected = 0.098 / 1.0_f64.hypot(0.04);
        assert!((found - expected).abs() < 1e-6, "{found}");
    }
}
