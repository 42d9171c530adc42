use super::*;

#[test]
fn a_tumbling_box_keeps_angular_momentum_and_energy() {
    let inertia = DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0));
    let mut s = Shadow {
        inertia,
        inv_inertia: inertia.inverse(),
        principal: (DQuat::IDENTITY, DVec3::new(1.0, 2.0, 3.0)),
        w: DVec3::new(0.3, 4.0, 0.2),
        ..Shadow::FIXED
    };
    let (l0, e0) = (inertia * s.w, s.w.dot(inertia * s.w));
    for _ in 0..10_000 {
        s.advance(1e-4);
    }
    assert!((s.inertia * s.w - l0).length() < 1e-6 * l0.length());
    assert!((s.w.dot(s.inertia * s.w) - e0).abs() < 1e-3 * e0);
}

/// A rod whose axis is almost square to its momentum: it turns that axis round the momentum at L/I₁, and keeps the angle,
/// in substeps in which the turn about the spin at their start would triple it.
#[test]
fn a_thin_rod_tumbles_about_its_momentum() {
    let moments = DVec3::new(0.1, 0.1 / 2400.0, 0.1);
    let (momentum, h) = (DVec3::new(4.5, 1e-3, 0.0), 1e-3);
    let mut s = Shadow {
        inertia: DMat3::from_diagonal(moments),
        inv_inertia: DMat3::from_diagonal(moments.recip()),
        principal: (DQuat::IDENTITY, moments),
        w: momentum / moments,
        ..Shadow::FIXED
    };
    assert!(s.tumbles(h));
    let energy = s.w.dot(momentum);
    for i in 1..=1000 {
        s.advance(h);
        assert!((s.inertia * s.w - momentum).length() < 1e-9 * momentum.length());
        assert!((s.w.dot(momentum) / energy - 1.0).abs() < 1e-6, "{i}");
        let turn = DQuat::from_scaled_axis(momentum * (f64::from(i) * h / moments.x));
        let off = s.rot * DVec3::Y - turn * DVec3::Y;
        assert!(off.length() < 1e-6, "{i}: {off}");
    }
}

/// A brick of three moments: the error of energy is of second order and does not grow.
#[test]
fn a_brick_tumbles_without_gaining_energy() {
    let moments = DVec3::new(1.0, 2.0, 3.0);
    // In a frame of its own, and turned.
    let (frame, rot) = (DQuat::from_rotation_x(0.7), DQuat::from_rotation_z(0.4));
    let axes = DMat3::from_quat(rot * frame);
    let inertia = axes * DMat3::from_diagonal(moments) * axes.transpose();
    let start = Shadow {
        rot,
        inertia,
        inv_inertia: inertia.inverse(),
        principal: (frame, moments),
        w: axes * DVec3::new(0.3, 4.0, 0.2),
        ..Shadow::FIXED
    };
    let worst = |h: f64| {
        let (mut s, energy) = (start, start.w.dot(start.inertia * start.w));
        let mut worst = 0.0_f64;
        for _ in 0..(50.0 / h) as usize {
            s.advance(h);
            worst = worst.max((s.w.dot(s.inertia * s.w) / energy - 1.0).abs());
        }
        worst
    };
    let (one, half) = (worst(0.02), worst(0.01));
    assert!(one < 2e-3, "{one}");
    assert!((one / half - 4.0).abs() < 0.5, "{one} {half}");
}

#[test]
fn the_response_matrix_agrees_with_the_response() {
    let inertia = DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0));
    let s = Shadow {
        inv_inertia: inertia.inverse(),
        inv_mass: DMat3::from_diagonal(DVec3::splat(0.25)),
        cross: Some(DMat3::from_cols(
            DVec3::new(0.1, 0.0, 0.05),
            DVec3::new(-0.02, 0.03, 0.0),
            DVec3::new(0.0, 0.07, -0.04),
        )),
        ..Shadow::FIXED
    };
    let (arm, n) = (DVec3::new(0.3, -0.2, 0.7), DVec3::new(0.6, 0.0, -0.8));
    let matrix = s.response_matrix(arm);
    assert!((n.dot(matrix * n) - s.response(arm, n)).abs() < 1e-12);
    assert!((matrix * n).length() <= s.norms().response(arm));
    assert!(s.norms().response(arm) < 4.0 * matrix.x_axis.length());
}
