//! A pivot of several nodes: a point as the weighted sum of them.

use crate::math::{DMat3, DVec3};

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
