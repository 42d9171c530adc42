//! Hollows of one collider: bodies that slide along one of its faces to the next, and lie against several of them.

use super::Random;
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::parry::utils::Array2;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box};

fn boxes(parts: &[(Vector, f32, Vector)]) -> ColliderBuilder {
    let part = |&(at, turn, half): &(Vector, f32, Vector)| {
        let turned = Pose::from_parts(at, Rotation::from_rotation_z(turn));
        (turned, SharedShape::cuboid(half.x, half.y, half.z))
    };
    ColliderBuilder::compound(parts.iter().map(part).collect())
}

/// A floor 0.2 m thick with its top at y = 0, and a wall from x = 1 m on that goes `under` m into it.
fn floor_and_wall(thickness: f32, under: f32) -> ColliderBuilder {
    let v = Vector::new;
    boxes(&[
        (v(0.0, -0.1, 0.0), 0.0, v(4.0, 0.1, 4.0)),
        (
            v(1.0 + 0.5 * thickness, 0.5 - 0.5 * under, 0.0),
            0.0,
            v(0.5 * thickness, 0.5 + 0.5 * under, 4.0),
        ),
    ])
}

/// The same of cells as thick as the wall.
fn floor_and_wall_of_voxels(size: f32) -> ColliderBuilder {
    let count = |length: f32| (length / size).round() as i32;
    let mut cells = Vec::new();
    for x in -count(1.0)..count(3.0) {
        for z in -count(0.5)..count(0.5) {
            let height = if x == count(1.0) { count(1.0) } else { 0 };
            cells.extend((-2..height).map(|y| IVector::new(x, y, z)));
        }
    }
    ColliderBuilder::voxels(Vector::splat(size), &cells)
}

fn node() -> DeformableBuilder {
    DeformableBuilder::new(Net::new(vec![Node::new(Vector::ZERO, 0.1)], vec![]))
}

/// One that stands at a side, or lies.
fn triangle(a: Vector, b: Vector) -> DeformableBuilder {
    let nodes = [Vector::ZERO, a, b].map(|at| Node::new(at, 0.1));
    let spring = |a, b| Spring::new(a, b, 3e3).damping(10.0);
    let springs = vec![spring(0, 1), spring(1, 2), spring(0, 2)];
    let mut net = Net::new(nodes.to_vec(), springs);
    net.faces = vec![[0, 1, 2]];
    DeformableBuilder::new(net)
}

fn rubber() -> DeformableBuilder {
    let mesh = tet_box(Vector::splat(0.2), 0.1, TetSplit::Six).unwrap();
    DeformableBuilder::tets(mesh, Solid::new(1e6, 0.3, 300.0).damping(1.0, 1e-3))
}

fn block() -> DeformableBuilder {
    DeformableBuilder::new(lattice(Vector::splat(0.2), 0.1))
        .material(Material::elastic(1e6, 300.0).viscosity(1e3))
}

/// While nodes lay on the floor they had rows for nothing else, and were v·h in the wall, or behind it, when that was nearest.
#[test]
fn what_slides_to_a_wall_is_stopped_by_it() {
    let v = Vector::new;
    let bodies = || {
        let sheet = DeformableBuilder::new(sheet(0.4, 0.4, 5, 5, 0.003))
            .material(Material::elastic(1e6, 1000.0).viscosity(5e3));
        [
            ("node", node(), 0.001),
            (
                "triangle",
                triangle(v(-0.1, 0.0, 0.1), v(-0.1, 0.0, -0.1)),
                0.001,
            ),
            ("sheet", sheet, 0.001),
            ("block", block(), 0.101),
            ("rubber", rubber(), 0.101),
        ]
    };
    let walls = [
        ("flush, 2 mm", 0.002, floor_and_wall(0.002, 0.0)),
        ("flush, 5 cm", 0.05, floor_and_wall(0.05, 0.0)),
        ("sunk in, 2 mm", 0.002, floor_and_wall(0.002, 0.05)),
        ("sunk in, 20 cm", 0.2, floor_and_wall(0.2, 0.05)),
        ("voxels of 5 cm", 0.05, floor_and_wall_of_voxels(0.05)),
    ];
    for (wall, thickness, collider) in walls {
        for speed in [5.0, 30.0] {
            for (name, body, height) in bodies() {
                let (mut world, mut set) = (PhysicsWorld::default(), DeformableWorld::default());
                world.insert(RigidBodyBuilder::fixed(), collider.clone().friction(0.0));
                let body = body
                    .translation(Vector::Y * height)
                    .linvel(Vector::X * speed);
                let body = set.insert(body.friction(0.0)).unwrap();
                let mut farthest = 0.0_f32;
                for _ in 0..30 {
                    set.step(&mut world);
                    // What is thrown over the wall may come down behind it.
                    let below = set[body].positions().filter(|p| p.y < 0.9);
                    farthest = below.map(|p| p.x).fold(farthest, f32::max);
                }
                let behind = farthest - 1.0 - thickness;
                assert!(
                    behind < 1e-3,
                    "{name} at {speed} m/s, {wall}: {behind} m behind"
                );
            }
        }
    }
}

/// A node at the wall's face and a little in the floor was told to leave through the floor's underside, 0.2 m away.
#[test]
fn what_lies_in_a_corner_lies_still() {
    for friction in [0.0, 0.4] {
        for (name, body) in [("rubber", rubber()), ("block", block())] {
            let mut world = PhysicsWorld {
                gravity: Vector::new(6.937, -6.937, 0.0),
                ..PhysicsWorld::default()
            };
            world.insert(
                RigidBodyBuilder::fixed(),
                floor_and_wall(0.2, 0.05).friction(friction),
            );
            let mut set = DeformableWorld::default();
            let body = body.translation(Vector::new(0.8, 0.15, 0.0));
            let body = set
                .insert(body.friction(friction).can_sleep(false))
                .unwrap();
            let mut deepest = 0.0_f64;
            for _ in 0..300 {
                set.step(&mut world);
                let depths = set.contacts_of(body).map(|c| c.depth);
                deepest = depths.fold(deepest, f64::max);
            }
            let fastest = set[body].velocities().map(|v| v.length());
            let fastest = fastest.fold(0.0, f32::max);
            let weight = set[body].mass() * 6.937;
            let force = set.contacts_of(body).next().unwrap().force / weight;
            assert!(deepest < 1e-6, "{name}, μ {friction}: {deepest} m deep");
            assert!(fastest < 1e-3, "{name}, μ {friction}: {fastest} m/s");
            assert!(
                (force.x + 1.0).abs() < 0.01 && (force.y - 1.0).abs() < 0.01,
                "{name}, μ {friction}: {force} of the weight"
            );
            let moved = set[body].energies().work.push_out / weight;
            assert!(moved.abs() < 1e-5, "{name}, μ {friction}: push_out {moved}");
        }
    }
}

/// Where two parts of a compound overlap by a tenth of a millimetre, nothing falls between them.
#[test]
fn troughs_hold_what_falls_in() {
    let v = Vector::new;
    for slope in [0.5_f32, 0.8, 1.2] {
        let side = |sign: f32| {
            let turn = Rotation::from_rotation_z(sign * slope);
            let at = turn * v(sign * (0.4 - 1e-4), -0.1, 0.0);
            (at, sign * slope, v(0.4, 0.1, 0.6))
        };
        let trough = boxes(&[side(-1.0), side(1.0)]);
        let rope = DeformableBuilder::new(rope(v(0.0, 0.0, -0.2), v(0.02, 0.04, 0.2), 4, 4e-5))
            .material(Material::elastic(8e5, 300.0).viscosity(2e3));
        let bodies = [
            ("node", node()),
            ("rope", rope),
            ("triangle", triangle(v(-0.1, 0.2, 0.0), v(0.1, 0.2, 0.05))),
        ];
        for (name, body) in bodies {
            for speed in [0.0, 5.0] {
                let (mut world, mut set) = (PhysicsWorld::default(), DeformableWorld::default());
                world.insert(RigidBodyBuilder::fixed(), trough.clone());
                let body = body.clone().translation(v(0.004, 0.3, 0.0));
                let body = body.linvel(Vector::NEG_Y * speed).friction(0.3);
                let body = set.insert(body).unwrap();
                for _ in 0..100 {
                    set.step(&mut world);
                }
                let lowest = set[body].positions().map(|p| p.y).fold(1.0, f32::min);
                assert!(
                    lowest > -1e-3,
                    "{name} at {speed} m/s, slope {slope}: {lowest} m"
                );
            }
        }
    }
}

/// Hills and pits of up to 0.12 m in cells of 0.3 m, as a mesh and as a height field.
fn terrains(random: &mut Random) -> [(&'static str, ColliderBuilder); 2] {
    const N: usize = 21;
    let heights: Vec<f32> = (0..N * N)
        .map(|_| random.within(-0.12, 0.12) as f32)
        .collect();
    let at = |i: usize, j: usize| {
        let along = |i: usize| 6.0 * (i as f32 / (N - 1) as f32 - 0.5);
        Vector::new(along(i), heights[i * N + j], along(j))
    };
    let points = (0..N).flat_map(|i| (0..N).map(move |j| at(i, j)));
    let cells = (0..N - 1).flat_map(|i| (0..N - 1).map(move |j| i * N + j));
    let faces = cells.flat_map(|a| {
        let [a, b, c, d] = [a, a + 1, a + N, a + N + 1].map(|i| i as u32);
        [[a, b, c], [b, d, c]]
    });
    let mesh = ColliderBuilder::trimesh(points.collect(), faces.collect()).unwrap();
    let mut field = Array2::repeat(N, N, 0.0);
    for i in 0..N {
        for j in 0..N {
            field[(i, j)] = heights[i * N + j];
        }
    }
    let field = ColliderBuilder::heightfield(field, Vector::new(6.0, 1.0, 6.0));
    [("mesh", mesh), ("height field", field)]
}

/// How far a node is under a surface \[m\].
fn below(surface: &dyn Shape, p: Vector) -> f32 {
    let down = Ray::new(Vector::new(p.x, 10.0, p.z), Vector::NEG_Y);
    let hit = surface.cast_local_ray(&down, 20.0, false);
    let under = hit.is_some_and(|t| 10.0 - t > p.y);
    let distance = surface.project_local_point(p, false).point.distance(p);
    if under { distance } else { 0.0 }
}

/// A pit is a peak to what is below it: faces and edges whose nodes a blow had pushed through the surface were held under it.
#[test]
fn what_falls_on_rough_ground_lies_on_it() {
    let v = Vector::new;
    let bodies = || {
        let sheet = DeformableBuilder::new(sheet(0.6, 0.6, 2, 2, 0.006))
            .material(Material::elastic(6e4, 500.0).viscosity(18.0));
        [
            ("triangle", triangle(v(0.3, 0.0, 0.0), v(0.15, 0.0, 0.24))),
            ("sheet", sheet),
        ]
    };
    for seed in 0..6 {
        let mut random = Random(seed);
        for (ground, collider) in terrains(&mut random) {
            for (name, body) in bodies() {
                let (mut world, mut set) = (PhysicsWorld::default(), DeformableWorld::default());
                world.insert(RigidBodyBuilder::fixed(), collider.clone().friction(0.5));
                let places = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
                let all = places.map(|(x, z)| {
                    let turn = Rotation::from_scaled_axis(random.direction() * 3.0);
                    let body = body.clone().translation(v(x, 1.5, z)).rotation(turn);
                    set.insert(body).unwrap()
                });
                for _ in 0..240 {
                    set.step(&mut world);
                }
                for body in all {
                    let under = set[body].positions().map(|p| below(&*collider.shape, p));
                    let under = under.fold(0.0, f32::max);
                    assert!(
                        under < 1e-3,
                        "{name} on a {ground}, {seed}: {under} m under"
                    );
                }
            }
        }
    }
}

/// A corner of three plates was told to be left straight through the one behind it: all faces of each end in another, and so do the
/// edges in which two of them meet.
#[test]
fn a_box_of_plates_keeps_what_is_in_it() {
    let mut random = Random(7);
    for thickness in [0.01, 0.04] {
        let plates = [0, 1, 2].into_iter().flat_map(|axis| {
            [-0.4, 0.4].map(|side| {
                let (mut at, mut half) = (Vector::ZERO, Vector::splat(0.4));
                (at[axis], half[axis]) = (side, 0.5 * thickness);
                (at, 0.0, half)
            })
        });
        let plates = boxes(&plates.collect::<Vec<_>>());
        for seed in 0..4 {
            let bodies = [
                ("node", node()),
                (
                    "triangle",
                    triangle(Vector::new(-0.1, 0.0, 0.1), Vector::new(-0.1, 0.0, -0.1)),
                ),
                ("block", block()),
            ];
            for (name, body) in bodies {
                let mut world = PhysicsWorld {
                    gravity: Vector::ZERO,
                    ..PhysicsWorld::default()
                };
                let turn = random.direction() * 5.0;
                let (plated, _) = world.insert(
                    RigidBodyBuilder::dynamic().angvel(turn),
                    plates.clone().density(100.0).friction(0.0),
                );
                let mut set = DeformableWorld::default();
                let body = body.linvel(random.direction() * 3.0).friction(0.0);
                let body = set.insert(body.can_sleep(false)).unwrap();
                for frame in 0..240 {
                    set.step(&mut world);
                    let pose = *world.bodies[plated].position();
                    let inside = set[body]
                        .positions()
                        .map(|p| pose.inverse_transform_point(p));
                    let farthest = inside.map(|p| p.abs().max_element()).fold(0.0, f32::max);
                    assert!(
                        farthest < 0.4,
                        "{name} in plates of {thickness} m, {seed}: {farthest} m from the middle in frame {frame}"
                    );
                }
            }
        }
    }
}
