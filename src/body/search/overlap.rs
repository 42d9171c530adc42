//! What of a body a shape touches, by parry's intersection tests.

use super::tree::Bounds;
use super::{Feature, Search};
use crate::math::{DVec3, Pose, Real, Vector, narrow};
use rapier3d::parry::query::{DefaultQueryDispatcher, QueryDispatcher};
use rapier3d::parry::shape::{Ball, Capsule, Segment, Shape, ShapeType, Triangle};

/// The size below which a shape is blown up before parry is asked, whose tolerances are lengths \[m\].
const SMALL: Real = 0.1;

/// A shape at a pose, and how many times as large as it is all is taken.
struct Blown<'a> {
    shape: &'a dyn Shape,
    pose: Pose,
    by: Real,
}

impl Search<'_> {
    /// The features that a shape at `pose` about the body's origin touches, in the order of their indices. Nothing outside
    /// of `within` is looked at.
    pub fn touching(&self, pose: &Pose, shape: &dyn Shape, within: Bounds) -> Vec<Feature> {
        let size = shape.compute_local_aabb().extents().max_element();
        let by = 1.0 / size;
        let is_small = size > 0.0 && size < SMALL && grows(shape);
        let larger = is_small.then(|| shape.scale_dyn(Vector::splat(by), 0));
        let larger = larger.flatten();
        let blown = match &larger {
            None => Blown {
                shape,
                pose: *pose,
                by: 1.0,
            },
            Some(larger) => Blown {
                shape: &**larger,
                pose: Pose::from_parts(pose.translation * by, pose.rotation),
                by,
            },
        };
        let near = |bounds: Bounds| overlap(self.padded(bounds), within).is_some();
        let mut found: Vec<Feature> = self
            .tree
            .leaves(near)
            .filter_map(|leaf| self.feature(leaf))
            .filter(|feature| self.touches(*feature, &blown))
            .collect();
        found.sort_unstable();
        found
    }

    fn touches(&self, feature: Feature, blown: &Blown) -> bool {
        let Blown { shape, pose, by } = *blown;
        let [a, b, c] = self.corners(feature).map(|corner| narrow(corner) * by);
        let radius = self.radius as Real * by;
        let meets = |own_pose: Pose, own: &dyn Shape| {
            DefaultQueryDispatcher
                .intersection_test(&pose.inv_mul(&own_pose), shape, own)
                .is_ok_and(|found| found.intersecting)
        };
        match feature {
            Feature::Face(_) => meets(Pose::IDENTITY, &Triangle::new(a, b, c)),
            Feature::Spring(_) if radius > 0.0 => {
                meets(Pose::IDENTITY, &Capsule::new(a, b, radius))
            }
            Feature::Spring(_) => meets(Pose::IDENTITY, &Segment::new(a, b)),
            Feature::Node(_) if radius > 0.0 => {
                meets(Pose::from_translation(a), &Ball::new(radius))
            }
            Feature::Node(_) => shape.contains_point(&pose, a),
        }
    }
}

/// Whether parry makes it larger as a whole: shapes with a border keep that as it is.
fn grows(shape: &dyn Shape) -> bool {
    use ShapeType::{Ball, Capsule, Cone, ConvexPolyhedron, Cuboid, Cylinder, Segment, Triangle};
    matches!(
        shape.shape_type(),
        Ball | Capsule | Cone | ConvexPolyhedron | Cuboid | Cylinder | Segment | Triangle
    )
}

/// What two boxes share.
pub(crate) fn overlap(a: Bounds, b: Bounds) -> Option<Bounds> {
    let (lo, hi): (DVec3, DVec3) = (a.0.max(b.0), a.1.min(b.1));
    lo.cmple(hi).all().then_some((lo, hi))
}
