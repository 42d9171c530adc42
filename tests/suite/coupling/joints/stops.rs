//! Limits: stops and ropes.

use super::{G, Stage};
use crate::coupling::Mode;
use crate::support::close;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// A flap of 4 kg, hinged at x = 0, that lies on its stop, under a block; or the same plate, fixed.
fn flap(mode: Mode, fixed: bool, speed: f32) -> (Stage, RigidBodyHandle, DeformableHandle) {
    let mut stage = Stage::new(mode, G as f32);
    let flap = stage.body(Vector::X * 0.5, [0.5, 0.05, 0.3], 4.0);
    if fixed {
        stage.world.bodies[flap].set_body_type(RigidBodyType::Fixed, true);
    } else {
        stage.join(flap, hinge([0.0, 1.0]));
    }
    let at = Vector::new(0.75, 0.27, 0.0);
    let soft = stage.insert(10.0, 1e6, at, Vector::Y * -speed);
    (stage, flap, soft)
}

fn hinge(limits: [f32; 2]) -> RevoluteJointBuilder {
    RevoluteJointBuilder::new(Vector::Z)
        .local_anchor2(Vector::X * -0.5)
        .limits(limits)
}

/// A block strikes the flap on its stop: all of its momentum goes to the ground, as if the flap was part of it.
#[test]
fn a_flap_on_its_stop_is_as_good_as_fixed() {
    for mode in Mode::BOTH {
        for speed in [1.0, 5.0] {
            let [flap, fixed] = [false, true].map(|fixed| {
                let (mut stage, flap, soft) = flap(mode, fixed, speed);
                let (mut turned, mut up) = (0.0_f32, f64::MIN);
                for _ in 0..30 {
                    stage.step();
                    up = up.max(stage.set[soft].linvel().y);
                    let tilt = (*stage.world.bodies[flap].rotation() * Vector::X).y;
                    turned = turned.max(tilt.abs());
                }
                assert!(turned < 1e-4, "turned by {turned}");
                // Of 5 J and 125 J.
                stage.foresaw(0.02);
                (up, f64::from(stage.scales.impulse.y))
            });
            close("rebound [m/s]", flap.0, fixed.0, 2e-3);
            close("impulse [N·s]", flap.1, fixed.1, 5e-3);
        }
    }
}

/// And bears it at rest.
#[test]
fn a_flap_on_its_stop_bears_a_block() {
    for mode in Mode::BOTH {
        let (mut stage, flap, _) = flap(mode, false, 0.0);
        for _ in 0..240 {
            stage.step();
        }
        let force = stage.force(60);
        let tilt = (*stage.world.bodies[flap].rotation() * Vector::X).y;
        close("weight [N]", force.y.into(), 10.0 * G, 0.002);
        assert!(tilt.abs() < 1e-4, "turned by {tilt}");
    }
}

/// A flap or a slider that a block strikes goes to its stop, and the block goes on as where Rapier is stepped at every
/// substep.
#[test]
fn what_is_struck_goes_as_far_as_its_stop() {
    let slider = PrismaticJointBuilder::new(Vector::Y).limits([-0.1, 0.1]);
    let joints: [(GenericJoint, f32); 2] = [
        (hinge([-0.2, 1.0]).into(), -0.2_f32.sin()),
        (slider.into(), -0.1),
    ];
    for (joint, stop) in joints {
        let speeds = Mode::BOTH.map(|mode| {
            let mut stage = Stage::new(mode, 0.0);
            let is_slider = joint.locked_axes == JointAxesMask::LOCKED_PRISMATIC_AXES;
            let at = if is_slider { 0.0 } else { 0.5 };
            let body = stage.body(Vector::X * at, [0.5, 0.05, 0.3], 4.0);
            stage.join(body, joint);
            let place = Vector::new(1.5 * at, 0.27, 0.0);
            let soft = stage.insert(10.0, 1e6, place, Vector::Y * -5.0);
            let mut lowest = 0.0_f32;
            for _ in 0..30 {
                stage.step();
                let pose = stage.world.bodies[body].position();
                let tilt = (pose.rotation * Vector::X).y;
                lowest = lowest.min(pose.translation.y * f32::from(is_slider as u8) + tilt);
            }
            // Of 125 J. Rapier sees a limit only when it is passed: in the step of the arrival it may be late.
            stage.foresaw(0.5);
            assert!((lowest - stop).abs() < 5e-3, "{lowest} for {stop}");
            stage.set[soft].linvel().y
        });
        close("velocity after [m/s]", speeds[0], speeds[1], 0.01);
    }
}

/// A weight on a taut rope, struck from above, is as good as fixed.
#[test]
fn a_rope_holds_what_a_block_strikes() {
    for mode in Mode::BOTH {
        let [rope, fixed] = [false, true].map(|fixed| {
            let mut stage = Stage::new(mode, G as f32);
            let weight = stage.body(Vector::ZERO, [0.3, 0.1, 0.3], 5.0);
            if fixed {
                stage.world.bodies[weight].set_body_type(RigidBodyType::Fixed, true);
            } else {
                let rope = RopeJointBuilder::new(1.0).local_anchor1(Vector::Y);
                stage.join(weight, rope);
            }
            let soft = stage.insert(10.0, 1e6, Vector::Y * 0.32, Vector::Y * -3.0);
            let mut up = f64::MIN;
            for _ in 0..20 {
                stage.step();
                up = up.max(stage.set[soft].linvel().y);
            }
            // Of 45 J.
            stage.foresaw(0.02);
            (up, f64::from(stage.scales.impulse.y))
        });
        close("rebound [m/s]", rope.0, fixed.0, 1e-3);
        close("impulse [N·s]", rope.1, fixed.1, 1e-3);
    }
}

/// And one on a slack rope is as free as without.
#[test]
fn a_slack_rope_does_nothing() {
    let [rope, free] = [true, false].map(|rope| {
        let mut stage = Stage::new(Mode::Shipped, 0.0);
        let weight = stage.body(Vector::ZERO, [0.3, 0.1, 0.3], 5.0);
        if rope {
            stage.join(weight, RopeJointBuilder::new(9.0));
        }
        let soft = stage.insert(10.0, 1e6, Vector::Y * 0.32, Vector::Y * -3.0);
        for _ in 0..20 {
            stage.step();
        }
        stage.set[soft].linvel().y
    });
    close("velocity after [m/s]", rope, free, 1e-3);
}
