//! Rays and nearest points, against loops over all faces.

use super::brute::{ALL, Dice, apart, faces, first, shaken, winding};
use crate::fixtures::{bead, cube, floored};
use crumple::body::{Net, Node};
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

#[test]
fn ten_thousand_rays_meet_what_a_loop_over_all_faces_meets() {
    for at in [Vector::ZERO, Vector::new(4000.0, -300.0, 70.0)] {
        let mut set = DeformableWorld::new();
        let block = shaken(&mut set, at);
        let faces = faces(&set[block]);
        let mut dice = Dice(11);
        let mut met = 0;
        for i in 0..10_000 {
            let origin = at + dice.vector(2.0);
            let dir = at + dice.vector(0.8) - origin;
            let ray = Ray::new(origin, dir);
            let solid = i % 2 == 0;
            let inside = solid && winding(&faces, ray.origin.as_dvec3()) > 0.5;
            let expected = if inside {
                Some(0.0)
            } else {
                first(&faces, &ray)
            };
            let hit = set.cast_ray(&ray, f32::MAX, solid, ALL);
            assert_eq!(hit.is_some(), expected.is_some(), "{ray:?}");
            let (Some(hit), Some(t)) = (hit, expected) else {
                continue;
            };
            met += 1;
            assert!(
                (f64::from(hit.time_of_impact) - t).abs() < 1e-6 * (1.0 + t),
                "{hit:?} {t}"
            );
            let Feature::Face(face) = hit.at.feature else {
                panic!("{hit:?}")
            };
            let nodes = set[block].blueprint().faces[face as usize];
            assert_eq!(hit.at.nodes.map(|n| n.0), nodes);
            if t > 0.0 {
                assert!(hit.normal.dot(ray.dir) <= 0.0);
                assert!((hit.normal.length() - 1.0).abs() < 1e-6);
                let point = set[block].world_point(&hit.at).unwrap();
                let expected = ray.origin.as_dvec3() + ray.dir.as_dvec3() * t;
                assert!(point.distance(expected) < 1e-6, "{point} {expected}");
                // Just short of it there is nothing, just beyond there is.
                let short = hit.time_of_impact * (1.0 - 1e-5);
                assert!(set.cast_ray(&ray, short, solid, ALL).is_none());
                let beyond = hit.time_of_impact * (1.0 + 1e-5);
                assert!(set.cast_ray(&ray, beyond, solid, ALL).is_some());
            } else {
                assert_eq!(hit.normal, Vector::ZERO);
            }
        }
        assert!((2000..9000).contains(&met), "{met}");
    }
}

/// Rays along the axes through nodes, sides and diagonals of an undeformed block: the box hits them all.
#[test]
fn a_grid_of_rays_slips_through_no_seam() {
    let mut set = DeformableWorld::new();
    set.insert(cube(0.6)).unwrap();
    for i in -30..=30 {
        for j in -30..=30 {
            let (x, z) = (i as f32 * 0.01, j as f32 * 0.01);
            for (origin, dir) in [
                (Vector::new(x, 2.0, z), -Vector::Y),
                (Vector::new(2.0, x, z), -Vector::X),
                (Vector::new(x, z, -2.0), Vector::Z),
            ] {
                // The outermost rays graze the border, whose coordinate is rounded.
                let inner = x.abs() < 0.2999 && z.abs() < 0.2999;
                match set.cast_ray(&Ray::new(origin, dir), 5.0, true, ALL) {
                    Some(hit) => assert!((hit.time_of_impact - 1.7).abs() < 1e-5),
                    None => assert!(!inner, "{origin} {dir}"),
                }
            }
        }
    }
}

#[test]
fn ten_thousand_points_project_as_by_a_loop_over_all_faces() {
    for at in [Vector::ZERO, Vector::new(-900.0, 5000.0, 40.0)] {
        let mut set = DeformableWorld::new();
        let block = shaken(&mut set, at);
        let faces = faces(&set[block]);
        let mut dice = Dice(5);
        let mut within = 0;
        for i in 0..10_000 {
            let point = at + dice.vector(if i % 2 == 0 { 0.6 } else { 3.0 });
            let p = point.as_dvec3();
            let nearest = faces
                .iter()
                .map(|f| apart(p, *f))
                .fold(f64::INFINITY, f64::min);
            let inside = winding(&faces, p) > 0.5;
            within += usize::from(inside);
            let found = set.project_point(point, f32::INFINITY, false, ALL).unwrap();
            assert_eq!(found.is_inside, inside, "{point}");
            assert!((f64::from(found.distance) - nearest).abs() < 1e-6 * (1.0 + nearest));
            let on = set[block].world_point(&found.at).unwrap();
            assert!((on.distance(p) - nearest).abs() < 1e-6);
            let solid = set.project_point(point, f32::INFINITY, true, ALL).unwrap();
            assert_eq!(solid.is_inside, inside);
            if inside {
                assert_eq!((solid.point, solid.distance), (point, 0.0));
            } else {
                assert_eq!((solid.point, solid.distance), (found.point, found.distance));
            }
            assert_eq!(set.intersect_point(point, ALL).contains(&block), inside);
            let near = 0.999 * nearest as f32;
            assert!(set.project_point(point, near, false, ALL).is_none());
        }
        assert!((1000..6000).contains(&within), "{within}");
    }
}

/// The tree follows the nodes: after steps, after edits, and after a body has flown to pieces.
#[test]
fn queries_see_nodes_where_they_are_now() {
    let (mut world, _) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let block = set.insert(cube(0.6).translation(Vector::Y * 2.0)).unwrap();
    let ray = |x| Ray::new(Vector::new(x, 9.0, 0.013), -Vector::Y);
    for _ in 0..40 {
        set.step(&mut world);
        let faces = faces(&set[block]);
        let hit = set.cast_ray(&ray(0.021), 20.0, true, ALL).unwrap();
        let expected = first(&faces, &ray(0.021)).unwrap();
        assert!((f64::from(hit.time_of_impact) - expected).abs() < 1e-5);
    }
    assert!(set.cast_ray(&ray(7.0), 20.0, true, ALL).is_none());
    let moved = Pose::from_translation(Vector::X * 7.0);
    assert!(set[block].transform(moved));
    assert!(set.cast_ray(&ray(7.021), 20.0, true, ALL).is_some());
    assert!(set.cast_ray(&ray(0.021), 20.0, true, ALL).is_none());
    let copy = set.clone();
    let mut dice = Dice(8);
    for node in 0..set[block].node_count() as u32 {
        assert!(set[block].set_position(NodeId(node), dice.vector(3.0)));
    }
    let faces = faces(&set[block]);
    for _ in 0..500 {
        let ray = Ray::new(dice.vector(4.0), dice.vector(1.0));
        let hit = set
            .cast_ray(&ray, 50.0, false, ALL)
            .map(|h| f64::from(h.time_of_impact));
        match (hit, first(&faces, &ray).filter(|t| *t <= 50.0)) {
            (Some(t), Some(expected)) => assert!((t - expected).abs() < 1e-5 * (1.0 + t)),
            (found, expected) => assert_eq!(found, expected),
        }
    }
    // The copy stands where the original stood.
    assert!(copy.cast_ray(&ray(7.021), 20.0, true, ALL).is_some());
}

#[test]
fn the_nearest_of_several_bodies_and_of_both_worlds_is_met() {
    let (mut world, floor) = floored(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let low = set.insert(cube(0.4).translation(Vector::Y)).unwrap();
    let high = set.insert(cube(0.4).translation(Vector::Y * 2.0)).unwrap();
    world.step();
    let pipeline = world.query_pipeline();
    let down = Ray::new(Vector::new(0.05, 5.0, 0.03), -Vector::Y);
    let up = Ray::new(Vector::new(0.05, 0.1, 0.03), Vector::Y);
    let met = |ray: &Ray, filter| set.cast_ray(ray, 10.0, true, filter).map(|h| h.deformable);
    assert_eq!(met(&down, ALL), Some(high));
    assert_eq!(met(&up, ALL), Some(low));
    assert_eq!(met(&down, ALL.exclude(high)), Some(low));
    let not_low = |handle: DeformableHandle, _: &Deformable| handle != low;
    assert_eq!(met(&up, ALL.predicate(&not_low)), Some(high));
    let (one, two) = (Group::GROUP_1, Group::GROUP_2);
    let nobody = InteractionGroups::new(one, two, InteractionTestMode::And);
    let mut masked = set.clone();
    masked[high].surface_mut().collision_groups = nobody;
    let hit = masked.cast_ray(
        &down,
        10.0,
        true,
        ALL.groups(InteractionGroups::new(one, one, InteractionTestMode::And)),
    );
    assert_eq!(hit.map(|h| h.deformable), Some(low));
    let mut off = set.clone();
    off[high].set_enabled(false);
    assert_eq!(
        off.cast_ray(&down, 10.0, true, ALL).unwrap().deformable,
        low
    );

    let both = |ray: &Ray, max| set.cast_ray_with(&pipeline, ray, max, true, ALL);
    assert!(matches!(both(&down, 10.0), Some(RayHit::Deformable(h)) if h.deformable == high));
    let aside = Ray::new(Vector::new(2.0, 5.0, 0.0), -Vector::Y);
    let hit = both(&aside, 10.0).unwrap();
    assert!(matches!(hit, RayHit::Rigid { collider, .. } if collider == floor));
    assert!((hit.time_of_impact() - 5.0).abs() < 1e-5 && hit.normal().y > 0.99);
    let below = Ray::new(Vector::new(0.05, -3.0, 0.03), Vector::Y);
    assert!(matches!(both(&below, 10.0), Some(RayHit::Rigid { .. })));
    assert!(both(&aside, 1.0).is_none());
    assert!(both(&Ray::new(Vector::Y * 9.0, Vector::Y), 10.0).is_none());
    // Rapier alone gives the same as through us.
    let alone = pipeline
        .cast_ray_and_get_normal(&aside, 10.0, true)
        .unwrap();
    assert_eq!(alone.1.time_of_impact, hit.time_of_impact());
}

#[test]
fn sheets_have_two_sides_and_no_inside() {
    let mut set = DeformableWorld::new();
    let sheet = sheet(1.0, 1.0, 6, 6, 0.002);
    let sheet = set
        .insert(DeformableBuilder::new(sheet).material(Material::rubber()))
        .unwrap();
    for side in [Vector::Y, -Vector::Y] {
        let ray = Ray::new(Vector::new(0.13, 0.0, 0.27) + side * 2.0, -side * 0.5);
        let hit = set.cast_ray(&ray, 10.0, true, ALL).unwrap();
        assert_eq!((hit.deformable, hit.normal), (sheet, side));
        assert!((hit.time_of_impact - 4.0).abs() < 1e-5);
    }
    let found = set
        .project_point(Vector::new(0.1, 0.3, 0.1), 1.0, true, ALL)
        .unwrap();
    assert!(!found.is_inside && (found.distance - 0.3).abs() < 1e-6);
    assert!(set.intersect_point(Vector::ZERO, ALL).is_empty());
}

#[test]
fn ropes_are_lines_with_the_thickness_a_query_gives_them() {
    let mut set = DeformableWorld::new();
    let net = rope(-Vector::X, Vector::X, 4, 1.0e-4);
    let rope = set
        .insert(DeformableBuilder::new(net).material(Material::rubber()))
        .unwrap();
    let bead = set.insert(bead(1.0).translation(Vector::Z * 3.0)).unwrap();
    let ray = |x: f32, z| Ray::new(Vector::new(x, 2.0, z), -Vector::Y);
    let thick = ALL.line_radius(0.05);
    assert!(set.cast_ray(&ray(0.3, 0.0), 9.0, true, ALL).is_none());
    let hit = set.cast_ray(&ray(0.3, 0.0), 9.0, true, thick).unwrap();
    assert_eq!(
        (hit.deformable, hit.at.feature),
        (rope, Feature::Spring(SpringId(2)))
    );
    assert!((hit.time_of_impact - 1.95).abs() < 1e-5 && hit.normal == Vector::Y);
    assert!((hit.at.weights[1] - 0.6).abs() < 1e-5 && hit.at.weights[2] == 0.0);
    let hit = set.cast_ray(&ray(0.0, 3.0), 9.0, true, thick).unwrap();
    assert_eq!(
        (hit.deformable, hit.at.feature),
        (bead, Feature::Node(NodeId(0)))
    );
    let from_within = Ray::new(Vector::X * 0.3, Vector::Y);
    assert_eq!(
        set.cast_ray(&from_within, 9.0, true, thick)
            .unwrap()
            .time_of_impact,
        0.0
    );

    let p = Vector::new(0.3, 0.5, 0.0);
    let bare = set.project_point(p, 9.0, true, ALL).unwrap();
    assert!((bare.distance - 0.5).abs() < 1e-6 && !bare.is_inside);
    let round = set.project_point(p, 9.0, true, thick).unwrap();
    assert!((round.distance - 0.45).abs() < 1e-6 && (round.point.y - 0.05).abs() < 1e-6);
    let inner = set
        .project_point(p * Vector::new(1.0, 0.04, 0.0), 9.0, false, thick)
        .unwrap();
    assert!(inner.is_inside && (inner.distance - 0.03).abs() < 1e-6);
    assert_eq!(set.intersect_point(Vector::X * 0.3, thick), [rope]);

    // A broken spring is gone.
    let mut world = PhysicsWorld::default();
    set[rope]
        .set_spring(SpringId(1), |s| s.break_force = 1.0)
        .unwrap();
    assert!(set[rope].set_linvel_of(NodeId(0), -Vector::X * 20.0));
    assert!(set[rope].set_linvel_of(NodeId(1), -Vector::X * 20.0));
    for _ in 0..3 {
        set.step(&mut world);
    }
    assert_eq!(set[rope].is_broken(SpringId(1)), Some(true));
    let gap = set[rope].position(NodeId(1)).unwrap() + set[rope].position(NodeId(2)).unwrap();
    let gap = Ray::new((gap * 0.5).as_vec3() + Vector::Y, -Vector::Y);
    assert!(set.cast_ray(&gap, 9.0, true, thick).is_none());
}

/// A point on the axis of a rope is as near to the surface on every side, and one of them is taken: across the rope, out of
/// every spring.
#[test]
fn a_point_on_the_axis_of_a_rope_is_projected_on_its_surface() {
    let mut set = DeformableWorld::new();
    let bent = [Vector::X, Vector::ZERO, Vector::Y].map(|x| Node::new(x, 1.0));
    let springs = vec![Spring::new(0, 1, 1000.0), Spring::new(1, 2, 1000.0)];
    let wire = DeformableBuilder::new(Net::new(bent.into(), springs));
    let wire = set.insert(wire).unwrap();
    let lone = set.insert(bead(1.0).translation(Vector::Z * 3.0)).unwrap();
    let thick = ALL.line_radius(0.05);
    let axis = |p: Vector| {
        let apart = |end: Vector| p.distance(end * p.dot(end).clamp(0.0, 1.0));
        apart(Vector::X).min(apart(Vector::Y))
    };
    for p in [Vector::X * 0.3, Vector::Y * 0.7, Vector::ZERO, Vector::Y] {
        let found = set.project_point(p, 9.0, false, thick).unwrap();
        assert!(found.is_inside && found.deformable == wire);
        assert!((found.distance - 0.05).abs() < 1e-6, "{found:?}");
        assert!((axis(found.point) - 0.05).abs() < 1e-6, "{found:?}");
        assert_eq!(set.project_point(p, 9.0, false, thick), Some(found));
        let solid = set.project_point(p, 9.0, true, thick).unwrap();
        assert!(solid.is_inside && solid.point == p && solid.distance == 0.0);
        let bare = set.project_point(p, 9.0, false, ALL).unwrap();
        assert!(!bare.is_inside && bare.point == p && bare.distance == 0.0);
        assert_eq!(set.project_point(p, 0.01, false, thick), None);
    }
    let p = Vector::Z * 3.0;
    let found = set.project_point(p, 9.0, false, thick).unwrap();
    assert!(found.is_inside && found.deformable == lone);
    assert!((found.point.distance(p) - 0.05).abs() < 1e-6);
}

/// A query after the first looks at few faces: 40,000 rays against all of 97,200 faces would take most of a minute.
#[test]
fn many_rays_at_many_faces_are_quick() {
    let mut set = DeformableWorld::new();
    let net = lattice(Vector::new(2.0, 2.0, 2.0), 2.0 / 90.0).unwrap();
    let shell: Vec<[u32; 3]> = net.faces.clone();
    let hollow = Net {
        springs: Vec::new(),
        faces: shell,
        nodes: net
            .nodes
            .iter()
            .map(|n| Node::new(n.position, 1.0))
            .collect(),
        skin: None,
    };
    let body = set.insert(DeformableBuilder::new(hollow)).unwrap();
    assert!(set[body].blueprint().faces.len() > 90_000);
    let start = std::time::Instant::now();
    set.cast_ray(&Ray::new(Vector::Y * 9.0, -Vector::Y), 20.0, true, ALL)
        .unwrap();
    let built = start.elapsed();
    assert!(set[body].set_position(NodeId(0), Vector::splat(-1.1)));
    let start = std::time::Instant::now();
    set.cast_ray(&Ray::new(Vector::Y * 9.0, -Vector::Y), 20.0, true, ALL)
        .unwrap();
    let fitted = start.elapsed();
    let mut dice = Dice(2);
    let start = std::time::Instant::now();
    let mut met = 0;
    for _ in 0..40_000 {
        let origin = dice.vector(5.0);
        let ray = Ray::new(origin, dice.vector(1.0) - origin);
        met += usize::from(set.cast_ray(&ray, 2.0, true, ALL).is_some());
    }
    let cast = start.elapsed();
    let start = std::time::Instant::now();
    for _ in 0..40_000 {
        assert!(
            set.project_point(dice.vector(3.0), 50.0, true, ALL)
                .is_some()
        );
    }
    let projected = start.elapsed();
    println!("built {built:?}, fitted {fitted:?}, 40000 rays {cast:?}, 40000 points {projected:?}");
    assert!(met > 35_000);
    assert!(cast.as_secs() < 10 && projected.as_secs() < 20);
}

#[test]
fn worlds_go_between_threads() {
    fn both<T: Send + Sync>() {}
    both::<DeformableWorld>();
    both::<Deformable>();
    let mut set = DeformableWorld::new();
    set.insert(cube(0.6)).unwrap();
    let ray = Ray::new(Vector::new(0.02, 2.0, 0.03), -Vector::Y);
    let cast = || set.cast_ray(&ray, 9.0, true, ALL).unwrap();
    std::thread::scope(|scope| {
        let other = scope.spawn(cast);
        let here = cast();
        assert_eq!(other.join().unwrap(), here);
    });
}

#[test]
fn a_point_of_the_surface_moves_and_is_pushed_with_its_nodes() {
    let mut world = PhysicsWorld {
        gravity: Vector::ZERO,
        ..PhysicsWorld::default()
    };
    let mut set = DeformableWorld::new();
    let block = set.insert(cube(0.6).linvel(Vector::X)).unwrap();
    let ray = Ray::new(Vector::new(0.02, 2.0, 0.03), -Vector::Y);
    let hit = set.cast_ray(&ray, 9.0, true, ALL).unwrap();
    let body = &mut set[block];
    assert!(body.velocity_at(&hit.at).unwrap().distance(DVec3::X) < 1e-6);
    assert!(body.add_step_force_at(&hit.at, Vector::Y * 30.0));
    let before = body.momentum();
    set.step(&mut world);
    let gained = set[block].momentum() - before;
    assert!(gained.distance(DVec3::Y * 0.5) < 1e-4, "{gained}");
}
