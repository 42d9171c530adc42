//! Small bodies and worlds the tests share.

use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// A bar of springs along x, `n` springs over `length` m: total stiffness EA/L = `stiffness`, total mass `mass`, end
/// nodes of half a mass. Node 0 is at x = 0.
pub fn bar(n: usize, length: f32, stiffness: f32, mass: f32) -> Net {
    let node_mass = mass / n as f32;
    let nodes = (0..=n)
        .map(|i| {
            let share = if i == 0 || i == n { 0.5 } else { 1.0 };
            Node::new(
                Vector::new(length * i as f32 / n as f32, 0.0, 0.0),
                node_mass * share,
            )
        })
        .collect();
    let springs = (0..n as u32)
        .map(|i| Spring::new(i, i + 1, stiffness * n as f32))
        .collect();
    Net::new(nodes, springs)
}

/// A Rapier world without gravity and a step of `dt` s.
pub fn weightless(dt: f32) -> PhysicsWorld {
    let mut world = PhysicsWorld {
        gravity: Vector::ZERO,
        ..PhysicsWorld::default()
    };
    world.integration_parameters.dt = dt;
    world
}

/// Asserts `measured` against `expected` with a relative tolerance, naming all three.
#[track_caller]
pub fn close(what: &str, measured: f64, expected: f64, tolerance: f64) {
    let error = (measured - expected).abs() / expected.abs().max(f64::MIN_POSITIVE);
    assert!(
        error <= tolerance,
        "{what}: measured {measured}, expected {expected} to {tolerance}, off by {error:.3e}"
    );
}

/// A generator of numbers in [0, 1), the same in every run (Steele, Lea and Flood 2014: SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// A direction, all alike.
    pub fn direction(&mut self) -> Vector {
        loop {
            let [x, y, z] = [(); 3].map(|()| self.within(-1.0, 1.0) as f32);
            let v = Vector::new(x, y, z);
            if (0.1..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }
}
