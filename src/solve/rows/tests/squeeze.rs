//! Light nodes between a heavy body and the fixed world.

use super::*;

/// A node of 10 g lies on the fixed world, and a body of 10 kg comes down on it at `v`.
fn squeezed(friction: f64, v: DVec3) -> (Rows, [Shadow; 2]) {
    let mut rows = rows(friction, 0.0, DVec3::ZERO, DVec3::ZERO);
    rows.nodes[0].inv_mass = 100.0;
    let above = Row {
        shadow: 1,
        normal: DVec3::NEG_Y,
        ..rows.contacts[0]
    };
    rows.contacts.push(above);
    let body = Shadow {
        inv_mass: DMat3::from_diagonal(DVec3::splat(0.1)),
        v,
        ..Shadow::FIXED
    };
    (rows, [Shadow::FIXED, body])
}

/// Four passes that see the node alone would take a thousandth of the body's momentum each.
#[test]
fn a_light_node_between_a_heavy_body_and_the_floor_stops_it() {
    for reversed in [false, true] {
        let (mut rows, mut shadows) = squeezed(0.0, DVec3::new(0.0, -2.0, 0.0));
        rows.solve(&mut shadows, 1e-3, 4, reversed);
        assert!(shadows[1].v.length() < 1e-6, "{}", shadows[1].v);
        assert!(rows.nodes[0].v.length() < 1e-6, "{}", rows.nodes[0].v);
        assert!((shadows[1].impulse.y - 20.0).abs() < 1e-6);
    }
}

/// A grid of n × n nodes of 10 g on the fixed world, and a body of 10 kg and 0.4 m that can turn, its centre of mass `off` the
/// middle, comes down on it at 2 m/s.
fn bed(n: u32, off: DVec3) -> (Rows, [Shadow; 2]) {
    let (mut rows, [fixed, body]) = squeezed(0.3, DVec3::Y * -2.0);
    let [under, above] = [rows.contacts[0], rows.contacts[1]];
    let node = rows.nodes[0];
    rows.clear();
    for i in 0..n * n {
        let place = |k: u32| 0.4 * (f64::from(k) / f64::from(n - 1) - 0.5);
        let arm = DVec3::new(place(i / n), -0.1, place(i % n)) - off;
        rows.nodes.push(node);
        let terms = rows.add_terms([Term {
            node: i,
            weight: 1.0,
            share: 1.0,
        }]);
        rows.contacts.push(Row { terms, ..under });
        rows.contacts.push(Row {
            terms,
            arm,
            ..above
        });
    }
    let inv_inertia = DMat3::from_diagonal(DVec3::splat(6.0 / (10.0 * 0.4 * 0.4)));
    let body = Shadow {
        inv_inertia,
        ..body
    };
    (rows, [fixed, body])
}

/// The loads after a substep in which the body comes to rest.
fn loads((mut rows, mut shadows): (Rows, [Shadow; 2]), reversed: bool) -> Vec<f64> {
    rows.solve(&mut shadows, 1e-3, 4, reversed);
    let [_, Shadow { v, w, .. }] = shadows;
    assert!(v.length() < 1e-6 && w.length() < 1e-6, "{v} {w}");
    let of_body = rows.contacts.iter().filter(|row| row.shadow == 1);
    of_body.map(|row| row.normal_impulse).collect()
}

/// All of these nodes can bear the body, whichever is asked first: each bears as much of it, though the body could turn about any.
#[test]
fn nodes_share_the_load_of_what_squeezes_them() {
    for (n, reversed) in [(2, false), (2, true), (9, false), (9, true)] {
        for load in loads(bed(n, DVec3::ZERO), reversed) {
            let part = load / 20.0 * f64::from(n * n);
            assert!((part - 1.0).abs() < 1e-6, "{n}, {reversed}: {part}");
        }
    }
}

/// The moments of the loads balance, and they grow evenly towards the side of the centre of mass.
#[test]
fn nodes_on_the_heavier_side_bear_more() {
    for reversed in [false, true] {
        let off = DVec3::X * 0.05;
        // A line of n loads a + b·x has the sum n·a and the moment b·Σx².
        for (i, load) in loads(bed(5, off), reversed).into_iter().enumerate() {
            let x = 0.1 * ((i / 5) as f64 - 2.0);
            let expected = 20.0 / 25.0 * (1.0 + x * off.x / 0.02);
            assert!((load - expected).abs() < 1e-6, "{reversed}, {x}: {load}");
        }
    }
}

/// Beyond the middle third some bear nothing: which, is found by leaving out those that would have to pull.
#[test]
fn nodes_under_an_overhanging_body_only_press() {
    for reversed in [false, true] {
        let off = DVec3::X * (0.4 / 3.0);
        // The least sum of squares: a triangle of three times the distance of the centre of mass from the nearer side.
        for (i, load) in loads(bed(21, off), reversed).into_iter().enumerate() {
            let x = 0.02 * ((i / 21) as f64 - 10.0);
            if x.abs() > 0.03 {
                assert_eq!(load > 0.0, x > 0.0, "{reversed}, {x}: {load}");
            }
        }
    }
}

/// Friction goes through the node as if the body lay on the floor itself: it loses μ times its normal momentum.
#[test]
fn friction_goes_through_a_squeezed_node() {
    for (friction, left) in [(0.3, 0.4), (0.9, 0.0)] {
        let (mut rows, mut shadows) = squeezed(friction, DVec3::new(1.0, -2.0, 0.0));
        rows.solve(&mut shadows, 1e-3, 4, false);
        let v = shadows[1].v;
        assert!(v.y.abs() < 1e-6, "μ = {friction}: {v}");
        assert!((v.x - left).abs() < 1e-3, "μ = {friction}: {v}");
        let node = rows.nodes[0].v.length();
        assert!(node <= v.length() + 1e-2, "μ = {friction}: {node}");
    }
}

/// The friction of an arrival that was carried over is given even where the point is about to leave again.
#[test]
fn carried_friction_of_a_squeezed_row_is_not_lost() {
    for squeezed in [false, true] {
        let mut rows = rows(0.5, 0.0, DVec3::ZERO, DVec3::new(1.0, 0.2, 0.0));
        rows.contacts[0].carried = 0.4;
        if squeezed {
            let beside = Row {
                normal: DVec3::Z,
                depth: -1.0,
                carried: 0.0,
                ..rows.contacts[0]
            };
            rows.contacts.push(beside);
        }
        rows.solve(&mut [Shadow::FIXED], 1e-3, 4, false);
        let expected = DVec3::new(0.8, 0.2, 0.0);
        assert!(
            (rows.nodes[0].v - expected).length() < 1e-12,
            "{}",
            rows.nodes[0].v
        );
    }
}

/// A node of 10 g that is 1 mm deep in a body of 10 kg below it and 3 mm in one above.
fn between(moves: [bool; 2]) -> (Rows, [Shadow; 3]) {
    let (mut rows, [fixed, body]) = squeezed(0.0, DVec3::ZERO);
    rows.push_out = 0.3;
    for (row, (shadow, depth)) in rows.contacts.iter_mut().zip([(1, 1e-3), (2, 3e-3)]) {
        (row.shadow, row.depth) = (shadow, depth);
    }
    let shadows = moves.map(|moves| if moves { body } else { fixed });
    let mut shadows = [fixed, shadows[0], shadows[1]];
    rows.solve(&mut shadows, 1e-3, 4, false);
    (rows, shadows)
}

/// Moved out of the one it would be moved into the other.
#[test]
fn what_is_deep_in_two_bodies_parts_them() {
    let (_, [_, below, above]) = between([true, true]);
    assert!(below.v.y < -1e-3 && above.v.y > 1e-3, "{below:?} {above:?}");
    let parted = above.v.y - below.v.y;
    assert!(parted < 1.01 * LEAD_RATE * 4e-3, "{parted} m/s");
}

/// And half-way between two that can't be parted it stays.
#[test]
fn what_is_deep_in_two_that_stay_is_led_half_way_between() {
    let (rows, _) = between([false, false]);
    let pinched = [0, 1].map(|i| rows.contacts[i].pinched);
    assert_eq!(pinched, [3e-3, 1e-3]);
    let (rows, [_, _, above]) = between([false, true]);
    assert_eq!(rows.contacts[0].pinched, 0.0);
    assert!(above.v.y > 0.0, "{}", above.v);
}

/// What presses a node into a rigid body by another deformable has to give way itself.
#[test]
fn a_node_goes_into_no_rigid_body_for_another_deformable() {
    let (mut rows, _) = between([false, false]);
    rows.contacts[1].between = true;
    assert!(rows.is_blocked(1, 0, DVec3::Y * -1e-3));
    assert!(!rows.is_blocked(1, 0, DVec3::Y * 1e-3));
    rows.contacts[0].depth = -2e-3;
    assert!(!rows.is_blocked(1, 0, DVec3::Y * -1e-3));
}

/// A node on the floor, `under` m deep, another deformable's node on it, and a body of 10 kg 3 mm deep on that: how fast the body rises
/// \[m/s\].
fn rise_from_a_layer(under: f64) -> f64 {
    let (mut rows, [fixed, body]) = squeezed(0.0, DVec3::ZERO);
    rows.push_out = 0.3;
    rows.nodes.push(rows.nodes[0]);
    let first = rows.terms.len();
    rows.add_term(1, 1.0, 1.0);
    let above = rows.terms_since(first);
    let first = rows.terms.len();
    rows.add_term(1, 1.0, 1.0);
    rows.add_term(0, -1.0, 1.0);
    let between = rows.terms_since(first);
    rows.contacts[0].depth = under;
    (rows.contacts[1].terms, rows.contacts[1].depth) = (above, 3e-3);
    rows.contacts.push(Row {
        terms: between,
        shadow: 0,
        between: true,
        depth: 1e-3,
        ..rows.contacts[0]
    });
    let mut shadows = [fixed, body];
    rows.solve(&mut shadows, 1e-3, 4, false);
    shadows[1].v.y
}

/// Symptom: a box sank into sheets on each other, which were moved out of it and of each other for good.
#[test]
fn what_presses_on_layers_is_lifted_if_they_are_held() {
    assert!(rise_from_a_layer(0.0) > 1e-2);
    assert!(rise_from_a_layer(-1e-2) < 1e-6);
}
