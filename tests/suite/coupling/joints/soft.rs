//! Soft joints: locked axes that give way.

use super::{G, Stage};
use crate::coupling::Mode;
use crate::support::close;
use crumple::prelude::*;
use crumple::rapier3d::dynamics::SpringCoefficients;
use crumple::rapier3d::prelude::*;
use crumple::scenario::survey::mechanical_energy;

/// The frequency at which Rapier's joints are hard \[Hz\].
const HARD: f32 = 1e6;

fn soft(joint: impl Into<GenericJoint>, frequency: f32, ratio: f32) -> GenericJoint {
    let mut joint = joint.into();
    joint.softness = SpringCoefficients::new(frequency, ratio);
    joint
}

/// A body of 2 kg at `at`, and a stiff block of 8 kg welded below it.
fn load(stage: &mut Stage, at: Vector) -> (RigidBodyHandle, DeformableHandle, AttachmentHandle) {
    let link = stage.body(at, [0.1, 0.1, 0.1], 2.0);
    let block = DeformableBuilder::new(lattice(Vector::splat(0.3), 0.1))
        .material(Material::elastic(2e6, 300.0).viscosity(2e3))
        .total_mass(8.0)
        .translation(at - Vector::Y * 0.25)
        .collision_groups(InteractionGroups::none())
        .can_sleep(false);
    let block = stage.set.insert(block).unwrap();
    let nodes = (0..).zip(stage.set[block].positions());
    let top = nodes.filter(|(_, p)| p.y > at.y - 0.101);
    let top: Vec<NodeId> = top.map(|(i, _)| NodeId(i)).collect();
    let bodies = &stage.world.bodies;
    let weld = stage.set.attach(block, Attachment::weld(top), link, bodies);
    (link, block, weld.unwrap())
}

fn energy(stage: &Stage) -> f64 {
    mechanical_energy(&stage.world, &stage.set)
}

/// What came of a swing.
struct Swing {
    /// How much energy it had at most beyond that of its start \[J\].
    gain: f64,
    /// What its block has turned into heat \[J\].
    heat: f64,
    defect: f64,
    /// When it had turned by a quarter \[s\].
    quarters: Vec<f64>,
}

/// 2 s of a block on a link on a soft hinge at `hinge` from its middle, in a gravity along `down`.
fn swing(frequency: f32, hinge: Vector, down: Vector) -> Swing {
    let mut stage = Stage::new(Mode::Shipped, 0.0);
    stage.world.gravity = down * G as f32;
    let (link, block, _) = load(&mut stage, -hinge);
    let joint = RevoluteJointBuilder::new(Vector::Z).local_anchor2(hinge);
    stage.join(link, soft(joint, frequency, 1.0));
    let (start, mut gain) = (energy(&stage), f64::MIN);
    let (mut last, mut quarters) = (1.0, Vec::new());
    for i in 1..=120 {
        stage.step();
        gain = gain.max(energy(&stage) - start);
        let rotation = stage.world.bodies[link].rotation();
        let now = f64::from((*rotation * Vector::Y).y);
        if last * now < 0.0 {
            quarters.push((f64::from(i) - now / (now - last)) / 60.0);
        }
        last = now;
    }
    Swing {
        gain,
        heat: stage.set[block].energies().dissipated(),
        defect: stage.defect,
        quarters,
    }
}

/// One of 20 J about the middle of the link, where the joint is as stiff along all ways: it goes as on a hard hinge.
#[test]
fn a_swing_on_a_soft_hinge_goes_as_on_a_hard_one() {
    let hard = swing(HARD, Vector::ZERO, Vector::X);
    for frequency in [20.0, 60.0, 300.0] {
        let soft = swing(frequency, Vector::ZERO, Vector::X);
        let what = format!("{frequency} Hz");
        assert!(soft.gain < 0.2, "{what}: {} J more", soft.gain);
        assert!(soft.heat < 0.05, "{what}: {} J of heat", soft.heat);
        assert!(soft.defect < 0.2, "{what}: a defect of {} J", soft.defect);
        assert!(hard.quarters.len() > 1 && soft.quarters.len() == hard.quarters.len());
        for (soft, hard) in soft.quarters.iter().zip(&hard.quarters) {
            close(&what, *soft, *hard, 0.05);
        }
    }
}

/// One of 25 J on a lever of 0.5 m, which Rapier's soft joints drive by themselves: of their own stiffness along the lever and across it.
/// Its block was driven as well, and made 24 kJ of heat at 20 Hz, 2.5 kJ at 60, 76 J at 300.
#[test]
fn what_swings_on_a_soft_hinge_is_led_as_rapier_leads_it() {
    for (frequency, defect) in [(20.0, 1.5), (60.0, 0.4), (300.0, 0.2)] {
        let soft = swing(frequency, Vector::X * -0.5, Vector::Y * -1.0);
        assert!(soft.heat < 0.05, "{frequency} Hz: {} J", soft.heat);
        assert!(soft.defect < defect, "{frequency} Hz: {} J", soft.defect);
    }
}

/// A bracket in a soft joint sags under a block as under a force in Rapier alone, with as short a step, and bears its weight.
#[test]
fn a_soft_bracket_sags_as_in_rapier() {
    for (frequency, ratio, relaxes) in [
        (20.0, 1.0, 1),
        (20.0, 0.2, 1),
        (60.0, 1.0, 1),
        (300.0, 1.0, 1),
        (5.0, 1.0, 0),
    ] {
        let what = format!("{frequency} Hz, {ratio}, {relaxes}");
        let joint = soft(FixedJointBuilder::new(), frequency, ratio);
        let mut stage = Stage::new(Mode::Shipped, G as f32);
        let parameters = &mut stage.world.integration_parameters;
        parameters.num_internal_stabilization_iterations = relaxes;
        let (link, _, weld) = load(&mut stage, Vector::ZERO);
        stage.join(link, joint);
        for _ in 0..240 {
            stage.step();
        }
        // Of 78 N on a way of up to 0.2 m.
        stage.foresaw(0.01);
        stage.defect = 0.0;
        for _ in 0..60 {
            stage.step();
        }
        stage.foresaw(1e-4);
        let weight = -stage.set.attachment_force(weld).unwrap().0.y;
        close(&what, weight, 8.0 * G, 1e-3);
        let steps = stage.set.report().rigid_steps;
        let mut alone = Stage::new(Mode::Shipped, G as f32);
        let parameters = &mut alone.world.integration_parameters;
        parameters.num_internal_stabilization_iterations = relaxes;
        parameters.dt /= steps as f32;
        let bracket = alone.body(Vector::ZERO, [0.1, 0.1, 0.1], 2.0);
        alone.join(bracket, joint);
        let force = Vector::Y * (-8.0 * G) as f32;
        alone.world.bodies[bracket].add_force(force, true);
        for _ in 0..300 * steps {
            alone.world.step();
        }
        close(&what, stage.height(link), alone.height(bracket), 1e-4);
    }
}

/// A bar of 3 kg on a soft ball joint at a body with a block: both go on with the momentum that they have, and no more energy.
#[test]
fn a_soft_ball_joint_keeps_momentum() {
    for frequency in [20.0, 60.0, 300.0] {
        let mut stage = Stage::new(Mode::Shipped, 0.0);
        let (link, block, _) = load(&mut stage, Vector::ZERO);
        let bar = stage.body(Vector::X, [0.2, 0.1, 0.1], 3.0);
        let joint = SphericalJointBuilder::new()
            .local_anchor1(Vector::X * 0.5)
            .local_anchor2(Vector::X * -0.5);
        let joint = soft(joint, frequency, 1.0);
        stage.world.insert_impulse_joint(link, bar, joint);
        stage.world.bodies[bar].set_linvel(Vector::new(0.0, 3.0, 0.5), true);
        let momentum = |stage: &Stage| {
            let rigid = [link, bar].map(|b| &stage.world.bodies[b]);
            let rigid = rigid.map(|b| (b.linvel() * b.mass()).as_dvec3());
            rigid[0] + rigid[1] + stage.set[block].momentum()
        };
        let (start, held) = (momentum(&stage), energy(&stage));
        for i in 0..120 {
            stage.step();
            let now = energy(&stage);
            assert!(now < 1.01 * held, "{frequency} Hz: {now} J in {i}");
        }
        let off = (momentum(&stage) - start).length();
        assert!(off < 1e-4 * start.length(), "{frequency} Hz: {off} N·s");
        stage.foresaw(0.01 * held);
    }
}
