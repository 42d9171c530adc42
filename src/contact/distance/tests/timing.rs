//! What a query costs, printed: `cargo test --release what_queries_cost -- --ignored --nocapture`.

use super::super::Solid;
use super::reference::Random;
use super::{composites, convex};
use crate::math::DVec3;
use rapier3d::geometry::SharedShape;
use std::hint::black_box;
use std::time::Instant;

fn nanoseconds(points: &[DVec3], mut f: impl FnMut(DVec3)) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let start = Instant::now();
        for &p in points {
            f(p);
        }
        best = best.min(start.elapsed().as_secs_f64() * 1e9 / points.len() as f64);
    }
    best
}

#[test]
#[ignore = "prints times"]
fn what_queries_cost() {
    let boxed: Vec<_> = (0..8)
        .map(|i| super::super::edges::corner(i).as_vec3() * 0.5)
        .collect();
    let more = [("hull 8 points", SharedShape::convex_hull(&boxed).unwrap())];
    println!("ns: inside, within 1 cm outside, anywhere, cast of 5 cm, segment of 10 cm");
    for (name, shape) in convex().into_iter().chain(more).chain(composites()) {
        let solid = Solid::of(&*shape).unwrap();
        let mut random = Random(43);
        let far: Vec<DVec3> = (0..20_000).map(|_| random.vector() * 1.2).collect();
        let at = |height: &mut dyn FnMut() -> f64| -> Vec<DVec3> {
            far.iter()
                .map(|&p| {
                    let (d, n) = solid.signed_distance(p);
                    p + n * (height() - d)
                })
                .collect()
        };
        let near = at(&mut || 0.01 * random.unit());
        let inside = at(&mut || -0.0005);
        let ask = |p: DVec3| {
            black_box(solid.signed_distance(black_box(p)));
        };
        let step = DVec3::new(0.02, -0.04, 0.02);
        println!(
            "{name:15} {:6.1} {:6.1} {:6.1} {:6.1} {:6.1}",
            nanoseconds(&inside, ask),
            nanoseconds(&near, ask),
            nanoseconds(&far, ask),
            nanoseconds(&near, |p| {
                black_box(solid.cast(black_box(p), p + step));
            }),
            nanoseconds(&near, |p| {
                black_box(solid.nearest_on_segment(black_box(p - step), p + step));
            }),
        );
    }
}
