//! V31: bars that collide end on.
//!
//! The bars are the exact one-dimensional chains of V09, with a thickness: the node at the end of one meets the end of the
//! last spring of the other, node on node.

use crate::support::{bar, close, weightless};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

const N: usize = 50;
const THICKNESS: f32 = 0.009;

/// Velocities of the centres of mass after a bar of 1 m/s has hit one at rest that is `ratio` times as long.
fn collide(ratio: usize) -> [f64; 2] {
    // EA = 1e4 N, ρA = 1 kg/m, so c = 100 m/s; a quarter of the limit h = Δx/c.
    let (dx, c) = (1.0 / N as f32, 100.0);
    let h = 0.25 * dx / c;
    let mut world = weightless(h * 20.0);
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = f64::from(h * 20.0);
    let mut insert = |n: usize, x: f32, v: f32| {
        let length = n as f32 * dx;
        let body = DeformableBuilder::new(bar(n, length, 1e4 / length, length))
            .thickness(THICKNESS)
            .friction(0.0)
            .translation(Vector::new(x, 0.0, 0.0))
            .linvel(Vector::new(v, 0.0, 0.0))
            .substeps(Substeps::Fixed(20));
        deformables.insert(body).unwrap()
    };
    let first = insert(N, -1.0 - THICKNESS - 1e-4, 1.0);
    let second = insert(N * ratio, 0.0, 0.0);
    let total = deformables[first].momentum() + deformables[second].momentum();
    for _ in 0..(0.1 / (h * 20.0)) as usize {
        deformables.step(&mut world);
    }
    let after = deformables[first].momentum() + deformables[second].momentum();
    assert!((after - total).length() < 1e-5 * total.length());
    [first, second].map(|b| deformables[b].linvel().x)
}

#[test]
fn v31_equal_bars_change_places() {
    let v = collide(1);
    close("velocity of the first [v0], +1", 1.0 + v[0], 1.0063, 0.02);
    close("velocity of the second [v0]", v[1], 0.9937, 0.02);
}

#[test]
fn v31_a_bar_on_one_of_twice_its_length() {
    let v = collide(2);
    close("velocity of the first [v0], +1", 1.0 - v[0], 1.0085, 0.02);
    close("velocity of the second [v0]", v[1], 0.5043, 0.02);
}
