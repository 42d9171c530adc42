//! Casts and segments against many points on them.

use super::super::Solid;
use super::reference::Random;
use super::{composites, convex};
use crate::math::DVec3;
use rapier3d::geometry::SharedShape;
use rapier3d::math::Vector;

/// Nodes at 5 to 100 m/s in steps of 1 ms, from within 5 cm of the surface.
#[test]
fn fast_nodes_never_pass_through() {
    for (name, shape) in convex().into_iter().chain(composites()) {
        let solid = Solid::of(&*shape).unwrap();
        let mut random = Random(29);
        let mut hits = 0;
        for _ in 0..10_000 {
            let mut a = random.vector() * 1.2;
            let (d, n) = solid.signed_distance(a);
            a += n * (0.05 * random.unit() - d);
            let speed = 5.0 + 95.0 * random.unit();
            let aim = random.vector().normalize() - n * random.unit();
            let b = a + aim.normalize() * speed * 1e-3;
            let cast = solid.cast(a, b);
            let inside = |t: f64| solid.signed_distance(a + (b - a) * t).0 < -1e-9;
            if inside(0.0) {
                assert_eq!(cast, None, "{name} from {a} to {b}");
                continue;
            }
            let samples = 200;
            let first = (0..=samples)
                .map(|i| f64::from(i) / f64::from(samples))
                .find(|&t| inside(t));
            if let Some(first) = first {
                hits += 1;
                let (t, _) = cast.unwrap_or_else(|| panic!("{name} missed from {a} to {b}"));
                assert!(
                    t <= first + 1e-9,
                    "{name} from {a} to {b}: {t}, inside at {first}"
                );
            }
            if let Some((t, normal)) = cast {
                let at = solid.signed_distance(a + (b - a) * t).0;
                assert!(at.abs() < 1e-8, "{name} from {a} to {b}: {at} at {t}");
                assert!(normal.dot(b - a) < 0.0);
            }
        }
        assert!(hits > 500, "{name}: only {hits}");
    }
}

/// Straight through a 2 mm plate and a 1 cm capsule: every one is seen, and at the right place.
#[test]
fn thin_solids_are_entered_where_they_begin() {
    let plate = Solid::of(&*SharedShape::cuboid(0.5, 0.001, 0.5)).unwrap();
    let pole = Solid::of(&*SharedShape::capsule_z(0.5, 0.005)).unwrap();
    let mut random = Random(31);
    for _ in 0..10_000 {
        let (x, z) = (0.9 * random.unit() - 0.45, 0.9 * random.unit() - 0.45);
        let (a, b) = (DVec3::new(x, 0.05, z), DVec3::new(x, -0.05, z));
        let (t, n) = plate.cast(a, b).unwrap();
        assert!((t - 0.49).abs() < 1e-9 && n == DVec3::Y, "{t} {n}");
        let x = 0.00999 * (random.unit() - 0.5);
        let (a, b) = (DVec3::new(x, 0.05, z), DVec3::new(x, -0.05, z));
        let (t, _) = pole.cast(a, b).unwrap();
        let top = (2.5e-5 - x * x).sqrt();
        assert!((t - (0.05 - top) / 0.1).abs() < 1e-6, "{x}: {t}");
    }
    // From the surface itself, in and away.
    let on = DVec3::new(0.1, f64::from(0.001_f32), 0.1);
    assert_eq!(plate.cast(on, on - DVec3::Y), Some((0.0, DVec3::Y)));
    assert_eq!(plate.cast(on, on + DVec3::Y), None);
    let cells = Solid::of(&*SharedShape::voxels(
        Vector::ONE,
        &[rapier3d::math::IVector::ZERO],
    ))
    .unwrap();
    for axis in DVec3::AXES {
        let on = DVec3::splat(0.5) * (DVec3::ONE - axis);
        assert_eq!(cells.cast(on, on + axis * 3.0), Some((0.0, -axis)));
        assert_eq!(cells.cast(on, on - axis), None);
        assert_eq!(cells.cast(on - axis, on + axis * 3.0), Some((0.25, -axis)));
    }
}

#[test]
fn segments_come_nearest_where_sampling_says() {
    for (name, shape) in convex() {
        let solid = Solid::of(&*shape).unwrap();
        let mut random = Random(37);
        let (mut outside, mut between) = (0, 0);
        for _ in 0..2000 {
            let a = random.vector() * 1.2;
            let b = a + random.vector() * 0.8;
            let (t, d, n) = solid.nearest_on_segment(a, b);
            let at = |t: f64| solid.signed_distance(a + (b - a) * t).0;
            let least = (0..=200)
                .map(|i| at(f64::from(i) / 200.0))
                .fold(f64::INFINITY, f64::min);
            assert!(
                at(t) <= least + 1e-8,
                "{name} {a} {b}: {} at {t}, {least}",
                at(t)
            );
            assert!((n.length() - 1.0).abs() < 1e-9);
            if d > 1e-9 {
                outside += 1;
                assert!((d - at(t)).abs() < 1e-8, "{name} {a} {b}: {d} at {t}");
                let raw = solid.signed_distance(a + (b - a) * t).1;
                assert!((n - raw).length() < 1e-3, "{name} {a} {b}: {n} {raw}");
            }
            if t > 1e-6 && t < 1.0 - 1e-6 && d > 1e-9 {
                between += 1;
                let along = n.dot((b - a).normalize());
                assert!(along.abs() < 1e-9, "{name} {a} {b}: {n} leans by {along}");
            }
        }
        assert!(outside > 100 && between > 30, "{name}: {outside} {between}");
    }
}

/// A segment across an edge of a box, 1 mm deep: the normal is perpendicular to both.
#[test]
fn across_an_edge_the_normal_is_the_edges() {
    let half = DVec3::new(1.0, 1.0, 2.0);
    let solid = Solid::of(&*SharedShape::cuboid(1.0, 1.0, 2.0)).unwrap();
    for depth in [-1e-3, 1e-3, 0.02] {
        let normal = DVec3::new(0.6, 0.8, 0.0);
        let middle = DVec3::new(half.x, half.y, 0.3) - normal * depth;
        let run = DVec3::new(0.8, -0.6, 0.5).normalize();
        let (t, d, n) = solid.nearest_on_segment(middle - run * 0.4, middle + run * 0.6);
        assert!((n - normal).length() < 1e-4, "{depth}: {n}");
        assert!((d + depth).abs() < 1e-8, "{depth}: {d}");
        assert!((t - 0.4).abs() < 1e-2, "{depth}: {t}");
    }
}

/// Every point of the surface is below the supporting plane, the foot of an outer point on it.
#[test]
fn supports_and_boxes_hold_the_surface() {
    for (name, shape) in convex() {
        let solid = Solid::of(&*shape).unwrap();
        let (lo, hi) = solid.bounds();
        let mut random = Random(41);
        let mut features = Vec::new();
        for _ in 0..2000 {
            let p = random.vector() * 2.0;
            let (d, n) = solid.signed_distance(p);
            let on = p - n * d;
            assert!(
                (on - lo).min_element() > -1e-6 && (hi - on).min_element() > -1e-6,
                "{name}"
            );
            if d > 0.0 {
                let depth = solid.depth_along(p, n).unwrap();
                assert!(
                    (depth + d).abs() < 1e-6,
                    "{name} at {p}: {depth} against {d}"
                );
                // The lowest feature towards p is the support.
                features.clear();
                solid.feature_points(-n, &mut features);
                let far = features
                    .iter()
                    .map(|f| f.dot(n))
                    .fold(f64::NEG_INFINITY, f64::max);
                let support = solid.support(n).unwrap().dot(n);
                // A box elsewhere meets one by growing that much, and not before.
                let from = random.vector() * 2.0;
                let apart = solid.points_apart(from, from);
                let needed = |f: &DVec3| (*f - from).abs().max_element();
                let needed = features.iter().map(needed).fold(f64::INFINITY, f64::min);
                assert!(apart <= needed + 1e-9, "{name}: {apart} of {needed}");
                assert!(
                    (far - support).abs() < 1e-9,
                    "{name} at {p}: {far} against {support}"
                );
                // Where the normal changes beside the foot, there is more than one flat face.
                let beside = solid.signed_distance(p + random.vector() * 1e-4).1;
                if (beside - n).length() > 1e-7 {
                    let probe = DVec3::splat(1e-3);
                    let apart = |from: DVec3| solid.edges_apart(from - probe, from + probe);
                    assert!(apart(on) <= 0.0, "{name} at {on}");
                    // A box elsewhere meets it by growing that much, and not before.
                    let from = random.vector() * 2.0;
                    let needed = (on - from).abs().max_element() - probe.x;
                    assert!(apart(from) <= needed + 1e-9, "{name} at {on} from {from}");
                }
            }
        }
        assert!(solid.edges_apart(hi * 2.0, hi * 3.0) > 0.0, "{name}");
    }
}

#[test]
fn the_middle_of_a_floor_has_no_edges() {
    let box_at = |p: DVec3| (p - DVec3::splat(0.2), p + DVec3::splat(0.2));
    let middle = box_at(DVec3::new(1.0, 0.5, -2.0));
    let edge = box_at(DVec3::new(4.9, 0.5, 0.0));
    let hull: Vec<Vector> = (0..8)
        .map(|i| super::super::edges::corner(i).as_vec3() * Vector::new(5.0, 0.5, 5.0))
        .collect();
    for shape in [
        SharedShape::cuboid(5.0, 0.5, 5.0),
        SharedShape::cylinder(0.5, 5.0),
        SharedShape::convex_hull(&hull).unwrap(),
    ] {
        let solid = Solid::of(&*shape).unwrap();
        assert!(solid.edges_apart(middle.0, middle.1) > 0.5, "{solid:?}");
        assert!(solid.edges_apart(edge.0, edge.1) <= 0.0, "{solid:?}");
    }
    let ground = Solid::of(&*SharedShape::halfspace(Vector::Y)).unwrap();
    assert_eq!(ground.edges_apart(-DVec3::ONE, DVec3::ONE), f64::INFINITY);
}
