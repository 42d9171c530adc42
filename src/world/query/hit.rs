//! The nearer of Rapier's hit and ours.

use super::{DeformableFilter, DeformableRayHit};
use crate::math::{Real, Vector};
use crate::world::DeformableWorld;
use rapier3d::geometry::{ColliderHandle, Ray, RayIntersection};
use rapier3d::pipeline::QueryPipeline;

/// What a ray meets first in both worlds.
#[derive(Clone, Copy, Debug)]
pub enum RayHit {
    /// A collider of Rapier's world.
    Rigid {
        /// The collider.
        collider: ColliderHandle,
        /// Where, as Rapier says it.
        intersection: RayIntersection,
    },
    /// A deformable.
    Deformable(DeformableRayHit),
}

impl RayHit {
    /// How far along the ray, in lengths of its direction.
    pub fn time_of_impact(&self) -> Real {
        match self {
            Self::Rigid { intersection, .. } => intersection.time_of_impact,
            Self::Deformable(hit) => hit.time_of_impact,
        }
    }

    /// Normal of what was met.
    pub fn normal(&self) -> Vector {
        match self {
            Self::Rigid { intersection, .. } => intersection.normal,
            Self::Deformable(hit) => hit.normal,
        }
    }
}

impl DeformableWorld {
    /// The first thing a ray meets among Rapier's colliders and the deformables; at the same distance, the collider.
    /// Rapier's side has a filter of its own, and its tree stands where the last step left it.
    ///
    /// ```
    /// use crumple::prelude::*;
    /// use crumple::rapier3d::prelude::*;
    /// let mut world = PhysicsWorld::default();
    /// world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::cuboid(5.0, 0.1, 5.0));
    /// let mut deformables = DeformableWorld::default();
    /// deformables.insert(
    ///     DeformableBuilder::new(lattice(Vector::splat(0.4), 0.1))
    ///         .material(Material::rubber())
    ///         .translation(Vector::new(0.0, 0.4, 0.0)),
    /// )?;
    /// deformables.step(&mut world);
    /// let down = |x| Ray::new(Vector::new(x, 5.0, 0.05), -Vector::Y);
    /// let first = |ray| {
    ///     deformables.cast_ray_with(&world.query_pipeline(), &ray, 10.0, true, DeformableFilter::default())
    /// };
    /// assert!(matches!(first(down(0.02)), Some(RayHit::Deformable(_))));
    /// assert!(matches!(first(down(2.0)), Some(RayHit::Rigid { .. })));
    /// # Ok::<(), crumple::body::BuildError>(())
    /// ```
    pub fn cast_ray_with(
        &self,
        rapier: &QueryPipeline,
        ray: &Ray,
        max_toi: Real,
        solid: bool,
        filter: DeformableFilter,
    ) -> Option<RayHit> {
        let good = ray.origin.is_finite() && ray.dir.is_finite() && ray.dir != Vector::ZERO;
        if !good || max_toi.is_nan() || max_toi < 0.0 {
            return None;
        }
        let rigid = rapier.cast_ray_and_get_normal(ray, max_toi.min(Real::MAX), solid);
        let nearest = rigid.map_or(max_toi, |(_, hit)| hit.time_of_impact);
        let soft = self
            .cast_ray(ray, nearest, solid, filter)
            .filter(|hit| rigid.is_none() || hit.time_of_impact < nearest);
        match (soft, rigid) {
            (Some(hit), _) => Some(RayHit::Deformable(hit)),
            (None, Some((collider, intersection))) => Some(RayHit::Rigid {
                collider,
                intersection,
            }),
            (None, None) => None,
        }
    }
}
