//! The point of a deformable nearest to a given one.

use super::DeformableFilter;
use crate::body::SurfacePoint;
use crate::body::search::distance;
use crate::math::{DVec3, Real, Vector, narrow, wide};
use crate::world::{Deformable, DeformableHandle, DeformableWorld};
use rapier3d::geometry::Aabb;

/// A point projected on a deformable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeformableProjection {
    /// The body.
    pub deformable: DeformableHandle,
    /// The point of the surface nearest to the given one, in terms of its nodes; on a line with a radius, the point of its
    /// axis.
    pub at: SurfacePoint,
    /// The projection \[m\].
    pub point: Vector,
    /// From the given point to the projection \[m\].
    pub distance: Real,
    /// Whether the given point lies inside of a closed body or a line with a radius.
    pub is_inside: bool,
}

/// A point that is nearer to the axis of a line than this lies on it, in radii: where it is beside it is a matter of rounding.
const ON_AXIS: f64 = 1e-6;

impl DeformableWorld {
    /// The nearest deformable within `max_dist` \[m\], and the point of it nearest to `point`. With `solid`, a point inside
    /// of a closed body is its own projection; without, it is projected on the surface, from the axis of a line across it to
    /// a side that is always the same. A point or distance that is NaN,
    /// and a point that is infinite, is near nothing.
    pub fn project_point(
        &self,
        point: Vector,
        max_dist: Real,
        solid: bool,
        filter: DeformableFilter,
    ) -> Option<DeformableProjection> {
        let mut limit = f64::from(max_dist);
        if !point.is_finite() || limit.is_nan() || limit < 0.0 {
            return None;
        }
        let radius = filter.radius();
        let mut best: Option<DeformableProjection> = None;
        for (handle, body) in self.filtered(&filter) {
            let Some((metres, found)) = body.project(handle, wide(point), limit, solid, radius)
            else {
                continue;
            };
            if best.is_none() || metres < limit {
                limit = metres;
                best = Some(found);
            }
        }
        best
    }

    /// The deformables that hold a point: closed bodies around it, and lines within their radius.
    pub fn intersect_point(
        &self,
        point: Vector,
        filter: DeformableFilter,
    ) -> Vec<DeformableHandle> {
        let radius = filter.radius();
        let inside = |handle: DeformableHandle, body: &Deformable| {
            body.project(handle, wide(point), 0.0, true, radius)
                .is_some_and(|(_, found)| found.is_inside)
        };
        if !point.is_finite() {
            return Vec::new();
        }
        self.filtered(&filter)
            .filter(|(handle, body)| inside(*handle, body))
            .map(|(handle, _)| handle)
            .collect()
    }
}

impl Deformable {
    /// The box of a body in Rapier's numbers \[m\], found once per step; `None` for a body with a node that is not finite.
    pub fn aabb(&self) -> Option<Aabb> {
        let (lo, hi) = self.extent(0.0)?;
        let origin = self.state.origin;
        Some(Aabb::new(narrow(origin + lo), narrow(origin + hi)))
    }

    fn project(
        &self,
        handle: DeformableHandle,
        point: DVec3,
        limit: f64,
        solid: bool,
        radius: f64,
    ) -> Option<(f64, DeformableProjection)> {
        let origin = self.state.origin;
        let p = point - origin;
        let extent = self.extent(radius)?;
        let apart = distance(extent, p);
        if apart > limit {
            return None;
        }
        let search = self.search(radius);
        let lines = search.is_lines();
        let thickness = if lines { radius } else { 0.0 };
        let holds = apart == 0.0 && search.holds(p);
        // Inside of a solid the surface may be any distance away.
        let reach = if solid && holds {
            f64::INFINITY
        } else {
            limit + thickness
        };
        let met = search.nearest(p, reach)?;
        let is_inside = holds || (lines && met.distance < thickness);
        let (distance, projected) = if solid && is_inside {
            (0.0, p)
        } else {
            let away = if thickness > 0.0 && met.distance < ON_AXIS * thickness {
                search.out_of_line(&met, thickness)
            } else {
                (p - met.vector).normalize_or_zero()
            };
            let surface = met.vector + away * thickness;
            (p.distance(surface), surface)
        };
        let found = DeformableProjection {
            deformable: handle,
            at: met.at,
            point: narrow(origin + projected),
            distance: distance as Real,
            is_inside,
        };
        (distance <= limit).then_some((distance, found))
    }
}
