//! Light rigid bodies that carry heavier nodes, where something stops them.

use crate::fixtures::floored;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

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
