//! What is not finite, empty or without area has no answers, or finite ones.

use super::*;
use crate::contact::soup::EdgeSearch;

#[test]
fn degenerate_soups_and_points_are_harmless() {
    let v = Vector::new;
    let shapes = [
        SharedShape::triangle(v(0.0, 0.0, 0.0), v(0.0, 0.0, 0.0), v(0.0, 0.0, 0.0)),
        SharedShape::triangle(v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.5, 0.0, 0.0)),
        SharedShape::triangle(v(0.0, f32::NAN, 0.0), v(1.0, 0.0, 0.0), v(0.5, 0.0, 1.0)),
        SharedShape::triangle(
            v(0.0, f32::INFINITY, 0.0),
            v(1.0, 0.0, 0.0),
            v(0.5, 0.0, 1.0),
        ),
        SharedShape::segment(v(0.0, 0.0, 0.0), v(0.0, 0.0, 0.0)),
        SharedShape::heightfield(
            Array2::new(2, 2, vec![0.0, f32::NAN, 0.0, 1.0]),
            v(1.0, 1.0, 1.0),
        ),
        SharedShape::heightfield(Array2::new(2, 2, vec![0.0; 4]), v(0.0, 0.0, 0.0)),
        SharedShape::trimesh(
            vec![
                v(0.0, 0.0, 0.0),
                v(1.0, 0.0, 0.0),
                v(2.0, 0.0, 0.0),
                v(0.0, 0.0, 1.0),
                v(f32::NAN, 0.0, 0.0),
            ],
            vec![[0, 1, 2], [0, 1, 3], [0, 0, 1], [0, 0, 0], [0, 1, 4]],
        )
        .unwrap(),
    ];
    let points = [
        DVec3::ZERO,
        DVec3::new(0.5, 0.0, 0.0),
        DVec3::new(0.5, 1e-3, 0.2),
        DVec3::splat(f64::NAN),
        DVec3::new(f64::INFINITY, 0.0, 0.0),
        DVec3::splat(1e300),
    ];
    let odd = [0.0, 1e-3, 1e3, f64::NAN, f64::INFINITY, -1.0];
    let mut answers = 0;
    for shape in &shapes {
        let soup = soup(shape);
        let (mut search, mut edges) = (EdgeSearch::default(), Vec::new());
        let (lo, hi) = (DVec3::splat(-9.0), DVec3::splat(9.0));
        soup.convex_edges_in(lo, hi, &mut search, &mut edges);
        let mut list = NodeFacets::default();
        for p in points {
            assert!(p.is_finite() || soup.inside(p).is_none());
            for margin in [0.1, f64::INFINITY, f64::NAN] {
                list.gather(&soup, std::iter::once((0, p)), margin);
                for motion in [
                    DVec3::ZERO,
                    DVec3::Y * -1.0,
                    DVec3::splat(f64::NAN),
                    DVec3::splat(1e300),
                ] {
                    for anchor in [None, Some(p), Some(DVec3::Y), Some(DVec3::NAN)] {
                        for x in odd {
                            let mut out = Touches::default();
                            touches(list.near(0), p, motion, anchor, x, x, &mut out);
                            for touch in out.as_slice() {
                                assert!(touch.depth.is_finite(), "{touch:?}");
                                assert!((touch.normal.length() - 1.0).abs() < 1e-6, "{touch:?}");
                                answers += 1;
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(answers > 100, "{answers}");
}

#[test]
fn other_shapes_are_no_soups_and_open_meshes_have_no_inside() {
    assert!(Soup::of(&SharedShape::ball(1.0)).is_none());
    assert!(Soup::of(&SharedShape::cuboid(1.0, 1.0, 1.0)).is_none());
    let v = Vector::new;
    let corners = vec![v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)];
    let open =
        SharedShape::trimesh_with_flags(corners, vec![[0, 1, 2]], TriMeshFlags::ORIENTED).unwrap();
    let open = soup(&open);
    assert!(!open.oriented());
    assert!(open.inside(DVec3::new(0.2, 0.2, -0.1)).is_none());
    assert!(open.facet(1).is_none());
}
