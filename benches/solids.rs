//! Solids of tets side by side with Rapier's own, engines in turn in one run, median over runs: blocks of 10³ and 20³ nodes
//! (1 m, 100 kg) in the same tets with the same E and ν, dropped 1 m or thrown at the floor from just above it; rubber bodies
//! of 5,000 tets; and a cantilever, with the error of its deflection.
//!
//! `cargo bench --bench solids --features native-fem` prints a CSV. What takes longer than 20 s is run once. With words behind
//! `--`, only cases that have them in their names.

#[path = "solids/beam.rs"]
mod beam;
#[path = "solids/outcome.rs"]
mod outcome;

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box_of_cells};
use outcome::{Clock, Outcome};
use std::time::Instant;

const MASS: f32 = 100.0;
const POISSON: f64 = 0.3;
const RUNS: usize = 3;
/// Seconds.
const LONG: f64 = 20.0;

/// How a block comes to the floor.
#[derive(Clone, Copy)]
struct Fall {
    /// Of its lower side \[m\].
    height: f32,
    /// Downwards \[m/s\].
    speed: f32,
    frames: usize,
}

/// Two seconds, some of them in the air.
const DROP: Fall = Fall {
    height: 1.0,
    speed: 0.0,
    frames: 120,
};

/// As fast as it is after 1 m, until it is off the floor again.
const IMPACT: Fall = Fall {
    height: 1e-3,
    speed: 4.43,
    frames: 6,
};

fn floor() -> PhysicsWorld {
    let mut world = PhysicsWorld::default();
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(10.0, 0.5, 10.0),
    );
    world
}

/// A box of `cells` in tets of one kind.
fn mesh(size: Vector, cells: [u32; 3], quadratic: bool) -> TetMesh {
    let mesh = tet_box_of_cells(size, cells, TetSplit::Six).expect("a box");
    if quadratic { mesh.quadratic() } else { mesh }
}

/// A block of `side` m of `cells`³·6 tets.
fn ours(solid: Solid, side: f32, cells: u32, quadratic: bool, fall: Fall) -> Outcome {
    let mut world = floor();
    let mesh = mesh(Vector::splat(side), [cells; 3], quadratic);
    let mut deformables = DeformableWorld::default();
    let builder = DeformableBuilder::tets(mesh, solid)
        .translation(Vector::new(0.0, fall.height + 0.5 * side, 0.0))
        .linvel(Vector::new(0.0, -fall.speed, 0.0));
    let body = deformables.insert(builder).expect("stable");
    let (mut clock, mut updates) = (Clock::new(f64::from(-fall.speed)), 0);
    for _ in 0..fall.frames {
        let start = Instant::now();
        deformables.step(&mut world);
        let seconds = start.elapsed().as_secs_f64();
        let body = &deformables[body];
        clock.frame(seconds, body.momentum().y / body.mass(), body.max_strain());
        updates += deformables.report().tet_updates;
    }
    Outcome {
        tets_per_second: updates as f64 / clock.seconds(),
        ..clock.outcome()
    }
}

/// How a block is damped.
#[derive(Clone, Copy)]
enum Damping {
    None,
    /// A loss factor of 2 % at the first mode, by stiffness: more at every higher one.
    Stiffness,
    /// The same by mass: less at every higher one.
    Mass,
}

/// The block of `nodes`³ nodes and 100 kg.
fn block(young: f64, law: SolidLaw, damping: Damping, nodes: u32, fall: Fall) -> Outcome {
    let solid = Solid::new(young, POISSON, f64::from(MASS)).law(law);
    // About the first mode [rad/s].
    let omega = (young / f64::from(MASS)).sqrt();
    let solid = match damping {
        Damping::None => solid,
        Damping::Stiffness => solid.damping(0.0, 0.02 / omega),
        Damping::Mass => solid.damping(0.02 * omega, 0.0),
    };
    ours(solid, 1.0, nodes - 1, false, fall)
}

/// The same block as Rapier's.
fn rapier(young: f64, solver: SoftBodySolver, n: usize, fall: Fall) -> Outcome {
    let mut world = floor();
    let at = Vector::new(0.0, fall.height + 0.5, 0.0);
    let builder = SoftBodyBuilder::cuboid(at, Vector::splat(0.5), n, n, n)
        .cell_model(SoftBodyCellModel::Corotational)
        .material(SoftBodyMaterial {
            young_modulus: young as f32,
            poisson_ratio: POISSON as f32,
            elastic_damping_ratio: 0.02,
            ..SoftBodyMaterial::default()
        })
        .solver(solver)
        .mass(MASS)
        .can_sleep(false);
    let edges = builder.cell_edges();
    let length = |x: &dyn Fn(usize) -> Vector, [a, b]: [u32; 2]| {
        f64::from(x(a as usize).distance(x(b as usize)))
    };
    let places = builder.particle_positions().to_vec();
    let rest: Vec<f64> = edges.iter().map(|e| length(&|i| places[i], *e)).collect();
    let handle = world.insert_soft_body(builder);
    for i in 0..places.len() {
        let v = Vector::new(0.0, -fall.speed, 0.0);
        world.soft_bodies[handle].set_particle_velocity(i, v);
    }
    let mut clock = Clock::new(f64::from(-fall.speed));
    for _ in 0..fall.frames {
        let start = Instant::now();
        world.step();
        let seconds = start.elapsed().as_secs_f64();
        let body = &world.soft_bodies[handle];
        let momenta = body.particles().iter().map(|p| p.mass() * p.velocity().y);
        let momentum: f64 = momenta.map(f64::from).sum();
        let now = |i: usize| body.particle_position(i);
        let strains = edges.iter().zip(&rest);
        let strains = strains.map(|(e, rest)| (length(&now, *e) / rest - 1.0).abs());
        let strain = strains.fold(0.0, f64::max);
        clock.frame(seconds, momentum / f64::from(MASS), strain);
    }
    clock.outcome()
}

/// A deflection and its time.
fn bent((tip, ms): (f64, f64)) -> Outcome {
    Outcome {
        error_percent: 100.0 * (tip / beam::THEORY - 1.0).abs(),
        ..Outcome::of(ms)
    }
}

/// Frames in which a beam comes to rest.
const BEND: usize = 120;

/// The beam of [`beam::rapier`].
fn our_beam(cells: [u32; 3], quadratic: bool) -> Outcome {
    let mesh = mesh(Vector::new(2.0, 0.2, 0.2), cells, quadratic);
    let tip = (0..).zip(&mesh.nodes).filter(|(_, x)| x.x > 0.9999);
    let tip: Vec<NodeId> = tip.map(|(n, _)| NodeId(n)).collect();
    // Twice the first angular frequency, as in the scene.
    let solid = Solid::new(1.2e7, 0.0, 100.0).damping(35.0, 0.0);
    let mut deformables = DeformableWorld::default();
    let builder = DeformableBuilder::tets(mesh, solid).pin(|x| x.x < -0.9999);
    let body = deformables.insert(builder).expect("stable");
    let height = |d: &DeformableWorld| {
        let each = tip.iter().filter_map(|n| d[body].position(*n));
        each.map(|x| x.y).sum::<f64>() / tip.len() as f64
    };
    let (mut world, before) = (PhysicsWorld::default(), height(&deformables));
    let start = Instant::now();
    for _ in 0..BEND {
        deformables.step(&mut world);
    }
    let ms = 1e3 * start.elapsed().as_secs_f64() / BEND as f64;
    bent((before - height(&deformables), ms))
}

type Case = (String, Box<dyn Fn() -> Outcome>);

fn cases() -> Vec<Case> {
    use SoftBodySolver::{Constraints, Fem};
    use SolidLaw::{Corotational, StableNeoHookean};
    let mut cases: Vec<Case> = Vec::new();
    let mut case = |name: String, run: Box<dyn Fn() -> Outcome>| cases.push((name, run));
    for (what, n, fall) in [
        ("drop", 10, DROP),
        ("impact", 10, IMPACT),
        ("impact", 20, IMPACT),
    ] {
        let name = |of: &str| format!("{what} {n}^3 {of}");
        for (law, name_of) in [
            (Corotational, "corotational"),
            (StableNeoHookean, "stable neo-Hookean"),
        ] {
            for (damping, damped) in [
                (Damping::Stiffness, ""),
                (Damping::Mass, " damped by mass"),
                (Damping::None, " undamped"),
            ] {
                let run = Box::new(move || block(0.2e6, law, damping, n, fall));
                case(name(&format!("crumple {name_of} 0.2 MPa{damped}")), run);
            }
        }
        case(
            name("rapier constraints 0.2 MPa"),
            Box::new(move || rapier(0.2e6, Constraints, n as usize, fall)),
        );
        let frames = fall.frames.min(60);
        case(
            name("rapier FEM 0.2 MPa"),
            Box::new(move || rapier(0.2e6, Fem, n as usize, Fall { frames, ..fall })),
        );
    }
    let rubber = |young| Solid::new(young, 0.45, 1000.0).law(StableNeoHookean);
    for (name, young, side, cells, quadratic) in [
        ("rubber 1 m 6000 tets 1 MPa", 1e6, 1.0, 10, false),
        ("rubber 1 m 4374 tets 2 MPa", 2e6, 1.0, 9, false),
        ("rubber 0.5 m 4374 tets 1 MPa", 1e6, 0.5, 9, false),
        ("rubber 1 m 750 quadratic tets 1 MPa", 1e6, 1.0, 5, true),
    ] {
        let run = move || ours(rubber(young), side, cells, quadratic, DROP);
        case(name.into(), Box::new(run));
    }
    for (name, cells, quadratic) in [
        ("60 quadratic tets 189 nodes", [10, 1, 1], true),
        ("480 linear tets 189 nodes", [20, 2, 2], false),
    ] {
        let run = move || our_beam(cells, quadratic);
        case(format!("cantilever crumple {name}"), Box::new(run));
    }
    for (name, cell, solver, iterations) in [
        ("constraints 189 nodes", 0.1, Constraints, 20),
        ("FEM 189 nodes", 0.1, Fem, 20),
        ("FEM 189 nodes 1000 iterations", 0.1, Fem, 1000),
        ("FEM 1025 nodes", 0.05, Fem, 20),
        ("FEM 1025 nodes 1000 iterations", 0.05, Fem, 1000),
    ] {
        let run = move || bent(beam::rapier(cell, solver, iterations, BEND));
        case(format!("cantilever rapier {name}"), Box::new(run));
    }
    cases
}

fn main() {
    let words = std::env::args().skip(1).filter(|a| !a.starts_with('-'));
    let words: Vec<String> = words.collect();
    let mut cases = cases();
    cases.retain(|(name, _)| words.iter().all(|w| name.contains(w.as_str())));
    let mut outcomes: Vec<Vec<Outcome>> = cases.iter().map(|_| Vec::new()).collect();
    let mut long = vec![false; cases.len()];
    for _ in 0..RUNS {
        for (i, (_, run)) in cases.iter().enumerate() {
            if !long[i] {
                let start = Instant::now();
                outcomes[i].push(run());
                long[i] = start.elapsed().as_secs_f64() > LONG;
            }
        }
    }
    println!("{}", Outcome::HEADER);
    for ((name, _), outcomes) in cases.iter().zip(&mut outcomes) {
        outcomes.sort_by(|a, b| a.ms_per_frame.total_cmp(&b.ms_per_frame));
        println!("{}", outcomes[outcomes.len() / 2].row(name));
    }
}
