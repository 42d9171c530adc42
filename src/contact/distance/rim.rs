//! Where a straight edge of a deformable crosses the rim of a cylinder or a cone: where it comes nearest to that circle.
//!
//! There the way between the two is perpendicular to both. Where the segment is as far from the axis as the rim is, or at the
//! height of its cap, it may be far from the rim: a segment that grazes the mantle has such places anywhere on it.

use super::crossing::between;
use super::primitive::radial;
use crate::math::DVec3;

/// The most Newton steps to where a segment comes nearest; they double the digits.
const STEPS: usize = 12;

/// When a step counts as none, per length of the segment.
const STILL: f64 = 1e-12;

/// How much farther from the rim a start can be than the segment comes near it: √2 where the rim is straight.
const ASIDE: f64 = 2.0;

/// The edge between a cap and the mantle above it.
pub(super) struct Rim {
    pub centre: DVec3,
    pub radius: f64,
    pub cap: DVec3,
    /// Rise of the mantle's normal from the radial direction away from the cap.
    pub slope: f64,
}

impl Rim {
    /// The meetings with the segment from `a` along `d` that are within `within` m: the part of the way, the normal and the
    /// distance along it \[m\]. One may lie before the point where the segment comes nearest to the axis, one behind it.
    pub fn meetings(&self, a: DVec3, d: DVec3, within: f64) -> [Option<(f64, DVec3, f64)>; 2] {
        let flat = d.x * d.x + d.z * d.z;
        let middle = -(a.x * d.x + a.z * d.z) / flat;
        let mut found: [Option<(f64, DVec3, f64)>; 2] = [None; 2];
        for start in self.starts(a, d, middle, flat) {
            let far = self.way(a + d * start).0.length();
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

    /// Where the line is as far from the axis as the rim, or nearest to it, and where it is at the height of the cap.
    fn starts(&self, a: DVec3, d: DVec3, middle: f64, flat: f64) -> [f64; 3] {
        let rest = a.x * a.x + a.z * a.z - self.radius * self.radius;
        let root = (middle * middle - rest / flat).max(0.0).sqrt();
        [middle - root, middle + root, (self.centre.y - a.y) / d.y]
    }

    /// From the rim to a point, in the plane of the axis and the point, and the direction from the axis there.
    fn way(&self, point: DVec3) -> (DVec3, DVec3) {
        let out = radial(point).1;
        (point - self.centre - out * self.radius, out)
    }

    /// Where the line comes nearest to the rim, from `t` on by Newton's method for the square of the distance.
    fn nearest(&self, a: DVec3, d: DVec3, mut t: f64) -> Option<f64> {
        for _ in 0..STEPS {
            let point = a + d * t;
            let (way, out) = self.way(point);
            let axis = radial(point).0;
            let (along, outwards) = (d.length_squared(), d.dot(out));
            let around = d.x * d.x + d.z * d.z - outwards * outwards;
            let bend = along - self.radius * around / axis;
            // No minimum here, or no numbers.
            if bend <= 1e-9 * along || bend.is_nan() {
                return None;
            }
            let step = way.dot(d) / bend;
            t -= step;
            if step.abs() < STILL {
                return (t > 0.0 && t < 1.0).then_some(t);
            }
        }
        None
    }

    fn meet(&self, a: DVec3, d: DVec3, t: f64) -> Option<(f64, DVec3, f64)> {
        let (way, out) = self.way(a + d * t);
        let mantle = (out - self.cap * self.slope).normalize();
        let n = between(d.cross(DVec3::Y.cross(out)), [self.cap, mantle])?;
        Some((t, n, way.dot(n)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rim(slope: f64) -> Rim {
        Rim {
            centre: DVec3::new(0.0, 0.2, 0.0),
            radius: 0.3,
            cap: DVec3::Y,
            slope,
        }
    }

    fn random(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }

    fn vector(seed: &mut u64) -> DVec3 {
        DVec3::new(random(seed), random(seed), random(seed))
    }

    /// Every place where a segment comes nearest to the rim, found by walking along it, is a meeting where the normal is one
    /// of the rim, and there are no others.
    #[test]
    fn meetings_are_where_a_segment_comes_nearest() {
        let (mut seed, mut met) = (1, 0);
        for slope in [0.0, 0.7] {
            let rim = rim(slope);
            for _ in 0..20_000 {
                // Past a point at the rim, at any angle.
                let turn = 7.0 * random(&mut seed);
                let at = DVec3::new(turn.cos(), 0.0, turn.sin()) * 0.3 + DVec3::Y * 0.2;
                let d = vector(&mut seed).normalize() * (0.05 + 0.1 * (random(&mut seed) + 0.5));
                let a = at + vector(&mut seed) * 0.02 - d * (0.5 + random(&mut seed));
                let squared = |t: f64| rim.way(a + d * t).0.length_squared();
                const N: usize = 400;
                let mut walked = Vec::new();
                for i in 1..N {
                    let [before, here, behind] =
                        [i - 1, i, i + 1].map(|i| squared(i as f64 / N as f64));
                    if here < before && here <= behind {
                        walked.push((i as f64 / N as f64, here.sqrt()));
                    }
                }
                let found = rim.meetings(a, d, 0.02);
                for (t, n, distance) in found.into_iter().flatten() {
                    met += 1;
                    assert!((distance.abs() - squared(t).sqrt()).abs() < 1e-9);
                    assert!(n.dot(d).abs() < 1e-12 && (n.length() - 1.0).abs() < 1e-12);
                    assert!(
                        t < 1.5 / N as f64
                            || t > 1.0 - 1.5 / N as f64
                            || walked.iter().any(|w| (w.0 - t).abs() < 1.5 / N as f64),
                        "{t} {walked:?}"
                    );
                }
                for (t, distance) in walked {
                    let exact = rim.nearest(a, d, t).unwrap();
                    if distance > 0.015 || rim.meet(a, d, exact).is_none() {
                        continue;
                    }
                    let near = |f: &(f64, DVec3, f64)| (f.0 - t).abs() < 1.5 / N as f64;
                    assert!(found.iter().flatten().any(near), "{t} {distance} {found:?}");
                }
            }
        }
        assert!(met > 5000, "{met}");
    }

    /// A segment that touches the mantle far from the caps is at no rim, however little it dips in.
    #[test]
    fn a_segment_on_the_mantle_meets_no_rim() {
        for dip in [-1e-9, 0.0, 1e-9, 1e-6, 1e-3] {
            for tilt in [0.0, 4e-4, -4e-4, 0.1] {
                let a = DVec3::new(0.3 - dip, 0.05, -0.06);
                let d = DVec3::new(0.0, 0.12 * tilt, 0.12);
                assert_eq!(rim(0.0).meetings(a, d, 0.1), [None; 2], "{dip} {tilt}");
            }
        }
    }
}
