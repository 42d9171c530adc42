//! Ropes and sheets without thickness that hang over the brink of a table. At whatever distance from the brink their nodes come
//! down, what is between them lies on it, though a node that has just slid over does not hold it.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// How far nodes come down beyond the brink \[m\].
const BEYOND: [f32; 11] = [
    -1e-3, -1e-5, 0.0, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03,
];

/// Tables with brinks at x = ±.5 m and their top at y = .5 m.
fn tables() -> [(&'static str, ColliderBuilder); 4] {
    let half = Vector::splat(0.5);
    [
        ("box", ColliderBuilder::cuboid(0.5, 0.5, 0.5)),
        (
            "hull",
            ColliderBuilder::convex_hull(&super::corners(-half, half)).unwrap(),
        ),
        ("cylinder", ColliderBuilder::cylinder(0.5, 0.5)),
        (
            "mesh",
            super::box_mesh(
                -half,
                half,
                TriMeshFlags::ORIENTED | TriMeshFlags::FIX_INTERNAL_EDGES,
            ),
        ),
    ]
}

/// How deep the deepest point of straight lines between nodes is in that table in the last of three seconds \[m\]; the body
/// still lies on it.
fn deepest(table: &ColliderBuilder, soft: DeformableBuilder, lines: &[[u32; 2]]) -> f32 {
    let mut world = PhysicsWorld::default();
    let shape = table.shape.clone();
    world.insert(RigidBodyBuilder::fixed(), table.clone());
    let mut set = DeformableWorld::default();
    let soft = set.insert(soft.friction(0.9)).unwrap();
    let depth = |p: Vector| {
        let projection = shape.project_local_point(p, false);
        if projection.is_inside {
            projection.point.distance(p)
        } else {
            0.0
        }
    };
    let mut worst: f32 = 0.0;
    for step in 0..180 {
        set.step(&mut world);
        if step < 120 {
            continue;
        }
        for line in lines {
            let [a, b] = line.map(|i| set[soft].position(NodeId(i)).unwrap().as_vec3());
            let along = (0..=100).map(|i| depth(a.lerp(b, 0.01 * i as f32)));
            worst = along.fold(worst, f32::max);
        }
    }
    let top = set[soft].bounds().1.y;
    assert!((0.499..0.53).contains(&top), "it has slid off, to {top}");
    worst
}

/// Symptom: some cut 3 cm deep into the edge for good.
#[test]
fn they_lie_on_the_brink_wherever_their_nodes_come_down() {
    for (name, table) in tables() {
        for beyond in BEYOND {
            let start = Vector::new(beyond, 0.52, 0.0);
            let material = Material::elastic(1e6, 1e3).viscosity(1e3);
            let net = rope(Vector::X * -0.7, Vector::X * 0.8, 15, 1e-4).unwrap();
            let lines: Vec<[u32; 2]> = (0..15).map(|i| [i, i + 1]).collect();
            let rope = DeformableBuilder::new(net)
                .material(material)
                .translation(start);
            let depth = deepest(&table, rope, &lines);
            assert!(depth < 1e-4, "rope, {name}, {beyond} m: {depth} m deep");

            let net = sheet(1.4, 0.4, 14, 4, 1e-3).unwrap();
            // A quad bends over its diagonals.
            let at = |i: u32| net.nodes[i as usize].position;
            let sides = net.springs.iter().map(|s| s.nodes);
            let sides = sides.filter(|&[a, b]| at(a).distance(at(b)) < 0.11);
            let lines: Vec<[u32; 2]> = sides.collect();
            let sheet = DeformableBuilder::new(net)
                .material(material)
                .translation(start);
            let depth = deepest(&table, sheet, &lines);
            assert!(depth < 1e-4, "sheet, {name}, {beyond} m: {depth} m deep");
        }
    }
}
