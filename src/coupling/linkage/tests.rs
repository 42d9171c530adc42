//! Against Rapier itself.

use super::*;
use crate::math::narrow;
use rapier3d::dynamics::*;
use rapier3d::geometry::ColliderBuilder;
use rapier3d::pipeline::PhysicsWorld;

/// Two boxes of 2 kg and 0.5 kg that tumble about a joint, under gravity.
fn joined(joint: impl Into<GenericJoint>) -> (PhysicsWorld, RigidBodyHandle) {
    let mut world = PhysicsWorld::default();
    // Rapier's solver is iterative; it shall be near its limit here.
    world.integration_parameters.num_solver_iterations = 32;
    world.integration_parameters.dt = 1.0 / 960.0;
    let [one, two] = [(0.0, 2.0), (0.5, 0.5)].map(|(x, mass)| {
        let body = RigidBodyBuilder::dynamic().translation(Vector::X * x);
        let shape = ColliderBuilder::cuboid(0.2, 0.05, 0.1);
        world.insert(body, shape.mass(mass)).0
    });
    let mut joint = joint.into();
    joint.set_local_anchor1(Vector::new(0.25, 0.1, 0.0));
    joint.set_local_anchor2(Vector::new(-0.25, 0.1, 0.0));
    world.impulse_joints.insert(one, two, joint, true);
    world.bodies[one].apply_torque_impulse(Vector::new(0.02, 0.05, -0.03), true);
    world.bodies[two].apply_impulse(Vector::new(0.1, 0.2, -0.3), true);
    for _ in 0..200 {
        world.step();
    }
    (world, two)
}

/// What is computed is what Rapier does, whatever the joint: to 1 % of what a free body would do.
#[test]
fn joints_answer_as_rapier_says() {
    let joints: [GenericJoint; 4] = [
        SphericalJointBuilder::new().build().into(),
        RevoluteJointBuilder::new(Vector::Z).build().into(),
        PrismaticJointBuilder::new(Vector::X).build().into(),
        FixedJointBuilder::new().build().into(),
    ];
    for joint in joints {
        let (mut world, body) = joined(joint);
        let around = Surroundings::from(&world);
        let dt = f64::from(world.integration_parameters.dt);
        let mobility = mobility(body, &around, dt);
        let (j, l) = (DVec3::new(0.3, -0.5, 0.2), DVec3::new(-0.03, 0.02, 0.05));
        let (dv, dw) = mobility.answer(j, l, dt);
        let rigid = &mut world.bodies[body];
        let free = Mobility::free(rigid, world.gravity);
        let (free_v, free_w) = free.answer(j, l, dt);
        let (v, w) = (wide(rigid.linvel()), wide(rigid.angvel()));
        rigid.apply_impulse(narrow(j), true);
        rigid.apply_torque_impulse(narrow(l), true);
        world.step();
        let rigid = &world.bodies[body];
        let (got_v, got_w) = (wide(rigid.linvel()) - v, wide(rigid.angvel()) - w);
        let off = (got_v - dv).length() / free_v.length();
        let turned = (got_w - dw).length() / free_w.length();
        let locked = joint.locked_axes;
        assert!(off < 0.01 && turned < 0.01, "{locked:?}: {off} {turned}");
        // The joint matters.
        assert!((free_v - dv).length() > 0.1 * free_v.length(), "{locked:?}");
    }
}

/// A box pressed on a floor gives way nowhere but upward is held as well: contacts count as joints while they press.
#[test]
fn a_contact_that_presses_holds() {
    let (mut world, body) = joined(SphericalJointBuilder::new().build());
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::Y * -3.0),
        ColliderBuilder::cuboid(9.0, 1.0, 9.0),
    );
    for _ in 0..3000 {
        world.step();
    }
    let around = Surroundings::from(&world);
    let mobility = mobility(body, &around, 1.0 / 240.0);
    let fall = mobility.acceleration.length();
    assert!(fall < 0.05 * 9.81, "falls at {fall} m/s²");
    let free = Mobility::free(&world.bodies[body], world.gravity);
    let down = |m: &Mobility| m.inv_mass.y_axis.y;
    assert!(down(&mobility) < 0.05 * down(&free));
}
