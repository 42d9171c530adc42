//! Boxes and shapes against deformables.

use super::DeformableFilter;
use crate::body::Feature;
use crate::body::search::overlap;
use crate::math::{DVec3, Pose, narrow, wide};
use crate::world::{Deformable, DeformableHandle, DeformableWorld};
use rapier3d::geometry::{Aabb, Shape};
use rapier3d::parry::shape::Cuboid;

/// What of a deformable a shape touches.
#[derive(Clone, Debug, PartialEq)]
pub struct DeformableOverlap {
    /// The body.
    pub deformable: DeformableHandle,
    /// The faces, or springs and lone nodes, that the shape touches, in the order of their indices; none where the shape
    /// lies wholly inside of a closed body.
    pub features: Vec<Feature>,
}

impl DeformableWorld {
    /// The deformables of which a face, a spring or a lone node reaches into a box, or which hold the whole box. A box
    /// that is NaN or inside out meets nothing.
    pub fn intersect_aabb(&self, aabb: Aabb, filter: DeformableFilter) -> Vec<DeformableHandle> {
        self.filtered(&filter)
            .filter(|(_, body)| body.touches_box(&aabb, filter.radius()))
            .map(|(handle, _)| handle)
            .collect()
    }

    /// The deformables that a shape touches or lies inside of. Shapes that parry can't test against triangles count as
    /// apart, as in Rapier's own queries; a pose that is not finite meets nothing.
    pub fn intersect_shape(
        &self,
        pose: &Pose,
        shape: &dyn Shape,
        filter: DeformableFilter,
    ) -> Vec<DeformableOverlap> {
        if !pose.is_finite() {
            return Vec::new();
        }
        self.filtered(&filter)
            .filter_map(|(handle, body)| {
                let features = body.touching(pose, shape, filter.radius())?;
                Some(DeformableOverlap {
                    deformable: handle,
                    features,
                })
            })
            .collect()
    }
}

impl Deformable {
    fn touches_box(&self, aabb: &Aabb, radius: f64) -> bool {
        let origin = self.state.origin;
        let asked = (wide(aabb.mins) - origin, wide(aabb.maxs) - origin);
        if !asked.0.cmple(asked.1).all() {
            return false;
        }
        // What sticks out of the body is cut off: half extents stay finite and precise.
        let shared = self.extent(radius).and_then(|(lo, hi)| {
            let margin = 1.0e-3 * (hi - lo).length();
            overlap((lo - margin, hi + margin), asked)
        });
        let Some((lo, hi)) = shared else { return false };
        let cuboid = Cuboid::new(narrow((hi - lo) * 0.5));
        let middle = (lo + hi) * 0.5;
        let search = self.search(radius);
        !search
            .touching(&Pose::from_translation(narrow(middle)), &cuboid, (lo, hi))
            .is_empty()
            || search.holds(middle)
    }

    /// `None` where they are apart.
    pub(in crate::world) fn touching(
        &self,
        pose: &Pose,
        shape: &dyn Shape,
        radius: f64,
    ) -> Option<Vec<Feature>> {
        let extent = self.extent(radius)?;
        // About the body's origin, where f32 is precise.
        let shift = wide(pose.translation) - self.state.origin;
        let local = Pose::from_parts(narrow(shift), pose.rotation);
        let turned = shape.compute_aabb(&Pose::from_parts(Default::default(), pose.rotation));
        let asked = (wide(turned.mins) + shift, wide(turned.maxs) + shift);
        let within = overlap(extent, asked)?;
        let search = self.search(radius);
        let features = search.touching(&local, shape, within);
        // No face is touched: the shape is outside or inside as a whole, as any of its points is.
        let any: DVec3 = wide(shape.project_point(&local, narrow(shift), true).point);
        (!features.is_empty() || search.holds(any)).then_some(features)
    }
}
