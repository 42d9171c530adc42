use super::*;
use crate::math::DMat3;
use crate::solve::shadow::Shadow;

fn node(v: DVec3) -> RowNode {
    RowNode {
        body: 0,
        node: 0,
        inv_mass: 1.0,
        v,
        free: v,
        before: v,
    }
}

fn rows(friction: f64, depth: f64, arm: DVec3, v: DVec3) -> Rows {
    let mut rows = Rows::default();
    rows.nodes.push(node(v));
    let terms = rows.add_terms([Term {
        node: 0,
        weight: 1.0,
        share: 1.0,
    }]);
    rows.contacts.push(Row {
        terms,
        shadow: 0,
        pair: 0,
        between: false,
        normal: DVec3::Y,
        depth,
        arm,
        rigid_share: 1.0,
        friction,
        softness: 0.0,
        drift: DVec3::ZERO,
        carried: 0.0,
        normal_impulse: 0.0,
        friction_impulse: DVec3::ZERO,
        mass: 0.0,
        turning: 0.0,
    });
    rows
}

#[test]
fn a_node_lands_sticks_or_slides_and_may_close_its_gap() {
    for (friction, depth, expected) in [
        (0.0, 0.0, DVec3::new(1.0, 0.0, 0.0)),
        (0.3, 0.0, DVec3::new(0.4, 0.0, 0.0)),
        (0.9, 0.0, DVec3::ZERO),
        (0.0, -0.001, DVec3::new(1.0, -1.0, 0.0)),
    ] {
        let v = DVec3::new(1.0, -2.0, 0.0);
        let mut rows = rows(friction, depth, DVec3::ZERO, v);
        rows.solve(&mut [Shadow::FIXED], 1e-3, 4, false);
        assert!(
            (rows.nodes[0].v - expected).length() < 1e-12,
            "μ = {friction}, depth {depth}: {}",
            rows.nodes[0].v
        );
    }
}

#[test]
fn a_collision_conserves_momentum() {
    let mut shadow = Shadow {
        inv_mass: DVec3::splat(0.5),
        inv_inertia: DMat3::IDENTITY,
        v: DVec3::new(0.0, 0.3, 0.1),
        ..Shadow::FIXED
    };
    let before = DVec3::new(0.3, -2.0, 0.0) + shadow.v / 0.5;
    let v = DVec3::new(0.3, -2.0, 0.0);
    let mut rows = rows(0.5, 0.0, DVec3::new(0.4, 0.1, -0.2), v);
    rows.solve(std::slice::from_mut(&mut shadow), 1e-3, 4, true);
    let after = rows.nodes[0].v + shadow.v / 0.5;
    assert!((after - before).length() < 1e-12);
    assert!((shadow.impulse - (shadow.v - DVec3::new(0.0, 0.3, 0.1)) / 0.5).length() < 1e-12);
}
