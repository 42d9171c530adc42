//! The scene `pile` side by side with Rapier's own soft bodies: the same rigid bodies, room, places, sizes, masses and
//! nodes in both.
//!
//! `cargo bench --bench pile --features scenario` prints a CSV: bodies whose middle is outside of the room at the end,
//! bodies that were ever lower than the ground, milliseconds per frame of 1/60 s, over several drops that differ by a
//! millionth of gravity: every heap falls together in its own way, and costs its own time. Rapier's soft bodies have their default
//! materials, which are not in N/m: what is compared is what gets lost and at what cost, not the shapes.

use crumple::rapier3d::prelude::*;
use crumple::scenario::pile::{BLOCK, ROOM, ROPE, ROPE_SPRINGS, SHEET, SHEET_NODES, places};
use crumple::scenario::speed::clock::{Clock, alone};
use crumple::scenario::{self, Run};

const FRAMES: usize = 180;
const DROPS: usize = 6;

struct Outcome {
    outside: usize,
    sunk: usize,
    ms_per_frame: f64,
}

/// Which bodies are outside of the room, and which have sunk into the ground.
fn strays(middles: impl Iterator<Item = Vector>) -> (usize, usize) {
    let (mut outside, mut sunk) = (0, 0);
    for at in middles {
        let inside = at.is_finite() && at.x.abs() < ROOM && at.z.abs() < ROOM && at.y > 0.0;
        outside += usize::from(!inside);
        sunk += usize::from(at.y < 0.0);
    }
    (outside, sunk)
}

fn build(drop: usize) -> Run {
    let scene = scenario::find("pile").expect("a scene of the catalog");
    let mut run = scene.build(&scene.options).expect("the catalog builds");
    run.world.gravity *= 1.0 + 1e-6 * drop as f32;
    run
}

fn rigid(world: &PhysicsWorld) -> impl Iterator<Item = Vector> {
    let bodies = world.bodies.iter().map(|(_, b)| b);
    let bodies = bodies.filter(|b| b.is_dynamic() && !b.is_soft_frame());
    bodies.map(|b| b.center_of_mass())
}

fn ours(drop: usize) -> Outcome {
    let mut run = build(drop);
    let mut spent = 0.0;
    for _ in 0..FRAMES {
        let clock = Clock::start();
        run.deformables.step(&mut run.world);
        spent += clock.spent().as_secs_f64();
    }
    let soft = run.deformables.iter();
    let soft = soft.map(|(_, b)| b.center_of_mass().as_vec3());
    let (outside, sunk) = strays(rigid(&run.world).chain(soft));
    Outcome {
        outside,
        sunk,
        ms_per_frame: 1e3 * spent / FRAMES as f64,
    }
}

/// Rapier's soft body for one of ours, by its name.
fn native(name: &str) -> SoftBodyBuilder {
    if name.starts_with("rope") {
        let end = Vector::X * (0.5 * ROPE[0]);
        SoftBodyBuilder::rope(-end, end, ROPE_SPRINGS + 1).particle_radius(0.5 * ROPE[1])
    } else if name.starts_with("sheet") {
        let cell = SHEET[0] / (SHEET_NODES - 1) as f32;
        let origin = Vector::new(-0.5 * SHEET[0], 0.0, -0.5 * SHEET[0]);
        let (u, v) = (Vector::X * cell, Vector::Z * cell);
        SoftBodyBuilder::cloth(origin, u, v, SHEET_NODES, SHEET_NODES)
            .particle_radius(0.5 * SHEET[1])
    } else {
        SoftBodyBuilder::cuboid(Vector::ZERO, 0.5 * BLOCK, 4, 4, 4)
    }
}

fn rapier(iterations: usize, drop: usize) -> Outcome {
    let Run {
        mut world,
        deformables,
        cast,
        ..
    } = build(drop);
    world.integration_parameters.num_solver_iterations = iterations;
    let poses = places().filter(|(_, soft)| *soft).map(|(pose, _)| pose);
    let handles: Vec<_> = cast
        .deformables
        .iter()
        .zip(poses)
        .map(|((name, handle), pose)| {
            let builder = native(name);
            let there = builder.particle_positions().iter().map(|x| pose * *x);
            let there = there.collect();
            let builder = builder.positions(there);
            world.insert_soft_body(builder.mass(deformables[*handle].mass() as f32))
        })
        .collect();
    let mut spent = 0.0;
    for _ in 0..FRAMES {
        let clock = Clock::start();
        world.step();
        spent += clock.spent().as_secs_f64();
    }
    let soft = handles.iter().map(|h| {
        let body = &world.soft_bodies[*h];
        let sum: Vector = body.particle_positions().sum();
        sum / body.num_particles() as f32
    });
    let (outside, sunk) = strays(rigid(&world).chain(soft));
    Outcome {
        outside,
        sunk,
        ms_per_frame: 1e3 * spent / FRAMES as f64,
    }
}

fn main() {
    alone(table);
}

fn table() {
    println!("case,drops,outside,sunk,ms_per_frame,least,most");
    let show = |case: &str, of_drop: &dyn Fn(usize) -> Outcome| {
        let all: Vec<Outcome> = (0..DROPS).map(of_drop).collect();
        let sum = |of: fn(&Outcome) -> usize| all.iter().map(of).sum::<usize>();
        let spent = || all.iter().map(|o| o.ms_per_frame);
        println!(
            "\"{case}\",{DROPS},{},{},{:.3},{:.3},{:.3}",
            sum(|o| o.outside),
            sum(|o| o.sunk),
            spent().sum::<f64>() / DROPS as f64,
            spent().fold(f64::INFINITY, f64::min),
            spent().fold(0.0, f64::max),
        );
    };
    for iterations in [4, 16] {
        let case = format!("rapier native, {iterations} iterations");
        show(&case, &|drop| rapier(iterations, drop));
    }
    show("crumple", &ours);
}
