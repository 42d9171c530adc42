//! What a face of a deformable can meet before its nodes do: corners, edges and curved parts of a solid.

use super::crossing::cuboid_edge;
use super::{Core, Solid, primitive};
use crate::contact::soup::{Edge, EdgeSearch};
use crate::math::DVec3;
use std::f64::consts::SQRT_2;

impl Solid {
    /// Whether it is made of filled cells.
    pub fn is_voxels(&self) -> bool {
        matches!(self.core, Core::Voxels(_))
    }

    /// Whether it is a box, grown or not.
    pub fn is_box(&self) -> bool {
        matches!(self.core, Core::Cuboid(_))
    }

    /// Puts into `out` the edges of filled cells that stand out and meet the box from `lo` to `hi` \[m\]; of other solids
    /// none.
    pub fn voxel_edges_in(
        &self,
        lo: DVec3,
        hi: DVec3,
        search: &mut EdgeSearch,
        out: &mut Vec<Edge>,
    ) {
        match &self.core {
            Core::Voxels(grid) => grid.edges_in((lo, hi), search, out),
            _ => out.clear(),
        }
    }

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

    /// Whether it is a box or a polyhedron that is not grown: its corners and edges are in the same places however it is
    /// looked at.
    pub fn is_sharp(&self) -> bool {
        self.radius <= 0.0 && matches!(self.core, Core::Cuboid(_) | Core::Hull(_))
    }

    /// Whether a solid has lines that [`Self::for_each_line`] tells.
    pub fn has_lines(&self) -> bool {
        matches!(
            self.core,
            Core::Segment(..)
                | Core::Cuboid(_)
                | Core::Cylinder(..)
                | Core::Cone(..)
                | Core::Hull(_)
        )
    }

    /// Calls `found` for the straight lines along which a solid that is not grown can touch a face, `normal` being a unit normal
    /// towards it, each with its number: edges of a box or a hull whose sides look that way, the axis of a capsule, the line along which
    /// the side of a cylinder or a cone is lowest.
    pub fn for_each_line(&self, normal: DVec3, found: &mut dyn FnMut(u32, [DVec3; 2])) {
        let lowest = |y: f64, radius: f64| primitive::radial(-normal).1 * radius + DVec3::Y * y;
        match &self.core {
            Core::Segment(a, b) => found(0, [*a, *b]),
            Core::Cylinder(half_height, radius) => {
                let at = |y: f64| lowest(y, *radius);
                found(0, [at(-half_height), at(*half_height)]);
            }
            Core::Cone(half_height, radius) => {
                found(0, [lowest(-half_height, *radius), DVec3::Y * *half_height]);
            }
            Core::Cuboid(half) => {
                for i in 0..12 {
                    let (ends, [left, right]) = cuboid_edge(i, *half);
                    if (left + right).dot(normal) < 0.0 {
                        found(i as u32, ends);
                    }
                }
            }
            Core::Hull(hull) => {
                let mut i = 0;
                hull.for_each_edge(&mut |ends, [left, right]| {
                    if (left + right).dot(normal) < 0.0 {
                        found(i, ends);
                    }
                    i += 1;
                });
            }
            _ => {}
        }
    }

    /// How far the box from `lo` to `hi` must grow, at least, before it can hold one of the
    /// [feature points](Self::feature_points) of a convex solid, whatever the normal \[m\].
    pub fn points_apart(&self, lo: DVec3, hi: DVec3) -> f64 {
        let margin = DVec3::splat(self.radius);
        let apart = |p: DVec3| (lo - margin - p).max(p - hi - margin);
        match &self.core {
            Core::Segment(a, b) => apart(*a).max_element().min(apart(*b).max_element()),
            Core::Cuboid(half) => apart(*half).min(apart(-*half)).max_element(),
            Core::Hull(hull) => {
                let corners = hull.vertices().iter();
                let apart = corners.map(|p| apart(*p).max_element());
                apart.fold(f64::INFINITY, f64::min)
            }
            _ => self.edges_apart(lo, hi),
        }
    }

    /// How far the box from `lo` to `hi` must grow, at least, before it can hold anything of the surface of a convex solid
    /// but one flat face: a corner, an edge or a curved part \[m\]. Not positive where it may hold some already; the middle
    /// of a large floor is far from any, a half-space for ever.
    pub fn edges_apart(&self, lo: DVec3, hi: DVec3) -> f64 {
        // A grown edge stays within the radius of the sharp one.
        let (lo, hi) = (
            lo - DVec3::splat(self.radius),
            hi + DVec3::splat(self.radius),
        );
        let apart = |low: DVec3, high: DVec3| (lo - high).max(low - hi).max_element();
        let round = |half_height: f64, radius: f64| {
            let reach = DVec3::new(radius, half_height, radius);
            apart(-reach, reach)
        };
        match &self.core {
            Core::Point => apart(DVec3::ZERO, DVec3::ZERO),
            Core::Segment(a, b) => apart(a.min(*b), a.max(*b)),
            Core::Cuboid(half) => {
                // A face that the box reaches through makes an edge with the next one.
                let through = (lo + *half).min(*half - hi);
                let [x, y, z] = through.to_array();
                let second = x.max(y).min(y.max(z)).min(z.max(x));
                apart(-*half, *half).max(second)
            }
            Core::Cylinder(half_height, radius) => {
                // A corner moves away from the axis by √2 of what its coordinates grow.
                let inside = (radius - farthest_from_axis(lo, hi)) / SQRT_2;
                round(*half_height, *radius).max(inside)
            }
            Core::Cone(half_height, radius) => {
                // Below the mantle with its highest and outermost point: only the base is left.
                let height = 2.0 * half_height;
                let out = farthest_from_axis(lo, hi) - radius;
                let over = out * height + (hi.y + half_height) * radius;
                let growth = (SQRT_2 * height + radius).max(f64::MIN_POSITIVE);
                round(*half_height, *radius).max(-over / growth)
            }
            Core::Hull(hull) => hull.edges_apart(lo, hi),
            Core::HalfSpace(_) => f64::INFINITY,
            Core::Compound(_) | Core::Voxels(_) => f64::NEG_INFINITY,
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
