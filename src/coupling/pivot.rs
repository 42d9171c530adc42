//! Points as sums of weighted nodes: the nearest point of a deformable's surface, and a pivot of several nodes.

use crate::body::{Blueprint, State};
use crate::math::{DMat3, DVec3, Real};

/// The nearest point of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// Its nodes and their weights, which sum to 1.
    pub weights: Vec<(u32, f64)>,
    /// How far it is \[m\].
    pub distance: f64,
    /// Longest edge of the face or spring it lies on \[m\]; 0 for a lone node.
    pub edge: f64,
}

/// The point of a deformable nearest to `point`: of its faces, of its springs where it has none, or else of its nodes.
pub fn nearest(blueprint: &Blueprint, state: &State<Real>, point: DVec3) -> Option<Nearest> {
    let mut best: Option<Nearest> = None;
    let mut offer = |nodes: &[u32]| {
        let corners: Vec<DVec3> = nodes.iter().map(|&n| state.position(n as usize)).collect();
        let weights = match corners[..] {
            [a, b, c] => in_triangle(point, a, b, c).to_vec(),
            [a, b] => on_segment(point, a, b).to_vec(),
            _ => vec![1.0],
        };
        let at: DVec3 = corners.iter().zip(&weights).map(|(x, w)| *x * *w).sum();
        let distance = at.distance(point);
        if best.as_ref().is_none_or(|b| distance < b.distance) {
            let edge = (0..corners.len())
                .map(|i| corners[i].distance(corners[(i + 1) % corners.len()]))
                .fold(0.0, f64::max);
            let pairs = nodes.iter().copied().zip(weights);
            best = Some(Nearest {
                weights: pairs.filter(|(_, w)| *w != 0.0).collect(),
                distance,
                edge,
            });
        }
    };
    if !blueprint.faces.is_empty() {
        blueprint.faces.iter().for_each(|face| offer(face));
    } else if !blueprint.springs.is_empty() {
        blueprint.springs.iter().for_each(|s| offer(&s.nodes));
    } else {
        (0..state.particles.len() as u32).for_each(|n| offer(&[n]));
    }
    best
}

fn on_segment(p: DVec3, a: DVec3, b: DVec3) -> [f64; 2] {
    let ab = b - a;
    let squared = ab.length_squared();
    let t = if squared > 0.0 {
        ((p - a).dot(ab) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    [1.0 - t, t]
}

/// Barycentric weights of the nearest point of a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
fn in_triangle(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let squared = normal.length_squared();
    if squared > 0.0 {
        let v = (p - a).cross(ac).dot(normal) / squared;
        let w = ab.cross(p - a).dot(normal) / squared;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return [1.0 - v - w, v, w];
        }
    }
    let edge = |x: DVec3, y: DVec3| {
        let [s, t] = on_segment(p, x, y);
        ((x * s + y * t).distance_squared(p), s, t)
    };
    let (d0, s0, t0) = edge(a, b);
    let (d1, s1, t1) = edge(b, c);
    let (d2, s2, t2) = edge(c, a);
    if d0 <= d1 && d0 <= d2 {
        [s0, t0, 0.0]
    } else if d1 <= d2 {
        [0.0, s1, t1]
    } else {
        [t2, 0.0, s2]
    }
}

/// Weights, summing to 1, that make `pivot` a point of the nodes: it moves with them as if they were a rigid body, and they
/// take its impulses as one would. Without a pivot it is their centre of mass. Returns as well how far the pivot is from any
/// point they can make \[m\], and their extent \[m\].
pub fn pivot(points: &[(DVec3, f64)], pivot: Option<DVec3>) -> (Vec<f64>, f64, f64) {
    let mass: f64 = points.iter().map(|(_, m)| m).sum();
    let centre = points.iter().map(|(x, m)| *x * *m).sum::<DVec3>() / mass;
    let far = |(x, _): &(DVec3, f64)| x.distance(centre);
    let extent = points.iter().map(far).fold(0.0, f64::max);
    let Some(pivot) = pivot else {
        return (points.iter().map(|(_, m)| m / mass).collect(), 0.0, extent);
    };
    let axes = span(points.iter().map(|(x, _)| *x - centre), extent);
    let local = |d: DVec3| DVec3::new(d.dot(axes[0]), d.dot(axes[1]), d.dot(axes[2]));
    let mut inertia = DMat3::from_diagonal(DVec3::from_array(
        axes.map(|a| if a == DVec3::ZERO { 1.0 } else { 0.0 }),
    ));
    for (x, m) in points {
        let d = local(*x - centre);
        inertia += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * (m / mass);
    }
    let wanted = local(pivot - centre);
    let slope = inertia.inverse() * wanted;
    let reached: DVec3 = axes
        .iter()
        .zip(wanted.to_array())
        .map(|(a, w)| *a * w)
        .sum();
    let weights = points
        .iter()
        .map(|(x, m)| m / mass * (1.0 + local(*x - centre).dot(slope)))
        .collect();
    (weights, (pivot - centre).distance(reached), extent)
}

/// An orthonormal basis of what vectors span; the axes it does not need are 0.
fn span(vectors: impl Iterator<Item = DVec3> + Clone, extent: f64) -> [DVec3; 3] {
    let mut axes = [DVec3::ZERO; 3];
    for k in 0..3 {
        let rest = |d: DVec3| axes.iter().fold(d, |d, a| d - *a * d.dot(*a));
        let longest = vectors
            .clone()
            .map(rest)
            .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        match longest {
            Some(d) if d.length() > 1e-4 * extent && d.length() > 0.0 => axes[k] = d.normalize(),
            _ => break,
        }
    }
    axes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_of_a_triangle() {
        let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for (p, expected) in [
            (DVec3::new(0.2, 0.3, 0.7), [0.5, 0.2, 0.3]),
            (DVec3::new(0.4, -1.0, 0.0), [0.6, 0.4, 0.0]),
            (DVec3::new(1.0, 1.0, 0.0), [0.0, 0.5, 0.5]),
            (DVec3::new(-1.0, 0.25, 1.0), [0.75, 0.0, 0.25]),
            (DVec3::new(-1.0, -1.0, 0.0), [1.0, 0.0, 0.0]),
        ] {
            let found = in_triangle(p, a, b, c);
            for k in 0..3 {
                assert!((found[k] - expected[k]).abs() < 1e-12, "{p}: {found:?}");
            }
        }
    }

    #[test]
    fn a_pivot_is_made_of_the_nodes_that_can_reach_it() {
        let mut points = vec![(DVec3::ZERO, 1.0), (DVec3::X, 3.0)];
        let (weights, off, _) = pivot(&points, None);
        assert_eq!((weights, off), (vec![0.25, 0.75], 0.0));
        let (weights, off, _) = pivot(&points, Some(DVec3::new(0.5, 0.2, 0.0)));
        assert!((weights[0] - 0.5).abs() < 1e-12 && (off - 0.2).abs() < 1e-12);
        points.extend([(DVec3::Y, 2.0), (DVec3::new(1.0, 1.0, 0.1), 1.0)]);
        let at = DVec3::new(1.4, 0.3, 0.2);
        let (weights, off, _) = pivot(&points, Some(at));
        let made: DVec3 = points.iter().zip(&weights).map(|((x, _), w)| *x * *w).sum();
        assert!((made - at).length() < 1e-12 && off < 1e-12);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(pivot(&points[..1], Some(DVec3::X)).1, 1.0);
    }
}
