//! Where a straight edge of a deformable crosses the rim of a cylinder or a cone: where it comes nearest to that circle.
//!
//! There the way between the two is perpendicular to both. Where the segment is as far from the axis as the rim is, or at the
//! height of its cap, it may be far from the rim: a segment that grazes the mantle has such places anywhere on it.

use super::crossing::between;
use super::primitive::radial;
use crate::math::DVec3;

/// The most Newton steps to where a segment comes nearest; each doubles the digits.
const STEPS: usize = 12;

/// When a step counts as none, per length of the segment.
const STILL: f64 = 1e-12;

/// By which part of itself the way may be longer than what of it is along the normal.
const ALONG: f64 = 1e-2;

/// How much farther from the rim a start can be than the segment comes near it: √2 where the rim is straight.
const ASIDE: f64 = 2.0;

/// The edge between a cap and the mantle above it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rim {
    /// \[m\].
    pub centre: DVec3,
    /// \[m\].
    pub radius: f64,
    /// Normal of the cap.
    pub cap: DVec3,
    /// Rise of the mantle's normal from the radial direction away from the cap.
    pub slope: f64,
}

impl Rim {
    /// The meetings with the segment from `a` along `d` that are within `within` m: the part of the way, the normal and the
    /// distance along it \[m\]. One may lie before the point where the segment comes nearest to the axis, one behind it.
    pub fn meetings(&self, a: DVec3, d: DVec3, within: f64) -> [Option<(f64, DVec3, f64)>; 2] {
        if self.apart(a, a + d) > within {
            return [None; 2];
        }
        let flat = d.x * d.x + d.z * d.z;
        let middle = -(a.x * d.x + a.z * d.z) / flat;
        let mut found: [Option<(f64, DVec3, f64)>; 2] = [None; 2];
        for start in self.starts(a, d, middle, flat) {
            let point = a + d * start;
            let far = self.way(point, radial(point).1).length();
            if far > ASIDE * within || far.is_nan() {
                continue;
            }
            let meeting = self.nearest(a, d, start).and_then(|t| self.meet(a, d, t));
            let Some((t, _, distance)) = meeting else {
                continue;
            };
            let place = &mut found[usize::from(t > middle)];
            if distance.abs() <= within && place.is_none_or(|known| distance.abs() < known.2.abs())
            {
                *place = meeting;
            }
        }
        found
    }

    /// How far the segment from `a` to `b` is from the rim, or less \[m\].
    fn apart(&self, a: DVec3, b: DVec3) -> f64 {
        self.away(0.5 * (a + b)) - 0.5 * a.distance(b)
    }

    /// How far a point is from the rim \[m\].
    pub fn away(&self, point: DVec3) -> f64 {
        self.way(point, radial(point).1).length()
    }

    /// Where the line is as far from the axis as the rim, or nearest to it, and where it is at the height of the cap.
    fn starts(&self, a: DVec3, d: DVec3, middle: f64, flat: f64) -> [f64; 3] {
        let rest = a.x * a.x + a.z * a.z - self.radius * self.radius;
        let root = (middle * middle - rest / flat).max(0.0).sqrt();
        [middle - root, middle + root, (self.centre.y - a.y) / d.y]
    }

    /// From the rim to a point, given with its direction from the axis \[m\].
    fn way(&self, point: DVec3, out: DVec3) -> DVec3 {
        point - self.centre - out * self.radius
    }

    /// Where the line comes nearest to the rim, from `t` on by Newton's method for the square of the distance.
    fn nearest(&self, a: DVec3, d: DVec3, mut t: f64) -> Option<f64> {
        for _ in 0..STEPS {
            let point = a + d * t;
            let (axis, out) = radial(point);
            let (along, outwards) = (d.length_squared(), d.dot(out));
            let around = d.x * d.x + d.z * d.z - outwards * outwards;
            let bend = along - self.radius * around / axis;
            // No minimum here, or no numbers.
            if bend <= 1e-9 * along || bend.is_nan() {
                return None;
            }
            let step = self.way(point, out).dot(d) / bend;
            t -= step;
            if step.abs() < STILL {
                return (t > 0.0 && t < 1.0).then_some(t);
            }
        }
        None
    }

    fn meet(&self, a: DVec3, d: DVec3, t: f64) -> Option<(f64, DVec3, f64)> {
        let point = a + d * t;
        let out = radial(point).1;
        let mantle = (out - self.cap * self.slope).normalize();
        let n = between(d.cross(DVec3::Y.cross(out)), [self.cap, mantle])?;
        let way = self.way(point, out);
        let distance = way.dot(n);
        // The way is along n, but that of a segment along the tangent is rounding.
        let off = way.length() - distance.abs();
        (off <= ALONG * way.length() + STILL * self.radius).then_some((t, n, distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lower one of a cylinder of 20 cm.
    const RIM: Rim = Rim {
        centre: DVec3::new(0.0, -0.03, 0.0),
        radius: 0.2,
        cap: DVec3::NEG_Y,
        slope: 0.0,
    };

    /// A rope of 6 mm across the mantle, 3 cm above the rim: the normal was rounding, and the segment 2 cm inside.
    #[test]
    fn a_segment_across_the_mantle_is_not_inside() {
        let a = DVec3::new(
            -0.20302106885713522,
            2.540667437983737e-16,
            0.01952362774256722,
        );
        let d = DVec3::new(
            2.195837138474488e-5,
            -4.444868415790637e-20,
            -0.020464331952011697,
        );
        for met in RIM.meetings(a, d, 0.05).into_iter().flatten() {
            assert!((met.2.abs() - 0.03).abs() < 1e-3, "{met:?}");
        }
    }

    /// Close to the rim and along it: the way to it is what it is, from every side.
    #[test]
    fn a_segment_along_the_rim_is_as_far_as_its_middle() {
        let mut found = 0;
        for (x, y) in [(1e-3, 0.0), (0.0, 1e-3), (7e-4, 7e-4), (-1e-4, -1e-4)] {
            for tilt in [1e-3, 0.1] {
                let a = DVec3::new(0.2 + x, -0.03 - y, 0.0);
                let d = DVec3::new(-tilt * y.signum(), -tilt * x.signum(), 1.0) * 0.02;
                for (t, n, distance) in RIM.meetings(a - d * 0.5, d, 0.01).into_iter().flatten() {
                    let point = a + d * (t - 0.5);
                    let way = RIM.way(point, radial(point).1);
                    assert!((way - n * distance).length() < 1e-6, "{x} {y} {tilt}");
                    found += 1;
                }
            }
        }
        assert!(found > 0);
    }
}
