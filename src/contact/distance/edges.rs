//! What a face of a deformable can meet before its nodes do: corners, edges and curved parts of a solid.

use super::{Core, Solid, primitive};
use crate::math::DVec3;

impl Solid {
    /// Appends the points of a convex solid \[m\] that a flat face can touch first, `normal` being the unit normal from the
    /// face towards the solid: corners; the ends of a capsule; of rims the lowest point and those turned by quarters. None
    /// for half-spaces, compounds and voxels.
    pub fn feature_points(&self, normal: DVec3, out: &mut Vec<DVec3>) {
        let start = out.len();
        let mut rim = |y: f64, radius: f64| {
            let lowest = primitive::radial(-normal).1 * radius;
            let turned = DVec3::new(lowest.z, 0.0, -lowest.x);
            out.extend([lowest, turned, -lowest, -turned].map(|p| p + DVec3::Y * y));
        };
        match &self.core {
            Core::Point => out.push(DVec3::ZERO),
            Core::Segment(a, b) => out.extend([*a, *b]),
            Core::Cuboid(half) => out.extend((0..8).map(|i| corner(i) * *half)),
            Core::Cylinder(half_height, radius) => {
                rim(-half_height, *radius);
                rim(*half_height, *radius);
            }
            Core::Cone(half_height, radius) => {
                rim(-half_height, *radius);
                out.push(DVec3::Y * *half_height);
            }
            Core::Hull(hull) => out.extend_from_slice(hull.vertices()),
            Core::HalfSpace(_) | Core::Compound(_) | Core::Voxels(_) => {}
        }
        for point in &mut out[start..] {
            *point -= normal * self.radius;
        }
    }

    /// Whether the box from `lo` to `hi` \[m\] may hold anything of the surface but one flat face: a corner, an edge or a
    /// curved part. A cheap test that errs towards yes; the middle of a large floor has none, a half-space never.
    pub fn has_edges_in(&self, lo: DVec3, hi: DVec3) -> bool {
        // A grown edge stays within the radius of the sharp one.
        let (lo, hi) = (
            lo - DVec3::splat(self.radius),
            hi + DVec3::splat(self.radius),
        );
        let meets = |low: DVec3, high: DVec3| lo.cmple(high).all() && hi.cmpge(low).all();
        match &self.core {
            Core::Point => meets(DVec3::ZERO, DVec3::ZERO),
            Core::Segment(a, b) => meets(a.min(*b), a.max(*b)),
            Core::Cuboid(half) => {
                // Any face but one that the box reaches through makes an edge.
                let through = |low: f64, high: f64, half: f64| low <= -half || high >= half;
                let reached = [
                    through(lo.x, hi.x, half.x),
                    through(lo.y, hi.y, half.y),
                    through(lo.z, hi.z, half.z),
                ];
                meets(-*half, *half) && reached.iter().filter(|r| **r).count() > 1
            }
            Core::Cylinder(half_height, radius) => {
                let reach = DVec3::new(*radius, *half_height, *radius);
                meets(-reach, reach) && farthest_from_axis(lo, hi) >= *radius
            }
            Core::Cone(half_height, radius) => {
                let reach = DVec3::new(*radius, *half_height, *radius);
                let top = DVec3::new(farthest_from_axis(lo, hi), hi.y, 0.0);
                // Below the mantle with its highest and outermost point: only the base is left.
                meets(-reach, reach)
                    && (top.x - radius) * 2.0 * half_height + (top.y + half_height) * radius >= 0.0
            }
            Core::HalfSpace(_) => false,
            Core::Hull(hull) => hull.has_edges_in(lo, hi),
            Core::Compound(compound) => compound.has_edges_in(lo, hi),
            Core::Voxels(grid) => grid.has_edges_in(lo, hi),
        }
    }
}

/// Corner `i` of 8 of the cube from −1 to 1.
pub fn corner(i: usize) -> DVec3 {
    let side = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    DVec3::new(side(0), side(1), side(2))
}

/// Greatest distance of any point of a box from the y axis.
fn farthest_from_axis(lo: DVec3, hi: DVec3) -> f64 {
    let far = lo.abs().max(hi.abs());
    far.x.hypot(far.z)
}
