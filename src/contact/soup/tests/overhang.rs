//! Nodes at the border of a surface, with and without edges that lead round it.

use super::soup;
use crate::contact::soup::overhang::{Margins, Overhang, bearing};
use crate::contact::soup::{NodeFacets, Touches, touches};
use crate::math::{DVec3, Vector};
use rapier3d::geometry::SharedShape;

const MARGINS: Margins = Margins {
    border: 1e-4,
    touching: 1e-5,
};

/// Two triangles in the plane z = 0, below y = 0.
fn square() -> NodeFacets {
    let at = |x, y| Vector::new(x, y, 0.0);
    let corners = vec![at(-1.0, 0.0), at(1.0, 0.0), at(1.0, -1.0), at(-1.0, -1.0)];
    let shape = SharedShape::trimesh(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let mut facets = NodeFacets::default();
    facets.gather(&soup(&shape), std::iter::once((0, DVec3::ZERO)), 3.0);
    facets
}

/// An edge of 10 cm along `way` over the upper border.
fn over_top(p: DVec3, way: DVec3) -> Overhang {
    Overhang {
        node: 0,
        border: 0,
        end: p + 0.1 * way.normalize(),
        length: 0.1,
    }
}

/// Moves a node from `p` in front by `down` m to behind; returns whether it is held and on which side it is thought to be then.
fn is_held(p: DVec3, way: DVec3, down: f64) -> (bool, DVec3) {
    let facets = square();
    let (mut slots, mut out) = (Vec::new(), Touches::default());
    let (behind, over) = (p - DVec3::Z * down, [over_top(p, way)]);
    let (near, back) = bearing(facets.near(0), &over, (behind, p), MARGINS, &mut slots);
    touches(near, behind, DVec3::ZERO, Some(p), 0.0, 1e-3, &mut out);
    let held = out.as_slice().iter().any(|t| t.depth > 0.0);
    (held, out.anchor.unwrap() + back)
}

#[test]
fn only_edges_that_lead_round_a_border_lead_nodes_over_it() {
    let over = DVec3::new(0.3, -0.3, -1.0);
    for (name, p, way, held) in [
        ("over the border", DVec3::new(0.3, -5e-5, 1e-6), over, false),
        ("far below it", DVec3::new(0.3, -2e-4, 1e-6), over, true),
        (
            "at the next border",
            DVec3::new(-1.0 + 5e-5, -0.3, 1e-6),
            over,
            true,
        ),
        (
            "an edge from behind",
            DVec3::new(0.3, -5e-5, 1e-6),
            DVec3::Z,
            true,
        ),
        (
            "an edge along the face",
            DVec3::new(0.3, -5e-5, 1e-6),
            DVec3::Y,
            true,
        ),
    ] {
        assert_eq!(is_held(p, way, 1e-3).0, held, "{name}");
    }
}

#[test]
fn what_rounding_takes_behind_a_border_has_not_gone_round_it() {
    let p = DVec3::new(0.3, -5e-5, 1e-6);
    let (held, side) = is_held(p, DVec3::NEG_Z, 5e-6);
    assert!(!held && side.z > 0.0, "{side}");
    let (held, side) = is_held(p, DVec3::NEG_Z, 1e-3);
    assert!(!held && side.z < -1e-4, "{side}");
}
