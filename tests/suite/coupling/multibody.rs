//! Links of multibodies. Rapier takes their velocities from joint coordinates, so impulses are lost on them and they get forces alone;
//! shadows keep their joints as they keep others.

use crate::support::close;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// How a body hangs on another.
#[derive(Clone, Copy, Debug, PartialEq)]
enum By {
    Multibody,
    Joint,
}

impl By {
    /// Joins two bodies; a multibody gets no damping of its own.
    fn join(
        self,
        world: &mut PhysicsWorld,
        bodies: [RigidBodyHandle; 2],
        joint: impl Into<GenericJoint>,
    ) {
        if self == Self::Joint {
            world.insert_impulse_joint(bodies[0], bodies[1], joint);
            return;
        }
        let joint = world.insert_multibody_joint(bodies[0], bodies[1], joint);
        let (multibody, _) = world.multibody_joints.get_mut(joint.unwrap()).unwrap();
        multibody.damping_mut().fill(0.0);
    }
}

/// Nodes of a body that lie within a ball \[m\].
fn near(body: &Deformable, at: Vector, within: f32) -> Vec<NodeId> {
    let nodes = (0..body.node_count() as u32).map(NodeId);
    let is_near = |n: &NodeId| (body.position(*n).unwrap().as_vec3() - at).length() < within;
    nodes.filter(is_near).collect()
}

/// A link of 2 kg and 0.4 m with a block of 8 kg welded below it, in a gravity that pulls 0.8 rad beside it: the way of its
/// middle \[m\], and what the block has turned into heat \[J\]. A multibody starts with its coordinates at zero.
fn swing(by: By) -> (Vec<f32>, f64) {
    let (sin, cos) = 0.8_f32.sin_cos();
    let mut world = PhysicsWorld {
        gravity: 9.81 * Vector::new(sin, -cos, 0.0),
        ..PhysicsWorld::default()
    };
    let top = world.insert_body(RigidBodyBuilder::fixed());
    let link = RigidBodyBuilder::dynamic()
        .translation(Vector::Y * -0.2)
        .can_sleep(false);
    let collider = ColliderBuilder::cuboid(0.02, 0.2, 0.02)
        .density(0.0)
        .mass(2.0);
    let (link, _) = world.insert(link, collider);
    let hinge = RevoluteJointBuilder::new(Vector::Z).local_anchor2(Vector::Y * 0.2);
    by.join(&mut world, [top, link], hinge);
    let mut set = DeformableWorld::default();
    let block = DeformableBuilder::new(lattice(Vector::splat(0.2), 0.1))
        .material(Material::elastic(2e6, 1e3).viscosity(2e3))
        .total_mass(8.0)
        .translation(Vector::Y * -0.5)
        .collision_groups(InteractionGroups::none());
    let block = set.insert(block).unwrap();
    let nodes = near(&set[block], Vector::Y * -0.4, 0.15);
    let weld = Attachment::weld(nodes);
    set.attach(block, weld, link, &world.bodies).unwrap();
    let mut way = Vec::new();
    for _ in 0..120 {
        set.step(&mut world);
        way.push(world.bodies[link].translation().x);
    }
    (way, set[block].energies().dissipated())
}

/// It exploded: one of 25 J took up 466 J.
#[test]
fn a_block_swings_on_a_link_as_on_a_joint() {
    let (reference, _) = swing(By::Joint);
    let (way, heat) = swing(By::Multibody);
    for (i, (way, reference)) in way.iter().zip(&reference).enumerate() {
        assert!(
            (way - reference).abs() < 5e-3,
            "{way} m, {reference} m in {i}"
        );
    }
    println!("{heat} J of heat");
    assert!(heat < 0.01, "{heat} J");
}

/// A block of 2.4 kg and 2 MPa lies under a plate on a prismatic joint, pressed by a force. It was hammered, with 40 to 88 N of 69.8 by a
/// plate of 1 kg, and 134 J were moved out of one of 0.2 kg in 3 s.
#[test]
fn a_pressed_link_rests_on_a_soft_block() {
    for (mass, push) in [(1.0, 60.0), (0.2, 60.0), (1.0, 300.0)] {
        let what = format!("{mass} kg, {push} N");
        let mut world = super::floor();
        let top = world.insert_body(RigidBodyBuilder::fixed());
        let plate = ColliderBuilder::cuboid(0.15, 0.02, 0.15)
            .density(0.0)
            .mass(mass);
        let body = RigidBodyBuilder::dynamic().translation(Vector::Y * 0.221);
        let (body, collider) = world.insert(body.can_sleep(false), plate);
        let slide = PrismaticJointBuilder::new(Vector::Y).local_anchor1(Vector::Y * 0.221);
        By::Multibody.join(&mut world, [top, body], slide);
        world.bodies[body].add_force(Vector::Y * -push, true);
        let soft = DeformableBuilder::new(lattice(Vector::splat(0.2), 0.05))
            .material(Material::elastic(2e6, 300.0).viscosity(2e3))
            .translation(Vector::Y * 0.1005)
            .can_sleep(false);
        let mut set = DeformableWorld::default();
        let soft = set.insert(soft).unwrap();
        let expected = push + mass * 9.81;
        for i in 0..120 {
            set.step(&mut world);
            let force = set.contact_force(soft, collider).unwrap_or_default().y;
            if i >= 60 {
                close(&what, -force, f64::from(expected), 2e-3);
            }
        }
        let moved_out = set[soft].energies().work.push_out;
        assert!(moved_out.abs() < 1.5, "{what}: {moved_out} J");
    }
}

/// An arm of two links that motors hold level, with a block welded to it: at rest it was heated by 2.3 and by 716 W. Links feel
/// the springs behind their nodes as one force over a step of Rapier's, and these swing many times in it.
#[test]
fn an_arm_that_motors_hold_stays_cold() {
    for (young, mass) in [(2e6, 1.27), (1e7, 0.5)] {
        let mut world = PhysicsWorld {
            gravity: Vector::X * -9.81,
            ..PhysicsWorld::default()
        };
        let mut before = world.insert_body(RigidBodyBuilder::fixed());
        for i in 0..2 {
            let link = RigidBodyBuilder::dynamic()
                .translation(Vector::Y * (-0.4 * (i as f32 + 0.5)))
                .can_sleep(false);
            let collider = ColliderBuilder::cuboid(0.03, 0.19, 0.03).mass(mass);
            let none = InteractionGroups::none();
            let (link, _) = world.insert(link, collider.collision_groups(none));
            let above = if i == 0 { 0.0 } else { -0.2 };
            let hinge = RevoluteJointBuilder::new(Vector::Z)
                .local_anchor1(Vector::Y * above)
                .local_anchor2(Vector::Y * 0.2)
                .motor_position(0.0, 3e3, 300.0)
                .motor_model(MotorModel::ForceBased);
            world.insert_multibody_joint(before, link, hinge);
            before = link;
        }
        let mut set = DeformableWorld::default();
        let block = DeformableBuilder::new(lattice(Vector::splat(0.19), 0.095))
            .material(Material::elastic(young, 500.0).viscosity(1e-3 * young))
            .translation(Vector::Y * -0.895)
            .can_sleep(false);
        let block = set.insert(block).unwrap();
        let nodes = (0..set[block].node_count() as u32).map(NodeId);
        let high = |n: &NodeId| set[block].position(*n).unwrap().y > -0.801;
        let nodes: Vec<NodeId> = nodes.filter(high).collect();
        assert_eq!(nodes.len(), 9);
        set.attach(block, Attachment::weld(nodes), before, &world.bodies)
            .unwrap();
        (0..120).for_each(|_| set.step(&mut world));
        let given = set[block].energies().work.rigid;
        (0..60).for_each(|_| set.step(&mut world));
        let more = set[block].energies().work.rigid - given;
        println!("{young} Pa on {mass} kg: {more:.4} J in a second");
        assert!(
            more.abs() < 0.1,
            "{young} Pa on {mass} kg: {more} J in a second"
        );
    }
}
