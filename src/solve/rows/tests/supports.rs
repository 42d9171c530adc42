//! Bodies on points that give way to nothing.

use super::*;

/// A falling and turning body of 2 kg on points that stand still, the first `free` of which are nodes of 1 kg instead.
fn supported(arms: &[DVec3], free: usize) -> (Rows, [Shadow; 2]) {
    let mut rows = Rows::default();
    for (i, arm) in arms.iter().enumerate() {
        let node = RowNode {
            inv_mass: if i < free { 1.0 } else { 0.0 },
            ..node(DVec3::ZERO)
        };
        add_tied(&mut rows, node, *arm);
    }
    let body = Shadow {
        inv_mass: DMat3::from_diagonal(DVec3::splat(0.5)),
        inv_inertia: DMat3::from_diagonal(DVec3::new(3.0, 40.0, 500.0)),
        v: DVec3::new(0.3, -1.0, 0.2),
        w: DVec3::new(5.0, -3.0, 2.0),
        ..Shadow::FIXED
    };
    (rows, [Shadow::FIXED, body])
}

const ARMS: [DVec3; 5] = [
    DVec3::new(0.5, 0.4, 0.3),
    DVec3::new(-0.5, 0.2, 0.1),
    DVec3::new(0.1, -0.6, 0.2),
    DVec3::new(0.0, 0.1, -0.7),
    DVec3::new(0.3, 0.3, 0.3),
];

/// What stops the body, and among several such loads the smallest: that of a field of a rigid motion.
#[test]
fn supports_stop_a_body_with_the_least_impulses() {
    let (mut rows, mut shadows) = supported(&ARMS, 0);
    let before = shadows[1];
    rows.solve(&mut shadows, 1e-3, 1, false);
    let body = shadows[1];
    assert!(
        body.v.length() < 1e-12 && body.w.length() < 1e-12,
        "{body:?}"
    );
    let impulse: DVec3 = rows.ties.iter().map(|t| t.impulse).sum();
    let torque: DVec3 = rows.ties.iter().map(|t| t.arm.cross(t.impulse)).sum();
    assert!((impulse - 2.0 * before.v).length() < 1e-12, "{impulse}");
    let momentum = before.w / DVec3::new(3.0, 40.0, 500.0);
    assert!((torque - momentum).length() < 1e-12, "{torque}");
    // The distances between points do not change in a rigid motion.
    for a in &rows.ties {
        for b in &rows.ties {
            let stretch = (a.impulse - b.impulse).dot(a.arm - b.arm);
            assert!(stretch.abs() < 1e-10, "{stretch}");
        }
    }
}

/// About the line through two of them, and about one, it goes on turning.
#[test]
fn what_supports_leave_free_goes_on() {
    for n in [1, 2] {
        let (mut rows, mut shadows) = supported(&ARMS[..n], 0);
        let energy = |s: &Shadow| {
            let spin = s.w * s.w / DVec3::new(3.0, 40.0, 500.0);
            2.0 * s.v.length_squared() + spin.x + spin.y + spin.z
        };
        let before = energy(&shadows[1]);
        rows.solve(&mut shadows, 1e-3, 1, true);
        for tie in &rows.ties {
            let v = shadows[1].velocity_at(tie.arm);
            assert!(v.length() < 1e-12, "{v}");
            assert!(tie.impulse.length() < 20.0);
        }
        let after = energy(&shadows[1]);
        assert!(after > 0.01 * before && after < before, "{after} {before}");
    }
}

/// They stand on a line but for rounding: no lever of that is used.
#[test]
fn supports_on_a_line_do_not_stop_turning_about_it() {
    let line = [-0.5, 0.0, 0.7].map(|x| DVec3::new(x, 0.2, 1e-8 * (x * x - 0.3)));
    let (mut rows, mut shadows) = supported(&line, 0);
    let before = shadows[1].w.x;
    rows.solve(&mut shadows, 1e-3, 4, false);
    assert!(shadows[1].w.x.abs() > 0.01 * before, "{}", shadows[1].w);
    for tie in &rows.ties {
        assert!(tie.impulse.length() < 10.0, "{}", tie.impulse);
    }
}

/// Nodes tied to the same body stop with it, and what they bring is borne as well; so is what presses on the body.
#[test]
fn supports_bear_what_nodes_and_contacts_bring() {
    for reversed in [false, true] {
        let (mut rows, mut shadows) = supported(&ARMS, 2);
        for i in 0..2 {
            let v = DVec3::new(1.0, -2.0, 0.5);
            (rows.nodes[i].v, rows.nodes[i].free) = (v, v);
        }
        rows.nodes.push(RowNode {
            inv_mass: 100.0,
            ..node(DVec3::Y * -3.0)
        });
        let terms = rows.add_terms([Term {
            node: 5,
            weight: 1.0,
            share: 1.0,
        }]);
        rows.contacts.push(Row {
            shadow: 1,
            arm: DVec3::new(0.2, 0.4, 0.1),
            ..row(terms)
        });
        let before = shadows[1];
        rows.solve(&mut shadows, 1e-3, 16, reversed);
        let body = shadows[1];
        assert!(
            body.v.length() < 1e-12 && body.w.length() < 1e-12,
            "{body:?}"
        );
        assert!(rows.nodes[..2].iter().all(|n| n.v.length() < 1e-12));
        // Its surface turned as the rows were prepared, see `turning`.
        let pressed = rows.contacts[0].normal_impulse;
        assert!((pressed - 0.03).abs() < 1e-4, "{pressed}");
        let ties: DVec3 = rows.ties.iter().map(|t| t.impulse).sum();
        let sum = 2.0 * before.v - ties - DVec3::Y * rows.contacts[0].normal_impulse;
        assert!(sum.length() < 1e-9, "{sum}");
    }
}

/// Along an axis in which the body can't move nothing is borne.
#[test]
fn locked_axes_bear_what_supports_need_not() {
    let (mut rows, mut shadows) = supported(&ARMS, 0);
    shadows[1].inv_mass.y_axis = DVec3::ZERO;
    shadows[1].inv_inertia = DMat3::ZERO;
    (shadows[1].v.y, shadows[1].w) = (0.0, DVec3::ZERO);
    rows.solve(&mut shadows, 1e-3, 1, false);
    for tie in &rows.ties {
        let expected = DVec3::new(0.6, 0.0, 0.4) / 5.0;
        assert!((tie.impulse - expected).length() < 1e-12, "{}", tie.impulse);
    }
}
