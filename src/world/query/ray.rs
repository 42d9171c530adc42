//! Rays against deformables.

use super::DeformableFilter;
use crate::body::SurfacePoint;
use crate::body::search::slab;
use crate::math::{DVec3, Real, Vector, narrow, wide};
use crate::world::{Deformable, DeformableHandle, DeformableWorld};
use rapier3d::geometry::Ray;

/// Where a ray meets a deformable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeformableRayHit {
    /// The body.
    pub deformable: DeformableHandle,
    /// The point of the surface, in terms of its nodes.
    pub at: SurfacePoint,
    /// How far along the ray, in lengths of its direction.
    pub time_of_impact: Real,
    /// Where in the world \[m\].
    pub point: Vector,
    /// Unit normal of the surface, towards the side the ray comes from; 0 for a ray that starts inside of a solid body or
    /// a line.
    pub normal: Vector,
}

/// A ray in `f64`, and how far it goes.
struct Wide {
    origin: DVec3,
    /// Of unit length.
    dir: DVec3,
    /// Length of the direction as given.
    scale: f64,
    /// Metres.
    limit: f64,
}

impl Wide {
    /// `None` for a ray that leads nowhere.
    fn new(ray: &Ray, max_toi: Real) -> Option<Self> {
        let (origin, dir) = (wide(ray.origin), wide(ray.dir));
        let scale = dir.length();
        let limit = f64::from(max_toi) * scale;
        (origin.is_finite() && dir.is_finite() && scale > 0.0 && limit >= 0.0).then(|| Self {
            origin,
            dir: dir / scale,
            scale,
            limit,
        })
    }
}

impl DeformableWorld {
    /// The first deformable that a ray meets, within `max_toi` lengths of its direction. With `solid`, a ray that starts
    /// inside of a closed body meets it at once, at the point of the surface nearest to its origin; without, it meets the
    /// wall from inside. A ray or `max_toi` that is not finite (an infinite `max_toi` is none), of no length or negative
    /// meets nothing.
    ///
    /// ```
    /// use crumple::prelude::*;
    /// use crumple::rapier3d::prelude::*;
    /// let mut deformables = DeformableWorld::default();
    /// let block = deformables.insert(
    ///     DeformableBuilder::new(lattice(Vector::splat(1.0), 0.25)).material(Material::rubber()),
    /// )?;
    /// let ray = Ray::new(Vector::new(0.1, 3.0, 0.2), -Vector::Y);
    /// let hit = deformables.cast_ray(&ray, 10.0, true, DeformableFilter::default()).unwrap();
    /// assert_eq!((hit.deformable, hit.normal), (block, Vector::Y));
    /// assert!((hit.time_of_impact - 2.5).abs() < 1e-6);
    /// // Pull where it was hit.
    /// assert!(deformables[block].add_step_force_at(&hit.at, Vector::Y * 100.0));
    /// # Ok::<(), crumple::body::BuildError>(())
    /// ```
    pub fn cast_ray(
        &self,
        ray: &Ray,
        max_toi: Real,
        solid: bool,
        filter: DeformableFilter,
    ) -> Option<DeformableRayHit> {
        let mut ray = Wide::new(ray, max_toi)?;
        let radius = filter.radius();
        let mut best: Option<DeformableRayHit> = None;
        for (handle, body) in self.filtered(&filter) {
            let Some((metres, hit)) = body.cast_ray(handle, &ray, solid, radius) else {
                continue;
            };
            // The first of two at the same place stays.
            if best.is_none() || metres < ray.limit {
                ray.limit = metres;
                best = Some(hit);
            }
        }
        best
    }
}

impl Deformable {
    fn cast_ray(
        &self,
        handle: DeformableHandle,
        ray: &Wide,
        solid: bool,
        radius: f64,
    ) -> Option<(f64, DeformableRayHit)> {
        let origin = ray.origin - self.state.origin;
        let enter = slab(self.extent(radius)?, origin, ray.dir);
        if !enter.is_finite() || enter > ray.limit {
            return None;
        }
        let search = self.search(radius);
        let met = if solid && enter == 0.0 && search.holds(origin) {
            let nearest = search.nearest(origin, f64::INFINITY)?;
            crate::body::search::Met {
                distance: 0.0,
                vector: DVec3::ZERO,
                ..nearest
            }
        } else {
            search.cast_ray((origin, ray.dir), ray.limit)?
        };
        let hit = DeformableRayHit {
            deformable: handle,
            at: met.at,
            time_of_impact: (met.distance / ray.scale) as Real,
            point: narrow(ray.origin + ray.dir * met.distance),
            normal: narrow(met.vector),
        };
        Some((met.distance, hit))
    }
}
