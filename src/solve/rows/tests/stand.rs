//! Light bodies between heavy nodes and the fixed world.

use super::*;

/// Sixteen nodes of 0.4 kg come down at 5 m/s on a plate of 0.1 kg that stands on its corners: passes alone leave it sinking at a metre
/// a second and more.
#[test]
fn a_light_body_passes_on_what_heavy_nodes_give_it() {
    let corner = |i: u32, n: u32| {
        let place = |k: u32| 0.2 * (f64::from(k) / f64::from(n - 1) - 0.5);
        DVec3::new(place(i / n), 0.0, place(i % n))
    };
    let mut shadows = [
        Shadow::FIXED,
        Shadow {
            inv_mass: DMat3::from_diagonal(DVec3::splat(10.0)),
            inv_inertia: DMat3::from_diagonal(DVec3::splat(10.0 * 6.0 / 0.04)),
            ..Shadow::FIXED
        },
    ];
    let mut rows = Rows {
        push_out: 0.3,
        ..Rows::default()
    };
    for i in 0..16 {
        rows.nodes.push(RowNode {
            inv_mass: 2.5,
            ..node(DVec3::Y * -5.0)
        });
        let terms = rows.add_terms([Term {
            node: i,
            weight: 1.0,
            share: 1.0,
        }]);
        rows.contacts.push(Row {
            shadow: 1,
            arm: corner(i, 4),
            ..row(terms)
        });
    }
    rows.rigid = (0..4)
        .map(|i| RigidRow {
            shadows: [0, 1],
            arms: [DVec3::ZERO, corner(i, 2)],
            normal: DVec3::Y,
            shares: [1.0, 1.0],
            ..RigidRow::default()
        })
        .collect();
    rows.solve(&mut shadows, 1e-4, 16, false);
    rows.end(&shadows, 1e-4);
    rows.spare_contacts(&mut shadows, 1e-4);
    for node in &rows.nodes {
        assert!(node.v.y > -0.02 && node.v.y < 0.1, "{}", node.v);
    }
    assert!(shadows[1].v.length() < 0.05, "{}", shadows[1].v);
    let given = shadows[1].impulse.y;
    assert!((given + 32.0).abs() < 0.5, "{given} N s of 32");
    let left = (shadows[1].given().0.y).abs();
    assert!(left < 0.5, "{left} N s are left for Rapier to bear");
}

/// What Rapier's contacts bear by themselves stays with them, and so does what stops bodies that come on their own.
#[test]
fn rapiers_contacts_keep_what_they_can_bear() {
    let fall = |v: f64, push: f64, bears: f64| {
        let mut rows = rows(0.0, 0.0, DVec3::ZERO, DVec3::Y * -push);
        rows.contacts[0].shadow = 1;
        rows.rigid = vec![RigidRow {
            shadows: [0, 1],
            normal: DVec3::Y,
            shares: [1.0, 1.0],
            bears,
            ..RigidRow::default()
        }];
        let body = Shadow {
            inv_mass: DMat3::from_diagonal(DVec3::splat(0.5)),
            v: DVec3::Y * -v,
            ..Shadow::FIXED
        };
        let mut shadows = [Shadow::FIXED, body];
        rows.solve(&mut shadows, 1e-3, 64, false);
        rows.end(&shadows, 1e-3);
        rows.spare_contacts(&mut shadows, 1e-3);
        shadows[1].borne.0.y
    };
    assert_eq!(fall(3.0, 0.0, 0.0), 0.0, "it comes by itself");
    let [all, some, none] = [0.0, 1e3, 1e4].map(|bears| fall(0.0, 3.0, bears));
    // A node of 1 kg.
    assert!((all - 3.0).abs() < 1e-2, "{all}");
    assert!((some - 2.0).abs() < 1e-2, "{some}");
    assert_eq!(none, 0.0);
}

/// What two bodies get of a contact, with its friction, is opposite and along one line; a body that dominates the other gets nothing.
#[test]
fn what_a_contact_is_spared_is_momentum_of_both_bodies() {
    let point = DVec3::new(0.3, 0.1, -0.2);
    let body = |com: DVec3, mass: f64| Shadow {
        com,
        inv_mass: DMat3::from_diagonal(DVec3::splat(1.0 / mass)),
        inv_inertia: DMat3::from_diagonal(DVec3::new(9.0, 7.0, 8.0) / mass),
        ..Shadow::FIXED
    };
    let spared = |shares: [f64; 2]| {
        let mut shadows = [
            Shadow::FIXED,
            body(DVec3::new(0.2, -0.1, 0.0), 5.0),
            body(DVec3::new(0.1, 0.3, -0.1), 0.5),
        ];
        let mut rows = rows(
            0.8,
            0.0,
            DVec3::new(0.1, 0.2, 0.0),
            DVec3::new(2.0, -5.0, 1.0),
        );
        rows.contacts[0].shadow = 2;
        rows.rigid = vec![RigidRow {
            shadows: [1, 2],
            arms: [1, 2].map(|i: usize| point - shadows[i].com),
            normal: DVec3::Y,
            shares,
            friction: 0.5,
            ..RigidRow::default()
        }];
        rows.solve(&mut shadows, 1e-3, 64, false);
        rows.end(&shadows, 1e-3);
        rows.spare_contacts(&mut shadows, 1e-3);
        shadows
    };
    let [_, one, two] = spared([1.0, 1.0]);
    let (impulse, torque) = two.borne;
    assert!(impulse.y > 0.1 && impulse.x.abs() > 0.01, "{impulse}");
    assert!((one.borne.0 + impulse).length() < 1e-12);
    let about = |s: &Shadow| s.com.cross(s.borne.0) + s.borne.1;
    assert!((about(&one) + about(&two)).length() < 1e-12, "{torque}");
    assert!((about(&two) - point.cross(impulse)).length() < 1e-12);
    let [_, one, two] = spared([0.0, 1.0]);
    assert_eq!(one.borne, Default::default());
    assert!(two.borne.0.y > 0.1);
}
