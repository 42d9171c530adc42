//! Nodes tied to one body, and that body.

use super::*;
use crate::law::joint::Axes;
use crate::solve::rows::{Joint, JointRow};

/// Four nodes of 1 kg about the centre of a body of 10 g that hardly resists turning, all of them going elsewhere.
fn composite() -> (Rows, [Shadow; 3]) {
    let mut rows = Rows::default();
    let corners = [
        DVec3::new(0.5, 0.4, 0.3),
        DVec3::new(-0.5, 0.2, 0.1),
        DVec3::new(0.1, -0.6, 0.2),
        DVec3::new(0.0, 0.1, -0.7),
    ];
    for (i, arm) in corners.into_iter().enumerate() {
        let v = DVec3::new(i as f64, 1.0 - i as f64, 0.3);
        let node = RowNode {
            inv_mass: 1.0,
            ..node(v)
        };
        add_tied(&mut rows, node, arm);
    }
    let body = |mass: f64| Shadow {
        inv_mass: DMat3::from_diagonal(DVec3::splat(1.0 / mass)),
        inv_inertia: DMat3::from_diagonal(DVec3::splat(100.0 / mass)),
        ..Shadow::FIXED
    };
    (rows, [Shadow::FIXED, body(0.01), body(20.0)])
}

fn momenta(rows: &Rows, shadows: &[Shadow]) -> (DVec3, DVec3) {
    let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
    for (node, tie) in rows.nodes.iter().zip(&rows.ties) {
        linear += node.v / node.inv_mass;
        angular += tie.arm.cross(node.v / node.inv_mass);
    }
    let body = &shadows[1];
    (
        linear + body.v / body.inv_mass.x_axis.x,
        angular + body.w / body.inv_inertia.x_axis.x,
    )
}

#[test]
fn all_ties_of_a_light_body_hold_after_one_pass() {
    let (mut rows, mut shadows) = composite();
    let (alone, before) = (shadows[1], momenta(&rows, &shadows));
    rows.solve(&mut shadows, 1e-3, 1, false);
    for (node, tie) in rows.nodes.iter().zip(&rows.ties) {
        let error = node.v - shadows[1].velocity_at(tie.arm);
        assert!(error.length() < 1e-12, "{error}");
        let given = (node.v - node.free) / node.inv_mass;
        assert!((tie.impulse - given).length() < 1e-12);
    }
    let after = momenta(&rows, &shadows);
    assert!((after.0 - before.0).length() < 1e-12);
    assert!((after.1 - before.1).length() < 1e-12);
    let sum: DVec3 = rows.ties.iter().map(|t| t.impulse).sum();
    assert!((shadows[1].impulse + sum).length() < 1e-12);
    // It answers alone again.
    assert_eq!(shadows[1].inv_mass, alone.inv_mass);
    assert_eq!(shadows[1].cross, alone.cross);
    assert_eq!(shadows[1].inv_inertia, alone.inv_inertia);
}

/// Solved alone, the joint would see 10 g and undo in each pass what the ties do.
#[test]
fn a_joint_of_the_light_body_moves_all_of_its_nodes() {
    let (mut rows, mut shadows) = composite();
    let joint = Joint {
        shadows: [1, 2],
        anchors: [DVec3::X, DVec3::X],
        axes: Axes {
            locked: [true, true, true, false, false, false],
            ..Axes::default()
        },
        ..Joint::default()
    };
    let row = JointRow::new(joint, [false; 6], &shadows);
    rows.joints.push(row);
    rows.solve(&mut shadows, 1e-3, 4, true);
    let [_, one, other] = &shadows;
    let open = one.velocity_at(DVec3::X) - other.velocity_at(DVec3::X);
    assert!(open.length() < 1e-6, "{open}");
    for (node, tie) in rows.nodes.iter().zip(&rows.ties) {
        let error = node.v - shadows[1].velocity_at(tie.arm);
        assert!(error.length() < 1e-12, "{error}");
    }
}

/// Whoever strikes a node strikes the whole of it.
#[test]
fn a_contact_of_a_node_stops_the_composite() {
    for reversed in [false, true] {
        let (mut rows, mut shadows) = composite();
        let before = momenta(&rows, &shadows);
        let terms = rows.ties[1].terms;
        rows.contacts.push(Row {
            normal: DVec3::NEG_X,
            ..row(terms)
        });
        rows.solve(&mut shadows, 1e-3, 4, reversed);
        assert!(rows.nodes[1].v.x.abs() < 1e-6, "{}", rows.nodes[1].v);
        for (node, tie) in rows.nodes.iter().zip(&rows.ties) {
            let error = node.v - shadows[1].velocity_at(tie.arm);
            assert!(error.length() < 1e-12, "{error}");
        }
        let impulse = DVec3::NEG_X * rows.contacts[0].normal_impulse;
        let after = momenta(&rows, &shadows);
        assert!(impulse.x < -0.1, "{impulse}");
        assert!((after.0 - before.0 - impulse).length() < 1e-9);
        let turned = rows.ties[1].arm.cross(impulse);
        assert!((after.1 - before.1 - turned).length() < 1e-9);
    }
}
