//! Every solid against references that share no code with it.

mod degenerate;
mod lines;
mod reference;
mod rims;
mod timing;

use super::Solid;
use crate::math::DVec3;
use rapier3d::geometry::SharedShape;
use rapier3d::math::{IVector, Pose, Vector};
use reference::{Random, cells, inner_box, parry_distance, triangles};

/// Points on a sphere, spread by the golden angle, and squeezed.
fn pebble(n: usize) -> Vec<Vector> {
    (0..n)
        .map(|i| {
            let y = 1.0 - 2.0 * (i as f32 + 0.5) / n as f32;
            let (s, c) = (2.399_963_2 * i as f32).sin_cos();
            let r = (1.0 - y * y).sqrt();
            Vector::new(0.5 * r * c, 0.3 * y, 0.4 * r * s)
        })
        .collect()
}

/// A tilted plate of 2 mm and 1 m.
fn plate() -> Vec<Vector> {
    let turn = rapier3d::math::Rotation::from_axis_angle(Vector::new(0.6, 0.0, 0.8), 0.4);
    (0..8)
        .map(|i| {
            let side = |bit: usize, half: f32| if i >> bit & 1 == 1 { half } else { -half };
            turn * Vector::new(side(0, 0.5), side(1, 0.001), side(2, 0.4))
        })
        .collect()
}

fn octahedron() -> Vec<Vector> {
    let axes = [Vector::X, Vector::Y * 0.5, Vector::Z * 0.7];
    axes.into_iter().flat_map(|a| [a, -a]).collect()
}

/// Named shapes without parts.
fn convex() -> Vec<(&'static str, SharedShape)> {
    let hull = |points: &[Vector]| SharedShape::convex_hull(points).unwrap();
    let round = |points: &[Vector]| SharedShape::round_convex_hull(points, 0.05).unwrap();
    vec![
        ("ball", SharedShape::ball(0.7)),
        ("cuboid", SharedShape::cuboid(0.5, 0.3, 0.8)),
        ("thin cuboid", SharedShape::cuboid(0.5, 0.001, 0.8)),
        (
            "capsule",
            SharedShape::capsule(
                Vector::new(-0.2, -0.4, 0.1),
                Vector::new(0.3, 0.5, 0.0),
                0.25,
            ),
        ),
        ("thin capsule", SharedShape::capsule_x(0.4, 0.005)),
        ("cylinder", SharedShape::cylinder(0.5, 0.35)),
        ("cone", SharedShape::cone(0.5, 0.35)),
        ("flat cone", SharedShape::cone(0.05, 0.6)),
        ("octahedron", hull(&octahedron())),
        ("hull 60", hull(&pebble(60))),
        ("plate hull", hull(&plate())),
        (
            "round cuboid",
            SharedShape::round_cuboid(0.4, 0.2, 0.6, 0.1),
        ),
        ("round cylinder", SharedShape::round_cylinder(0.4, 0.3, 0.1)),
        ("round cone", SharedShape::round_cone(0.4, 0.3, 0.1)),
        ("round hull", round(&pebble(30))),
    ]
}

/// A floor of two boxes, an L on it, and a turned box, or cells like these.
fn composites() -> Vec<(&'static str, SharedShape)> {
    let boxes = |list: &[([i32; 3], [i32; 3])]| {
        let parts = list.iter().map(|&(lo, hi)| inner_box(lo, hi)).collect();
        SharedShape::compound(parts)
    };
    vec![
        (
            "compound",
            boxes(&[
                ([-4, 0, -4], [0, 1, 4]),
                ([0, 0, -4], [4, 1, 4]),
                ([-4, 1, -4], [-3, 4, 4]),
            ]),
        ),
        ("voxels", SharedShape::voxels(Vector::splat(0.25), &blob())),
    ]
}

/// A hilly ground of cells with holes, across chunks and through zero.
fn blob() -> Vec<IVector> {
    let mut random = Random(7);
    let mut all = Vec::new();
    for x in -6..6 {
        for z in -6..6 {
            let top = 1 + (random.unit() * 2.5) as i32;
            for y in -3..=top {
                if random.unit() < 0.95 {
                    all.push(IVector::new(x, y, z));
                }
            }
        }
    }
    all
}

#[test]
fn simple_shapes_agree_with_parry_where_it_is_right() {
    for (name, shape) in convex() {
        let solid = Solid::of(&*shape).unwrap();
        let mut random = Random(1);
        for _ in 0..10_000 {
            let p = random.vector() * 1.2;
            let Some(reference) = parry_distance(&shape, p) else {
                continue;
            };
            let (d, n) = solid.signed_distance(p);
            assert!(
                (d - reference).abs() < 3e-6,
                "{name} at {p}: {d} against {reference}"
            );
            assert!((n.length() - 1.0).abs() < 1e-9);
        }
    }
}

/// Over the triangles of parry's own tessellation, one by one.
#[test]
fn hulls_agree_with_their_triangles() {
    let cases = [octahedron(), pebble(12), pebble(60), pebble(300)];
    for points in cases {
        let shape = SharedShape::convex_hull(&points).unwrap();
        let solid = Solid::of(&*shape).unwrap();
        let mesh = triangles(&points);
        let mut random = Random(3);
        for k in 0..10_000 {
            // Also close to the surface, where contacts are.
            let mut p = random.vector() * 1.2;
            if k % 2 == 0 {
                let (d, n) = solid.signed_distance(p);
                p -= n * (d - 1e-3 * random.unit());
            }
            let (d, n) = solid.signed_distance(p);
            let reference = reference::distance_to_triangles(&mesh, p);
            assert!(
                (d - reference).abs() < 1e-6,
                "{} points at {p}: {d} against {reference}",
                points.len()
            );
            assert!((n.length() - 1.0).abs() < 1e-9);
        }
    }
}

/// A tilted 2 mm plate made of points is the box it was made from, and has an inside.
#[test]
fn a_thin_hull_has_an_inside() {
    let solid = Solid::of(&*SharedShape::convex_hull(&plate()).unwrap()).unwrap();
    let turn = crate::math::DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.4);
    let mut random = Random(5);
    for _ in 0..10_000 {
        let local = random.vector() * DVec3::new(0.6, 0.003, 0.5);
        let (d, n) = solid.signed_distance(turn * local);
        let (reference, normal) = super::primitive::cuboid(local, DVec3::new(0.5, 0.001, 0.4));
        assert!(
            (d - reference).abs() < 2e-7,
            "{local}: {d} against {reference}"
        );
        // Within a rounding of the surface the normal near an edge is anyone's.
        if d.abs() > 1e-5 && (d > 0.0 || d < -1e-5 && local.y.abs() > 1e-5) {
            assert!((n - turn * normal).length() < 0.05, "{local}: {n}");
        }
    }
    assert!((solid.width() - 0.002).abs() < 1e-6);
    assert!(solid.signed_distance(DVec3::ZERO).0 < -0.000_999);
}

/// Where the distance is smooth the normal is its gradient, by central differences.
#[test]
fn normals_are_gradients() {
    for (name, shape) in convex().into_iter().chain(composites()) {
        let solid = Solid::of(&*shape).unwrap();
        let mut random = Random(11);
        let mut smooth = 0;
        for _ in 0..10_000 {
            let p = random.vector() * 1.2;
            let step = 1e-5;
            let difference = |axis: DVec3| {
                let ahead = solid.signed_distance(p + axis * step).0;
                (ahead - solid.signed_distance(p - axis * step).0) / (2.0 * step)
            };
            let gradient = DVec3::new(
                difference(DVec3::X),
                difference(DVec3::Y),
                difference(DVec3::Z),
            );
            // A kink within the step shortens the difference.
            if (gradient.length() - 1.0).abs() < 1e-4 {
                smooth += 1;
                let n = solid.signed_distance(p).1;
                assert!(
                    (n - gradient).length() < 2e-2,
                    "{name} at {p}: {n}, {gradient}"
                );
            }
        }
        assert!(smooth > 9000, "{name}: only {smooth} smooth points");
    }
}

/// From just inside to just outside, through the surface, the normal stays.
#[test]
fn the_normal_is_the_same_on_both_sides_of_the_surface() {
    for (name, shape) in convex().into_iter().chain(composites()) {
        let solid = Solid::of(&*shape).unwrap();
        let mut random = Random(13);
        let mut seen = 0;
        for _ in 0..10_000 {
            let start = random.vector() * 1.2;
            let (d, n) = solid.signed_distance(start);
            let on = start - n * d;
            // The foot of a point beside an edge lies on it, where the inside has another face.
            let (below, above) = (
                solid.signed_distance(on - n * 1e-5),
                solid.signed_distance(on + n * 1e-5),
            );
            if (below.0 + 1e-5).abs() > 1e-8 || (below.1 - above.1).length() > 1e-3 {
                continue;
            }
            seen += 1;
            for offset in [-1e-9, -1e-12, 0.0, 1e-12, 1e-9] {
                let (distance, normal) = solid.signed_distance(on + n * offset);
                assert!(
                    (distance - offset).abs() < 1e-12,
                    "{name} at {on}: {distance}"
                );
                assert!(
                    (normal - n).length() < 1e-3,
                    "{name} at {on} {offset}: {normal}, {n}"
                );
            }
        }
        assert!(seen > 100, "{name}: {seen}");
    }
}

/// Boxes that fill cells, against all cells one by one.
#[test]
fn voxels_agree_with_a_list_of_all_cells() {
    let solid = Solid::of(&*SharedShape::voxels(Vector::splat(0.25), &blob())).unwrap();
    let all = cells(&blob());
    let mut random = Random(17);
    for _ in 0..10_000 {
        let p = random.vector() * DVec3::new(2.5, 1.6, 2.5);
        let (d, n) = solid.signed_distance(p);
        let reference = reference::distance_to_cells(&all, 0.25, p);
        assert!((d - reference).abs() < 1e-9, "{p}: {d} against {reference}");
        assert!((n.length() - 1.0).abs() < 1e-9);
        // The normal leads to the surface.
        let foot = solid.signed_distance(p - n * d).0;
        assert!(foot.abs() < 1e-9, "{p}: {foot} at the foot");
    }
    assert_eq!(solid.width(), 0.25);
}

#[test]
fn far_from_voxels_and_deep_inside_them_there_is_an_answer() {
    let coords: Vec<IVector> = (0..24_i32.pow(3))
        .map(|i| IVector::new(i % 24, i / 24 % 24, i / 576))
        .collect();
    let solid = Solid::of(&*SharedShape::voxels(Vector::splat(0.1), &coords)).unwrap();
    let (d, n) = solid.signed_distance(DVec3::new(50.0, 1.23, 1.27));
    assert!((d - 47.6).abs() < 1e-5, "{d}");
    assert!((n - DVec3::X).length() < 1e-6, "{n}");
    let (d, n) = solid.signed_distance(DVec3::new(1.05, 1.21, 1.22));
    assert!((d + 1.05).abs() < 1e-6, "{d}");
    assert!((n - DVec3::NEG_X).length() < 1e-6, "{n}");
    // A lone cell a long way off: no table of all chunks between.
    let far = [IVector::ZERO, IVector::new(1_000_000, -1_000_000, 500_000)];
    let solid = Solid::of(&*SharedShape::voxels(Vector::ONE, &far)).unwrap();
    assert!((solid.signed_distance(DVec3::new(0.5, 3.0, 0.5)).0 - 2.0).abs() < 1e-9);
    assert!(
        (solid
            .signed_distance(DVec3::new(1e6 + 0.5, -1e6 - 0.25, 500_000.5))
            .0
            - 0.25)
            .abs()
            < 1e-9
    );
}

/// Two boxes side by side are one floor, an L has an inner edge: against all cells one by one.
#[test]
fn compounds_of_boxes_act_as_one_body() {
    let (_, few) = composites().swap_remove(0);
    let mut filled = Vec::new();
    for (x, y, z) in (0..8 * 4 * 8).map(|i| (i % 8 - 4, i / 8 % 4, i / 32 - 4)) {
        if y == 0 || x == -4 {
            filled.push(IVector::new(x, y, z));
        }
    }
    // The same of so many that they are looked for by a tree.
    let part = |cell: &IVector| {
        let middle = (cell.as_vec3() + 0.5) * 0.25;
        (
            Pose::from_translation(middle),
            SharedShape::cuboid(0.125, 0.125, 0.125),
        )
    };
    let many = SharedShape::compound(filled.iter().map(part).collect());
    let all = cells(&filled);
    for shape in [few, many] {
        act_as_one_body(&Solid::of(&*shape).unwrap(), &all);
    }
}

fn act_as_one_body(solid: &Solid, all: &(Vec<IVector>, Vec<IVector>)) {
    let mut random = Random(19);
    let mut inside = 0;
    for _ in 0..10_000 {
        let p = random.vector() * DVec3::new(1.2, 1.2, 1.2) + DVec3::Y * 0.3;
        let (d, n) = solid.signed_distance(p);
        let reference = reference::distance_to_cells(all, 0.25, p);
        assert!((d - reference).abs() < 1e-6, "{p}: {d} against {reference}");
        assert!((n.length() - 1.0).abs() < 1e-9);
        inside += usize::from(d < 0.0);
    }
    assert!(inside > 800, "{inside}");
    for x in [-5e-5, -1e-9, 0.0, 1e-9, 5e-5] {
        for depth in [1e-4, 1e-8, 0.0, -1e-8, -1e-4] {
            let (d, n) = solid.signed_distance(DVec3::new(x, 0.25 - depth, 0.1));
            assert!((d + depth).abs() < 1e-12, "{x}: {d} at depth {depth}");
            assert_eq!(n, DVec3::Y, "{x}, {depth}");
        }
    }
}

/// A ball that sticks out of a box: no face is a way out of its hidden half.
#[test]
fn hidden_parts_still_have_a_way_out() {
    let shape = SharedShape::compound(vec![
        (Pose::identity(), SharedShape::cuboid(1.0, 1.0, 1.0)),
        (Pose::translation(0.0, 1.0, 0.0), SharedShape::ball(0.5)),
    ]);
    let solid = Solid::of(&*shape).unwrap();
    let mut random = Random(23);
    for _ in 0..2000 {
        let p = random.vector() * 1.5;
        let (d, n) = solid.signed_distance(p);
        let ball = p.distance(DVec3::Y) - 0.5;
        let (cuboid, _) = super::primitive::cuboid(p, DVec3::ONE);
        assert_eq!(d < 0.0, ball.min(cuboid) < 0.0, "{p}: {d}");
        let end = p + n * (1e-5 - d);
        if d < 0.0 {
            let out =
                (end.distance(DVec3::Y) - 0.5).min(super::primitive::cuboid(end, DVec3::ONE).0);
            assert!(out > 0.0, "{p}: {d} along {n} ends {out} inside");
        }
    }
}

#[test]
fn surfaces_are_no_solids() {
    let triangle = SharedShape::triangle(Vector::ZERO, Vector::X, Vector::Y);
    let with_a_surface = SharedShape::compound(vec![
        (Pose::identity(), SharedShape::ball(1.0)),
        (Pose::identity(), triangle.clone()),
    ]);
    for shape in [
        triangle,
        with_a_surface,
        SharedShape::segment(Vector::X, Vector::Y),
    ] {
        assert!(Solid::of(&*shape).is_none());
        assert!(!Solid::takes(&*shape));
    }
    for (_, shape) in convex().into_iter().chain(composites()) {
        assert!(Solid::takes(&*shape));
    }
}
