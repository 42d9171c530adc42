//! Time of whole steps over the catalog of scenes, and of the solver alone, in spring updates per second.
//!
//! `cargo bench --bench steps --features cli`. A spring update is one spring, its force evaluated once, integration of its
//! nodes included.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use crumple::body::Blueprint;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario;
use crumple::solve::Solver;
use std::time::{Duration, Instant};

/// Every scene, stepped without a recorder, from its start over 50 ms.
fn scenes(c: &mut Criterion) {
    let mut group = c.benchmark_group("scene");
    group.sample_size(10);
    for scene in scenario::all() {
        let mut options = scene.options;
        options.duration = 0.05;
        let pass = || -> (Duration, u64) {
            let mut run = scene.build(&options).expect("the catalog builds");
            let mut updates = 0;
            let start = Instant::now();
            for _ in 0..run.total_steps() {
                run.deformables.step(&mut run.world);
                updates += run.deformables.report().spring_updates;
            }
            (start.elapsed(), updates)
        };
        group.throughput(Throughput::Elements(pass().1));
        group.bench_function(scene.name, |b| {
            b.iter_custom(|n| (0..n).map(|_| pass().0).sum());
        });
    }
    group.finish();
}

/// A lattice of 20³ nodes on its own: elastic, damped, plastic, both.
fn solver(c: &mut Criterion) {
    let net = lattice(Vector::splat(1.0), 1.0 / 19.0).expect("a lattice");
    let elastic = Material::elastic(1e6, 100.0);
    let mut group = c.benchmark_group("substep of 20³ nodes");
    for (name, material) in [
        ("elastic", elastic),
        ("damped", elastic.viscosity(100.0)),
        ("plastic", elastic.yielding(1e4, 0.0)),
        (
            "damped and plastic",
            elastic.viscosity(100.0).yielding(1e4, 0.0),
        ),
    ] {
        let blueprint =
            Blueprint::resolve(net.clone(), |_| Some(material), None).expect("a blueprint");
        let mut state = blueprint.rest_state();
        let mut solver = Solver::new(&blueprint.springs, &state);
        group.throughput(Throughput::Elements(blueprint.springs.len() as u64));
        for integrator in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
            group.bench_function(BenchmarkId::new(name, integrator.name()), |b| {
                b.iter(|| solver.substep(&mut state, integrator, 1e-5));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, scenes, solver);
criterion_main!(benches);
