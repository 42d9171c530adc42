//! The dropped block side by side with Rapier's own soft bodies: same nodes, mass, size, drop and floor, one run.
//!
//! `cargo bench --bench peers --features scenario` prints a CSV with milliseconds per frame of 1/60 s (median over runs, both
//! engines in turn, so that a noisy machine hits both) and the largest strain either body suffers. Rapier's block is
//! shown at its default stiffness and at stiffer ones, ours at a modulus that deforms no more. `crumple speed` has the
//! short form of it, with a cloth and a wall.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario::speed::clock::median;
use crumple::scenario::speed::native::{Native, floor, of_net};
use crumple::scenario::speed::peers::{ABOVE, BLOCK_MASS, Scene, falling};
use std::time::Instant;

const NODES: usize = 10;
const FRAMES: usize = 120;
const RUNS: usize = 7;

fn net() -> Net {
    lattice(Vector::ONE, 1.0 / (NODES - 1) as f32).expect("a lattice")
}

fn ours(young: f32) -> Box<dyn Scene> {
    falling(&net(), young).expect("the block is stable")
}

/// Distance constraints along the springs of our block.
fn edges() -> Box<dyn Scene> {
    let body = of_net(&net(), BLOCK_MASS).translated(ABOVE);
    Box::new(Native::new(floor(), body, Vector::ZERO))
}

/// Rapier's default: corotational tetrahedra with volume preservation.
fn cells(iterations: usize) -> Box<dyn Scene> {
    let mut world = floor();
    world.integration_parameters.num_solver_iterations = iterations;
    let body = SoftBodyBuilder::cuboid(ABOVE, Vector::splat(0.5), NODES, NODES, NODES);
    Box::new(Native::new(world, body.mass(BLOCK_MASS), Vector::ZERO))
}

/// Milliseconds per frame, and the largest strain.
fn run(mut scene: Box<dyn Scene>) -> (f64, f64) {
    let (mut spent, mut strain) = (0.0, 0.0_f64);
    for _ in 0..FRAMES {
        let start = Instant::now();
        scene.step();
        spent += start.elapsed().as_secs_f64();
        strain = strain.max(scene.strain());
    }
    (1e3 * spent / FRAMES as f64, strain)
}

fn main() {
    type Case = (&'static str, fn() -> Box<dyn Scene>);
    let cases: [Case; 6] = [
        ("crumple, E = 0.08 MPa", || ours(0.08e6)),
        ("crumple, E = 0.2 MPa", || ours(0.2e6)),
        ("crumple, E = 1 MPa", || ours(1e6)),
        ("rapier native, edges", edges),
        ("rapier native, cells", || cells(4)),
        ("rapier native, cells, 16 iterations", || cells(16)),
    ];
    let mut outcomes = vec![Vec::new(); cases.len()];
    for _ in 0..RUNS {
        for ((_, scene), outcomes) in cases.iter().zip(&mut outcomes) {
            outcomes.push(run(scene()));
        }
    }
    println!("case,ms_per_frame,max_strain");
    for ((name, _), outcomes) in cases.iter().zip(outcomes) {
        let time = median(outcomes.iter().map(|o| o.0));
        println!("\"{name}\",{time:.4},{:.4}", outcomes[0].1);
    }
}
