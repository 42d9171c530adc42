//! What of a frame's rigid shapes is drawn.

use super::ground::Ground;
use super::mesh::Mesh;
use crate::math::{Pose, Rotation, Vector};
use crate::record::frame::FrameCollider;
use rapier3d::geometry::{Segment, Shape, TypedShape};

/// Segments around a cone.
const AROUND: u32 = 40;

/// Appends the meshes of a collider: none of half-spaces, lines and custom shapes. Rounded hulls, cones and triangles are
/// drawn without their rounding.
pub fn draw(collider: &FrameCollider, out: &mut Vec<Mesh>) {
    let color = if collider.dynamic {
        [0.74, 0.58, 0.40]
    } else {
        [0.66, 0.67, 0.69]
    };
    add(&*collider.shape, &collider.pose, color, out);
}

fn add(shape: &dyn Shape, pose: &Pose, color: [f32; 3], out: &mut Vec<Mesh>) {
    use TypedShape as T;
    let corners = |(corners, triangles): (Vec<Vector>, Vec<[u32; 3]>)| {
        Mesh::welded(&corners, &triangles, pose, color)
    };
    out.push(match shape.as_typed_shape() {
        T::Cuboid(s) => Mesh::cuboid(s.half_extents, pose, color),
        T::RoundCuboid(s) => {
            let half_extents = s.inner_shape.half_extents + Vector::splat(s.border_radius);
            Mesh::cuboid(half_extents, pose, color)
        }
        T::Ball(s) => Mesh::ball(s.radius, pose, color),
        T::Capsule(s) => capsule(&s.segment, s.radius, pose, color),
        T::Cylinder(s) => Mesh::cylinder(s.half_height, s.radius, pose, color),
        T::RoundCylinder(s) => {
            let (inner, r) = (&s.inner_shape, s.border_radius);
            Mesh::cylinder(inner.half_height + r, inner.radius + r, pose, color)
        }
        T::Cone(s) => corners(s.to_trimesh(AROUND)),
        T::RoundCone(s) => corners(s.inner_shape.to_trimesh(AROUND)),
        T::ConvexPolyhedron(s) => corners(s.to_trimesh()),
        T::RoundConvexPolyhedron(s) => corners(s.inner_shape.to_trimesh()),
        T::HeightField(s) => corners(s.to_trimesh()),
        T::Voxels(s) => corners(s.to_trimesh()),
        T::TriMesh(s) => Mesh::triangles(s.vertices(), s.indices().to_vec(), pose, color),
        T::Triangle(s) => Mesh::triangles(&[s.a, s.b, s.c], vec![[0, 1, 2]], pose, color),
        T::RoundTriangle(s) => {
            let s = &s.inner_shape;
            Mesh::triangles(&[s.a, s.b, s.c], vec![[0, 1, 2]], pose, color)
        }
        T::Compound(s) => {
            for (part, shape) in s.shapes() {
                add(&**shape, &(*pose * *part), color, out);
            }
            return;
        }
        T::Segment(_) | T::Polyline(_) | T::HalfSpace(_) | T::Custom(_) => return,
    });
}

fn capsule(segment: &Segment, radius: f32, pose: &Pose, color: [f32; 3]) -> Mesh {
    let along = segment.b - segment.a;
    let turn = along.try_normalize().map_or_else(Default::default, |up| {
        Rotation::from_rotation_arc(Vector::Y, up)
    });
    let middle = Pose::from_parts(0.5 * (segment.a + segment.b), turn);
    Mesh::capsule(0.5 * along.length(), radius, &(*pose * middle), color)
}

/// The plane that stands for a floor: the top of a box, or a half-space. A terrain is no plane.
pub fn ground(collider: &FrameCollider) -> Option<Ground> {
    let (origin, up) = match collider.shape.as_typed_shape() {
        TypedShape::Cuboid(_) => {
            let top = collider.shape.compute_aabb(&collider.pose).maxs.y;
            (Vector::new(0.0, top, 0.0), Vector::Y)
        }
        TypedShape::HalfSpace(s) => (collider.pose.translation, collider.pose.rotation * s.normal),
        _ => return None,
    };
    Some(Ground {
        origin,
        up,
        ..Ground::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::geometry::{ColliderHandle, SharedShape};
    use rapier3d::math::IVector;
    use rapier3d::parry::utils::Array2;

    fn collider(shape: SharedShape) -> FrameCollider {
        FrameCollider {
            collider: ColliderHandle::invalid(),
            shape,
            pose: Pose::from_translation(Vector::X),
            dynamic: false,
        }
    }

    #[test]
    fn every_shape_with_a_surface_is_drawn_where_it_is() {
        let v = Vector::new;
        let tip = [Vector::ZERO, Vector::X, Vector::Y, Vector::Z];
        let cells = [IVector::splat(0), IVector::splat(1)];
        let ball = SharedShape::ball(0.5);
        let shapes = [
            SharedShape::cuboid(0.1, 0.2, 0.3),
            SharedShape::round_cuboid(0.1, 0.2, 0.3, 0.05),
            ball.clone(),
            SharedShape::capsule(v(-0.2, 0.0, 0.1), v(0.3, 0.1, 0.0), 0.1),
            SharedShape::capsule(Vector::ZERO, Vector::ZERO, 0.1),
            SharedShape::cylinder(0.2, 0.1),
            SharedShape::round_cylinder(0.2, 0.1, 0.01),
            SharedShape::cone(0.2, 0.1),
            SharedShape::convex_hull(&tip).unwrap(),
            SharedShape::triangle(tip[0], tip[1], tip[2]),
            SharedShape::trimesh(tip.to_vec(), vec![[0, 1, 2], [0, 3, 1]]).unwrap(),
            SharedShape::heightfield(Array2::repeat(3, 3, 0.5), Vector::ONE),
            SharedShape::compound(vec![(Pose::from_translation(Vector::Y), ball)]),
        ];
        for shape in shapes {
            let collider = collider(shape);
            let around = collider.shape.compute_aabb(&collider.pose);
            let kind = collider.shape.shape_type();
            let apart = bounds(&collider)
                .map(|(lo, hi)| (lo - around.mins).abs() + (hi - around.maxs).abs());
            assert!(apart.is_some_and(|a| a.max_element() < 0.01), "{kind:?}");
        }
        // The box of voxels that parry knows is that of whole chunks.
        let voxels = SharedShape::voxels(Vector::splat(0.1), &cells);
        let (lo, hi) = bounds(&collider(voxels)).unwrap();
        let far = (lo - Vector::X).abs() + (hi - Vector::X - Vector::splat(0.2)).abs();
        assert!(far.max_element() < 1e-6, "{lo} {hi}");
    }

    /// Of what is drawn.
    fn bounds(collider: &FrameCollider) -> Option<(Vector, Vector)> {
        let mut meshes = Vec::new();
        draw(collider, &mut meshes);
        let points = meshes.iter().flat_map(|m| &m.vertices);
        points
            .map(|p| (*p, *p))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    #[test]
    fn a_floor_is_a_plane_and_a_terrain_is_not() {
        let top = ground(&collider(SharedShape::cuboid(9.0, 0.5, 9.0))).unwrap();
        assert_eq!(top.origin.y, 0.5);
        let plane = ground(&collider(SharedShape::halfspace(Vector::Y))).unwrap();
        assert_eq!((plane.origin.y, plane.up), (0.0, Vector::Y));
        let terrain = SharedShape::heightfield(Array2::repeat(3, 3, 0.5), Vector::ONE);
        assert_eq!(ground(&collider(terrain)), None);
    }
}
