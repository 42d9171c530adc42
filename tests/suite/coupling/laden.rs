//! Light rigid bodies that carry heavier nodes, where something stops them.

use crate::fixtures::floored;
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box};

/// A block on a plate on a floor, welded or linked to it: plates of a fifth to a ninetieth of the mass of the nodes that they
/// carry. Nothing happens, so nothing may move. It shook at up to 6 m/s, and by more than 1e4 J.
#[test]
fn a_block_rests_on_the_light_plate_that_it_is_welded_to() {
    for (cell, mass, link) in [
        (0.1, 0.2, false),
        (0.1, 0.05, false),
        (0.1, 0.02, false),
        (0.05, 0.2, false),
        (0.1, 0.1, true),
    ] {
        let what = format!("{mass} kg, cells of {cell} m, link {link}");
        let (mut world, _) = floored(1.0 / 60.0);
        let plate = ColliderBuilder::cuboid(0.15, 0.05, 0.15)
            .density(0.0)
            .mass(mass);
        let body = RigidBodyBuilder::dynamic().translation(Vector::Y * 0.05);
        let (plate, _) = world.insert(body.can_sleep(false), plate);
        let none = InteractionGroups::none();
        let block = DeformableBuilder::new(lattice(Vector::splat(0.3), cell))
            .material(Material::elastic(5e5, 400.0).viscosity(2e3))
            .translation(Vector::Y * 0.25)
            .collision_groups(none)
            .can_sleep(false);
        let mut set = DeformableWorld::default();
        let block = set.insert(block).unwrap();
        let nodes = (0..set[block].node_count() as u32).map(NodeId);
        let low = |n: &NodeId| set[block].position(*n).unwrap().y < 0.11;
        let nodes: Vec<NodeId> = nodes.filter(low).collect();
        let bond = if link {
            Attachment::link(nodes, 2e4).damping(20.0)
        } else {
            Attachment::weld(nodes)
        };
        set.attach(block, bond, plate, &world.bodies).unwrap();
        for i in 0..240 {
            set.step(&mut world);
            let speeds = set[block].velocities().map(|v| v.length());
            let fastest = speeds.fold(0.0, f32::max);
            assert!(i < 180 || fastest < 5e-3, "{what}: {fastest} m/s in {i}");
        }
        let given = set[block].energies().work.rigid;
        assert!(given < 60.0, "{what}: {given} J");
    }
}

/// Blocks of the crate's own materials on plates that are light for them. Rapier's contacts give way like dampers, by the mass of the plate
/// alone, and the springs of a block push back the harder, once a rigid step. What the block got by that, in 5 s: 1,033 J from a
/// plate of 4 kg, 15 kJ of foam, 0.6 MJ of aluminium.
#[test]
fn stiff_blocks_rest_on_light_plates() {
    let tets = |_: Material| {
        let mesh = tet_box(Vector::splat(0.4), 0.1, TetSplit::Six).unwrap();
        DeformableBuilder::tets(mesh, Solid::new(20e6, 0.3, 300.0).damping(0.0, 1e-4))
    };
    let net = |m| DeformableBuilder::new(lattice(Vector::new(0.8, 0.4, 0.8), 0.2)).material(m);
    type Make<'a> = &'a dyn Fn(Material) -> DeformableBuilder;
    let cases: [(&str, Make, Material, f32, bool); 6] = [
        ("car body", &net, Material::car_body(), 4.0, false),
        ("car body, pinned", &net, Material::car_body(), 4.0, true),
        ("foam", &net, Material::polypropylene_foam(), 2.0, false),
        (
            "aluminium foam",
            &net,
            Material::aluminium_foam(),
            50.0,
            false,
        ),
        ("steel foam", &net, Material::mild_steel_foam(), 10.0, false),
        ("tets", &tets, Material::car_body(), 2.0, false),
    ];
    for (name, make, material, mass, pinned) in cases {
        let what = format!("{name} on {mass} kg");
        let (mut world, _) = floored(1.0 / 60.0);
        let body = RigidBodyBuilder::dynamic().translation(Vector::Y * 0.05);
        let plate = ColliderBuilder::cuboid(0.4, 0.05, 0.4).density(0.0);
        let (plate, _) = world.insert(body, plate.mass(mass));
        let mut set = DeformableWorld::default();
        let block = make(material).translation(Vector::Y * 0.301);
        let block = set.insert(block).unwrap();
        let nodes = (0..set[block].node_count() as u32).map(NodeId);
        let low = |n: &NodeId| set[block].position(*n).unwrap().y < 0.11;
        let nodes: Vec<NodeId> = nodes.filter(low).collect();
        let bond = if pinned {
            Attachment::pin(nodes)
        } else {
            Attachment::weld(nodes)
        };
        set.attach(block, bond, plate, &world.bodies).unwrap();
        let mut given = Vec::new();
        for _ in 0..3 {
            (0..60).for_each(|_| set.step(&mut world));
            given.push(set[block].energies().work.rigid);
        }
        let more = given[2] - given[1];
        assert!(more.abs() < 0.01, "{what}: {more} J in the third second");
        // As the plate settles, by less than the block weighs times the slop of Rapier's contacts.
        let weight = 9.81 * set[block].mass();
        assert!(given[0].abs() < 4e-3 * weight, "{what}: {} J", given[0]);
    }
}
/// A car of 1 t, its engine and wheels carried by it.
struct Car {
    world: PhysicsWorld,
    set: DeformableWorld,
    body: DeformableHandle,
}

impl Car {
    /// At a speed \[m/s\], on wheels that are balls or cylinders, on carriers of 20 kg like the wheels.
    fn new(speed: f32, balls: bool) -> Self {
        let mut world = PhysicsWorld::default();
        let road = ColliderBuilder::cuboid(60.0, 0.5, 10.0).friction(0.8);
        let ground = RigidBodyBuilder::fixed().translation(Vector::Y * -0.5);
        world.insert(ground, road);
        let mut set = DeformableWorld::default();
        let (at, velocity) = (Vector::Y * 0.75, Vector::X * speed);
        let none = InteractionGroups::none();
        let chassis = DeformableBuilder::new(lattice(Vector::new(3.6, 0.8, 1.6), 0.2))
            .material(Material::car_body())
            .collision_groups(none)
            .translation(at)
            .linvel(velocity);
        let body = set.insert(chassis).unwrap();
        let rigid = |at| {
            let builder = RigidBodyBuilder::dynamic().translation(at).linvel(velocity);
            builder.can_sleep(false)
        };
        let mut carry = |world: &mut PhysicsWorld, part, center: Vector, half: DVec3| {
            let nodes = (0..set[body].node_count() as u32).map(NodeId);
            let is_in = |n: &NodeId| {
                let off = set[body].position(*n).unwrap() - center.as_dvec3();
                off.abs().cmplt(half).all()
            };
            let nodes: Vec<NodeId> = nodes.filter(is_in).collect();
            assert!(nodes.len() > 5);
            set.attach(body, &nodes, part, &world.bodies).unwrap();
        };
        let engine = ColliderBuilder::cuboid(0.3, 0.25, 0.35).collision_groups(none);
        let (engine, _) = world.insert(rigid(at), engine.mass(150.0));
        carry(&mut world, engine, at, DVec3::new(0.31, 0.26, 0.36));
        for (x, z) in [(-1.2, -0.8), (-1.2, 0.8), (1.2, -0.8), (1.2, 0.8_f32)] {
            let (hub, out) = (
                at + Vector::new(x, -0.4, z),
                Vector::Z * (0.15 * z.signum()),
            );
            let carrier = ColliderBuilder::cuboid(0.1, 0.1, 0.1).collision_groups(none);
            let (carrier, _) = world.insert(rigid(hub), carrier.mass(20.0));
            carry(&mut world, carrier, hub, DVec3::new(0.21, 0.05, 0.21));
            let wheel = if balls {
                ColliderBuilder::ball(0.35)
            } else {
                let axle = Vector::X * std::f32::consts::FRAC_PI_2;
                ColliderBuilder::cylinder(0.08, 0.35).rotation(axle)
            };
            let spin = Vector::Z * (-speed / 0.35);
            let (wheel, _) = world.insert(
                rigid(hub + out).angvel(spin),
                wheel.mass(20.0).friction(0.8),
            );
            let hinge = RevoluteJointBuilder::new(Vector::Z).local_anchor1(out);
            world.insert_impulse_joint(carrier, wheel, hinge.contacts_enabled(false));
        }
        Self { world, set, body }
    }
}

/// Rapier leaves hinges in error by what its iterations do not get to, and nodes followed their carriers. Parked, the car took up
/// 1,710 J in 2 s, at 20 m/s 32 kJ on balls and 86 kJ on cylinders.
#[test]
fn a_car_stands_and_rolls_on_light_carriers() {
    for (speed, balls, most) in [(0.0, false, 10.0), (20.0, true, 600.0), (20.0, false, 3e3)] {
        let mut car = Car::new(speed, balls);
        (0..120).for_each(|_| car.set.step(&mut car.world));
        let soft = &car.set[car.body];
        let (lost, v) = (soft.energies().dissipated(), soft.linvel());
        let what = format!("{speed} m/s, balls {balls}");
        assert!(lost < most, "{what}: {lost} J");
        assert!((v.x - f64::from(speed)).abs() < 0.2, "{what}: {v}");
    }
}
