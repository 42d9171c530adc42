//! Boxes and shapes, against loops over all faces.

use super::brute::{ALL, Dice, apart, faces, shaken, winding};
use crate::fixtures::cube;
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::parry::shape::{Ball, Capsule, Cone, Cuboid, Cylinder, HalfSpace};
use crumple::rapier3d::prelude::*;

#[test]
fn boxes_find_what_reaches_into_them() {
    let mut set = DeformableWorld::new();
    let block = shaken(&mut set, Vector::ZERO);
    let rope = rope(
        Vector::new(2.0, -1.0, 0.0),
        Vector::new(2.0, 1.0, 0.0),
        4,
        1e-4,
    );
    let rope = set
        .insert(DeformableBuilder::new(rope).material(Material::rubber()))
        .unwrap();
    let found = |lo: Vector, hi: Vector, filter| set.intersect_aabb(Aabb::new(lo, hi), filter);
    let cube = |at: Vector, half: f32| found(at - half, at + half, ALL);
    assert_eq!(cube(Vector::ZERO, 10.0), [block, rope]);
    assert_eq!(found(Vector::MIN, Vector::MAX, ALL), [block, rope]);
    assert_eq!(cube(Vector::ZERO, 0.01), [block], "wholly inside");
    assert_eq!(cube(Vector::new(0.6, 0.0, 0.0), 0.1), [block]);
    assert_eq!(cube(Vector::new(0.8, 0.0, 0.0), 0.1), []);
    assert_eq!(cube(Vector::new(2.0, 0.3, 0.0), 0.001), [rope]);
    let beside = (Vector::new(2.02, -0.1, -0.1), Vector::new(2.1, 0.1, 0.1));
    assert_eq!(found(beside.0, beside.1, ALL), []);
    assert_eq!(found(beside.0, beside.1, ALL.line_radius(0.03)), [rope]);
    // Against sampling: a box meets the block where any of a grid of its points does.
    let mut dice = Dice(21);
    let faces = faces(&set[block]);
    let mut met = 0;
    for _ in 0..300 {
        let (at, half) = (dice.vector(0.9), 0.12);
        let hit = cube(at, half).contains(&block);
        met += usize::from(hit);
        let mut nearest = f64::INFINITY;
        for i in 0..343 {
            let step = |i: i32| (i % 7 - 3) as f32 / 3.0 * half;
            let p = (at + Vector::new(step(i), step(i / 7), step(i / 49))).as_dvec3();
            let gap = if winding(&faces, p) > 0.5 {
                0.0
            } else {
                faces
                    .iter()
                    .map(|f| apart(p, *f))
                    .fold(f64::INFINITY, f64::min)
            };
            nearest = nearest.min(gap);
        }
        // No point of a box is farther from the grid than half a cell's diagonal.
        assert!(hit || nearest > 0.0, "{at}");
        assert!(!hit || nearest < 0.04 * 0.87, "{at} {nearest}");
    }
    assert!((50..250).contains(&met), "{met}");
}

#[test]
fn shapes_touch_faces_and_lie_inside() {
    let mut set = DeformableWorld::new();
    let block = set.insert(cube(0.6)).unwrap();
    let touched = |at: Vector, shape: &dyn Shape| {
        let mut found = set.intersect_shape(&Pose::from_translation(at), shape, ALL);
        assert!(found.len() <= 1);
        found.pop().map(|f| f.features.len())
    };
    let ball = Ball::new(0.1);
    assert_eq!(touched(Vector::Y * 0.41, &ball), None);
    assert!(touched(Vector::Y * 0.39, &ball).unwrap() >= 1);
    assert_eq!(touched(Vector::ZERO, &ball), Some(0), "wholly inside");
    let all = set[block].blueprint().faces.len();
    assert_eq!(
        touched(Vector::ZERO, &Cuboid::new(Vector::splat(9.0))),
        Some(all)
    );
    let ground = HalfSpace::new(Vector::Y);
    assert_eq!(touched(Vector::Y * -0.31, &ground), None);
    assert!(touched(Vector::Y * -0.29, &ground).unwrap() >= 18);
    // A ball against the distance by a loop.
    let faces = faces(&set[block]);
    let mut dice = Dice(33);
    for _ in 0..2000 {
        let at = dice.vector(0.6);
        let found = set.intersect_shape(&Pose::from_translation(at), &ball, ALL);
        let near = |f: &[DVec3; 3]| apart(at.as_dvec3(), *f);
        let (sure, maybe) = (0.1 - 1e-5, 0.1 + 1e-5);
        let features = found.first().map_or(&[][..], |f| &f.features);
        for (i, face) in (0..).zip(&faces) {
            let has = features.contains(&Feature::Face(i));
            assert!(has || near(face) > sure, "{at} {i}");
            assert!(!has || near(face) < maybe, "{at} {i}");
        }
    }
}

/// Symptom: a cylinder of 0.3 mm was told to touch a sheet across a gap of 0.1 mm: parry's tolerances are lengths. In millimetres
/// and in metres shapes touch the same faces.
#[test]
fn shapes_touch_alike_at_every_size() {
    let faces_of = |size: f32| {
        let mut set = DeformableWorld::new();
        let net = sheet(0.4 * size, 0.4 * size, 5, 5, 0.01 * size).unwrap();
        let sheet = DeformableBuilder::new(net).material(Material::elastic(1e6, 1e3));
        set.insert(sheet).unwrap();
        let mut dice = Dice(5);
        let mut found = Vec::new();
        for _ in 0..400 {
            let (at, turn) = (dice.vector(0.3) * size, dice.vector(3.0));
            let pose = Pose::new(at, turn);
            let shapes: [&dyn Shape; 4] = [
                &Cylinder::new(0.12 * size, 0.1 * size),
                &Capsule::new_y(0.12 * size, 0.1 * size),
                &Cone::new(0.12 * size, 0.1 * size),
                &Ball::new(0.1 * size),
            ];
            let touched = shapes.map(|shape| {
                let found = set.intersect_shape(&pose, shape, ALL).pop();
                found.map_or(0, |f| f.features.len())
            });
            found.push(touched);
        }
        found
    };
    let (large, small) = (faces_of(1.0), faces_of(1e-3));
    let touching = large.iter().flatten().filter(|n| **n > 0).count();
    assert!((100..1500).contains(&touching), "{touching}");
    // Which are just touched is a matter of rounding.
    let pairs = || large.iter().zip(&small);
    let others = pairs().filter(|(l, s)| l != s).count();
    let wrong = pairs().filter(|(l, s)| (0..4).any(|k| (l[k] == 0) != (s[k] == 0)));
    assert!(others <= 4, "{others}");
    assert_eq!(wrong.count(), 0);
}
