//! Colliders of no extent, and colliders that change under a block.

use super::{block, box_mesh, flat_field, grid_mesh};
use crate::fixtures::{all_finite, bead};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

struct Scene {
    world: PhysicsWorld,
    deformables: DeformableWorld,
    block: DeformableHandle,
    floor: ColliderHandle,
    body: RigidBodyHandle,
    /// A rigid body far away that nothing may touch.
    other: RigidBodyHandle,
}

impl Scene {
    fn new(floor: ColliderBuilder, rigid: RigidBodyBuilder) -> Self {
        let mut world = PhysicsWorld::default();
        let (body, floor) = world.insert(rigid, floor);
        let (other, _) = world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::new(50.0, 0.0, 0.0)),
            ColliderBuilder::ball(0.5),
        );
        let mut deformables = DeformableWorld::default();
        // Rapier makes the very steps it would make alone.
        deformables.params.max_rigid_dt = 1.0;
        let block = deformables
            .insert(block().translation(Vector::new(0.0, 0.16, 0.0)))
            .unwrap();
        Self {
            world,
            deformables,
            block,
            floor,
            body,
            other,
        }
    }

    fn run(&mut self, frames: usize) -> f64 {
        for _ in 0..frames {
            self.deformables.step(&mut self.world);
        }
        assert_eq!(self.deformables.report().frozen, []);
        assert!(all_finite(&self.world));
        self.deformables[self.block].center_of_mass().y
    }

    /// The other body falls as it would alone.
    fn check_other(&self) {
        let mut world = PhysicsWorld::default();
        let (handle, _) = world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::new(50.0, 0.0, 0.0)),
            ColliderBuilder::ball(0.5),
        );
        let frames = (self.deformables.time() * 60.0).round() as usize;
        for _ in 0..frames {
            world.step();
        }
        assert_eq!(
            world.bodies[handle].position(),
            self.world.bodies[self.other].position()
        );
    }
}

/// Floors of both kinds, their tops at y = 0.
fn floors() -> [ColliderBuilder; 3] {
    [
        ColliderBuilder::cuboid(2.0, 0.5, 2.0).translation(Vector::new(0.0, -0.5, 0.0)),
        grid_mesh((-2.0, -2.0), (4.0, 4.0), (13, 13), TriMeshFlags::empty()),
        flat_field(4.0, 4.0, 0.3),
    ]
}

#[test]
fn a_floor_that_goes_lets_the_block_fall() {
    for floor in floors() {
        for way in 0..3 {
            let mut scene = Scene::new(floor.clone(), RigidBodyBuilder::fixed());
            assert!(scene.run(60) > 0.14);
            match way {
                0 => {
                    scene.world.remove_collider(scene.floor);
                }
                1 => scene.world.colliders[scene.floor].set_enabled(false),
                _ => scene.world.bodies[scene.body].set_enabled(false),
            }
            let height = scene.run(30);
            assert!(height < -0.8, "way {way}: is still at {height} m");
            scene.check_other();
        }
    }
}

#[test]
fn a_floor_that_comes_back_beneath_catches_the_block() {
    for floor in floors() {
        let mut scene = Scene::new(floor.clone(), RigidBodyBuilder::fixed());
        scene.run(30);
        scene.world.colliders[scene.floor].set_enabled(false);
        scene.run(12);
        scene.world.bodies[scene.body].set_translation(Vector::new(0.0, -1.0, 0.0), true);
        scene.world.colliders[scene.floor].set_enabled(true);
        let height = scene.run(120);
        assert!((height + 0.85).abs() < 0.01, "rests at {height} m");
        scene.check_other();
    }
}

/// A floor put elsewhere in one go carries nothing along and remembers no sides.
#[test]
fn a_floor_teleported_through_the_block_leaves_it_where_it_is() {
    for floor in &floors()[1..] {
        let mut scene = Scene::new(floor.clone(), RigidBodyBuilder::fixed());
        scene.run(60);
        scene.world.bodies[scene.body].set_translation(Vector::new(0.0, 1.0, 0.0), true);
        let height = scene.run(30);
        assert!(height < -0.8 && height > -1.5, "is at {height} m");
        scene.check_other();
    }
}

#[test]
fn a_floor_may_change_its_shape() {
    for floor in floors() {
        let mut scene = Scene::new(floor, RigidBodyBuilder::fixed());
        scene.run(60);
        scene.world.colliders[scene.floor].set_translation_wrt_parent(Vector::ZERO);
        for next in [
            flat_field(4.0, 4.0, 0.5),
            ColliderBuilder::cuboid(2.0, 0.0, 2.0),
            grid_mesh((-2.0, -2.0), (4.0, 4.0), (5, 5), TriMeshFlags::empty()),
        ] {
            scene.world.colliders[scene.floor].set_shape(next.shape.clone());
            let height = scene.run(30);
            assert!((height - 0.15).abs() < 0.01, "is at {height} m");
        }
        scene.check_other();
    }
}

/// A block on a pillar between its nodes, which becomes shorter under it. Seen once: the block stayed up in the air, on the
/// corners of the shape that the collider had before. Expected: it comes down to the new top.
#[test]
fn a_pillar_within_a_face_may_change_its_shape() {
    let mut world = PhysicsWorld::default();
    world.integration_parameters.dt = 1.0 / 240.0;
    let pillar = ColliderBuilder::cuboid(0.06, 0.5, 0.06);
    let (_, pillar) = world.insert(RigidBodyBuilder::fixed(), pillar);
    let mut deformables = DeformableWorld::default();
    let net = lattice(Vector::new(0.6, 0.2, 0.6), 0.2);
    let block = DeformableBuilder::new(net)
        .material(Material::elastic(2.0e5, 200.0).viscosity(2.0e3))
        .translation(Vector::Y * 0.605);
    let block = deformables.insert(block).unwrap();
    for (half, top) in [(0.5, 0.5), (0.3, 0.3)] {
        world.colliders[pillar].set_shape(SharedShape::cuboid(0.06, half, 0.06));
        for _ in 0..180 {
            deformables.step(&mut world);
        }
        let height = deformables[block].center_of_mass().y;
        assert!((height - top - 0.1).abs() < 0.005, "is at {height} m");
    }
}

#[test]
fn colliders_of_no_extent_do_no_harm() {
    let point = Vector::new(0.05, 0.0, 0.05);
    let mesh =
        |points: [Vector; 3]| ColliderBuilder::trimesh(points.to_vec(), vec![[0, 1, 2]]).unwrap();
    let far = Vector::splat(f32::NAN);
    let colliders = [
        ColliderBuilder::cuboid(0.0, 0.0, 0.0),
        ColliderBuilder::ball(0.0),
        ColliderBuilder::capsule_y(0.0, 0.0),
        ColliderBuilder::cylinder(0.0, 0.0),
        ColliderBuilder::cone(0.0, 0.0),
        ColliderBuilder::round_cuboid(0.0, 0.0, 0.0, 0.0),
        ColliderBuilder::segment(point, point),
        ColliderBuilder::triangle(point, point, point),
        ColliderBuilder::triangle(Vector::ZERO, point, 2.0 * point),
        ColliderBuilder::triangle(point, far, Vector::ZERO),
        ColliderBuilder::round_triangle(point, point, point, 0.0),
        ColliderBuilder::polyline(vec![point, point], None),
        mesh([point; 3]),
        mesh([Vector::ZERO, point, 2.0 * point]),
        ColliderBuilder::heightfield(
            crumple::rapier3d::parry::utils::Array2::repeat(3, 3, 0.0),
            Vector::ZERO,
        ),
    ];
    for (i, collider) in colliders.into_iter().enumerate() {
        for rigid in [RigidBodyBuilder::fixed(), RigidBodyBuilder::dynamic()] {
            let mut scene = Scene::new(collider.clone(), rigid);
            let height = scene.run(60);
            assert!(height.is_finite(), "collider {i}: {height}");
            scene.check_other();
        }
    }
}

/// A node .3 m inside an oriented mesh is led out by the nearest way, without being thrown.
#[test]
fn a_node_deep_inside_an_oriented_mesh_comes_out() {
    let mut world = PhysicsWorld::default();
    let (lo, hi) = (Vector::new(-1.0, -2.0, -1.0), Vector::new(1.0, 0.0, 1.0));
    world.insert_collider(box_mesh(lo, hi, TriMeshFlags::ORIENTED), None);
    let mut deformables = DeformableWorld::default();
    let node = deformables
        .insert(bead(1.0).translation(Vector::new(0.1, -0.3, 0.2)))
        .unwrap();
    let mut highest = f64::NEG_INFINITY;
    for _ in 0..180 {
        deformables.step(&mut world);
        highest = highest.max(deformables[node].center_of_mass().y);
    }
    let end = deformables[node].center_of_mass();
    assert!(end.y.abs() < 1e-4, "ends at {end}");
    assert!(highest < 1e-4, "rose to {highest} m");
}
