//! Questions that make no sense have no answer.

use crate::fixtures::{cube, floored};
use crumple::prelude::*;
use crumple::rapier3d::parry::shape::Ball;
use crumple::rapier3d::prelude::*;

const BAD: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];

fn worlds() -> Vec<DeformableWorld> {
    let mut set = DeformableWorld::new();
    set.insert(cube(0.6)).unwrap();
    let rope = rope(Vector::Y, Vector::X, 3, 1e-4);
    set.insert(DeformableBuilder::new(rope).material(Material::rubber()))
        .unwrap();
    vec![DeformableWorld::new(), set]
}

#[test]
fn rays_that_lead_nowhere() {
    let (mut world, _) = floored(1.0 / 60.0);
    world.step();
    let filter = DeformableFilter::new().line_radius(0.1);
    for set in worlds() {
        let none = |origin: Vector, dir: Vector, max| {
            let ray = Ray::new(origin, dir);
            for solid in [true, false] {
                assert_eq!(
                    set.cast_ray(&ray, max, solid, filter),
                    None,
                    "{ray:?} {max}"
                );
                let both = set.cast_ray_with(&world.query_pipeline(), &ray, max, solid, filter);
                assert!(both.is_none(), "{ray:?} {max}");
            }
        };
        let (origin, dir) = (Vector::new(0.1, 0.2, 0.0), Vector::Y);
        for bad in BAD {
            none(Vector::new(bad, 0.0, 0.0), dir, 9.0);
            none(origin, Vector::new(0.0, bad, 0.0), 9.0);
        }
        none(origin, Vector::ZERO, 9.0);
        none(origin, dir, f32::NAN);
        none(origin, dir, -1.0);
        none(origin, dir, f32::NEG_INFINITY);
    }
    let far = Ray::new(Vector::Y * 3.0e38, -Vector::Y * 1.0e38);
    let infinite = worlds()[1].cast_ray(&far, f32::INFINITY, true, filter);
    assert!((infinite.unwrap().time_of_impact - 3.0).abs() < 1e-5);
    let tiny = Ray::new(Vector::new(0.02, 2.0, 0.01), -Vector::Y * 1.0e-30);
    assert!(
        worlds()[1]
            .cast_ray(&tiny, f32::MAX, true, filter)
            .is_some()
    );
}

#[test]
fn points_boxes_and_shapes_that_are_nowhere() {
    for set in worlds() {
        let filter = DeformableFilter::new();
        for bad in BAD {
            let point = Vector::new(0.0, bad, 0.0);
            assert_eq!(set.project_point(point, 9.0, true, filter), None);
            assert!(set.intersect_point(point, filter).is_empty());
            let pose = Pose::from_translation(point);
            assert!(
                set.intersect_shape(&pose, &Ball::new(1.0), filter)
                    .is_empty()
            );
        }
        for max in [f32::NAN, -1.0, f32::NEG_INFINITY] {
            assert_eq!(set.project_point(Vector::ZERO, max, true, filter), None);
        }
        for (lo, hi) in [
            (Vector::splat(f32::NAN), Vector::ONE),
            (-Vector::ONE, Vector::splat(f32::NAN)),
            (Vector::ONE, -Vector::ONE),
        ] {
            assert_eq!(set.intersect_aabb(Aabb::new(lo, hi), filter).len(), 0);
        }
        for radius in [f32::NAN, -1.0, f32::INFINITY] {
            let odd = filter.line_radius(radius);
            let ray = Ray::new(Vector::new(0.5, 5.0, 0.0), -Vector::Y);
            assert_eq!(set.cast_ray(&ray, 9.0, true, odd), None);
        }
    }
}

/// All nodes in one place, and all on one line: no face has a normal, and nothing panics.
#[test]
fn bodies_crushed_flat_are_still_near() {
    for flat in [Vector::ZERO, Vector::X] {
        let mut set = worlds().pop().unwrap();
        let block = set.iter().next().unwrap().0;
        let places: Vec<Vector> = set[block].positions().collect();
        for (node, place) in (0..).zip(places) {
            assert!(set[block].set_position(NodeId(node), place * flat));
        }
        let filter = DeformableFilter::new();
        let found = set.project_point(-Vector::Y, 9.0, true, filter).unwrap();
        assert!((found.distance - 1.0).abs() < 1e-6 && found.deformable == block);
        let ray = Ray::new(Vector::Y * 0.5, -Vector::Y);
        assert_eq!(set.cast_ray(&ray, 9.0, true, filter), None);
        let aabb = Aabb::new(-Vector::splat(0.1), Vector::splat(0.1));
        assert!(set.intersect_aabb(aabb, filter).contains(&block));
    }
}
