//! What contact costs: whole steps of crash scenes against their force loops alone, and a block at rest on the ground.
//!
//! `cargo bench --bench throughput --features scenario` prints three CSV tables. Spring updates per second: one physical
//! spring, its force evaluated once, integration of its nodes included. Times are those of the thread, least of some runs.
//! `-- scenes`, `-- resting` or `-- building` prints one of them; a number leaves out blocks of more nodes. The third is how long
//! it takes to build a body of a million springs, and what memory it takes.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario;
use crumple::scenario::speed::clock::{Clock, alone};
use crumple::scenario::speed::subject::shuffled;
use crumple::shape::{TetSplit, tet_box_of_cells};
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

/// Bytes that the process has in memory (Linux).
fn resident() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|l| l.starts_with("VmRSS:"));
    let kib = line.and_then(|l| l.split_whitespace().nth(1)?.parse::<f64>().ok());
    kib.map_or(f64::NAN, |kib| 1024.0 * kib)
}

fn building() {
    println!("body,springs,net_s,body_s,first_step_s,hot_bytes_per_spring,bytes_per_spring");
    let elastic = Material::elastic(5.0e5, 100.0);
    let plastic = elastic.yielding(1e5, 0.0);
    let mesh = || {
        let mesh = tet_box_of_cells(Vector::ONE, [53; 3], TetSplit::Six).expect("a box");
        shuffled(&mesh.springs())
    };
    let bodies: [(&str, &dyn Fn() -> Net); 2] = [
        ("lattice", &|| {
            lattice(Vector::ONE, 1.0 / 43.0).expect("a lattice")
        }),
        ("mesh without order", &mesh),
    ];
    for (name, net) in bodies {
        for (kind, material) in [("plain", elastic), ("yields", plastic)] {
            let before = resident();
            let clock = Clock::start();
            let net = net();
            let made = clock.spent().as_secs_f64();
            let mut deformables = DeformableWorld::default();
            let body = deformables
                .insert(DeformableBuilder::new(net).material(material))
                .expect("the body is stable");
            let built = clock.spent().as_secs_f64();
            let mut world = PhysicsWorld::default();
            world.integration_parameters.dt = 1e-5;
            deformables.step(&mut world);
            let stepped = clock.spent().as_secs_f64();
            let springs = deformables[body].spring_count() as f64;
            println!(
                "{name} {kind},{springs},{made:.2},{:.2},{:.2},{:.0},{:.0}",
                built - made,
                stepped - built,
                hot(&deformables[body]) / springs,
                (resident() - before) / springs,
            );
        }
    }
}

/// Bytes that a substep without yielding reads or writes.
fn hot(body: &Deformable) -> f64 {
    let mut state = body.blueprint().rest_state();
    let mut solver = Solver::new(&body.blueprint().springs, &state);
    solver.substep(&mut state, Integrator::SymplecticEuler, 1e-7);
    let nodes = 80 * body.node_count();
    (solver.table_bytes()[0] + nodes) as f64
}

fn main() {
    alone(tables);
}

fn tables() {
    let asked: Vec<String> = std::env::args().collect();
    let wants = |what: &str| asked.iter().any(|a| a == what);
    let all = !["scenes", "resting", "building"].iter().any(|w| wants(w));
    if all || wants("building") {
        building();
    }
    if all || wants("scenes") {
        scenes();
    }
    if all || wants("resting") {
        let most = asked.iter().find_map(|a| a.parse().ok());
        resting(most.unwrap_or(usize::MAX));
    }
}
