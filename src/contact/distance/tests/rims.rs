//! Crossings with the rims of cylinders and cones, against walks along the segment.

use super::reference::Random;
use crate::contact::distance::Solid;
use crate::contact::distance::crossing::Crossing;
use crate::math::DVec3;
use rapier3d::geometry::SharedShape;

/// Half height and radius \[m\].
const SIZE: [f64; 2] = [0.2, 0.3];

fn crossings(shape: &SharedShape, a: DVec3, b: DVec3, within: f64) -> Vec<Crossing> {
    let (solid, mut found) = (Solid::of(&**shape).unwrap(), Vec::new());
    solid.for_each_crossing(a, b, within, &mut |c| found.push(c));
    found
}

/// Where a segment comes nearest to the circle at a height y, and how it lies to it there: outwards and upwards \[m\].
fn walk(at: impl Fn(f64) -> DVec3, y: f64, steps: usize) -> Vec<(f64, [f64; 2])> {
    let way = |i: usize| {
        let p = at(i as f64 / steps as f64);
        [p.x.hypot(p.z) - SIZE[1], p.y - y]
    };
    let far = |i: usize| way(i)[0].hypot(way(i)[1]);
    (1..steps)
        .filter(|&i| far(i) < far(i - 1) && far(i) <= far(i + 1))
        .map(|i| (i as f64 / steps as f64, way(i)))
        .collect()
}

/// What crosses a rim does so where it comes nearest, and wherever it comes nearest between the normals of cap and mantle
/// there is a crossing.
#[test]
fn rims_are_crossed_where_a_segment_comes_nearest() {
    const STEPS: usize = 400;
    let step = 1.5 / STEPS as f64;
    let [height, radius] = SIZE;
    let cone = [1.0, 0.5 * radius / height];
    for (shape, rims) in [
        (
            SharedShape::cylinder(height as f32, radius as f32),
            vec![(height, [1.0, 0.0]), (-height, [1.0, 0.0])],
        ),
        (
            SharedShape::cone(height as f32, radius as f32),
            vec![(-height, cone)],
        ),
    ] {
        let solid = Solid::of(&*shape).unwrap();
        let (mut random, mut met, mut due) = (Random(1), 0, 0);
        for _ in 0..10_000 {
            // Past a point at a rim, at any angle.
            let turn = std::f64::consts::TAU * random.unit();
            let on = DVec3::new(turn.cos() * radius, -height, turn.sin() * radius);
            let d = random.vector().normalize() * (0.05 + 0.1 * random.unit());
            let a = on + random.vector() * 0.01 - d * random.unit();
            let at = |t: f64| a + d * t;
            let found = crossings(&shape, a, a + d, 0.02);
            // What bounds the distance of edges from rims: they are parts of the surface.
            let from = solid.nearest_on_segment(a, a + d).1;
            for &(y, _) in &rims {
                let far = |t: f64| (at(t).x.hypot(at(t).z) - radius).hypot(at(t).y - y);
                let least = (0..=STEPS).map(|i| far(i as f64 / STEPS as f64));
                let least = least.fold(f64::INFINITY, f64::min);
                assert!(from < least + 1e-7, "{from} of {least}");
            }
            let mut walked = Vec::new();
            for &(y, mantle) in &rims {
                for (t, [out, up]) in walk(at, y, STEPS) {
                    // In terms of the normals of mantle and cap, of either sign.
                    let length = out.hypot(up);
                    let mantle_part = out / mantle[0];
                    let cap_part = (up - mantle_part * mantle[1]) * y.signum();
                    walked.push((t, length));
                    let least = mantle_part.min(cap_part).max(-mantle_part.max(cap_part));
                    // The walk is coarse: nearer, the direction is not known.
                    if (0.002..0.015).contains(&length) && least > 0.2 * length {
                        due += 1;
                        let near = |c: &Crossing| (c.t - t).abs() < step;
                        assert!(found.iter().any(near), "{a} {d} at {t}, {length} off");
                    }
                }
            }
            for c in &found {
                met += 1;
                let p = at(c.t);
                let far = |y: f64| (p.x.hypot(p.z) - radius).hypot(p.y - y);
                let far = rims
                    .iter()
                    .map(|rim| far(rim.0))
                    .fold(f64::INFINITY, f64::min);
                // The shapes are of f32.
                assert!((c.distance.abs() - far).abs() < 1e-7, "{c:?}: {far}");
                assert!(c.normal.dot(d).abs() < 1e-12 && (c.normal.length() - 1.0).abs() < 1e-12);
                let at_end = c.t < step || c.t > 1.0 - step;
                let near = |w: &(f64, f64)| (w.0 - c.t).abs() < step;
                assert!(at_end || walked.iter().any(near), "{c:?} {walked:?}");
            }
        }
        assert!(met > 2000 && due > 1000, "{met} {due}");
    }
}

/// A segment that touches the mantle far from the caps is at no rim, however little it dips in.
#[test]
fn a_segment_on_the_mantle_crosses_no_rim() {
    let shape = SharedShape::cylinder(SIZE[0] as f32, SIZE[1] as f32);
    for dip in [-1e-9, 0.0, 1e-9, 1e-6, 1e-3] {
        for tilt in [0.0, 4e-4, -4e-4, 0.1] {
            let a = DVec3::new(SIZE[1] - dip, 0.05, -0.06);
            let b = a + DVec3::new(0.0, tilt, 1.0) * 0.12;
            assert_eq!(crossings(&shape, a, b, 0.1), [], "{dip} {tilt}");
        }
    }
}
