//! How long a node takes.

use super::*;
use std::time::Instant;

#[test]
#[ignore = "prints times; run alone"]
fn nanoseconds_per_node() {
    let half = DVec3::splat(0.5);
    let soup = soup(&box_mesh(half, 20, TriMeshFlags::empty()));
    let mut random = Random(61);
    for (what, low, high, fall) in [
        ("near", 2e-3, 8e-3, 1e-4),
        ("about to touch", 1e-5, 1e-4, 2e-4),
        ("resting", 0.0, 0.0, 2.5e-6),
    ] {
        let nodes: Vec<DVec3> = (0..1000)
            .map(|_| {
                let y = 0.5 + low + (high - low) * random.next().abs();
                DVec3::new(0.4 * random.next(), y, 0.4 * random.next())
            })
            .collect();
        let mut list = NodeFacets::default();
        let start = Instant::now();
        list.gather(
            &soup,
            nodes.iter().enumerate().map(|(i, &p)| (i as u32, p)),
            0.012,
        );
        let gather = start.elapsed().as_secs_f64() * 1e6;
        let facets: usize = (0..nodes.len()).map(|i| list.near(i).slots.len()).sum();
        let mut anchors = vec![None; nodes.len()];
        let mut out = Touches::default();
        let (mut count, mut best) = (0, f64::INFINITY);
        for _ in 0..50 {
            let start = Instant::now();
            for (k, &i) in list.nodes().iter().enumerate() {
                let i = i as usize;
                touches(
                    list.near(k),
                    nodes[i],
                    DVec3::Y * -fall,
                    anchors[i],
                    0.0,
                    0.01,
                    &mut out,
                );
                anchors[i] = out.anchor;
                count += out.as_slice().len();
            }
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!(
            "{what}: {:.1} facets, {:.0} ns a node, {:.0} ns to gather, {count} touches",
            facets as f64 / nodes.len() as f64,
            best * 1e9 / nodes.len() as f64,
            gather,
        );
        assert!(count > 0);
    }
}
