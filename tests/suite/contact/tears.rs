//! Nothing is where springs have broken.

use crate::support::{close, weightless};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

const MATTER: Material = Material::elastic(1.0e6, 500.0).viscosity(1.0e3);

/// A sheet or a rope along x whose springs in the middle have broken and whose ends were drawn apart by half a metre, held there; and
/// what it is in, with gravity from now on.
fn torn(net: Net) -> (PhysicsWorld, DeformableWorld, DeformableHandle) {
    let places: Vec<Vector> = net.nodes.iter().map(|n| n.position).collect();
    let weak = Material {
        strength: 2.0e4,
        ..MATTER
    };
    let body = DeformableBuilder::new(net.pin(|x| x.x.abs() > 0.3))
        .material(MATTER)
        .material_where(|x| x.x.abs() < 0.05, weak)
        .can_sleep(false);
    let mut world = weightless(1.0 / 60.0);
    let mut set = DeformableWorld::default();
    let body = set.insert(body).unwrap();
    for i in 1..=60 {
        for (n, place) in (0..).zip(&places).filter(|(_, place)| place.x > 0.3) {
            let way = Vector::X * (0.5 * i as f32 / 60.0);
            set[body].set_kinematic_target(NodeId(n), *place + way);
        }
        set.step(&mut world);
    }
    let broken = (0..set[body].spring_count() as u32)
        .filter(|&i| set[body].is_broken(SpringId(i)) == Some(true));
    assert!(broken.count() > 0);
    world.gravity = Vector::Y * -9.81;
    (world, set, body)
}

fn cloth() -> Net {
    sheet(1.0, 0.6, 12, 7, 2.0e-3).unwrap()
}

fn cord() -> Net {
    rope(Vector::X * -0.5, Vector::X * 0.5, 11, 1.0e-4).unwrap()
}

/// Symptom: a sheet was torn in two, and what fell through the gap of 0.7 m was caught in it. Cause: faces stayed when all springs
/// across them had broken. And a rope's broken links were met by the edges of boxes.
#[test]
fn what_falls_between_torn_halves_meets_nothing() {
    for net in [cloth, cord] {
        let shapes = [
            ColliderBuilder::ball(0.05),
            ColliderBuilder::cuboid(0.05, 0.05, 0.05),
            ColliderBuilder::capsule_x(0.05, 0.02),
        ];
        for shape in shapes {
            let (mut world, mut set, body) = torn(net());
            let at = RigidBodyBuilder::dynamic().translation(Vector::new(0.25, 0.2, 0.013));
            let (load, collider) = world.insert(at, shape.mass(1.0));
            for _ in 0..60 {
                set.step(&mut world);
                assert_eq!(set.contact_force(body, collider), None);
            }
            let y = f64::from(world.bodies[load].translation().y);
            close("the fall", 0.2 - y, 4.905, 0.01);
        }
        let (mut world, mut set, body) = torn(net());
        let cube = DeformableBuilder::new(lattice(Vector::splat(0.1), 0.05)).material(MATTER);
        let cube = set
            .insert(cube.translation(Vector::new(0.25, 0.2, 0.013)))
            .unwrap();
        for _ in 0..60 {
            set.step(&mut world);
        }
        assert!(set.contacts_of(cube).next().is_none());
        close("the fall", 0.2 - set[cube].center_of_mass().y, 4.905, 0.03);
        let down = Ray::new(Vector::new(0.25, 1.0, 0.013), Vector::Y * -1.0);
        let hit = set.cast_ray(&down, 2.0, true, Default::default());
        assert!(hit.is_none_or(|hit| hit.deformable != body));
    }
}

/// What is left of it holds as before.
#[test]
fn what_is_left_of_a_torn_sheet_holds() {
    let (mut world, mut set, body) = torn(cloth());
    let faces = set[body].blueprint().faces.clone();
    let at_rest = |n: u32| set[body].blueprint().nodes[n as usize].position.x;
    let across = |face: &[u32; 3]| {
        face.iter().any(|n| at_rest(*n) < 0.0) && face.iter().any(|n| at_rest(*n) > 0.0)
    };
    let is_torn = |f: usize| set[body].is_torn(f).unwrap();
    let all = faces.iter().enumerate();
    assert!(all.clone().all(|(f, face)| !across(face) || is_torn(f)));
    let far = |face: &[u32; 3]| face.iter().all(|n| at_rest(*n).abs() > 0.15);
    assert!(all.clone().all(|(f, face)| !far(face) || !is_torn(f)));
    let torn = all.clone().filter(|(f, _)| is_torn(*f)).count();
    assert_eq!(set[body].whole_faces().count(), faces.len() - torn);
    assert_eq!(set[body].is_torn(faces.len()), None);

    let at = RigidBodyBuilder::dynamic().translation(Vector::new(-0.36, 0.06, 0.013));
    let (ball, collider) = world.insert(at, ColliderBuilder::ball(0.05).mass(0.05));
    for _ in 0..20 {
        set.step(&mut world);
    }
    assert!(world.bodies[ball].translation().y > 0.04);
    assert!(set.contact_force(body, collider).is_some());
}

/// A snapshot knows what is torn by the springs that have broken.
#[test]
fn what_is_torn_stays_torn_after_a_restore() {
    let (mut world, mut set, body) = torn(cloth());
    let at = RigidBodyBuilder::dynamic().translation(Vector::new(0.25, 0.2, 0.013));
    let (ball, _) = world.insert(at, ColliderBuilder::ball(0.05).mass(1.0));
    let cube = DeformableBuilder::new(lattice(Vector::splat(0.1), 0.05)).material(MATTER);
    set.insert(cube.translation(Vector::new(0.1, 0.3, 0.1)))
        .unwrap();
    set.step(&mut world);
    let bytes = set.save(&world).unwrap();
    let (mut again, mut world_again) = DeformableWorld::load(&bytes).unwrap();
    for _ in 0..60 {
        set.step(&mut world);
        again.step(&mut world_again);
    }
    assert!(world_again.bodies[ball].translation().y < -4.5);
    assert_eq!(again.state_hash(), set.state_hash());
    let faces = set[body].blueprint().faces.len();
    assert!((0..faces).all(|f| again[body].is_torn(f) == set[body].is_torn(f)));
}
