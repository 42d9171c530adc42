//! The scene `pile` side by side with Rapier's own soft bodies: the same rigid bodies, room, places, sizes, masses and
//! nodes in both.
//!
//! `cargo bench --bench pile --features scenario` prints a CSV: bodies whose middle is outside of the room at the end,
//! bodies that were ever lower than the ground, strains of the edges of ropes, sheets and blocks (root mean square over the
//! drops), milliseconds per frame of 1/60 s, over several drops that differ by a millionth of gravity: every heap falls together
//! in its own way, and costs its own time. The materials of Rapier's soft bodies are not in N/m: they are shown with the default
//! ones, whose ropes and sheets are much softer than ours, and with stiffer ones.

use crumple::rapier3d::prelude::*;
use crumple::scenario::pile::{BLOCK, ROOM, ROPE, ROPE_SPRINGS, SHEET, SHEET_NODES, places};
use crumple::scenario::speed::clock::{Clock, alone};
use crumple::scenario::speed::native::Edges;
use crumple::scenario::{self, Run};

const FRAMES: usize = 180;
const DROPS: usize = 6;

struct Outcome {
    outside: usize,
    sunk: usize,
    strains: Strains,
    ms_per_frame: f64,
}

/// Kinds of bodies, as their names begin.
const KINDS: [&str; 3] = ["rope", "sheet", "block"];

/// Of each kind the sum of mean squares, and of how many.
#[derive(Clone, Copy, Default)]
struct Strains([(f64, usize); 3]);

impl Strains {
    fn add(&mut self, name: &str, mean_square: f64) {
        for (kind, (sum, count)) in KINDS.iter().zip(&mut self.0) {
            if name.starts_with(kind) {
                *sum += mean_square;
                *count += 1;
            }
        }
    }

    /// Root mean square of each kind.
    fn of(all: &[Outcome]) -> [f64; 3] {
        std::array::from_fn(|kind| {
            let each = all.iter().map(|o| o.strains.0[kind]);
            let (sum, count) = each.fold((0.0, 0), |(s, n), (sum, count)| (s + sum, n + count));
            (sum / count as f64).sqrt()
        })
    }
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
    let (mut spent, mut strains) = (0.0, Strains::default());
    let edges: Vec<Edges> = run
        .cast
        .deformables
        .iter()
        .map(|(_, handle)| {
            let body = &run.deformables[*handle];
            let places: Vec<Vector> = body.positions().collect();
            let springs = body.blueprint().springs.iter();
            Edges::new(springs.map(|s| s.nodes).collect(), &places)
        })
        .collect();
    for _ in 0..FRAMES {
        let clock = Clock::start();
        run.deformables.step(&mut run.world);
        spent += clock.spent().as_secs_f64();
        for ((name, handle), edges) in run.cast.deformables.iter().zip(&edges) {
            let places: Vec<Vector> = run.deformables[*handle].positions().collect();
            strains.add(name, edges.mean_square(|i| places[i as usize]));
        }
    }
    let soft = run.deformables.iter();
    let soft = soft.map(|(_, b)| b.center_of_mass().as_vec3());
    let (outside, sunk) = strays(rigid(&run.world).chain(soft));
    Outcome {
        outside,
        sunk,
        strains,
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

/// With so many iterations, and of so many oscillations a second \[Hz\] if not of the default material.
fn rapier(iterations: usize, frequency: Option<f32>, drop: usize) -> Outcome {
    let Run {
        mut world,
        deformables,
        cast,
        ..
    } = build(drop);
    world.integration_parameters.num_solver_iterations = iterations;
    let poses = places().filter(|(_, soft)| *soft).map(|(pose, _)| pose);
    let bodies: Vec<_> = cast
        .deformables
        .iter()
        .zip(poses)
        .map(|((name, handle), pose)| {
            let builder = native(name);
            let there = builder.particle_positions().iter().map(|x| pose * *x);
            let there = there.collect();
            let mut builder = builder.positions(there);
            if let Some(frequency) = frequency {
                let springs = SpringCoefficients::new(frequency, 1.0);
                builder = builder.material(SoftBodyMaterial::uniform(springs));
            }
            let edges = Edges::of_native(&builder);
            let builder = builder.mass(deformables[*handle].mass() as f32);
            (name, world.insert_soft_body(builder), edges)
        })
        .collect();
    let (mut spent, mut strains) = (0.0, Strains::default());
    for _ in 0..FRAMES {
        let clock = Clock::start();
        world.step();
        spent += clock.spent().as_secs_f64();
        for (name, body, edges) in &bodies {
            let body = &world.soft_bodies[*body];
            let place = |i| body.particle_position(i as usize);
            strains.add(name, edges.mean_square(place));
        }
    }
    let soft = bodies.iter().map(|(_, body, _)| {
        let body = &world.soft_bodies[*body];
        let sum: Vector = body.particle_positions().sum();
        sum / body.num_particles() as f32
    });
    let (outside, sunk) = strays(rigid(&world).chain(soft));
    Outcome {
        outside,
        sunk,
        strains,
        ms_per_frame: 1e3 * spent / FRAMES as f64,
    }
}

fn main() {
    alone(table);
}

fn table() {
    println!(
        "case,drops,outside,sunk,rope_strain,sheet_strain,block_strain,ms_per_frame,least,most"
    );
    let show = |case: &str, of_drop: &dyn Fn(usize) -> Outcome| {
        let all: Vec<Outcome> = (0..DROPS).map(of_drop).collect();
        let sum = |of: fn(&Outcome) -> usize| all.iter().map(of).sum::<usize>();
        let spent = || all.iter().map(|o| o.ms_per_frame);
        let [rope, sheet, block] = Strains::of(&all);
        println!(
            "\"{case}\",{DROPS},{},{},{rope:.4},{sheet:.4},{block:.4},{:.3},{:.3},{:.3}",
            sum(|o| o.outside),
            sum(|o| o.sunk),
            spent().sum::<f64>() / DROPS as f64,
            spent().fold(f64::INFINITY, f64::min),
            spent().fold(0.0, f64::max),
        );
    };
    for (iterations, frequency) in [
        (4, None),
        (16, None),
        (4, Some(120.0)),
        (16, Some(120.0)),
        (4, Some(1000.0)),
        (16, Some(1000.0)),
        (32, Some(1000.0)),
    ] {
        let mut case = format!("rapier native, {iterations} iterations");
        if let Some(frequency) = frequency {
            case += &format!(", {frequency} Hz");
        }
        show(&case, &|drop| rapier(iterations, frequency, drop));
    }
    show("crumple", &ours);
}
