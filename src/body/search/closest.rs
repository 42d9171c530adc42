//! Rays and points against triangles and round lines, in `f64`.

use crate::math::DVec3;

/// Where on the segment from `a` to `b` the point nearest to `p` lies, from 0 at `a` to 1 at `b`; 0 for one of no length.
pub(crate) fn on_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let squared = along.length_squared();
    if squared > 0.0 {
        ((p - a).dot(along) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// Weights of the corners at the point of a triangle nearest to `p`. The borders are tried one by one where the foot of
/// the perpendicular lies outside or there is no plane: a crushed triangle has as good an answer as any other.
pub(crate) fn on_triangle(p: DVec3, corners: [DVec3; 3]) -> [f64; 3] {
    let [a, b, c] = corners;
    let n = (b - a).cross(c - a);
    let squared = n.length_squared();
    if squared > 0.0 {
        let v = (p - a).cross(c - a).dot(n) / squared;
        let w = (b - a).cross(p - a).dot(n) / squared;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return [1.0 - v - w, v, w];
        }
    }
    let mut best = (f64::INFINITY, [1.0, 0.0, 0.0]);
    for i in 0..3 {
        let j = (i + 1) % 3;
        let t = on_segment(p, corners[i], corners[j]);
        let distance = p.distance_squared(corners[i].lerp(corners[j], t));
        if distance < best.0 {
            let mut weights = [0.0; 3];
            (weights[i], weights[j]) = (1.0 - t, t);
            best = (distance, weights);
        }
    }
    best.1
}

/// Volumes that a line from the origin along `dir` spans with the three sides of a triangle, each opposite to the corner
/// of its index. All of one sign where the line passes through; a side shared by two triangles has exactly opposite
/// volumes in both, so that nothing slips between them.
pub(crate) fn volumes(dir: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    [
        dir.dot(b.cross(c)),
        dir.dot(c.cross(a)),
        dir.dot(a.cross(b)),
    ]
}

/// Where a ray from `origin` along the unit vector `dir` meets a triangle, from either side: distance \[m\] and weights
/// of the corners.
pub(crate) fn ray_triangle(
    origin: DVec3,
    dir: DVec3,
    corners: [DVec3; 3],
) -> Option<(f64, [f64; 3])> {
    let corners = corners.map(|c| c - origin);
    let volumes = volumes(dir, corners);
    let through = volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0);
    let sum: f64 = volumes.iter().sum();
    if !through || sum == 0.0 || !sum.is_finite() {
        return None;
    }
    let weights = volumes.map(|v| v / sum);
    let point: DVec3 = corners.iter().zip(weights).map(|(c, w)| *c * w).sum();
    let t = point.dot(dir);
    (t >= 0.0).then_some((t, weights))
}

/// Where a ray from `origin` along the unit vector `dir` enters all points within `radius` of the segment from `a` to `b`
/// \[m\]; 0 from inside. Nothing for a line of no thickness.
pub(crate) fn ray_capsule(
    origin: DVec3,
    dir: DVec3,
    [a, b]: [DVec3; 2],
    radius: f64,
) -> Option<f64> {
    if radius.is_nan() || radius <= 0.0 {
        return None;
    }
    let nearest = a.lerp(b, on_segment(origin, a, b));
    if nearest.distance_squared(origin) <= radius * radius {
        return Some(0.0);
    }
    let ends = [a, b].map(|end| enter(dir, origin - end, radius));
    let axis = (b - a).normalize_or_zero();
    let across = |v: DVec3| v - axis * v.dot(axis);
    let slant = across(dir).length();
    // Along the axis the ends are all there is to meet.
    let side = (slant > 1.0e-9)
        .then(|| enter(across(dir) / slant, across(origin - a), radius))
        .flatten()
        .map(|t| t / slant)
        .filter(|t| (0.0..=a.distance(b)).contains(&(origin + dir * *t - a).dot(axis)));
    [ends[0], ends[1], side]
        .into_iter()
        .flatten()
        .reduce(f64::min)
}

/// Where a line along the unit vector `dir` from outside enters a sphere about the origin.
fn enter(dir: DVec3, from: DVec3, radius: f64) -> Option<f64> {
    let along = from.dot(dir);
    let rest = radius * radius - (from - dir * along).length_squared();
    let t = -along - rest.max(0.0).sqrt();
    (rest >= 0.0 && t >= 0.0).then_some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] = [
        DVec3::new(0.0, 0.0, 0.0),
        DVec3::new(2.0, 0.0, 0.0),
        DVec3::new(0.0, 1.0, 0.0),
    ];

    fn at(weights: [f64; 3]) -> DVec3 {
        (0..3).map(|i| TRIANGLE[i] * weights[i]).sum()
    }

    #[test]
    fn the_nearest_point_is_nearer_than_any_of_a_grid() {
        for i in 0..400 {
            let f = f64::from(i);
            let p = DVec3::new((f * 1.7).sin(), (f * 2.3).cos(), (f * 0.9).sin()) * 3.0;
            let found = at(on_triangle(p, TRIANGLE)).distance(p);
            let mut grid = f64::INFINITY;
            for u in 0..=50 {
                for v in 0..=50 - u {
                    let (u, v) = (f64::from(u) / 50.0, f64::from(v) / 50.0);
                    grid = grid.min(at([1.0 - u - v, u, v]).distance(p));
                }
            }
            assert!(found <= grid + 1e-12, "{p}: {found} {grid}");
            assert!(found >= grid - 0.04, "{p}: {found} {grid}");
        }
    }

    #[test]
    fn a_triangle_crushed_to_a_line_or_a_point_has_a_nearest_point() {
        let p = DVec3::new(1.5, 1.0, 0.0);
        let line = [DVec3::ZERO, DVec3::X, DVec3::X * 4.0];
        let weights = on_triangle(p, line);
        let point: DVec3 = (0..3).map(|i| line[i] * weights[i]).sum();
        assert!(point.distance(DVec3::X * 1.5) < 1e-12);
        assert_eq!(on_triangle(p, [DVec3::X; 3]).iter().sum::<f64>(), 1.0);
        assert!(ray_triangle(p, -DVec3::Y, line).is_none());
    }

    #[test]
    fn rays_meet_both_sides_and_not_what_lies_behind() {
        let above = DVec3::new(0.5, 0.25, 3.0);
        let (t, weights) = ray_triangle(above, -DVec3::Z, TRIANGLE).unwrap();
        assert_eq!(t, 3.0);
        assert!(at(weights).distance(DVec3::new(0.5, 0.25, 0.0)) < 1e-12);
        let below = DVec3::new(0.5, 0.25, -2.0);
        assert_eq!(ray_triangle(below, DVec3::Z, TRIANGLE).unwrap().0, 2.0);
        assert!(ray_triangle(above, DVec3::Z, TRIANGLE).is_none());
        assert!(ray_triangle(above + DVec3::X * 2.0, -DVec3::Z, TRIANGLE).is_none());
    }

    #[test]
    fn rays_enter_the_side_and_the_ends_of_a_round_line() {
        let line = [DVec3::ZERO, DVec3::X];
        let close = |t: Option<f64>, expected: f64| assert!((t.unwrap() - expected).abs() < 1e-12);
        let from = DVec3::new(0.5, 2.0, 0.0);
        close(ray_capsule(from, -DVec3::Y, line, 0.1), 1.9);
        close(ray_capsule(DVec3::X * -2.0, DVec3::X, line, 0.1), 1.9);
        close(ray_capsule(DVec3::X * 0.3, DVec3::Z, line, 0.1), 0.0);
        let past_the_end = DVec3::new(1.05, 2.0, 0.0);
        let expected = 2.0 - (0.01_f64 - 0.0025).sqrt();
        close(ray_capsule(past_the_end, -DVec3::Y, line, 0.1), expected);
        assert!(ray_capsule(from, DVec3::Y, line, 0.1).is_none());
        assert!(ray_capsule(from, -DVec3::Y, line, 0.0).is_none());
        assert!(ray_capsule(from + DVec3::X, -DVec3::Y, line, 0.1).is_none());
        close(ray_capsule(from, -DVec3::Y, [DVec3::X * 0.5; 2], 0.1), 1.9);
    }
}
