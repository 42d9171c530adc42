//! What contact costs: whole steps of crash scenes against their force loops alone, and a block at rest on the ground.
//!
//! `cargo bench --bench throughput --features scenario` prints two CSV tables. Spring updates per second: one physical
//! spring, its force evaluated once, integration of its nodes included. Times are those of the thread, least of some runs.
//! `-- scenes` or `-- resting` prints one of them; a number leaves out blocks of more nodes.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario;
use crumple::scenario::speed::clock::Clock;
use crumple::solve::Solver;

const RUNS: usize = 3;

fn least(times: impl Iterator<Item = f64>) -> f64 {
    times.fold(f64::INFINITY, f64::min)
}

/// Seconds per substep of the bodies' springs alone, at rest.
fn force_loop(deformables: &DeformableWorld) -> f64 {
    let bodies = deformables.iter().map(|(_, body)| {
        let mut state = body.blueprint().rest_state();
        let mut solver = Solver::new(&body.blueprint().springs, &state);
        let count = 2_000_000 / body.spring_count().max(1) + 1;
        let mut chunk = || {
            let clock = Clock::start();
            for _ in 0..count {
                solver.substep(&mut state, Integrator::SymplecticEuler, 1e-7);
            }
            clock.spent().as_secs_f64() / count as f64
        };
        least((0..7).map(|_| chunk()))
    });
    bodies.sum()
}

/// Seconds and spring updates of a scene, with or without its recorder.
fn whole(scene: &scenario::Scene, duration: f64, recorded: bool) -> (f64, f64) {
    let mut options = scene.options;
    options.duration = duration;
    let mut run = scene.build(&options).expect("the catalog builds");
    let (mut spent, mut updates) = (0.0, 0.0);
    for _ in 0..run.total_steps() {
        let clock = Clock::start();
        if recorded {
            run.deformables
                .step_with(&mut run.world, &(), &(), &mut run.recorder);
        } else {
            run.deformables.step(&mut run.world);
        }
        spent += clock.spent().as_secs_f64();
        updates += run.deformables.report().spring_updates as f64;
    }
    (spent, updates)
}

fn scenes() {
    println!("scene,force_loop_M_per_s,whole_step_M_per_s,ratio,recorded_M_per_s");
    for (name, duration) in [("wall", 0.15), ("pole", 0.05), ("drop", 1.0), ("pile", 3.0)] {
        let scene = scenario::find(name).expect("a scene of the catalog");
        let built = scene.build(&scene.options).expect("the catalog builds");
        let springs: usize = built
            .deformables
            .iter()
            .map(|(_, b)| b.spring_count())
            .sum();
        let rate = |recorded| {
            let runs = (0..RUNS).map(|_| whole(scene, duration, recorded));
            1e-6 / least(runs.map(|(spent, updates)| spent / updates))
        };
        let (whole, recorded) = (rate(false), rate(true));
        let alone = 1e-6 * springs as f64 / force_loop(&built.deformables);
        let ratio = whole / alone;
        println!("{name},{alone:.1},{whole:.1},{ratio:.3},{recorded:.1}");
    }
}

/// Seconds per substep of a block of n³ nodes of 10 cm on the ground, or of the same one without ground and gravity; how
/// many nodes touch.
fn block(n: usize, ground: bool) -> (f64, u32) {
    let mut world = PhysicsWorld::default();
    let cell = 0.1;
    let side = cell * (n - 1) as f32;
    let floor = ground.then(|| {
        let body = RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0));
        world
            .insert(body, ColliderBuilder::cuboid(50.0, 0.5, 50.0))
            .1
    });
    if !ground {
        world.gravity = Vector::ZERO;
    }
    let mut deformables = DeformableWorld::default();
    let block = DeformableBuilder::new(lattice(Vector::splat(side), cell))
        .material(Material::elastic(5.0e5, 100.0).viscosity(500.0))
        .translation(Vector::Y * 0.5 * side);
    let block = deformables.insert(block).expect("the block is stable");
    world.integration_parameters.dt = 1.0 / 240.0;
    let mut step = |count: usize| {
        let clock = Clock::start();
        let mut updates = 0;
        for _ in 0..count {
            deformables.step(&mut world);
            updates += deformables.report().spring_updates;
        }
        let spent = clock.spent().as_secs_f64();
        spent * deformables[block].spring_count() as f64 / updates as f64
    };
    // The first step measures all distances; what the system tells of time has grains of milliseconds.
    let count = 1_000_000 / (n * n * n) + 1;
    step(count / 4 + 1);
    let time = least((0..3).map(|_| step(count)));
    let contact = floor.and_then(|f| deformables.contacts_with(f).next().copied());
    (time, contact.map_or(0, |c| c.touching))
}

fn resting(most: usize) {
    println!("nodes,touching,substep_us,without_contact_us,contact_us,ns_per_touching_node");
    for n in [10, 22, 46, 100] {
        if n * n * n > most {
            break;
        }
        let runs: Vec<_> = (0..RUNS)
            .map(|_| (block(n, true), block(n, false).0))
            .collect();
        let with = least(runs.iter().map(|r| r.0.0));
        let without = least(runs.iter().map(|r| r.1));
        let touching = runs[0].0.1;
        let each = 1e9 * (with - without) / f64::from(touching.max(1));
        println!(
            "{},{touching},{:.2},{:.2},{:.2},{each:.0}",
            n * n * n,
            1e6 * with,
            1e6 * without,
            1e6 * (with - without),
        );
    }
}

fn main() {
    let asked: Vec<String> = std::env::args().collect();
    let wants = |what: &str| asked.iter().any(|a| a == what);
    if !wants("resting") {
        scenes();
    }
    if !wants("scenes") {
        let most = asked.iter().find_map(|a| a.parse().ok());
        resting(most.unwrap_or(usize::MAX));
    }
}
