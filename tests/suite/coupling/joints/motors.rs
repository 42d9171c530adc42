//! Motors and springs.

use super::{G, Stage};
use crate::coupling::{Mode, block, cuboid};
use crate::support::close;
use crumple::rapier3d::prelude::*;
use std::f64::consts::TAU;

/// A plate of 5 kg that slides up and down on a spring of 4 kN/m without force at y = 0.
fn lift(stage: &mut Stage, damping: f32, start: f32, model: MotorModel) -> RigidBodyHandle {
    let plate = stage.body(Vector::Y * start, [0.3, 0.05, 0.3], 5.0);
    let per = if model == MotorModel::ForceBased {
        1.0
    } else {
        5.0
    };
    let joint = PrismaticJointBuilder::new(Vector::Y)
        .motor_model(model)
        .motor_position(0.0, 4000.0 / per, damping / per);
    stage.join(plate, joint);
    plate
}

/// A block of 10 kg that falls 5 cm on the plate presses the spring by (M + m)·g/k, and then lies still.
#[test]
fn a_slider_on_a_spring_bears_a_block() {
    for model in [MotorModel::ForceBased, MotorModel::AccelerationBased] {
        for mode in Mode::BOTH {
            let mut stage = Stage::new(mode, G as f32);
            let start = -5.0 * 9.81 / 4000.0;
            let plate = lift(&mut stage, 150.0, start, model);
            stage.insert(10.0, 1e6, Vector::Y * (0.3 + start), Vector::ZERO);
            for _ in 0..240 {
                stage.step();
            }
            // Of about 6 J that the block falls.
            stage.foresaw(0.02);
            stage.defect = 0.0;
            let force = stage.force(60);
            stage.foresaw(2e-3);
            let down = 15.0 * G / 4000.0;
            close("deflection [m]", -stage.height(plate), down, 0.002);
            close("weight [N]", force.y.into(), 10.0 * G, 0.002);
        }
    }
}

/// Together they swing with 2π·√((M + m)/k), and lose what Rapier's solver damps, which takes the force at the end of its
/// iterations: k·dt/n [N·s/m].
#[test]
fn a_block_swings_on_a_slider_with_a_spring() {
    let mut stage = Stage::new(Mode::Shipped, G as f32);
    let plate = lift(&mut stage, 0.0, -0.022, MotorModel::ForceBased);
    let at = Vector::Y * (0.25 - 0.022);
    stage.insert(10.0, 2e6, at, Vector::ZERO);
    let middle = -15.0 * G / 4000.0;
    let (mut last, mut top) = (stage.height(plate) - middle, 0.0_f64);
    let (mut crossings, mut tops) = (Vec::new(), Vec::new());
    for step in 1..=180 {
        stage.step();
        let now = stage.height(plate) - middle;
        top = top.max(now);
        if last > 0.0 && now <= 0.0 {
            crossings.push((f64::from(step) - now / (now - last)) / 60.0);
            tops.push(std::mem::take(&mut top));
        }
        last = now;
    }
    let n = crossings.len() - 1;
    let omega = (4000.0_f64 / 15.0).sqrt();
    let period = (crossings[n] - crossings[0]) / n as f64;
    close("period [s]", period, TAU / omega, 2e-3);
    let decay = (tops[1] / tops[n]).ln() / (n - 1) as f64 / TAU;
    close("damping ratio", decay, 0.5 * omega / 960.0, 0.1);
}

/// A piston of 5 kg with a motor of 100 N at most pushes a block of 10 kg: F·t in all, and up to 2 m/s.
#[test]
fn a_motor_pushes_with_no_more_than_its_force() {
    for model in [MotorModel::ForceBased, MotorModel::AccelerationBased] {
        for mode in Mode::BOTH {
            let mut stage = Stage::new(mode, 0.0);
            let piston = stage.body(Vector::ZERO, [0.05, 0.3, 0.3], 5.0);
            let joint = PrismaticJointBuilder::new(Vector::X)
                .motor_model(model)
                .motor_velocity(2.0, 1e5)
                .motor_max_force(100.0);
            stage.join(piston, joint);
            let soft = stage.insert(10.0, 1e6, Vector::X * 0.25, Vector::ZERO);
            for _ in 0..9 {
                stage.step();
            }
            let v = f64::from(stage.world.bodies[piston].linvel().x);
            let momentum = stage.set[soft].momentum().x;
            close("momentum [N·s]", momentum + 5.0 * v, 15.0, 1e-3);
            close(
                "that of the block",
                momentum,
                stage.scales.impulse.x.into(),
                1e-4,
            );
            close("velocity [m/s]", momentum / 10.0, 1.0, 0.005);
            for _ in 0..21 {
                stage.step();
            }
            close("in the end [m/s]", stage.set[soft].linvel().x, 2.0, 0.01);
            // Of 20 J.
            stage.foresaw(1e-3);
        }
    }
}

/// Against a wall it presses a block with its force.
#[test]
fn a_motor_presses_with_its_force() {
    for mode in Mode::BOTH {
        let mut stage = Stage::new(mode, 0.0);
        let piston = stage.body(Vector::ZERO, [0.05, 0.3, 0.3], 5.0);
        let joint = PrismaticJointBuilder::new(Vector::X)
            .motor_velocity(0.5, 1e5)
            .motor_max_force(100.0);
        stage.join(piston, joint);
        let wall = RigidBodyBuilder::fixed().translation(Vector::X * 0.55);
        stage.world.insert(wall, cuboid([0.1, 0.5, 0.5], 1.0));
        stage.insert(10.0, 1e6, Vector::X * 0.25, Vector::ZERO);
        for _ in 0..120 {
            stage.step();
        }
        stage.scales.of = Some(stage.world.bodies[piston].colliders()[0]);
        close("force [N]", stage.force(30).x.into(), 100.0, 1e-4);
        stage.foresaw(1e-3);
    }
}

/// Two rollers with 2 N·m each turn under a block and drive it by friction: M·a = 2·(T − I·α)/r.
#[test]
fn rollers_drive_a_block() {
    for mode in Mode::BOTH {
        let mut stage = Stage::new(mode, G as f32);
        let r = 0.1;
        for x in [-0.12, 0.12] {
            let body = RigidBodyBuilder::dynamic()
                .translation(Vector::new(x, -r, 0.0))
                .rotation(Vector::X * std::f32::consts::FRAC_PI_2)
                .can_sleep(false);
            let roller = ColliderBuilder::cylinder(0.5, r).mass(4.0).friction(0.8);
            let (body, _) = stage.world.insert(body, roller);
            let mut joint: GenericJoint = RevoluteJointBuilder::new(Vector::Z)
                .local_anchor1(Vector::new(x, -r, 0.0))
                .motor_velocity(-100.0, 1e4)
                .motor_max_force(2.0)
                .into();
            joint.set_local_axis2(Vector::Y);
            stage.join(body, joint);
        }
        let block = block(10.0, 4e6).friction(0.8).translation(Vector::Y * 0.2);
        let soft = stage.set.insert(block).unwrap();
        for _ in 0..6 {
            stage.step();
        }
        // I = ½·m·r²: as heavy as half its mass at the rim.
        let a = 2.0 * 2.0 / 0.1 / (10.0 + 2.0 * 0.5 * 4.0);
        close("velocity [m/s]", stage.set[soft].linvel().x, a * 0.1, 0.005);
        stage.foresaw(1e-3);
    }
}

/// A plate on spring joints bears a block: it hangs down by the weight of both.
#[test]
fn spring_joints_bear_a_block() {
    for mode in Mode::BOTH {
        let mut stage = Stage::new(mode, G as f32);
        let plate = stage.body(Vector::ZERO, [0.3, 0.05, 0.3], 5.0);
        for (x, z) in [(0.25, 0.25), (0.25, -0.25), (-0.25, 0.25), (-0.25, -0.25)] {
            let spring = SpringJointBuilder::new(1.0, 1000.0, 40.0)
                .local_anchor1(Vector::new(x, 1.0, z))
                .local_anchor2(Vector::new(x, 0.0, z));
            stage.join(plate, spring);
        }
        stage.insert(10.0, 1e6, Vector::Y * 0.25, Vector::ZERO);
        for _ in 0..300 {
            stage.step();
        }
        let force = stage.force(60);
        let down = 15.0 * G / 4000.0;
        close("deflection [m]", -stage.height(plate), down, 0.002);
        close("weight [N]", force.y.into(), 10.0 * G, 0.002);
        stage.foresaw(0.02);
    }
}

/// A slider on a spring that a crumb of 1 g lies on swings as it does in Rapier alone with as short a step.
#[test]
fn what_is_hardly_touched_moves_as_in_rapier() {
    let run = |crumb: bool| {
        let mut stage = Stage::new(Mode::Shipped, G as f32);
        let plate = lift(&mut stage, 0.0, -0.005, MotorModel::ForceBased);
        if crumb {
            stage.insert(1e-3, 1e2, Vector::Y * 0.245, Vector::ZERO);
        } else {
            stage.world.integration_parameters.dt /= 4.0;
        }
        let heights = (0..60).map(|_| {
            for _ in 0..if crumb { 1 } else { 4 } {
                stage.step();
            }
            stage.height(plate)
        });
        heights.collect::<Vec<f64>>()
    };
    let off = run(true).into_iter().zip(run(false));
    let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // Of 7 mm to either side.
    assert!(off < 4e-4, "{off} m off");
}
