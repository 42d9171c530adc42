//! Small rigid bodies that tumble as they are shot at a coarse sheet, into which they go as deep as it is wide.

use super::Random;
use crate::support::weightless;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

const HALF: f32 = 0.03;

fn shape(name: &str) -> ColliderBuilder {
    let r = HALF;
    match name {
        "ball" => ColliderBuilder::ball(r),
        "cube" => ColliderBuilder::cuboid(r, r, r),
        "capsule" => ColliderBuilder::capsule_y(1.5 * r, 0.6 * r),
        "cylinder" => ColliderBuilder::cylinder(r, r),
        "disc" => ColliderBuilder::cylinder(0.1 * r, 2.0 * r),
        "plate" => ColliderBuilder::cuboid(2.0 * r, 0.1 * r, 1.5 * r),
        "mesh" => {
            let (points, triangles) = Cuboid::new(Vector::splat(r)).to_trimesh();
            let flags = TriMeshFlags::ORIENTED;
            ColliderBuilder::trimesh_with_flags(points, triangles, flags).unwrap()
        }
        other => unreachable!("{other}"),
    }
}

/// Whether a body comes through a pinned sheet of 1 m, 3 mm and 2 MPa in so many cells, and by how much the energy of both ever exceeds
/// that of the shot.
fn shoot(
    collider: ColliderBuilder,
    (speed, cells): (f32, usize),
    friction: f32,
    random: &mut Random,
) -> (bool, f64) {
    let mut world = weightless(1.0 / 60.0);
    let mut within = |most: f64| random.within(-most, most) as f32;
    let (tilt, azimuth) = (0.6 + within(0.6), within(std::f64::consts::PI));
    let way = Vector::new(
        tilt.sin() * azimuth.cos(),
        -tilt.cos(),
        tilt.sin() * azimuth.sin(),
    );
    let aim = Vector::new(within(0.3), 0.0, within(0.3));
    let body = RigidBodyBuilder::dynamic()
        .translation(aim - way * (0.12 / way.y.abs()))
        .rotation(Vector::new(within(1.5), within(1.5), within(1.5)))
        .linvel(way * speed)
        .angvel(Vector::new(within(30.0), within(30.0), within(30.0)));
    let (body, _) = world.insert(body, collider.friction(friction).restitution(0.0));
    let mut deformables = DeformableWorld::default();
    let net = sheet(1.0, 1.0, cells + 1, cells + 1, 0.003)
        .unwrap()
        .pin_border();
    let sheet = deformables
        .insert(
            DeformableBuilder::new(net)
                .material(Material::elastic(2.0e6, 500.0).viscosity(300.0))
                .friction(friction),
        )
        .unwrap();
    let start = f64::from(world.bodies[body].kinetic_energy());
    let (mut through, mut most) = (false, 0.0_f64);
    for _ in 0..60 {
        deformables.step(&mut world);
        let soft = deformables[sheet].energies();
        let rigid = f64::from(world.bodies[body].kinetic_energy());
        most = most.max((rigid + soft.kinetic + soft.elastic) / start - 1.0);
        let place = world.bodies[body].translation();
        let lowest = deformables[sheet].positions().map(|p| p.y);
        let lowest = lowest.fold(f32::INFINITY, f32::min);
        through |= place.x.abs().max(place.z.abs()) < 0.45 && place.y < lowest - 0.1;
    }
    (through, most)
}

/// Of 648 such shots 27 went through while the side of a fold was told by its normal, boxes had no edges over twisted faces, balls
/// touched them by the normal of their middle, and what had slid under a face from beside it was let go. Of cubes that are meshes
/// one in seven did while those were no solids.
fn tumble(masses: &[f32], frictions: &[f32]) {
    let mut random = Random(7);
    let mut through = Vec::new();
    for name in [
        "ball", "cube", "capsule", "cylinder", "disc", "plate", "mesh",
    ] {
        for speed in [5.0, 15.0, 40.0] {
            for cells in [5, 10, 20] {
                for &mass in masses {
                    for &friction in frictions {
                        let collider = shape(name).mass(mass);
                        let (gone, gain) = shoot(collider, (speed, cells), friction, &mut random);
                        let shot = format!(
                            "{name} of {mass} kg at {speed} m/s, {cells} cells, friction {friction}"
                        );
                        assert!(gain < 0.01, "{shot}: gains {gain}");
                        if gone {
                            through.push(shot);
                        }
                    }
                }
            }
        }
    }
    // A capsule and a mesh do, both at 40 m/s.
    assert!(through.len() <= 2, "{through:#?}");
}

#[test]
fn what_tumbles_is_caught_by_a_coarse_sheet() {
    tumble(&[0.3], &[0.0, 0.5]);
}

#[test]
#[ignore = "long: 756 shots"]
fn whatever_tumbles_is_caught_by_a_coarse_sheet() {
    tumble(&[0.05, 0.3, 2.0], &[0.0, 0.25, 0.5, 1.0]);
}

/// The middle of the box around a tetrahedron with a right-angled corner lies beyond its slanted facet. While that was taken for the
/// middle of the body, more than half of those that came down with this facet first went through.
#[test]
fn a_slanted_facet_does_not_come_through() {
    for (size, speed, cells, at) in [
        (0.06, 0.5, 5, 0.0),
        (0.06, 3.0, 10, 0.03),
        (0.1, 0.5, 10, 0.05),
        (0.1, 3.0, 5, 0.07),
        (0.1, 8.0, 10, 0.02),
    ] {
        let mut world = weightless(1.0 / 60.0);
        let corners = [
            Vector::ZERO,
            Vector::X * size,
            Vector::Y * size,
            Vector::Z * size,
        ];
        let hull = ColliderBuilder::convex_hull(&corners).unwrap().mass(0.3);
        // The facet looks along (1, 1, 1), and is to look down.
        let turn = Rotation::from_rotation_arc(Vector::ONE.normalize(), -Vector::Y);
        let middle = turn * (Vector::splat(size) / 3.0);
        let start = Vector::new(at, 0.02, at) - middle;
        let body = RigidBodyBuilder::dynamic()
            .translation(start)
            .rotation(turn.to_scaled_axis())
            .linvel(Vector::Y * -speed);
        let (body, _) = world.insert(body, hull);
        let mut deformables = DeformableWorld::default();
        let net = sheet(1.0, 1.0, cells + 1, cells + 1, 0.003).unwrap();
        let material = Material::elastic(2.0e6, 500.0).viscosity(300.0);
        let sheet = DeformableBuilder::new(net.pin_border()).material(material);
        let sheet = deformables.insert(sheet).unwrap();
        let mut lowest = f32::INFINITY;
        for _ in 0..60 {
            deformables.step(&mut world);
            let over = world.bodies[body].center_of_mass().y
                - deformables[sheet]
                    .positions()
                    .map(|p| p.y)
                    .fold(f32::INFINITY, f32::min);
            lowest = lowest.min(over);
        }
        assert!(
            lowest > 0.0,
            "{size} m, {speed} m/s, {cells} cells: {lowest} m over the sheet"
        );
    }
}
