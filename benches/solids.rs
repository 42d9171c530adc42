//! Blocks of tets in contact side by side with Rapier's own: the block of 10³ nodes (1 m, 100 kg, dropped 1 m) in the same
//! tets with the same E and ν, and rubber bodies of 5,000 tets. One run, engines in turn, median over runs.
//!
//! `cargo bench --bench solids --features native-fem` prints a CSV: milliseconds per frame of 1/60 s, largest strain of
//! any edge, and for ours tets × substeps per second.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box_of_cells};
use std::time::Instant;

const NODES: u32 = 10;
const MASS: f32 = 100.0;
const POISSON: f64 = 0.3;
const RUNS: usize = 3;

struct Outcome {
    ms_per_frame: f64,
    max_strain: f64,
    tets_per_second: f64,
}

fn floor() -> PhysicsWorld {
    let mut world = PhysicsWorld::default();
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(10.0, 0.5, 10.0),
    );
    world
}

/// A block of `side` m of `cells`³·6 tets dropped 1 m; two seconds.
fn ours(solid: Solid, side: f32, cells: u32, quadratic: bool) -> Outcome {
    let mut world = floor();
    let mut mesh = tet_box_of_cells(Vector::splat(side), [cells; 3], TetSplit::Six).expect("a box");
    if quadratic {
        mesh = mesh.quadratic();
    }
    let mut deformables = DeformableWorld::default();
    let at = Vector::new(0.0, 1.0 + 0.5 * side, 0.0);
    let body = deformables
        .insert(DeformableBuilder::tets(mesh, solid).translation(at))
        .expect("stable");
    let (mut spent, mut updates, mut max_strain) = (0.0, 0, 0.0_f64);
    let frames = 120;
    for _ in 0..frames {
        let start = Instant::now();
        deformables.step(&mut world);
        spent += start.elapsed().as_secs_f64();
        updates += deformables.report().tet_updates;
        max_strain = max_strain.max(deformables[body].max_strain());
    }
    Outcome {
        ms_per_frame: 1e3 * spent / f64::from(frames),
        max_strain,
        tets_per_second: updates as f64 / spent,
    }
}

/// The block of 10³ nodes and 100 kg.
fn block(young: f64, law: SolidLaw) -> Outcome {
    let solid = Solid::new(young, POISSON, f64::from(MASS)).law(law);
    ours(
        solid.damping(0.0, damping_time(young)),
        1.0,
        NODES - 1,
        false,
    )
}

/// A loss factor of 2 % at the first mode of the block, as in the bench `peers`.
fn damping_time(young: f64) -> f64 {
    0.02 / (young / f64::from(MASS)).sqrt()
}

fn rapier(young: f64, solver: SoftBodySolver, frames: usize) -> Outcome {
    let mut world = floor();
    let n = NODES as usize;
    let builder = SoftBodyBuilder::cuboid(Vector::new(0.0, 1.5, 0.0), Vector::splat(0.5), n, n, n)
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
    let rest: Vec<f32> = {
        let x = builder.particle_positions();
        let length = |[a, b]: &[u32; 2]| x[*a as usize].distance(x[*b as usize]);
        edges.iter().map(length).collect()
    };
    let handle = world.insert_soft_body(builder);
    let (mut spent, mut max_strain) = (0.0, 0.0_f64);
    for _ in 0..frames {
        let start = Instant::now();
        world.step();
        spent += start.elapsed().as_secs_f64();
        let body = &world.soft_bodies[handle];
        for ([a, b], rest) in edges.iter().zip(&rest) {
            let length = body
                .particle_position(*a as usize)
                .distance(body.particle_position(*b as usize));
            max_strain = max_strain.max(f64::from((length / rest - 1.0).abs()));
        }
    }
    Outcome {
        ms_per_frame: 1e3 * spent / frames as f64,
        max_strain,
        tets_per_second: 0.0,
    }
}

fn main() {
    use SolidLaw::{Corotational, StableNeoHookean};
    let rubber = |young| Solid::new(young, 0.45, 1000.0).law(StableNeoHookean);
    type Case = (&'static str, Box<dyn Fn() -> Outcome>);
    let cases: [Case; 12] = [
        (
            "crumple corotational 0.2 MPa",
            Box::new(|| block(0.2e6, Corotational)),
        ),
        (
            "crumple corotational 1 MPa",
            Box::new(|| block(1e6, Corotational)),
        ),
        (
            "crumple stable neo-Hookean 0.2 MPa",
            Box::new(|| block(0.2e6, StableNeoHookean)),
        ),
        (
            "crumple stable neo-Hookean 1 MPa",
            Box::new(|| block(1e6, StableNeoHookean)),
        ),
        (
            "crumple stable neo-Hookean 0.2 MPa undamped",
            Box::new(|| {
                let solid = Solid::new(0.2e6, POISSON, f64::from(MASS));
                ours(solid.law(StableNeoHookean), 1.0, NODES - 1, false)
            }),
        ),
        (
            "rapier constraints 0.2 MPa",
            Box::new(|| rapier(0.2e6, SoftBodySolver::Constraints, 120)),
        ),
        (
            "rapier constraints 1 MPa",
            Box::new(|| rapier(1e6, SoftBodySolver::Constraints, 120)),
        ),
        (
            "rapier FEM 0.2 MPa",
            Box::new(|| rapier(0.2e6, SoftBodySolver::Fem, 60)),
        ),
        (
            "rubber 1 m 6000 tets 1 MPa",
            Box::new(move || ours(rubber(1e6), 1.0, 10, false)),
        ),
        (
            "rubber 1 m 4374 tets 2 MPa",
            Box::new(move || ours(rubber(2e6), 1.0, 9, false)),
        ),
        (
            "rubber 0.5 m 4374 tets 1 MPa",
            Box::new(move || ours(rubber(1e6), 0.5, 9, false)),
        ),
        (
            "rubber 1 m 750 quadratic tets 1 MPa",
            Box::new(move || ours(rubber(1e6), 1.0, 5, true)),
        ),
    ];
    let mut outcomes: Vec<Vec<Outcome>> = cases.iter().map(|_| Vec::new()).collect();
    for _ in 0..RUNS {
        for ((_, run), outcomes) in cases.iter().zip(&mut outcomes) {
            outcomes.push(run());
        }
    }
    println!("case,ms_per_frame,max_strain,tets_per_second");
    for ((name, _), outcomes) in cases.iter().zip(&mut outcomes) {
        outcomes.sort_by(|a, b| a.ms_per_frame.total_cmp(&b.ms_per_frame));
        let Outcome {
            ms_per_frame,
            max_strain,
            tets_per_second,
        } = &outcomes[RUNS / 2];
        println!("\"{name}\",{ms_per_frame:.3},{max_strain:.3},{tets_per_second:.3e}");
    }
}
