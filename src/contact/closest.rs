//! Nearest points on triangles and between segments.

use crate::math::DVec3;

/// The box around some points.
pub fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.fold(start, |(lo, hi), p| (lo.min(p), hi.max(p)))
}

/// On which part of an element a nearest point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Inside the triangle.
    Face,
    /// On the side from corner k to the next.
    Side(usize),
    /// On corner k.
    Corner(usize),
}

/// The nearest point of an element: barycentric weights of its corners, and where that is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Weights of the corners, summing to 1.
    pub weights: [f64; 3],
    /// Where it lies.
    pub feature: Feature,
}

impl Nearest {
    /// A corner.
    pub fn corner(k: usize) -> Self {
        let mut weights = [0.0; 3];
        weights[k] = 1.0;
        Self {
            weights,
            feature: Feature::Corner(k),
        }
    }

    fn side(k: usize, share: f64) -> Self {
        let mut weights = [0.0; 3];
        (weights[k], weights[(k + 1) % 3]) = (1.0 - share, share);
        Self {
            weights,
            feature: Feature::Side(k),
        }
    }

    /// The point itself \[m\].
    pub fn point(&self, corners: &[DVec3; 3]) -> DVec3 {
        let [a, b, c] = self.weights;
        corners[0] * a + corners[1] * b + corners[2] * c
    }
}

/// The point of side k of a triangle nearest to `p`.
pub fn on_side(p: DVec3, corners: &[DVec3; 3], k: usize) -> Nearest {
    let (a, b) = (corners[k], corners[(k + 1) % 3]);
    let along = b - a;
    let share = (p - a).dot(along) / along.length_squared();
    // Not so for a share that is NaN, of a side without length.
    if share >= 1.0 {
        Nearest::corner((k + 1) % 3)
    } else if share > 0.0 {
        Nearest::side(k, share)
    } else {
        Nearest::corner(k)
    }
}

/// The point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
pub fn on_triangle(p: DVec3, corners: &[DVec3; 3]) -> Nearest {
    let [a, b, c] = *corners;
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return Nearest::corner(0);
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return Nearest::corner(1);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return on_side(p, corners, 0);
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return Nearest::corner(2);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return on_side(p, corners, 2);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return on_side(p, corners, 1);
    }
    let sum = va + vb + vc;
    if sum.is_normal() {
        Nearest {
            weights: [va / sum, vb / sum, vc / sum],
            feature: Feature::Face,
        }
    } else {
        // A triangle without area is its sides.
        (0..3)
            .map(|k| on_side(p, corners, k))
            .min_by(|m, n| {
                let far = |n: &Nearest| n.point(corners).distance_squared(p);
                far(m).total_cmp(&far(n))
            })
            .unwrap_or(Nearest::corner(0))
    }
}

/// How far along each of two segments their lines come nearest, 0 and 1 being the ends, unless they are parallel
/// (sin < .03).
pub fn between_lines(a: [DVec3; 2], b: [DVec3; 2]) -> Option<[f64; 2]> {
    let (d, e, r) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (dd, ee, de) = (d.length_squared(), e.length_squared(), d.dot(e));
    let determinant = dd * ee - de * de;
    if determinant.is_nan() || determinant <= 1e-3 * dd * ee {
        return None;
    }
    let (dr, er) = (d.dot(r), e.dot(r));
    let s = (de * er - dr * ee) / determinant;
    let t = (dd * er - de * dr) / determinant;
    Some([s, t])
}

/// How far two segments are apart \[m\], or less where they are nearly parallel, and how far along each they come nearest
/// where that is inside both.
pub fn between_segments(a: [DVec3; 2], b: [DVec3; 2]) -> (f64, Option<[f64; 2]>) {
    let Some([s, t]) = between_lines(a, b) else {
        // That of the balls around them.
        let middle = 0.5 * (a[0] + a[1] - b[0] - b[1]);
        let reach = 0.5 * (a[0].distance(a[1]) + b[0].distance(b[1]));
        return (middle.length() - reach, None);
    };
    let within = |end: f64| [s, t].iter().all(|x| *x >= end && *x <= 1.0 - end);
    if within(0.0) {
        let apart = a[0].lerp(a[1], s).distance(b[0].lerp(b[1], t));
        return (apart, within(1e-6).then_some([s, t]));
    }
    // Then one of them comes nearest with an end.
    let far = |p: DVec3, [q, r]: [DVec3; 2]| {
        let along = r - q;
        let share = (p - q).dot(along) / along.length_squared();
        p.distance_squared(q + along * share.clamp(0.0, 1.0))
    };
    let to_b = far(a[0], b).min(far(a[1], b));
    let to_a = far(b[0], a).min(far(b[1], a));
    (to_a.min(to_b).sqrt(), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [
        DVec3::ZERO,
        DVec3::new(2.0, 0.0, 0.0),
        DVec3::new(0.0, 3.0, 0.0),
    ];

    #[test]
    fn every_part_of_a_triangle_is_found() {
        for (p, feature, at) in [
            ([0.5, 0.5, 1.0], Feature::Face, [0.5, 0.5]),
            ([1.0, -2.0, 1.0], Feature::Side(0), [1.0, 0.0]),
            ([-1.0, 1.0, 0.0], Feature::Side(2), [0.0, 1.0]),
            ([-1.0, -1.0, 0.3], Feature::Corner(0), [0.0, 0.0]),
            ([4.0, -1.0, 0.0], Feature::Corner(1), [2.0, 0.0]),
            ([-1.0, 5.0, 0.0], Feature::Corner(2), [0.0, 3.0]),
        ] {
            let found = on_triangle(DVec3::from_array(p), &CORNERS);
            assert_eq!(found.feature, feature, "{p:?}");
            let error = found.point(&CORNERS) - DVec3::new(at[0], at[1], 0.0);
            assert!(error.length() < 1e-12, "{p:?}");
        }
        let found = on_triangle(DVec3::new(2.0, 3.0, 0.0), &CORNERS);
        assert_eq!(found.feature, Feature::Side(1));
    }

    #[test]
    fn flat_triangles_are_their_sides() {
        let line = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        let p = DVec3::new(1.5, 1.0, 0.0);
        let found = on_triangle(p, &line).point(&line);
        assert!((found - DVec3::X * 1.5).length() < 1e-12, "{found}");
        let point = [DVec3::ONE; 3];
        assert_eq!(on_triangle(p, &point).point(&point), DVec3::ONE);
    }

    #[test]
    fn crossed_segments_meet_inside_or_not_at_all() {
        let a = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(3.0, 0.0, 0.0)];
        let b = [DVec3::new(0.0, 1.0, -1.0), DVec3::new(0.0, 1.0, 1.0)];
        let (apart, along) = between_segments(a, b);
        let [s, t] = along.unwrap();
        assert!((s - 0.25).abs() < 1e-12 && (t - 0.5).abs() < 1e-12);
        assert!((apart - 1.0).abs() < 1e-12);
        for b in [a.map(|p| p + DVec3::Y), [DVec3::Y; 2]] {
            let (apart, along) = between_segments(a, b);
            assert!(along.is_none() && apart <= 1.0);
        }
        let (apart, along) = between_segments(a, b.map(|p| p + DVec3::X * 5.0));
        assert!(along.is_none() && (apart - 5.0_f64.sqrt()).abs() < 1e-12);
    }

    /// No two points of them are nearer, and where they are not parallel some are as near.
    #[test]
    fn the_distance_of_segments_is_a_bound() {
        let mut seed = 1_u32;
        let mut number = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        for _ in 0..2000 {
            let mut point = || DVec3::new(number(), number(), number());
            let (a, b) = ([point(), point()], [point(), point()]);
            let (apart, _) = between_segments(a, b);
            let along = |[p, q]: [DVec3; 2], i: i32| p.lerp(q, f64::from(i) / 50.0);
            let pairs = (0..=50).flat_map(|i| (0..=50).map(move |k| (i, k)));
            let least = pairs.map(|(i, k)| along(a, i).distance(along(b, k)));
            let least = least.fold(f64::INFINITY, f64::min);
            assert!(apart <= least + 1e-12, "{apart} {least}");
            if between_lines(a, b).is_some() {
                assert!(apart > least - 0.03, "{apart} {least}");
            }
        }
    }
}
