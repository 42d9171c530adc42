//! Light rigid bodies that carry heavier nodes, where something stops them.

use crate::fixtures::floored;
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
    let cases: [(&str, Make, Material, f32, bool); 7] = [
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
        (
            "steel foam",
            &net,
            Material::mild_steel_foam(),
            500.0,
            false,
        ),
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

/// A block of foam under a plate on a hinge. The stiffness behind its nodes was told by the substep, which finer steps of Rapier cut: after
/// two seconds it was at every substep, and these were twice as many as foam needs.
#[test]
fn finer_steps_do_not_ask_for_finer_ones() {
    let mut world = PhysicsWorld::default();
    let ground = world.insert_body(RigidBodyBuilder::fixed().translation(Vector::Y * 2.0));
    let body = RigidBodyBuilder::dynamic().translation(Vector::Y * 2.0);
    let plate = ColliderBuilder::cuboid(0.2, 0.02, 0.2).mass(0.5);
    let (plate, _) = world.insert(body, plate.collision_groups(InteractionGroups::none()));
    world.insert_impulse_joint(ground, plate, RevoluteJointBuilder::new(Vector::Z));
    let mut set = DeformableWorld::default();
    let foam = DeformableBuilder::new(lattice(Vector::splat(0.4), 0.2))
        .material(Material::polypropylene_foam())
        .translation(Vector::Y * 1.78);
    let foam = set.insert(foam).unwrap();
    let nodes = (0..set[foam].node_count() as u32).map(NodeId);
    let high = |n: &NodeId| set[foam].position(*n).unwrap().y > 1.9;
    let nodes: Vec<NodeId> = nodes.filter(high).collect();
    assert_eq!(nodes.len(), 9);
    set.attach(foam, &nodes, plate, &world.bodies).unwrap();
    set.step(&mut world);
    let first = set.report().rigid_steps;
    assert!(first > 4, "{first}");
    for i in 0..120 {
        set.step(&mut world);
        let steps = set.report().rigid_steps;
        assert!(steps <= first + 2, "{steps} in {i}, {first} at first");
    }
}

/// Five links on hinges, from a wall, with a block of rubber of 15 kg welded to the last, swing down. It got 1.5 MJ, 67 and 9.6 kJ within
/// half a second, which has 160 J.
#[test]
fn a_chain_swings_with_a_block_of_rubber() {
    for mass in [0.5, 2.0, 5.0] {
        let mut world = PhysicsWorld::default();
        let none = InteractionGroups::none();
        let mut last = world.insert_body(RigidBodyBuilder::fixed());
        let mut end = Vector::ZERO;
        for i in 0..5 {
            let at = Vector::X * (0.1 + 0.2 * i as f32);
            let body = RigidBodyBuilder::dynamic().translation(at).can_sleep(false);
            let shape = ColliderBuilder::cuboid(0.1, 0.02, 0.02).collision_groups(none);
            let (link, _) = world.insert(body, shape.mass(mass));
            let hinge = RevoluteJointBuilder::new(Vector::Z)
                .local_anchor1(end)
                .local_anchor2(-0.1 * Vector::X);
            world.insert_impulse_joint(last, link, hinge);
            (last, end) = (link, 0.1 * Vector::X);
        }
        let mut set = DeformableWorld::default();
        let rubber = DeformableBuilder::new(lattice(Vector::new(0.4, 0.2, 0.2), 0.1))
            .material(Material::rubber())
            .translation(Vector::X * 1.1)
            .collision_groups(none);
        let rubber = set.insert(rubber).unwrap();
        let nodes = (0..set[rubber].node_count() as u32).map(NodeId);
        let near = |n: &NodeId| set[rubber].position(*n).unwrap().x < 1.0;
        let nodes: Vec<NodeId> = nodes.filter(near).collect();
        assert_eq!(nodes.len(), 9);
        set.attach(rubber, &nodes, last, &world.bodies).unwrap();
        let mut fastest = 0.0_f32;
        for _ in 0..120 {
            set.step(&mut world);
            let speeds = set[rubber].velocities().map(|v| v.length());
            fastest = speeds.fold(fastest, f32::max);
        }
        // What blows of the whip may take is less than half of what there is: mass times way down, of the block and of the links.
        let lost = set[rubber].energies().dissipated();
        let links: f64 = (0..5).map(|i| 0.1 + 0.2 * f64::from(i)).sum();
        let there = 9.81 * (1.2 * set[rubber].mass() + f64::from(mass) * links);
        assert!(
            lost < 0.5 * there,
            "links of {mass} kg: {lost} of {there} J"
        );
        // Whipped by the links it may be faster than √(2g·1.3 m).
        assert!(fastest < 15.0, "links of {mass} kg: {fastest} m/s");
    }
}

/// Planks 5 cm apart on two strongly damped ropes. What their damping asks for in substeps passed for stiffness, and planks that
/// do not touch for contacts: 15 of them took 2,584 of Rapier's steps a frame.
#[test]
fn planks_on_damped_ropes_take_usual_steps() {
    let mut world = PhysicsWorld::default();
    let mut set = DeformableWorld::default();
    let young = 6e8;
    let ropes = [-0.4, 0.4].map(|z| {
        let ends = [-1.0, 1.0].map(|x| Vector::new(x, 0.0, z));
        let net = rope(ends[0], ends[1], 16, 2e-4).unwrap();
        let rope = DeformableBuilder::new(net.pin(|p| p.x.abs() > 0.99))
            .material(Material::elastic(young, 1e3).viscosity(2e-3 * young));
        set.insert(rope).unwrap()
    });
    for i in 1..8 {
        let at = Vector::X * (0.25 * i as f32 - 1.0);
        let collider = ColliderBuilder::cuboid(0.1, 0.015, 0.5).mass(1.4);
        let (plank, _) = world.insert(RigidBodyBuilder::dynamic().translation(at), collider);
        for rope in ropes {
            let node = Attachment::pin([NodeId(2 * i)]);
            set.attach(rope, node, plank, &world.bodies).unwrap();
        }
    }
    for _ in 0..4 {
        set.step(&mut world);
        assert_eq!(set.report().rigid_steps, 4);
    }
}
