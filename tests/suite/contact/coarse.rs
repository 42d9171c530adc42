//! Bodies that are small beside the faces which bear them: those bend and twist by more than the bodies are thick.

use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Name, collider and half height of small bodies.
fn small_bodies() -> [(&'static str, ColliderBuilder, f32); 5] {
    let plate = |thickness: f32| ColliderBuilder::cuboid(0.05, 0.5 * thickness, 0.03);
    [
        ("plate of 1 mm", plate(1e-3), 5e-4),
        ("plate of 5 mm", plate(5e-3), 2.5e-3),
        ("cube", ColliderBuilder::cuboid(0.02, 0.02, 0.02), 0.02),
        ("rod", ColliderBuilder::capsule_x(0.05, 0.01), 0.01),
        ("ball", ColliderBuilder::ball(0.03), 0.03),
    ]
}

/// Where a small body comes to lie that can only go up and down, let go over the middle of a face of 50 cm of which one corner
/// is lower by `twist` m.
fn height_on_twisted(
    net: &Net,
    corner: DVec3,
    twist: f32,
    small: &ColliderBuilder,
    half: f32,
) -> f32 {
    let mut world = PhysicsWorld::default();
    let bound_to_y = RigidBodyBuilder::dynamic()
        .translation(Vector::Y * (half + 0.01))
        .lock_rotations()
        .enabled_translations(false, true, false);
    let (body, _) = world.insert(bound_to_y, small.clone().mass(0.1));
    let mut set = DeformableWorld::default();
    let face =
        DeformableBuilder::new(net.clone().pin(|_| true)).material(Material::elastic(2e6, 1e3));
    let face = set.insert(face).unwrap();
    let nearest = |i: &u32| {
        let place = net.nodes[*i as usize].position;
        (place.as_dvec3() - corner).length_squared()
    };
    let all = 0..net.nodes.len() as u32;
    let node = all
        .min_by(|a, b| nearest(a).total_cmp(&nearest(b)))
        .unwrap();
    let lower = set[face].position(NodeId(node)).unwrap().as_vec3() - Vector::Y * twist;
    assert!(set[face].set_position(NodeId(node), lower));
    for _ in 0..60 {
        set.step(&mut world);
    }
    world.bodies[body].translation().y
}

/// Symptom: a plate fell through where one corner of a quad was 4 mm lower, if it was the first or the third. Cause: the side on
/// which the plate is was told by the plane through the first corner, a quarter of the twist off the face.
#[test]
fn whichever_corner_is_lower_bears_alike() {
    let open = sheet(0.5, 0.5, 2, 2, 3e-3).unwrap();
    let mut closed = lattice(Vector::splat(0.5), 0.5).unwrap();
    closed.nodes.iter_mut().for_each(|n| n.position.y -= 0.25);
    let corners = [[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]];
    for net in [open, closed] {
        for (name, small, half) in small_bodies() {
            for twist in [0.004, 0.01, 0.1, 0.2] {
                let heights = corners.map(|[x, z]| {
                    let corner = DVec3::new(x, 0.0, z);
                    height_on_twisted(&net, corner, twist, &small, half)
                });
                // Its middle is a quarter of the twist lower, and a flat body lies higher than its middle would.
                let least = half - 0.25 * twist - 1e-3;
                for y in heights {
                    assert!(y > least && y < 0.04, "{name}, {twist} m: {heights:?}");
                    // Bodies and faces are their own mirror images.
                    assert!(
                        (y - heights[0]).abs() < 1e-4,
                        "{name}, {twist} m: {heights:?}"
                    );
                }
            }
        }
    }
}

/// A surface lies between its nodes, so what is on it never is below the lowest of them.
#[test]
fn nothing_small_falls_through_a_coarse_sheet() {
    for nodes in [3, 5, 9] {
        for (name, small, half) in small_bodies() {
            for mass in [0.1, 10.0] {
                let mut world = PhysicsWorld::default();
                let start =
                    RigidBodyBuilder::dynamic().translation(Vector::new(0.07, half + 0.02, 0.04));
                let (body, _) = world.insert(start, small.clone().mass(mass));
                let mut set = DeformableWorld::default();
                let net = sheet(1.0, 1.0, nodes, nodes, 3e-3).unwrap().pin_border();
                let sheet = DeformableBuilder::new(net)
                    .material(Material::elastic(2e6, 1e3).viscosity(4e3))
                    .friction(0.5);
                let sheet = set.insert(sheet).unwrap();
                for step in 0..180 {
                    set.step(&mut world);
                    let (y, lowest) = (world.bodies[body].translation().y, set[sheet].bounds().0.y);
                    assert!(
                        f64::from(y) > lowest - 1e-3,
                        "{name}, {mass} kg, {nodes} nodes: {y} m below {lowest} m in step {step}"
                    );
                }
            }
        }
    }
}

/// A sheet of 1 m and 2 kg that is held by its border, and a cube over it, with a friction of 0.5.
fn cube_over_a_light_sheet(
    mass: f32,
    half: f32,
    (x, z): (f32, f32),
    tilt: f32,
) -> (
    PhysicsWorld,
    DeformableWorld,
    DeformableHandle,
    RigidBodyHandle,
) {
    let mut world = PhysicsWorld::default();
    let mut deformables = DeformableWorld::default();
    let net = sheet(1.0, 1.0, 17, 17, 0.002).unwrap().pin_border();
    let material = Material::elastic(2.0e6, 1000.0).viscosity(300.0);
    let sheet = DeformableBuilder::new(net).material(material).friction(0.5);
    let sheet = deformables.insert(sheet).unwrap();
    let cube = RigidBodyBuilder::dynamic()
        .translation(Vector::new(x, 0.5, z))
        .rotation(Vector::new(tilt, 0.0, 0.7 * tilt));
    let collider = ColliderBuilder::cuboid(half, half, half);
    let (cube, _) = world.insert(cube.can_sleep(false), collider.mass(mass).friction(0.5));
    (world, deformables, sheet, cube)
}

/// A cube of 20 kg falls beside the middle of a sheet of 2 kg, which it stretches to 1.8 times its length, and tumbles. While a corner in a
/// fold went over from one face to the other, the light node below shot up by centimetres, and a tenth of the energy was gone in one frame.
#[test]
fn a_corner_bears_on_both_sides_of_a_fold() {
    let (mut world, mut deformables, sheet, cube) =
        cube_over_a_light_sheet(20.0, 0.06, (0.01, 0.02), 0.0);
    let brought = 20.0 * 9.81 * 0.5;
    let mut last = brought;
    for frame in 0..36 {
        deformables.step(&mut world);
        let (rigid, soft) = (&world.bodies[cube], deformables[sheet].energies());
        let height = f64::from(rigid.translation().y);
        let energy = f64::from(rigid.kinetic_energy()) + 20.0 * 9.81 * height;
        let energy = energy + soft.kinetic + soft.elastic + soft.gravity;
        let lost = (last - energy) / brought;
        assert!(lost < 0.04, "frame {frame} takes {lost} of the energy");
        last = energy;
    }
}

/// Cubes of thirty and fifty times its mass draw such a sheet round their corners, where a corner is past the border of all faces that it
/// bears on: cells slipped off one after the other, until the cube was through.
#[test]
fn a_sheet_is_drawn_round_the_corners_of_heavy_cubes() {
    let places = [
        ((0.01, 0.02), 0.0),
        ((0.01, 0.02), 0.3),
        ((0.03, -0.01), 0.5),
        ((0.05, 0.15), 0.2),
    ];
    for (mass, half) in [(60.0, 0.06), (100.0, 0.1)] {
        for (place, tilt) in places {
            let (mut world, mut deformables, _, cube) =
                cube_over_a_light_sheet(mass, half, place, tilt);
            for _ in 0..100 {
                deformables.step(&mut world);
                let height = world.bodies[cube].translation().y;
                assert!(
                    height > -1.0,
                    "{mass} kg at {place:?}, {tilt} rad: {height}"
                );
            }
        }
    }
}
