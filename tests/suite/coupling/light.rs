//! Light rigid bodies between soft ones and what they stand on. Rapier's contacts give way as springs do, the softer the lighter the body
//! is: by F/(m·ω²), which is 11 mm under 190 N for one of 0.12 kg on the ground. So they are spared what shadows' contacts, which are hard, bear.

use super::floor;
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// A block of 10.8 kg and 160 kPa.
fn block() -> DeformableBuilder {
    DeformableBuilder::new(lattice(Vector::new(0.3, 0.2, 0.3), 0.1))
        .material(Material::elastic(1.6e5, 600.0).viscosity(160.0))
        .friction(0.5)
}

fn shapes() -> [(&'static str, ColliderBuilder); 3] {
    [
        ("ball", ColliderBuilder::ball(0.05)),
        ("capsule", ColliderBuilder::capsule_x(0.1, 0.05)),
        ("box", ColliderBuilder::cuboid(0.08, 0.05, 0.08)),
    ]
}

/// A block falls at 5.6 m/s on a body of 0.12 or 0.5 kg on a plate of 2 mm. It drove them up to 48 mm deep, the box of 0.12 kg through,
/// and up to 60 of its 169 J were lost between bodies and shadows.
#[test]
fn a_soft_block_does_not_drive_light_bodies_into_the_ground() {
    for (name, shape) in shapes() {
        for mass in [0.12, 0.5] {
            let what = format!("{name} of {mass} kg");
            let mut world = PhysicsWorld::default();
            let plate = ColliderBuilder::cuboid(3.0, 0.001, 3.0).translation(Vector::Y * -0.001);
            world.insert_collider(plate.friction(0.5), None);
            let shape = shape.clone().density(0.0).mass(mass).friction(0.5);
            let light = RigidBodyBuilder::dynamic().translation(Vector::Y * 0.05);
            let (light, _) = world.insert(light.can_sleep(false), shape);
            let mut set = DeformableWorld::default();
            let soft = block()
                .translation(Vector::new(0.01, 0.22, 0.013))
                .rotation(Rotation::from_rotation_y(0.3))
                .linvel(Vector::Y * -5.6);
            set.insert(soft).unwrap();
            let (mut lowest, mut defect) = (f32::INFINITY, 0.0);
            for _ in 0..30 {
                set.step(&mut world);
                lowest = lowest.min(world.bodies[light].translation().y);
                defect += set.report().coupling_defect;
            }
            assert!(lowest > 0.048, "{what}: {lowest}");
            assert!(f64::abs(defect) < 2.0, "{what}: {defect} J");
        }
    }
}

/// A block of 19 kg lies on three cubes of 0.12 kg, which shook at 0.07 m/s and rocked by a millimetre for good.
#[test]
fn light_cubes_stand_still_under_a_soft_block() {
    let mut world = floor();
    let cubes = [0, 1, 2].map(|i| {
        let (sin, cos) = (i as f32 * 2.0944).sin_cos();
        let cube = ColliderBuilder::cuboid(0.05, 0.05, 0.05)
            .density(0.0)
            .mass(0.12);
        let at = Vector::new(0.13 * sin, 0.05, 0.13 * cos);
        let body = RigidBodyBuilder::dynamic().translation(at).can_sleep(false);
        world.insert(body, cube.friction(0.5))
    });
    let soft = DeformableBuilder::new(lattice(Vector::new(0.4, 0.2, 0.4), 0.1))
        .material(Material::elastic(2e6, 600.0).viscosity(2e3))
        .translation(Vector::new(0.01, 0.202, 0.013))
        .friction(0.5)
        .can_sleep(false);
    let mut set = DeformableWorld::default();
    let soft = set.insert(soft).unwrap();
    let corner = |world: &PhysicsWorld, body: RigidBodyHandle| {
        world.bodies[body].position() * Vector::splat(0.05)
    };
    let (mut starts, mut load) = ([Vector::ZERO; 3], 0.0);
    for i in 0..240 {
        set.step(&mut world);
        if i == 180 {
            starts = cubes.map(|(body, _)| corner(&world, body));
        }
        for ((body, collider), start) in cubes.into_iter().zip(starts).filter(|_| i > 180) {
            let moved = (corner(&world, body) - start).length();
            assert!(moved < 2e-4, "{moved} m in {i}");
            let force = set.contact_force(soft, collider).unwrap_or_default();
            load += force.y / 59.0;
        }
    }
    let weight = set[soft].mass() * 9.81;
    assert!((load / weight - 1.0).abs() < 1e-3, "{load} of {weight} N");
}

/// What a light body passes on to a plate that flies freely is neither lost nor given twice.
#[test]
fn what_light_bodies_pass_on_is_momentum_that_stays() {
    for (name, shape) in shapes() {
        let mut world = PhysicsWorld {
            gravity: Vector::ZERO,
            ..PhysicsWorld::default()
        };
        let body = |y: f32| RigidBodyBuilder::dynamic().translation(Vector::Y * y);
        let plate = ColliderBuilder::cuboid(0.5, 0.05, 0.5)
            .density(0.0)
            .mass(20.0);
        let (plate, _) = world.insert(body(-0.05), plate.friction(0.5));
        let shape = shape.density(0.0).mass(0.12).friction(0.5);
        let (light, _) = world.insert(body(0.0501), shape);
        let mut set = DeformableWorld::default();
        let soft = block()
            .translation(Vector::new(0.02, 0.22, 0.0))
            .linvel(Vector::Y * -3.0);
        let soft = set.insert(soft).unwrap();
        let momentum = |world: &PhysicsWorld, set: &DeformableWorld| -> DVec3 {
            let rigid = [plate, light].map(|b| {
                let body = &world.bodies[b];
                body.linvel().as_dvec3() * f64::from(body.mass())
            });
            set[soft].momentum() + rigid[0] + rigid[1]
        };
        let start = momentum(&world, &set);
        for _ in 0..30 {
            set.step(&mut world);
        }
        let lost = (momentum(&world, &set) - start).length() / start.length();
        assert!(lost < 1e-5, "{name}: {lost}");
        let speed = world.bodies[plate].linvel().y;
        assert!(speed < -0.5, "{name}: the plate has {speed} m/s");
    }
}

/// What is welded to a light body is a load as well: of a block of 10.8 kg that falls 0.5 m, on a plate of 0.05, 0.2 or 1 kg under it, the
/// plate came 47, 15 and 3 mm into the floor, and lay 18, 5 and 1.4 mm in it then.
#[test]
fn what_is_welded_to_light_bodies_does_not_press_them_into_the_ground() {
    for mass in [0.05, 0.2, 1.0] {
        let mut world = floor();
        let plate = ColliderBuilder::cuboid(0.15, 0.025, 0.15)
            .density(0.0)
            .mass(mass);
        let body = RigidBodyBuilder::dynamic().translation(Vector::Y * 0.525);
        let (plate, _) = world.insert(body.can_sleep(false), plate.friction(0.5));
        let mut set = DeformableWorld::default();
        let soft = block().translation(Vector::Y * 0.65).can_sleep(false);
        let soft = set.insert(soft).unwrap();
        let nodes = (0..set[soft].node_count() as u32).map(NodeId);
        let nodes: Vec<_> = nodes
            .filter(|n| set[soft].position(*n).unwrap().y < 0.551)
            .collect();
        let weld = Attachment::weld(nodes);
        set.attach(soft, weld, AttachTo::Body(plate), &world.bodies)
            .unwrap();
        let mut lowest = f32::INFINITY;
        for _ in 0..120 {
            set.step(&mut world);
            lowest = lowest.min(world.bodies[plate].translation().y - 0.025);
        }
        assert!(lowest > -1.2e-3, "{mass} kg: {lowest}");
        let speed = world.bodies[plate].linvel().length();
        assert!(speed < 2e-3, "{mass} kg: {speed} m/s");
    }
}
