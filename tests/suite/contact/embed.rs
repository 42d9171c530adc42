//! Contact of a fine surface that a coarse mesh of tets carries.

use crate::fixtures::floored;
use crate::support::{close, weightless};
use crumple::body::{BuildError, Surface};
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box};

/// A ball of radius .5 m, of 24 × 12 points.
fn ball() -> Surface {
    let (vertices, triangles) = Ball::new(0.5).to_trimesh(24, 12);
    Surface::new(vertices, triangles)
}

/// It in a cube of 40 tets, whose corners stand out of it by .37 m.
pub fn soft_ball() -> DeformableBuilder {
    let cube = tet_box(Vector::splat(1.0), 0.5, TetSplit::Five).unwrap();
    let solid = Solid::new(4.0e5, 0.3, 200.0).damping(0.0, 5.0e-3);
    DeformableBuilder::tets(cube, solid)
        .embed(ball())
        .friction(0.5)
}

/// The skin carries the weight; the corners of the mesh are below the floor and touch nothing.
#[test]
fn a_ball_in_a_cube_of_tets_lies_on_its_skin() {
    let (mut world, floor) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let body = soft_ball().translation(Vector::Y * 0.6).can_sleep(false);
    let body = set.insert(body).unwrap();
    let start = set[body].energies().balance();
    for _ in 0..240 {
        set.step(&mut world);
    }
    let low = |at: Vec<Vector>| at.iter().map(|x| x.y).fold(f32::INFINITY, f32::min);
    let skin = low(set[body].skin_positions());
    assert!(skin.abs() < 1e-4, "the skin ends at {skin} m");
    let nodes = low(set[body].positions().collect());
    assert!(nodes < -0.005, "the corners of the mesh are at {nodes} m");
    let force = set.contact_force(body, floor).unwrap().y;
    close("contact force [N]", force, set[body].mass() * 9.81, 0.01);
    let end = set[body].energies();
    let residual = (end.balance() - start).abs() / end.scale();
    assert!(residual < 1e-3, "{residual:.2e} of {:?}", end.work);
}

/// The surface of the mesh itself as its skin changes nothing.
#[test]
fn a_mesh_in_its_own_skin_moves_as_without() {
    let mesh = tet_box(Vector::new(0.6, 0.3, 0.3), 0.15, TetSplit::Six).unwrap();
    let surface = Surface::new(
        mesh.nodes.iter().map(|x| x.as_vec3()).collect(),
        mesh.faces.clone(),
    );
    let run = |skinned: bool| {
        let (mut world, _) = floored(1.0 / 60.0);
        let mut set = DeformableWorld::new();
        let solid = Solid::new(3.0e5, 0.3, 300.0).damping(0.0, 2.0e-3);
        let mut body = DeformableBuilder::tets(mesh.clone(), solid)
            .translation(Vector::Y * 0.5)
            .linvel(Vector::new(1.0, 0.0, 0.3))
            .friction(0.4);
        if skinned {
            body = body.embed(surface.clone());
        }
        let body = set.insert(body).unwrap();
        for _ in 0..60 {
            set.step(&mut world);
        }
        (
            set[body].center_of_mass(),
            set[body].energies().work.contact_friction,
        )
    };
    let (bare, skinned) = (run(false), run(true));
    let apart = bare.0.distance(skinned.0);
    assert!(apart < 1e-4, "{apart:.2e} m apart");
    close("friction [J]", skinned.1, bare.1, 1e-3);
}

/// A rigid ball strikes a soft one, and that another: momentum, angular momentum and energy are kept.
#[test]
fn collisions_of_skins_keep_momentum_and_energy() {
    let mut world = weightless(1.0 / 240.0);
    let rigid = RigidBodyBuilder::dynamic()
        .translation(Vector::new(-1.1, 0.1, 0.05))
        .linvel(Vector::X * 3.0);
    let (rigid, _) = world.insert(rigid, ColliderBuilder::ball(0.3).mass(20.0).friction(0.5));
    let mut set = DeformableWorld::new();
    let [a, b] = [(0.0, 0.0), (1.1, 0.15)].map(|(x, y)| {
        let body = soft_ball().translation(Vector::new(x, y, 0.0));
        set.insert(body).unwrap()
    });
    let momenta = |world: &PhysicsWorld, set: &DeformableWorld| {
        let body = &world.bodies[rigid];
        let p = (body.linvel() * body.mass()).as_dvec3();
        let spin = body.angvel().as_dvec3() * (0.4 * 0.09 * f64::from(body.mass()));
        let soft = [a, b].map(|h| (set[h].momentum(), set[h].angular_momentum(DVec3::ZERO)));
        let linear = p + soft[0].0 + soft[1].0;
        let angular = body.translation().as_dvec3().cross(p) + spin + soft[0].1 + soft[1].1;
        (linear, angular)
    };
    let (p0, l0) = momenta(&world, &set);
    let mut met = false;
    for _ in 0..240 {
        set.step(&mut world);
        met |= set.contact_force(a, b).is_some();
    }
    let (p, l) = momenta(&world, &set);
    assert!(met && set[b].linvel().x > 0.1, "{}", set[b].linvel());
    let lost = (p - p0).length() / p0.length();
    assert!(lost < 1e-5, "{lost:.1e} of the momentum is lost");
    let lost = (l - l0).length() / (p0.length() * 1.0);
    assert!(lost < 2e-4, "{lost:.1e} of the angular momentum is lost");
    for h in [a, b] {
        let e = set[h].energies();
        let residual = e.balance().abs() / e.scale();
        assert!(residual < 5e-3, "{residual:.2e} of {e:?}");
    }
}

/// A saved skin is made anew, and goes on bit for bit.
#[test]
fn a_restored_skin_goes_on() {
    let (mut world, _) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    set.insert(soft_ball().translation(Vector::Y * 0.52))
        .unwrap();
    for _ in 0..20 {
        set.step(&mut world);
    }
    let bytes = set.save(&world).unwrap();
    let (mut again, mut world_again) = DeformableWorld::load(&bytes).unwrap();
    for _ in 0..20 {
        set.step(&mut world);
        again.step(&mut world_again);
    }
    assert_eq!(again.state_hash(), set.state_hash());
}

/// The skin of a filled net can touch as well; what has none is refused.
#[test]
fn skins_of_nets() {
    let net = || crumple::shape::filled(&ball(), 0.25).unwrap();
    let soft =
        || DeformableBuilder::new(net()).material(Material::elastic(4.0e5, 200.0).viscosity(4.0e3));
    let (mut world, _) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let body = soft().touch_by_skin().translation(Vector::Y * 0.6);
    let body = set.insert(body).unwrap();
    for _ in 0..180 {
        set.step(&mut world);
    }
    let skin = set[body].skin_positions();
    let low = skin.iter().map(|x| x.y).fold(f32::INFINITY, f32::min);
    assert!(low.abs() < 1e-4, "the skin ends at {low} m");
    let bare = DeformableBuilder::new(lattice(Vector::ONE, 0.5)).material(Material::rubber());
    assert_eq!(
        bare.clone().touch_by_skin().build().unwrap_err(),
        BuildError::NoSkin
    );
    assert_eq!(
        bare.embed(ball()).build().unwrap_err(),
        BuildError::SkinWithoutTets
    );
}

/// What is embedded touches, told so or not.
#[test]
fn an_embedded_surface_may_be_told_to_touch() {
    let skin = |builder: DeformableBuilder| builder.build().unwrap().skin_positions().len();
    assert_eq!(skin(soft_ball().touch_by_skin()), skin(soft_ball()));
}
