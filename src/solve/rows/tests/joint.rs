//! Limits and motors of joints of shadows.

use super::*;
use crate::law::joint::{Axes, Motor, Softness};
use crate::math::{DMat3, DQuat};
use crate::solve::rows::{Joint, JointRow};

/// A rod of 2 kg and 1 m along x whose end is hinged at the origin, about z, at the end of what limits and motor leave it.
fn hinged(
    limits: Option<[f64; 2]>,
    motor: Option<Motor>,
    per_mass: bool,
) -> (JointRow, [Shadow; 2]) {
    let rod = Shadow {
        com: DVec3::X * 0.5,
        inv_mass: DMat3::from_diagonal(DVec3::splat(0.5)),
        // m·l²/12
        inv_inertia: DMat3::from_diagonal(DVec3::splat(6.0)),
        ..Shadow::FIXED
    };
    let shadows = [Shadow::FIXED, rod];
    let mut joint = Joint {
        shadows: [0, 1],
        anchors: [DVec3::ZERO, DVec3::X * -0.5],
        axes: Axes {
            locked: [true, true, true, true, true, false],
            solver_step: 1e-3,
            ..Axes::default()
        },
        ..Joint::default()
    };
    (joint.axes.limits[5], joint.axes.motors[5]) = (limits, motor);
    (JointRow::new(joint, [per_mass; 6], &shadows), shadows)
}

fn solve(row: &mut JointRow, shadows: &mut [Shadow], visits: usize) {
    row.start(shadows, 1e-3);
    for _ in 0..visits {
        row.solve(shadows, 0.0);
    }
}

/// m·l²/3 about the hinge stops within one visit, whatever strikes the rod.
#[test]
fn a_stop_takes_all_of_a_blow_at_once() {
    let (mut row, mut shadows) = hinged(Some([0.0, 1.0]), None, false);
    shadows[1].push(DVec3::X * 0.5, DVec3::Y * -3.0);
    solve(&mut row, &mut shadows, 1);
    let rod = &shadows[1];
    assert!(rod.v.length() < 1e-7 && rod.w.length() < 1e-7, "{rod:?}");
    // 3 N·s at 1 m from the hinge, which bears them too.
    assert!((row.impulses[5] - 3.0).abs() < 1e-6, "{}", row.impulses);
    assert!((row.impulses[1] - 3.0).abs() < 1e-6, "{}", row.impulses);
}

/// Upwards nothing holds it, and what the stop gave in the last substep is taken back.
#[test]
fn a_stop_lets_go() {
    let (mut row, mut shadows) = hinged(Some([0.0, 1.0]), None, false);
    row.impulses[5] = 7.0;
    shadows[1].push(DVec3::X * 0.5, DVec3::Y * 3.0);
    solve(&mut row, &mut shadows, 1);
    // L = 3 N·m·s on 2/3 kg·m².
    assert!((shadows[1].w.z - 4.5).abs() < 1e-6, "{}", shadows[1].w);
    assert!(row.impulses[5].abs() < 1e-9, "{}", row.impulses);
}

/// Stiffness per moment of inertia is that of what the motor alone would turn, as in Rapier: of the rod about its centre.
#[test]
fn a_motor_turns_what_hangs_on_it() {
    let motor = Motor {
        place: 0.1,
        velocity: 0.0,
        stiffness: 40.0,
        damping: 0.0,
        max_force: f64::MAX,
    };
    for (per_mass, stiffness) in [(false, 40.0), (true, 40.0 / 6.0)] {
        let (mut row, mut shadows) = hinged(None, Some(motor), per_mass);
        solve(&mut row, &mut shadows, 1);
        let inertia = 2.0 / 3.0;
        let (h, w) = (1e-3, shadows[1].w.z);
        // I·Δw = h·k·(0.1 − h·w)
        assert!(
            (inertia * w - h * stiffness * (0.1 - h * w)).abs() < 1e-9,
            "{w}"
        );
    }
}

/// Beyond half a turn a limit is found the shorter way round.
#[test]
fn limits_lie_anywhere_on_the_circle() {
    let (mut row, mut shadows) = hinged(Some([3.0, 3.5]), None, false);
    for (angle, w, left) in [
        (-3.0, -1.0, -1.0),
        (-2.7, 1.0, 0.0),
        (2.9, -1.0, 0.0),
        (2.9, 1.0, 1.0),
    ] {
        let turn = DQuat::from_rotation_z(angle);
        let rod = &mut shadows[1];
        (rod.rot, rod.com) = (turn, turn * DVec3::X * 0.5);
        (rod.v, rod.w) = (DVec3::Z.cross(rod.com) * w, DVec3::Z * w);
        row.impulses = Default::default();
        solve(&mut row, &mut shadows, 1);
        assert!(
            (shadows[1].w.z - left).abs() < 1e-6,
            "{angle} {w}: {}",
            shadows[1].w
        );
    }
}

/// A rope of 2 m: nothing before it is taut, and then nothing outward.
#[test]
fn a_rope_holds_only_when_it_is_taut() {
    for (at, v, left) in [
        (1.5, 3.0, 3.0),
        (1.999, 3.0, 1.0),
        (2.0, 3.0, 0.0),
        (2.0, -1.0, -1.0),
    ] {
        let ball = Shadow {
            com: DVec3::new(0.6, 0.8, 0.0) * at,
            v: DVec3::new(0.6, 0.8, 0.0) * v,
            inv_mass: DMat3::from_diagonal(DVec3::splat(0.5)),
            ..Shadow::FIXED
        };
        let mut shadows = [Shadow::FIXED, ball];
        let mut joint = Joint {
            shadows: [0, 1],
            axes: Axes {
                coupled: [true; 3],
                solver_step: 1e-3,
                ..Axes::default()
            },
            ..Joint::default()
        };
        joint.axes.limits[0] = Some([f64::NEG_INFINITY, 2.0]);
        let mut row = JointRow::new(joint, [false; 6], &shadows);
        solve(&mut row, &mut shadows, 1);
        let outward = shadows[1].v.dot(DVec3::new(0.6, 0.8, 0.0));
        assert!((outward - left).abs() < 1e-9, "{at} {v}: {outward}");
    }
}

/// A body of 2 kg in a soft joint at its centre that 8 kg are tied to: it gives way to a force and a torque by what it weighs itself.
#[test]
fn a_soft_joint_is_as_stiff_as_its_rigid_bodies_are_heavy() {
    let softness = Softness::new(100.0, 1.0, 1e-3, true);
    let of = |mass: f64| Shadow {
        inv_mass: DMat3::from_diagonal(DVec3::splat(1.0 / mass)),
        inv_inertia: DMat3::from_diagonal(DVec3::splat(10.0 / mass)),
        ..Shadow::FIXED
    };
    let mut shadows = [Shadow::FIXED, of(2.0)];
    let joint = Joint {
        shadows: [0, 1],
        axes: Axes {
            locked: [true; 6],
            softness: Some(softness),
            solver_step: 1e-3,
            ..Axes::default()
        },
        ..Joint::default()
    };
    let mut row = JointRow::new(joint, [false; 6], &shadows);
    assert!(row.is_soft() && row.is_spring());
    shadows[1] = of(10.0);
    for _ in 0..5000 {
        shadows[1].take(DVec3::X * (30.0 * 1e-3), DVec3::Z * 1e-3);
        row.start(&mut shadows, 1e-3);
        row.solve(&mut shadows, 0.0);
        assert!(!row.solve(&mut shadows, 1e-6), "solved at once");
        shadows[1].advance(1e-3);
    }
    let Shadow { com, rot, .. } = shadows[1];
    let (way, turn) = (com.x, rot.to_scaled_axis().z);
    assert!(
        (way - 30.0 / 2.0 / softness.stiffness).abs() < 1e-6 * way,
        "{way} m"
    );
    assert!(
        (turn - 1.0 * 5.0 / softness.stiffness).abs() < 1e-6 * turn,
        "{turn}"
    );
    // Rapier's velocity is ahead by the drift.
    let [_, (v, w)] = row.ahead(&shadows, false).unwrap();
    assert!((v.x + softness.drift * way).abs() < 1e-6 && v.y.abs() < 1e-9);
    assert!((w.z + softness.drift * turn).abs() < 1e-6);
}

/// What was open before the step is closed by and by, and not at all where Rapier does that.
#[test]
fn what_is_open_closes_where_that_is_left_to_shadows() {
    for closes in [false, true] {
        let ball = Shadow {
            com: DVec3::X * 0.01,
            inv_mass: DMat3::IDENTITY,
            inv_inertia: DMat3::IDENTITY,
            ..Shadow::FIXED
        };
        let mut shadows = [Shadow::FIXED, ball];
        let joint = Joint {
            shadows: [0, 1],
            axes: Axes {
                locked: [true, true, true, false, false, false],
                solver_step: 1e-3,
                ..Axes::default()
            },
            open: DVec3::X * 0.01,
            closes,
            ..Joint::default()
        };
        let mut row = JointRow::new(joint, [false; 6], &shadows);
        for _ in 0..100 {
            row.start(&mut shadows, 1e-3);
            row.solve(&mut shadows, 0.0);
            row.end(1e-3);
            shadows[1].advance(1e-3);
        }
        let right = if closes {
            0.01 * (-6.0_f64).exp()
        } else {
            0.01
        };
        let open = shadows[1].com.x;
        assert!((open - right).abs() < 2e-6, "{closes}: {open} for {right}");
    }
}
