//! Attachments.

use crate::support::close;
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Two damped springs under two pinned nodes; a body of 2 kg hangs on the lower nodes.
fn hanging() -> (
    PhysicsWorld,
    DeformableWorld,
    DeformableHandle,
    AttachmentHandle,
    RigidBodyHandle,
) {
    let mut world = PhysicsWorld::default();
    let (rigid, _) = world.insert(
        RigidBodyBuilder::dynamic()
            .translation(Vector::new(0.0, -1.3, 0.0))
            .can_sleep(false),
        ColliderBuilder::cuboid(0.2, 0.1, 0.1).mass(2.0),
    );
    let at = |x: f32, y: f32| Vector::new(x, y, 0.0);
    let net = Net::new(
        vec![
            Node::new(at(-0.2, 0.0), 0.1).pinned(),
            Node::new(at(0.2, 0.0), 0.1).pinned(),
            Node::new(at(-0.2, -1.0), 0.1),
            Node::new(at(0.2, -1.0), 0.1),
        ],
        vec![
            Spring::new(0, 2, 2000.0).damping(10.0),
            Spring::new(1, 3, 2000.0).damping(10.0),
        ],
    );
    let mut set = DeformableWorld::new();
    let soft = set.insert(DeformableBuilder::new(net)).unwrap();
    let held = set
        .attach(soft, &[NodeId(2), NodeId(3)], rigid, &world.bodies)
        .unwrap();
    (world, set, soft, held, rigid)
}

#[test]
fn a_hanging_body_pulls_with_its_weight() {
    let (mut world, mut set, soft, held, rigid) = hanging();
    assert_eq!(set.attachment_force(held).unwrap().0.length(), 0.0);
    for _ in 0..240 {
        set.step(&mut world);
    }
    let (force, torque) = set.attachment_force(held).unwrap();
    close("force on the body [N]", force.y, 2.0 * 9.81, 0.01);
    assert!(force.x.abs() + force.z.abs() < 0.1, "{force}");
    assert!(torque.length() < 0.02, "{torque}");
    let tension = set[soft].tension(SpringId(0)).unwrap();
    close("tension of each spring [N]", tension, 1.1 * 9.81, 0.01);
    let y = f64::from(world.bodies[rigid].translation().y);
    close("height [m]", y, -1.3 - 1.1 * 9.81 / 2000.0, 1e-3);
    // It does not move. Its velocity reads half a substep less half a solver iteration of gravity, which is the instant at
    // which Rapier's own integration keeps velocities.
    set.step(&mut world);
    let moved = f64::from(world.bodies[rigid].translation().y) - y;
    assert!(moved.abs() < 1e-5, "moved by {moved} m in a step");
    let [h, iteration] = [set[soft].substep_length(), 1.0 / 240.0 / 4.0];
    let reading = -f64::from(world.bodies[rigid].linvel().y);
    assert!(
        (reading - 0.5 * 9.81 * (h - iteration)).abs() < 1e-3,
        "{reading} m/s"
    );
}

#[test]
fn what_is_let_go_falls() {
    let (mut world, mut set, _, held, rigid) = hanging();
    for _ in 0..120 {
        set.step(&mut world);
    }
    let before = world.bodies[rigid].linvel().y;
    assert!(set.detach(held));
    set.step(&mut world);
    let gained = f64::from(world.bodies[rigid].linvel().y - before);
    close("velocity gained [m/s]", gained, -9.81 / 60.0, 1e-3);
    assert_eq!(set.attachment_force(held), None);
    assert!(!set.detach(held));
}

#[test]
fn a_removed_rigid_body_drops_its_attachment() {
    let (mut world, mut set, soft, held, rigid) = hanging();
    for _ in 0..60 {
        set.step(&mut world);
    }
    world.remove_body(rigid);
    for _ in 0..120 {
        set.step(&mut world);
    }
    assert_eq!(set.attachment_force(held), None);
    let tension = set[soft].tension(SpringId(0)).unwrap();
    close("tension of a spring alone [N]", tension, 0.1 * 9.81, 0.01);
}

#[test]
fn a_removed_or_disabled_deformable_lets_go() {
    for remove in [true, false] {
        let (mut world, mut set, soft, held, rigid) = hanging();
        for _ in 0..120 {
            set.step(&mut world);
        }
        let before = world.bodies[rigid].linvel().y;
        if remove {
            set.remove(soft);
        } else {
            set[soft].set_enabled(false);
        }
        set.step(&mut world);
        let gained = f64::from(world.bodies[rigid].linvel().y - before);
        close("velocity gained [m/s]", gained, -9.81 / 60.0, 1e-3);
        let force = set.attachment_force(held).map(|(f, _)| f.length());
        assert_eq!(force, if remove { None } else { Some(0.0) });
    }
}

/// Attached to a kinematic body, the nodes go where it goes.
#[test]
fn a_kinematic_body_leads_nodes() {
    let mut world = PhysicsWorld::default();
    let hand = world.insert_body(RigidBodyBuilder::kinematic_position_based());
    let mut set = DeformableWorld::new();
    let soft = set.insert(crate::fixtures::cube(0.3)).unwrap();
    let held = set.attach(soft, &[NodeId(0)], hand, &world.bodies).unwrap();
    let start = set[soft].position(NodeId(0)).unwrap();
    for i in 1..=60 {
        let to = Vector::new(0.01 * i as f32, 0.0, 0.0);
        world.bodies[hand].set_next_kinematic_translation(to);
        set.step(&mut world);
        let error = set[soft].position(NodeId(0)).unwrap() - start - to.as_dvec3();
        assert!(error.length() < 2e-3, "step {i}: {error}");
    }
    assert!(set.attachment_force(held).unwrap().0.y < 0.0);
}
