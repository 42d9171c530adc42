//! Whether two triangles cross.
//!
//! Separating axes rather than edge-against-triangle tests: two convex sets that only touch are separated by a plane in
//! the same way as two that are apart, coplanar triangles are no special algorithm, and an edge that passes exactly
//! through the side of its opponent, which slips between the half-open tests, is just an overlap.

use crate::math::DVec3;

fn sides([a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    [b - a, c - b, a - c]
}

/// Twice the area, along the normal \[m²\].
pub(super) fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Length of the longest side \[m\].
pub(super) fn longest_side(corners: [DVec3; 3]) -> f64 {
    sides(corners)
        .map(DVec3::length)
        .into_iter()
        .fold(0.0, f64::max)
}

/// Whether the interiors of two triangles meet, by separating axes: the two normals, the cross products of the sides
/// and, for coplanar ones, the normals of the sides in the plane. Overlaps of less than `tolerance` \[m\] don't count.
pub(super) fn cross(p: [DVec3; 3], q: [DVec3; 3], tolerance: f64) -> bool {
    let (n, m) = (normal(p), normal(q));
    let (sp, sq) = (sides(p), sides(q));
    let separates = |axis: DVec3, scale: f64| {
        let length = axis.length();
        if length <= 1.0e-6 * scale {
            return false; // Parallel sides: no axis of their own.
        }
        let range = |t: [DVec3; 3]| {
            let d = t.map(|v| v.dot(axis) / length);
            (d[0].min(d[1]).min(d[2]), d[0].max(d[1]).max(d[2]))
        };
        let ((a, b), (c, d)) = (range(p), range(q));
        let gap = (c - b).max(a - d);
        // Both flat along the axis: they are apart, or coplanar and to be told apart by another axis.
        if b - a < tolerance && d - c < tolerance {
            gap > tolerance
        } else {
            gap > -tolerance
        }
    };
    if separates(n, 0.0) || separates(m, 0.0) {
        return false;
    }
    for (own, normal) in [(sp, n), (sq, m)] {
        if own.iter().any(|s| separates(s.cross(normal), 0.0)) {
            return false;
        }
    }
    !sp.iter().any(|s| {
        sq.iter()
            .any(|t| separates(s.cross(*t), s.length() * t.length()))
    })
}
