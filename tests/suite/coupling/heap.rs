//! Bodies that press on others or hang on them while deformables push them.

use super::{block, cuboid, floor};
use crate::support::weightless;
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario::survey::mechanical_energy;
use crumple::world::{Observer, Substep};

/// The deepest that any node has been.
struct Deepest(f64);

impl Observer for Deepest {
    fn substep(&mut self, s: &Substep<'_>) {
        let depths = s.contacts.iter().map(|c| c.depth);
        self.0 = depths.fold(self.0, f64::max);
    }
}

/// A heavy plate falls at 5 m/s on a light one, which rests on a block: the light one is stopped within one of Rapier's
/// steps, by a contact that was not there in the step before, and its shadow must know. Without that the block's nodes are
/// 18 mm deep in the plate. What the ledger misses is the trapezoid's error: a quarter of it at half the substep.
#[test]
fn a_blow_on_a_plate_that_lies_on_a_block() {
    let residual = |safety: f64| {
        let mut world = floor();
        let mut set = DeformableWorld::default();
        let substeps = Substeps::Auto {
            safety,
            min_h: 1.0e-7,
        };
        let soft = block(10.0, 2.0e5).substeps(substeps);
        let soft = set.insert(soft.translation(Vector::Y * 0.2)).unwrap();
        let plate = |y: f32| RigidBodyBuilder::dynamic().translation(Vector::Y * y);
        world.insert(plate(0.42), cuboid([0.25, 0.02, 0.25], 1.5));
        world.insert(
            plate(0.75).linvel(Vector::Y * -5.0),
            cuboid([0.2, 0.05, 0.2], 6.0),
        );
        let start = set[soft].energies();
        let mut deepest = Deepest(0.0);
        for _ in 0..30 {
            set.step_with(&mut world, &(), &(), &mut deepest);
        }
        assert!(deepest.0 < 1.0e-3, "{:.2} mm deep", 1.0e3 * deepest.0);
        let end = set[soft].energies();
        (end.balance() - start.balance()).abs() / end.scale()
    };
    let (whole, half) = (residual(0.9), residual(0.45));
    assert!(
        whole < 1.0e-3 && half < whole / 3.0,
        "{whole:.2e}, {half:.2e}"
    );
}

/// What a row does to a node counts for how far it may go in the next substep: a bead at rest that is struck by as light a
/// hammer does not pass a plate of 1 mm that stands 1.5 mm behind it.
#[test]
fn a_bead_struck_towards_a_plate_is_stopped_there() {
    let mut world = PhysicsWorld {
        gravity: Vector::ZERO,
        ..PhysicsWorld::default()
    };
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::X * 0.002),
        cuboid([0.0005, 0.2, 0.2], 1.0),
    );
    let hammer = RigidBodyBuilder::dynamic()
        .translation(Vector::X * -0.06)
        .linvel(Vector::X * 100.0);
    world.insert(hammer, cuboid([0.05, 0.05, 0.05], 1e-3));
    let mut set = DeformableWorld::default();
    let bead = Net::new(vec![Node::new(Vector::ZERO, 1e-3)], vec![]);
    let bead = DeformableBuilder::new(bead).substeps(Substeps::Fixed(640));
    let bead = set.insert(bead).unwrap();
    for _ in 0..30 {
        set.step(&mut world);
        let x = set[bead].position(NodeId(0)).unwrap().x;
        assert!(x < 0.002, "{x}");
    }
}

/// A damped block that starts 1 cm deep in a floor is moved out of it while its springs and dampers work: all is booked.
#[test]
fn being_moved_out_is_booked_to_the_joule() {
    let mut world = floor();
    let mut set = DeformableWorld::default();
    let viscous = Material::elastic(2.0e5, 150.0).viscosity(4.0e3);
    let builder = block(10.0, 2.0e5).material(viscous);
    let soft = set.insert(builder.translation(Vector::Y * 0.19)).unwrap();
    let start = set[soft].energies().balance();
    for _ in 0..60 {
        set.step(&mut world);
    }
    let end = set[soft].energies();
    assert!(end.work.push_out > 0.1, "{:?}", end.work);
    let residual = (end.balance() - start).abs() / end.scale();
    assert!(residual < 1.0e-4, "{residual:.2e} of {:?}", end.work);
}

/// A light ball on the ground at the end of a lever of .8 m that a block swings: at that lever a few degrees are
/// centimetres, and Rapier must turn the ball when its shadow turns.
#[test]
fn a_block_drags_a_ball_by_a_long_lever() {
    for joined in [false, true] {
        let mut world = floor();
        let mut set = DeformableWorld::default();
        let ball = |x: f32| {
            RigidBodyBuilder::dynamic()
                .translation(Vector::new(x, 0.12, 0.0))
                .linvel(Vector::new(0.5, 0.0, 1.0))
        };
        let shape = || ColliderBuilder::ball(0.12).density(300.0).friction(0.6);
        let (first, _) = world.insert(ball(0.8), shape());
        let (second, _) = world.insert(ball(1.3), shape());
        if joined {
            let joint = SphericalJointBuilder::new()
                .local_anchor1(Vector::X * 0.25)
                .local_anchor2(Vector::X * -0.25);
            world.impulse_joints.insert(first, second, joint, true);
        }
        let soft = block(8.0, 3.0e5).translation(Vector::Y * 0.5);
        let soft = set
            .insert(soft.linvel(Vector::new(0.0, -1.0, 1.5)))
            .unwrap();
        let corner = Attachment::pin([NodeId(0)]);
        set.attach(soft, corner, AttachTo::Body(first), &world.bodies)
            .unwrap();
        let start = mechanical_energy(&world, &set);
        let mut least = start;
        for step in 0..300 {
            set.step(&mut world);
            let now = mechanical_energy(&world, &set);
            assert!(
                now < least + 0.01 * start.abs(),
                "joined {joined}, step {step}: {now} J after {least} J"
            );
            least = least.min(now);
        }
    }
}

/// A wheel that rolls keeps its height while something hangs on its axle: the point it stands on is below its hub, not the
/// one that was there at the start of the step.
#[test]
fn a_rolling_wheel_does_not_sink_under_its_load() {
    let mut world = floor();
    let mut set = DeformableWorld::default();
    let (radius, speed) = (0.3_f32, 6.0_f32);
    let rolling = RigidBodyBuilder::dynamic()
        .translation(Vector::Y * radius)
        .linvel(Vector::X * speed)
        .angvel(Vector::Z * (-speed / radius));
    let (wheel, _) = world.insert(rolling, ColliderBuilder::ball(radius).mass(5.0));
    let load = DeformableBuilder::new(Net::new(vec![Node::new(Vector::ZERO, 5.0)], vec![]));
    let load = load
        .translation(Vector::Y * radius)
        .linvel(Vector::X * speed);
    let load = set.insert(load.collision_groups(InteractionGroups::none()));
    let load = load.unwrap();
    let hub = Attachment::pin([NodeId(0)]);
    set.attach(load, hub, AttachTo::Body(wheel), &world.bodies)
        .unwrap();
    for _ in 0..60 {
        set.step(&mut world);
        let v = set[load].linvel();
        assert!(v.y.abs() < 0.02, "the load moves at {v} m/s");
    }
    assert!((set[load].linvel().x - f64::from(speed)).abs() < 0.06);
}

/// Two bodies on a hinge, of which a block hits one: they share the blow as Rapier's joint says, and the block loses no
/// momentum to the coupling.
#[test]
fn a_hinged_pair_takes_a_blow_beside_its_hinge() {
    let mut world = weightless(1.0 / 60.0);
    let body = |x: f32| RigidBodyBuilder::dynamic().translation(Vector::new(x, 0.0, 0.0));
    let (near, _) = world.insert(body(0.6), cuboid([0.15, 0.2, 0.2], 2.0));
    let (far, _) = world.insert(body(1.1), cuboid([0.15, 0.2, 0.2], 12.0));
    let hinge = RevoluteJointBuilder::new(Vector::Z)
        .local_anchor1(Vector::X * 0.25)
        .local_anchor2(Vector::X * -0.25);
    world.impulse_joints.insert(near, far, hinge, true);
    let mut set = DeformableWorld::default();
    let soft = block(6.0, 5.0e5).linvel(Vector::new(8.0, 3.0, 0.0));
    let soft = set.insert(soft.translation(Vector::Y * 0.1)).unwrap();
    let start = mechanical_energy(&world, &set);
    let momentum = set[soft].momentum();
    for _ in 0..30 {
        set.step(&mut world);
        assert!(mechanical_energy(&world, &set) < 1.002 * start);
    }
    let rigid = [near, far].map(|h| {
        let body = &world.bodies[h];
        (body.linvel() * body.mass()).as_dvec3()
    });
    let sum = set[soft].momentum() + rigid[0] + rigid[1];
    let lost = (sum - momentum).length() / momentum.length();
    assert!(lost < 1.0e-5, "{lost:.1e} of the momentum is lost");
}
