//! The dropped block side by side with Rapier's own soft bodies: same nodes, mass, size, drop and floor, one run.
//!
//! `cargo bench --bench peers` prints a table and a CSV with milliseconds per frame of 1/60 s (median over runs, both
//! engines in turn, so that a noisy machine hits both) and the largest strain either body suffers. Rapier's block is
//! shown at its default stiffness and at stiffer ones, ours at a modulus that deforms no more.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use std::time::Instant;

const NODES: usize = 10;
const MASS: f32 = 100.0;
const FRAMES: usize = 120;
const RUNS: usize = 7;

struct Outcome {
    ms_per_frame: f64,
    max_strain: f64,
}

fn world() -> PhysicsWorld {
    let mut world = PhysicsWorld::default();
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(10.0, 0.5, 10.0),
    );
    world
}

/// A block of 10³ nodes, 1 m, 100 kg, dropped 1 m.
fn ours(young: f32) -> Outcome {
    let mut world = world();
    let mut deformables = DeformableWorld::default();
    let cell = 1.0 / (NODES - 1) as f32;
    let first_mode = (young / MASS).sqrt();
    let body = deformables
        .insert(
            DeformableBuilder::new(lattice(Vector::splat(1.0), cell))
                .material(Material::elastic(young, 1.0).viscosity(0.02 * young / first_mode))
                .total_mass(MASS)
                .translation(Vector::new(0.0, 1.5, 0.0)),
        )
        .expect("the block is stable");
    let (mut spent, mut max_strain) = (0.0, 0.0_f64);
    for _ in 0..FRAMES {
        let start = Instant::now();
        deformables.step(&mut world);
        spent += start.elapsed().as_secs_f64();
        max_strain = max_strain.max(deformables[body].max_strain());
    }
    Outcome {
        ms_per_frame: 1e3 * spent / FRAMES as f64,
        max_strain,
    }
}

/// How Rapier's block is held together.
#[derive(Clone, Copy)]
enum Native {
    /// Its default: corotational tetrahedra with volume preservation.
    Cells,
    /// Distance constraints along the edges of those tetrahedra.
    Edges,
}

/// Triangles that belong to one tetrahedron only. The builder derives them from cells, and without cells not at all.
fn boundary(cells: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let mut faces: Vec<([u32; 3], [u32; 3])> = cells
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d], [a, d, b], [b, d, c]])
        .map(|face| {
            let mut key = face;
            key.sort_unstable();
            (key, face)
        })
        .collect();
    faces.sort_unstable();
    let once = |i: usize| {
        let key = faces[i].0;
        (i == 0 || faces[i - 1].0 != key) && faces.get(i + 1).is_none_or(|f| f.0 != key)
    };
    (0..faces.len())
        .filter(|&i| once(i))
        .map(|i| faces[i].1)
        .collect()
}

fn rapier(native: Native, iterations: usize) -> Outcome {
    let mut world = world();
    world.integration_parameters.num_solver_iterations = iterations;
    let builder = SoftBodyBuilder::cuboid(
        Vector::new(0.0, 1.5, 0.0),
        Vector::splat(0.5),
        NODES,
        NODES,
        NODES,
    );
    let edges = builder.cell_edges();
    let rest: Vec<f32> = {
        let x = builder.particle_positions();
        edges
            .iter()
            .map(|[a, b]| x[*a as usize].distance(x[*b as usize]))
            .collect()
    };
    let builder = match native {
        Native::Cells => builder,
        Native::Edges => {
            let surface = boundary(&builder.cells);
            builder
                .edges(edges.clone())
                .surface(surface)
                .cells(Vec::new())
        }
    }
    .mass(MASS)
    .can_sleep(false);
    let handle = world.insert_soft_body(builder);
    let (mut spent, mut max_strain) = (0.0, 0.0_f64);
    for _ in 0..FRAMES {
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
        ms_per_frame: 1e3 * spent / FRAMES as f64,
        max_strain,
    }
}

fn main() {
    type Case = (&'static str, fn() -> Outcome);
    let cases: [Case; 6] = [
        ("crumple, E = 0.07 MPa", || ours(0.07e6)),
        ("crumple, E = 0.2 MPa", || ours(0.2e6)),
        ("crumple, E = 1 MPa", || ours(1e6)),
        ("rapier native, edges", || rapier(Native::Edges, 4)),
        ("rapier native, cells", || rapier(Native::Cells, 4)),
        ("rapier native, cells, 16 iterations", || {
            rapier(Native::Cells, 16)
        }),
    ];
    let mut times = vec![Vec::new(); cases.len()];
    let mut strains = vec![0.0; cases.len()];
    for _ in 0..RUNS {
        for (i, (_, run)) in cases.iter().enumerate() {
            let outcome = run();
            times[i].push(outcome.ms_per_frame);
            strains[i] = outcome.max_strain;
        }
    }
    println!("case,ms_per_frame,max_strain");
    for ((name, _), (mut times, strain)) in cases.iter().zip(times.into_iter().zip(strains)) {
        times.sort_by(f64::total_cmp);
        println!("\"{name}\",{:.4},{strain:.4}", times[RUNS / 2]);
    }
}
