//! Parry's trees of boxes, which are in `f32`, asked in `f64`.

use crate::math::{DVec3, Vector};
use rapier3d::geometry::Aabb;
use rapier3d::parry::partitioning::Bvh;

/// A box of parry's that is not smaller than one in `f64`.
pub fn around(lo: DVec3, hi: DVec3) -> Aabb {
    Aabb::new(outward(lo, f32::next_down), outward(hi, f32::next_up))
}

/// A corner of a box in `f32`, moved outwards by more than the rounding.
fn outward(v: DVec3, next: fn(f32) -> f32) -> Vector {
    let v = v.clamp(
        DVec3::splat(f64::from(f32::MIN)),
        DVec3::splat(f64::from(f32::MAX)),
    );
    let v = v.as_vec3();
    Vector::new(next(v.x), next(v.y), next(v.z))
}

/// The leaf that is nearest to a point, and how far it is, both but for rounding of `f32` \[m\]; `distance` tells how far a leaf is.
pub fn nearest(tree: &Bvh, p: DVec3, distance: impl Fn(usize) -> f64) -> Option<(usize, f64)> {
    let at = p.as_vec3();
    let found = tree.find_best(
        f32::MAX,
        |node, _| {
            let gap = (node.mins() - at).max(at - node.maxs()).max(Vector::ZERO);
            gap.length() * (1.0 - 1e-6)
        },
        |leaf, least| {
            let away = distance(leaf as usize) as f32;
            (away < least).then_some(away)
        },
    );
    found.map(|(leaf, away)| (leaf as usize, away.into()))
}
