//! Nodes that are led over a ridge between two facets, along the plane of the far one.

use super::soup;
use crate::contact::soup::{NodeFacets, Touches, touches};
use crate::math::{DVec3, Vector};
use rapier3d::geometry::SharedShape;

/// Two squares of 1 m that meet at x = 0: one in the plane y = 0, the other falls away by an angle of this sine.
fn ridge(sine: f64) -> NodeFacets {
    let at = |x: f64, y: f64, z: f64| Vector::new(x as f32, y as f32, z as f32);
    let (x, y) = ((1.0 - sine * sine).sqrt(), -sine);
    let corners = vec![
        at(-1.0, 0.0, -0.5),
        at(-1.0, 0.0, 0.5),
        at(0.0, 0.0, -0.5),
        at(0.0, 0.0, 0.5),
        at(x, y, -0.5),
        at(x, y, 0.5),
    ];
    let facets = vec![[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]];
    let shape = SharedShape::trimesh(corners, facets).unwrap();
    let mut facets = NodeFacets::default();
    facets.gather(&soup(&shape), std::iter::once((0, DVec3::ZERO)), 3.0);
    facets
}

/// Symptom: a rope without thickness round an open tube of 47 to 72 facets jammed, at 350 times its tension. Its nodes come to a ridge
/// along the plane of the facet beyond it, before that or behind it by rounding, and some were taken for coming out from behind it.
#[test]
fn what_comes_along_the_plane_beyond_a_ridge_is_before_it() {
    for sine in [0.01, 0.09, 0.13, 0.3, 0.7] {
        let facets = ridge(sine);
        let along = DVec3::new((1.0 - sine * sine).sqrt(), -sine, 0.0);
        let out = DVec3::new(sine, along.x, 0.0);
        for i in 0..400 {
            // Of single precision.
            let off = f64::from(i % 20 - 10) * 3e-9;
            let before = 1e-6 * 1.05_f64.powi(i / 2);
            let p = DVec3::Z * 0.1 - along * before + out * off;
            let motion = along * (before * 1.3) - out * off * 0.7;
            let (mut found, mut anchor) = (Touches::default(), None);
            for p in [p, p + motion] {
                touches(facets.near(0), p, motion, anchor, 0.0, 1e-3, &mut found);
                anchor = found.anchor;
                for touch in found.as_slice() {
                    let from = format!("{sine}: {before} m before, {off} m off: {touch:?}");
                    assert!(touch.normal.y > 0.0, "{from}");
                }
            }
        }
    }
}
