//! The kernels of the force pass with their integration, against a scalar loop over springs: every width × topology, plain,
//! damped, and with springs that yield and break.
//!
//! `cargo bench --bench kernels --features scenario` prints criterion's times and then, measured in turn in one run, a CSV of spring updates per second
//! and ratios to the scalar loop. `-- table` prints the CSV alone.

use criterion::{BenchmarkId, Criterion, Throughput};
use crumple::body::Blueprint;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario::speed::clock::per_call;
use crumple::scenario::speed::subject::{ScalarLoop, Subject, shuffled};
use crumple::shape::{TetSplit, tet_box_of_cells};
use crumple::solve::Kernel;

fn topologies() -> Vec<(&'static str, Net)> {
    let tets = |cells| {
        let mesh = tet_box_of_cells(Vector::ONE, [cells; 3], TetSplit::Six).expect("a box");
        mesh.springs()
    };
    let side = |n: f32| lattice(Vector::ONE, 1.0 / (n - 1.0)).expect("a lattice");
    vec![
        ("lattice 20^3", side(20.0)),
        ("lattice 50^3", side(50.0)),
        (
            "cloth 100^2",
            sheet(1.0, 1.0, 100, 100, 1e-3).expect("a sheet"),
        ),
        ("tets 20^3", tets(20)),
        ("tets 20^3 unordered", shuffled(&tets(20))),
        ("tets 46^3", tets(46)),
        ("tets 46^3 unordered", shuffled(&tets(46))),
    ]
}

/// What the springs are made of, and by how much the body is squeezed along x.
fn materials() -> [(&'static str, Material, f32); 5] {
    let elastic = Material::elastic(1e6, 100.0);
    let mut plastic = elastic.yielding(1e4, 0.0);
    plastic.break_strain = 0.5;
    [
        ("plain", elastic, 0.0),
        ("yield and break", plastic, 0.0),
        ("yield and break, all flowing", plastic, 0.03),
        ("damped", elastic.viscosity(100.0), 0.0),
        ("damped, yield and break", plastic.viscosity(100.0), 0.0),
    ]
}

const KERNELS: [Kernel; 3] = [Kernel::Portable, Kernel::Avx2, Kernel::Avx512];

/// What the system tells of a thread's time has grains of milliseconds \[s\].
const LONG: f64 = 0.1;

/// Everything in turn, so that what else the machine does hits all alike; the least time of each counts.
fn table(rounds: usize) {
    println!("topology,springs,material,kernel,million_updates_per_s,vs_scalar_loop,vs_plain");
    for (topology, net) in topologies() {
        if !wanted(topology) {
            continue;
        }
        let blueprints = materials().map(|(name, material, squeeze)| {
            let blueprint = Blueprint::resolve(net.clone(), |_| Some(material), None);
            (name, blueprint.expect("a blueprint"), squeeze)
        });
        let springs = blueprints[0].1.springs.len();
        let count = 1_000_000 / springs + 1;
        let mut scalar = ScalarLoop::new(&blueprints[0].1);
        let mut least_scalar = f64::INFINITY;
        let mut least = [[f64::INFINITY; KERNELS.len()]; 5];
        for _ in 0..rounds {
            least_scalar = least_scalar.min(per_call(LONG, count, || scalar.substep()));
            for ((_, blueprint, squeeze), least) in blueprints.iter().zip(&mut least) {
                for (kernel, least) in KERNELS.iter().zip(least) {
                    let mut subject = Subject::new(blueprint, *kernel, *squeeze);
                    subject.substep();
                    *least = least.min(per_call(LONG, count, || subject.substep()));
                }
            }
        }
        let rate = |time: f64| 1e-6 * springs as f64 / time;
        println!(
            "{topology},{springs},plain,scalar loop,{:.0},1.00,1.00",
            rate(least_scalar)
        );
        for ((name, ..), times) in blueprints.iter().zip(&least) {
            for (k, kernel) in KERNELS.iter().enumerate() {
                println!(
                    "{topology},{springs},\"{name}\",{},{:.0},{:.2},{:.2}",
                    kernel.name(),
                    rate(times[k]),
                    least_scalar / times[k],
                    least[0][k] / times[k],
                );
            }
        }
    }
}

/// Whether a topology is asked for by name, or none is.
fn wanted(topology: &str) -> bool {
    let mut names = std::env::args().filter(|a| a.contains('^'));
    names.next().is_none_or(|a| topology.starts_with(&a))
}

fn criterion() {
    let mut criterion = Criterion::default().configure_from_args();
    for (topology, net) in topologies() {
        let (_, elastic, _) = materials()[0];
        let blueprint = Blueprint::resolve(net, |_| Some(elastic), None).expect("a blueprint");
        let mut group = criterion.benchmark_group(topology);
        group.throughput(Throughput::Elements(blueprint.springs.len() as u64));
        group.sample_size(20);
        let mut scalar = ScalarLoop::new(&blueprint);
        group.bench_function("scalar loop", |b| b.iter(|| scalar.substep()));
        for kernel in KERNELS {
            let mut subject = Subject::new(&blueprint, kernel, 0.0);
            let id = BenchmarkId::from_parameter(kernel.name());
            group.bench_function(id, |b| b.iter(|| subject.substep()));
        }
        group.finish();
    }
    criterion.final_summary();
}

fn main() {
    let asked: Vec<String> = std::env::args().collect();
    if !asked.iter().any(|a| a == "table") {
        criterion();
    }
    let rounds = asked.iter().find_map(|a| a.parse().ok());
    table(rounds.unwrap_or(5));
}
