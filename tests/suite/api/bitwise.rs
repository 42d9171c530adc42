//! What deformables don't touch moves bit for bit as in Rapier alone.

use crate::fixtures::{bits, cube, floored};
use crate::support::Random;
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Twenty bodies of five shapes, some jointed, fall into a heap; far off a floor and a kinematic paddle.
fn pile() -> PhysicsWorld {
    let mut world = PhysicsWorld::default();
    let ground = RigidBodyBuilder::fixed().translation(Vector::Y * -0.5);
    world.insert(ground, ColliderBuilder::cuboid(10.0, 0.5, 10.0));
    let mut last = None;
    for i in 0..20 {
        let (x, z) = ((i % 3) as f32 * 0.35 - 0.3, (i % 2) as f32 * 0.3);
        let collider = match i % 5 {
            0 => ColliderBuilder::cuboid(0.2, 0.1, 0.15),
            1 => ColliderBuilder::ball(0.15),
            2 => ColliderBuilder::capsule_y(0.1, 0.1),
            3 => ColliderBuilder::cylinder(0.1, 0.15),
            _ => ColliderBuilder::cone(0.15, 0.15),
        };
        let at = RigidBodyBuilder::dynamic()
            .translation(Vector::new(x, 0.3 + 0.35 * i as f32, z))
            .angvel(Vector::new(0.1 * i as f32, 0.5, -0.3));
        let (body, _) = world.insert(at, collider.friction(0.6).restitution(0.2));
        if let Some(last) = last.filter(|_| i % 4 == 1) {
            world.insert_impulse_joint(last, body, joint(i / 4));
        }
        last = Some(body);
    }
    let ground = RigidBodyBuilder::fixed().translation(Vector::new(60.0, -0.5, 0.0));
    world.insert(ground, ColliderBuilder::cuboid(10.0, 0.5, 10.0));
    let paddle = RigidBodyBuilder::kinematic_velocity_based()
        .translation(Vector::new(59.0, 0.3, 0.0))
        .linvel(Vector::X * 0.5);
    world.insert(paddle, ColliderBuilder::cuboid(0.1, 0.3, 0.3));
    world
}

/// Of another kind each time: with and without limits, motors and springs.
fn joint(kind: usize) -> GenericJoint {
    let mut joint: GenericJoint = match kind {
        0 => SphericalJointBuilder::new().into(),
        1 => RevoluteJointBuilder::new(Vector::Z)
            .limits([-0.5, 0.5])
            .into(),
        2 => RevoluteJointBuilder::new(Vector::X)
            .motor_velocity(3.0, 1.0)
            .into(),
        3 => RopeJointBuilder::new(0.3).into(),
        _ => SpringJointBuilder::new(0.2, 100.0, 1.0).into(),
    };
    joint.set_local_anchor1(Vector::new(0.0, 0.2, 0.0));
    joint.set_local_anchor2(Vector::new(0.0, -0.2, 0.0));
    joint
}

#[test]
fn without_dynamic_contact_rapier_is_alone() {
    let (mut plain, mut empty, mut beside) = (pile(), pile(), pile());
    let mut none = DeformableWorld::new();
    let mut set = DeformableWorld::new();
    let soft = set
        .insert(cube(0.3).translation(Vector::new(59.5, 0.2, 0.0)))
        .unwrap();
    for step in 0..600 {
        plain.step();
        none.step(&mut empty);
        set.step(&mut beside);
        assert_eq!(bits(&empty), bits(&plain), "no deformable, step {step}");
        assert_eq!(
            bits(&beside),
            bits(&plain),
            "beside fixed and kinematic bodies, step {step}"
        );
    }
    let x = set[soft].center_of_mass().x;
    assert!(
        x > 60.0,
        "the paddle must have pushed the cube, which is at {x} m"
    );
}

/// Rapier's own soft bodies and deformables pass through each other, bit for bit as if alone.
#[test]
fn rapiers_soft_bodies_are_left_alone() {
    let scene = |jelly: bool, soft: bool| {
        let mut world = PhysicsWorld::default();
        let ground = RigidBodyBuilder::fixed().translation(Vector::Y * -0.5);
        world.insert(ground, ColliderBuilder::cuboid(10.0, 0.5, 10.0));
        let handle = jelly.then(|| {
            let center = Vector::new(0.0, 0.6, 0.0);
            let half = Vector::splat(0.2);
            world.insert_soft_body(SoftBodyBuilder::cuboid(center, half, 3, 3, 3))
        });
        let mut set = DeformableWorld::new();
        if soft {
            let at = Vector::new(0.05, 0.9, 0.0);
            set.insert(cube(0.3).translation(at)).unwrap();
        }
        let mut trace = Vec::new();
        for _ in 0..60 {
            set.step(&mut world);
            if let Some(handle) = handle {
                let positions = world.soft_bodies[handle].particle_positions();
                trace.extend(positions.map(|p| p.to_array().map(f32::to_bits)));
            }
        }
        (trace, set.state_hash())
    };
    let both = scene(true, true);
    assert_eq!(both.0.len(), 60 * 27);
    assert_ne!(both.0[0], both.0[59 * 27], "the soft body must move");
    assert_eq!(both.0, scene(true, false).0);
    assert_eq!(both.1, scene(false, true).1);
}

/// Ten boxes, and far away a cube that falls on a dynamic box and makes Rapier take four steps a frame for a while. How
/// far any of the ten went, and the counts of Rapier's steps.
fn stack(sleeps: bool) -> (f32, Vec<usize>) {
    let mut world = PhysicsWorld::default();
    let ground = RigidBodyBuilder::fixed().translation(Vector::Y * -0.5);
    world.insert(ground, ColliderBuilder::cuboid(50.0, 0.5, 10.0));
    let mut insert = |at, sleeps| {
        let body = RigidBodyBuilder::dynamic()
            .translation(at)
            .can_sleep(sleeps);
        world
            .insert(body, ColliderBuilder::cuboid(0.25, 0.25, 0.25))
            .0
    };
    let boxes: Vec<_> = (0..10)
        .map(|i| insert(Vector::Y * (0.25 + 0.5 * i as f32), sleeps))
        .collect();
    insert(Vector::new(30.0, 0.25, 0.0), false);
    let mut set = DeformableWorld::new();
    for _ in 0..600 {
        set.step(&mut world);
    }
    let places = |world: &PhysicsWorld| -> Vec<Vector> {
        boxes
            .iter()
            .map(|&b| world.bodies[b].translation())
            .collect()
    };
    let before = places(&world);
    set.insert(cube(0.3).translation(Vector::new(30.0, 1.2, 0.0)))
        .unwrap();
    let (mut counts, mut most) = (Vec::new(), 0.0_f32);
    for _ in 0..180 {
        set.step(&mut world);
        if counts.last() != Some(&set.report().rigid_steps) {
            counts.push(set.report().rigid_steps);
        }
        for (now, then) in places(&world).iter().zip(&before) {
            most = most.max(now.distance(*then));
        }
    }
    (most, counts)
}

#[test]
fn a_stack_elsewhere_hardly_feels_that_rapiers_step_changes() {
    let (asleep, counts) = stack(true);
    assert!(counts.contains(&1) && counts.contains(&4), "{counts:?}");
    assert_eq!(asleep, 0.0, "a sleeping stack does not move at all");
    // Rapier starts a step from the impulses of the last one, whatever its dt was: going back from four short steps to
    // one long one lets a stack that never sleeps hop by half a per cent of a box.
    let (awake, counts) = stack(false);
    assert!(counts.contains(&1) && counts.contains(&4), "{counts:?}");
    assert!(awake < 8e-3, "an awake stack moved by {awake} m");
}

/// A damped cube that yields and breaks falls on an edge: what is left of it with a kernel.
fn wreck(kernel: Kernel, integrator: Integrator) -> (u64, usize, f64) {
    let (mut world, _) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    set.params.kernel = kernel;
    set.params.integrator = integrator;
    let material = Material {
        break_strain: 0.08,
        ..Material::elastic(2.0e5, 100.0)
            .yielding(4.0e3, 1.0e4)
            .viscosity(50.0)
    };
    let net = lattice(Vector::splat(0.5), 0.1).unwrap();
    let cube = DeformableBuilder::new(net)
        .material(material)
        .translation(Vector::new(0.05, 0.5, 0.0))
        .rotation(Rotation::from_rotation_z(0.6))
        .linvel(Vector::new(1.0, -6.0, 0.3));
    let cube = set.insert(cube).unwrap();
    for _ in 0..20 {
        set.step(&mut world);
    }
    let springs = 0..set[cube].spring_count() as u32;
    let broken = springs.filter(|&i| set[cube].is_broken(SpringId(i)) == Some(true));
    let dissipated = set[cube].energies().work.plastic;
    (set.state_hash(), broken.count(), dissipated)
}

#[test]
fn every_kernel_gives_the_same_bits() {
    for integrator in Integrator::ALL {
        let portable = wreck(Kernel::Portable, integrator);
        if integrator == Integrator::SymplecticEuler {
            assert!(portable.1 > 3 && portable.2 > 1.0, "{portable:?}");
        }
        for kernel in [Kernel::Auto, Kernel::Avx2, Kernel::Avx512] {
            let (hash, broken, plastic) = wreck(kernel, integrator);
            assert_eq!(
                (hash, broken),
                (portable.0, portable.1),
                "{}",
                kernel.name()
            );
            // Sums of work have another order where springs go one by one.
            let relative = (plastic - portable.2).abs() / portable.2;
            assert!(relative < 1e-6, "{}: {relative}", kernel.name());
        }
    }
}

/// Stars of two to five springs, half of which break or yield at forces of their own, kicked: what is left of them.
fn stars(kernel: Kernel, yields: bool, seed: u64) -> (u64, usize) {
    let mut random = Random(seed);
    let (mut nodes, mut springs) = (Vec::new(), Vec::new());
    for star in 0..200 {
        let at = Vector::X * (3.0 * star as f32);
        let hub = nodes.len() as u32;
        nodes.push(Node::new(at, 1.0));
        for _ in 0..2 + (4.0 * random.unit()) as usize {
            let end = nodes.len() as u32;
            nodes.push(Node::new(at + random.direction(), 1.0));
            let mut spring = Spring::new(hub, end, 1000.0).damping(1.0);
            if random.unit() < 0.5 {
                let force = random.within(5.0, 200.0) as f32;
                if yields {
                    (spring.yield_tension, spring.yield_compression) = (force, force);
                } else {
                    spring.break_force = force;
                }
            }
            springs.push(spring);
        }
    }
    let mut set = DeformableWorld::new();
    set.params.kernel = kernel;
    let count = nodes.len() as u32;
    let body = set
        .insert(DeformableBuilder::new(Net::new(nodes, springs)))
        .unwrap();
    for node in 0..count {
        let kick = random.direction() * random.within(0.0, 4.0) as f32;
        set[body].set_linvel_of(NodeId(node), kick);
    }
    let mut world = PhysicsWorld::default();
    for _ in 0..30 {
        set.step(&mut world);
    }
    let springs = 0..set[body].spring_count() as u32;
    let broken = springs.filter(|&i| set[body].is_broken(SpringId(i)) == Some(true));
    (set.state_hash(), broken.count())
}

/// Vectors of sixteen took the limits of eight springs for those of all sixteen side by side.
#[test]
fn every_spring_of_a_vector_has_its_own_limit() {
    for (yields, seed) in [false, true]
        .into_iter()
        .flat_map(|y| (0..6).map(move |s| (y, s)))
    {
        let portable = stars(Kernel::Portable, yields, seed);
        assert!(yields || portable.1 > 10, "{portable:?}");
        for kernel in [Kernel::Auto, Kernel::Avx2, Kernel::Avx512] {
            let other = stars(kernel, yields, seed);
            assert_eq!(
                other,
                portable,
                "{}, yields: {yields}, {seed}",
                kernel.name()
            );
        }
    }
}
