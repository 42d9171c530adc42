//! Shapes without extent, and points that are no numbers.

use super::super::Solid;
use super::{composites, convex};
use crate::math::{DVec3, wide};
use rapier3d::geometry::SharedShape;
use rapier3d::math::Vector;

#[test]
fn shapes_without_extent_and_points_that_are_none_are_answered() {
    let flat: Vec<Vector> = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
        .map(|(x, z)| Vector::new(x, 0.0, z))
        .into();
    let wide_points: Vec<DVec3> = flat.iter().map(|&p| wide(p)).collect();
    let hull = |points: &[Vector]| Solid {
        core: super::super::Core::hull(points).unwrap(),
        radius: 0.0,
    };
    let sheet = hull(&flat);
    assert_eq!(sheet.width(), 0.0);
    assert_eq!(
        sheet.signed_distance(DVec3::new(0.4, 0.2, 0.3)),
        (0.2, DVec3::Y)
    );
    assert_eq!(
        sheet.signed_distance(DVec3::new(0.4, -0.2, 0.3)),
        (0.2, DVec3::NEG_Y)
    );
    let beside = sheet.signed_distance(DVec3::new(-0.3, 0.0, 0.3));
    assert!(
        (beside.0 - 0.3).abs() < 1e-12 && (beside.1 - DVec3::NEG_X).length() < 1e-12,
        "{beside:?}"
    );
    assert_eq!(wide_points.len(), 4);
    let mut solids = vec![
        sheet,
        hull(&[Vector::ONE]),
        hull(&[Vector::ONE, Vector::ZERO, Vector::splat(0.5)]),
    ];
    let zero = [
        SharedShape::ball(0.0),
        SharedShape::cuboid(0.0, 0.0, 0.0),
        SharedShape::cuboid(0.0, 1.0, 1.0),
        SharedShape::capsule_y(0.0, 0.0),
        SharedShape::cylinder(0.0, 0.0),
        SharedShape::cylinder(0.0, 1.0),
        SharedShape::cone(0.0, 0.0),
        SharedShape::cone(0.0, 1.0),
        SharedShape::cone(1.0, 0.0),
        SharedShape::round_cuboid(0.0, 0.0, 0.0, 0.0),
    ];
    solids.extend(zero.iter().map(|s| Solid::of(&**s).unwrap()));
    let all = convex().into_iter().chain(composites());
    solids.extend(all.map(|(_, s)| Solid::of(&*s).unwrap()));
    solids.push(Solid::of(&*SharedShape::halfspace(Vector::Y)).unwrap());
    for solid in &solids {
        for p in [
            DVec3::ZERO,
            DVec3::ONE,
            DVec3::Y,
            DVec3::splat(0.5),
            DVec3::NEG_Y,
        ] {
            let (d, n) = solid.signed_distance(p);
            assert!(
                d.is_finite() && (n.length() - 1.0).abs() < 1e-9,
                "{solid:?} at {p}: {d} {n}"
            );
        }
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
            let bads = [DVec3::splat(bad), DVec3::new(0.1, bad, 0.2)];
            for p in bads {
                let _ = solid.signed_distance(p);
                let _ = solid.cast(p, DVec3::ZERO);
                let _ = solid.cast(DVec3::ONE * 3.0, p);
                let _ = solid.nearest_on_segment(p, DVec3::ONE);
                let _ = solid.edges_apart(p, p);
                let _ = solid.depth_along(p, p);
                solid.feature_points(p, &mut Vec::new());
            }
        }
        let _ = solid.bounds();
    }
    assert!(super::super::Core::hull(&[]).is_none());
    assert!(super::super::Core::hull(&[Vector::splat(f32::NAN)]).is_none());
}
