mod composite;
mod energy;
mod joint;
mod squeeze;
mod stand;
mod supports;

use super::*;
use crate::law::row::Lift;
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
        depth,
        arm,
        friction,
        ..row(terms)
    });
    rows
}

/// A row on the fixed world without friction.
fn row(terms: Terms) -> Row {
    Row {
        terms,
        shadow: 0,
        pair: 0,
        between: false,
        levers: None,
        normal: DVec3::Y,
        depth: 0.0,
        turn: Default::default(),
        arm: DVec3::ZERO,
        rigid_share: 1.0,
        friction: 0.0,
        softness: 0.0,
        drift: DVec3::ZERO,
        carried: 0.0,
        normal_impulse: 0.0,
        friction_impulse: DVec3::ZERO,
        response: Default::default(),
        lift: Lift::default(),
        pinched: 0.0,
    }
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
        inv_mass: DMat3::from_diagonal(DVec3::splat(0.5)),
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

/// A body on a table of the same mass, which stands on the fixed world, does not give way to a blow from above, and gives
/// way to one from the side.
#[test]
fn bodies_that_press_on_each_other_share_a_blow() {
    let body = |mass: f64, y: f64| Shadow {
        com: DVec3::Y * y,
        inv_mass: DMat3::from_diagonal(DVec3::splat(1.0 / mass)),
        ..Shadow::FIXED
    };
    let contact = |shadows: [u32; 2]| RigidRow {
        shadows,
        arms: [DVec3::ZERO; 2],
        normal: DVec3::Y,
        shares: [1.0, 1.0],
        ..RigidRow::default()
    };
    for blow in [DVec3::Y * -5.0, DVec3::X * 5.0] {
        let mut shadows = [Shadow::FIXED, body(2.0, 0.0), body(2.0, 0.0)];
        let mut rows = rows(1.0, 0.0, DVec3::ZERO, blow);
        rows.contacts[0].shadow = 2;
        rows.contacts[0].normal = -blow.normalize();
        rows.rigid = vec![contact([0, 1]), contact([1, 2])];
        rows.solve(&mut shadows, 1e-3, 16, false);
        let expected = if blow.y < 0.0 {
            0.0
        } else {
            // The body of 2 kg alone: there is no friction.
            5.0 / 3.0
        };
        let v = shadows[2].v.length();
        assert!((v - expected).abs() < 5e-3, "{blow}: {v}");
        assert!((rows.nodes[0].v.length() - expected).abs() < 5e-3);
        let given = shadows[2].impulse.length();
        assert!((given - (5.0 - expected)).abs() < 1e-2, "{given}");
        assert_eq!(
            shadows[1].impulse,
            DVec3::ZERO,
            "rigid contacts hand nothing over"
        );
    }
}

/// A body that is heavier now, or has got bodies on a joint, answers as it is and not as it was when its contact was prepared.
#[test]
fn contacts_of_bodies_see_how_these_answer_now() {
    let body = |mass: f64| Shadow {
        inv_mass: DMat3::from_diagonal(DVec3::splat(1.0 / mass)),
        inv_inertia: DMat3::from_diagonal(DVec3::splat(10.0 / mass)),
        v: DVec3::new(0.5, -1.0, 0.2),
        ..Shadow::FIXED
    };
    let contact = RigidRow {
        shadows: [0, 1],
        arms: [DVec3::ZERO, DVec3::new(0.2, -0.5, 0.1)],
        normal: DVec3::Y,
        shares: [1.0, 1.0],
        friction: 0.3,
        ..RigidRow::default()
    };
    let solve = |rows: &mut Rows, body: Shadow| {
        let mut shadows = [Shadow::FIXED, body];
        rows.rigid[0].scale(0.0);
        rows.solve(&mut shadows, 1e-3, 16, false);
        (shadows[1].v, shadows[1].w)
    };
    let start = || Rows {
        rigid: vec![contact],
        ..Rows::default()
    };
    let mut rows = start();
    let jointed = Shadow {
        cross: Some(DMat3::from_diagonal(DVec3::splat(0.05))),
        ..body(2.0)
    };
    for body in [body(2.0), body(2.01), body(8.0), jointed, body(2.0)] {
        let (v, w) = solve(&mut rows, body);
        let expected = solve(&mut start(), body);
        assert_eq!((v, w), expected);
    }
}

/// Two tiles of one floor meet under a node: two rows of the same normal carry it like one, and let it slide like one.
#[test]
fn a_node_on_two_tiles_slides_as_on_one() {
    let v = DVec3::new(1.0, -2.0, 0.0);
    let mut two = rows(0.3, 0.0, DVec3::ZERO, v);
    two.contacts.push(two.contacts[0]);
    two.solve(&mut [Shadow::FIXED], 1e-3, 4, false);
    assert!((two.nodes[0].v - DVec3::X * 0.4).length() < 1e-9);
    let sum: f64 = two.contacts.iter().map(|r| r.normal_impulse).sum();
    assert!((sum - 2.0).abs() < 1e-9, "{sum}");
}

/// A tie at the centre of the second shadow.
fn tie() -> Tie {
    Tie {
        terms: Terms::default(),
        shadow: 1,
        attachment: 0,
        between: false,
        arm: DVec3::ZERO,
        error: DVec3::ZERO,
        before: DVec3::ZERO,
        lean: 0.5,
        chord: DVec3::ZERO,
        bias: DVec3::ZERO,
        softness: 0.0,
        impulse: DVec3::ZERO,
        mass: DMat3::ZERO,
        give: Give::default(),
    }
}

/// Adds a node that is tied to the first body at `arm`.
fn add_tied(rows: &mut Rows, node: RowNode, arm: DVec3) {
    let terms = rows.add_terms([Term {
        node: rows.nodes.len() as u32,
        weight: 1.0,
        share: 1.0,
    }]);
    rows.nodes.push(node);
    rows.ties.push(Tie {
        terms,
        arm,
        ..tie()
    });
}

/// A node of 10 g on the fixed world, pinned to a body of 10 kg that moves at `v`, with what holds the body beside it.
fn pinned(depth: f64, v: DVec3, moves: f64) -> (Rows, [Shadow; 2]) {
    let mut rows = rows(0.0, depth, DVec3::ZERO, v);
    rows.nodes[0].inv_mass = 100.0;
    rows.push_out = 0.3;
    let terms = rows.contacts[0].terms;
    rows.ties.push(Tie { terms, ..tie() });
    let body = Shadow {
        inv_mass: DMat3::from_diagonal(DVec3::splat(0.1 * moves)),
        v,
        ..Shadow::FIXED
    };
    (rows, [Shadow::FIXED, body])
}

/// A heavy body that is held by a light node comes to a stop with it, in one substep.
#[test]
fn a_body_lands_on_a_light_node_that_it_holds() {
    for reversed in [false, true] {
        let (mut rows, mut shadows) = pinned(0.0, DVec3::new(1.0, -2.0, 0.0), 1.0);
        rows.solve(&mut shadows, 1e-3, 4, reversed);
        let expected = DVec3::X;
        assert!(
            (shadows[1].v - expected).length() < 1e-6,
            "{}",
            shadows[1].v
        );
        assert!((rows.nodes[0].v - expected).length() < 1e-6);
        let impulse = rows.contacts[0].normal_impulse;
        assert!((impulse - 20.02).abs() < 1e-6, "{impulse}");
    }
}

/// What such a node is in, the body is slowly lifted out of; what can't be moved is not pressed on.
#[test]
fn a_body_is_lifted_out_with_the_node_that_it_holds() {
    for (depth, speed) in [(0.002, 0.04), (0.1, 0.3)] {
        let (mut rows, mut shadows) = pinned(depth, DVec3::Y * -1.0, 1.0);
        rows.solve(&mut shadows, 1e-3, 4, false);
        assert!((shadows[1].v.y - speed).abs() < 1e-6, "{}", shadows[1].v);
        assert!((rows.nodes[0].v.y - speed).abs() < 1e-6);
    }
    // A node of ten times the mass of its body is lifted all the same.
    let (mut rows, mut shadows) = pinned(0.002, DVec3::ZERO, 1.0);
    rows.nodes[0].inv_mass = 0.01;
    rows.solve(&mut shadows, 1e-3, 4, false);
    assert!((shadows[1].v.y - 0.04).abs() < 1e-6, "{}", shadows[1].v);
    let (mut rows, mut shadows) = pinned(0.002, DVec3::ZERO, 0.0);
    rows.solve(&mut shadows, 1e-3, 4, false);
    assert_eq!(rows.contacts[0].normal_impulse, 0.0);
}

/// Faster than the lift is fast enough, and what flies off needs no push.
#[test]
fn a_body_that_leaves_by_itself_is_not_lifted() {
    let (mut rows, mut shadows) = pinned(0.002, DVec3::Y * 0.5, 1.0);
    rows.solve(&mut shadows, 1e-3, 4, false);
    assert_eq!(rows.contacts[0].normal_impulse, 0.0);
    assert!((shadows[1].v.y - 0.5).abs() < 1e-12);
}

/// A body that falls on a strip of light nodes, each row on two of them: once what is left concerns nobody it is left, which
/// moves the nodes by less than gravity and the body by less than a hundredth of it, and takes no momentum.
#[test]
fn what_is_settled_is_hardly_off() {
    let h = 2e-4;
    let strip = |negligible: Negligible| {
        let mut rows = Rows {
            negligible,
            ..Rows::default()
        };
        for i in 0..9 {
            let up = DVec3::Y * (0.02 + 0.005 * f64::from(i % 3));
            rows.nodes.push(RowNode {
                inv_mass: 100.0,
                ..node(up)
            });
        }
        for i in 0..8 {
            let half = |node: u32| Term {
                node,
                weight: 0.5,
                share: 0.5,
            };
            let terms = rows.add_terms([half(i), half(i + 1)]);
            rows.contacts.push(Row {
                shadow: 1,
                normal: DVec3::new(0.1 * (f64::from(i) - 3.5), -1.0, 0.0).normalize(),
                friction: 0.5,
                ..row(terms)
            });
        }
        let mut shadows = [Shadow::FIXED; 2];
        shadows[1].inv_mass = DMat3::from_diagonal(DVec3::splat(0.1));
        shadows[1].v = DVec3::Y * -9.81 * h;
        rows.solve(&mut shadows, h, 64, false);
        (rows, shadows[1])
    };
    let (exact, still) = strip(Negligible::default());
    let (quick, moved) = strip(Negligible::of(h, 1.0));
    let off = exact.nodes.iter().zip(&quick.nodes);
    let off = off.map(|(a, b)| a.v.distance(b.v)).fold(0.0, f64::max);
    assert!(0.0 < off && off < 10.0 * h, "nodes by {off} m/s");
    let body = still.v.distance(moved.v);
    assert!(body < 0.1 * h, "the body by {body} m/s");
    let nodes: DVec3 = quick.nodes.iter().map(|n| (n.v - n.free) * 0.01).sum();
    let given = (moved.v + DVec3::Y * 9.81 * h) * 10.0;
    assert!((nodes + given).length() < 1e-12);
}

/// A body of 6 kg falls at 2 m/s on light nodes, and these on heavier ones: after the few passes asked for they must not close
/// at more than a small part of the speed at which depth is mended.
#[test]
fn what_hangs_together_is_solved_until_nothing_sinks_in() {
    let mut rows = Rows {
        push_out: 0.3,
        ..Rows::default()
    };
    const N: u32 = 5;
    for inv_mass in [140.0, 27.0] {
        for _ in 0..N {
            rows.nodes.push(RowNode {
                inv_mass,
                ..node(DVec3::ZERO)
            });
        }
    }
    let term = |node: u32, weight: f64| Term {
        node,
        weight,
        share: weight,
    };
    for i in 0..N - 1 {
        let terms = rows.add_terms([term(i, 0.5), term(i + 1, 0.5)]);
        rows.contacts.push(Row {
            shadow: 1,
            normal: DVec3::NEG_Y,
            ..row(terms)
        });
    }
    for i in 0..N {
        let beside = N + (i + 1) % N;
        let terms = rows.add_terms([term(i, 1.0), term(N + i, -0.6), term(beside, -0.4)]);
        rows.contacts.push(Row {
            between: true,
            ..row(terms)
        });
    }
    let mut shadows = [Shadow::FIXED; 2];
    shadows[1].inv_mass = DMat3::from_diagonal(DVec3::splat(1.0 / 6.0));
    shadows[1].v = DVec3::Y * -2.0;
    rows.solve(&mut shadows, 4e-4, 4, false);
    assert!(!rows.contacts_stop(&shadows, 4e-4, 0.01));
    // They are all taken along.
    assert!(shadows[1].v.y > -2.0 && rows.nodes.iter().all(|n| n.v.y < -1.0));
}
