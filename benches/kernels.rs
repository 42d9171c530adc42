//! The kernels of the force pass with their integration, against a scalar loop over springs: every width × topology, plain,
//! damped, and with springs that yield and break.
//!
//! `cargo bench --bench kernels` prints criterion's times and then, measured in turn in one run, a CSV of spring updates per second
//! and ratios to the scalar loop. `-- table` prints the CSV alone.

mod clock;

use clock::Clock;
use criterion::{BenchmarkId, Criterion, Throughput};
use crumple::body::{Blueprint, Spring, State};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box_of_cells};
use crumple::solve::{Kernel, Solver};

/// A substep far below stability \[s\]: the bodies rest, and what is measured is the passes.
const H: f32 = 1e-6;

/// A spring of the scalar loop.
struct Link {
    nodes: [u32; 2],
    stiffness: f32,
    rest: f32,
}

/// What anyone would write: one loop over springs that adds to both nodes, one over nodes with compensated positions.
struct ScalarLoop {
    links: Vec<Link>,
    state: State<f32>,
    forces: Vec<[f32; 4]>,
}

impl ScalarLoop {
    fn new(springs: &[Spring], state: &State<f32>) -> Self {
        let link = |s: &Spring| Link {
            nodes: s.nodes,
            stiffness: s.stiffness,
            rest: s.rest_length.unwrap_or(0.0),
        };
        Self {
            links: springs.iter().map(link).collect(),
            state: state.clone(),
            forces: vec![[0.0; 4]; state.particles.len()],
        }
    }

    fn substep(&mut self) {
        self.forces.fill([0.0; 4]);
        for link in &self.links {
            let [a, b] = link.nodes.map(|n| n as usize);
            let (p, q) = (self.state.particles[a].x, self.state.particles[b].x);
            let d = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
            let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            let pull = link.stiffness * (length - link.rest) / length;
            for (k, d) in d.into_iter().enumerate() {
                self.forces[a][k] += d * pull;
                self.forces[b][k] -= d * pull;
            }
        }
        for (i, f) in self.forces.iter().enumerate() {
            let p = &mut self.state.particles[i];
            for (v, f) in p.v.iter_mut().zip(f) {
                *v += H * f * p.inv_mass;
            }
            let by = p.v.map(|v| H * v);
            self.state.displace(i, by);
        }
    }
}

/// The same net with its nodes in any order.
fn shuffled(net: &Net) -> Net {
    let mut names: Vec<u32> = (0..net.nodes.len() as u32).collect();
    let mut seed = 1_u64;
    for i in (1..names.len()).rev() {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        names.swap(i, (seed >> 33) as usize % (i + 1));
    }
    let mut nodes = net.nodes.clone();
    for (node, name) in net.nodes.iter().zip(&names) {
        nodes[*name as usize] = *node;
    }
    let renamed = |s: &Spring| Spring {
        nodes: s.nodes.map(|n| names[n as usize]),
        ..*s
    };
    Net::new(nodes, net.springs.iter().map(renamed).collect())
}

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

/// A body on its own.
struct Subject {
    solver: Solver<f32>,
    state: State<f32>,
}

impl Subject {
    fn new(blueprint: &Blueprint, kernel: Kernel, squeeze: f32) -> Self {
        let mut state = blueprint.rest_state();
        for p in &mut state.particles {
            // Goes on at a thousand times the squeeze per second.
            p.v[0] = -1e3 * squeeze * p.x[0];
            p.x[0] *= 1.0 - squeeze;
        }
        let mut solver = Solver::new(&blueprint.springs, &state);
        solver.kernel = kernel;
        Self { solver, state }
    }

    fn substep(&mut self) {
        self.solver
            .substep(&mut self.state, Integrator::SymplecticEuler, H.into());
    }
}

/// What the system tells of a thread's time has grains of milliseconds \[s\].
const LONG: f64 = 0.1;

/// Seconds of the thread per call: `count` calls at a time, as long as it takes to measure them.
fn time(count: usize, mut call: impl FnMut()) -> f64 {
    let clock = Clock::start();
    let mut calls = 0;
    loop {
        for _ in 0..count {
            call();
        }
        calls += count;
        let spent = clock.spent().as_secs_f64();
        if spent > LONG {
            return spent / calls as f64;
        }
    }
}

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
        let mut scalar = ScalarLoop::new(&blueprints[0].1.springs, &blueprints[0].1.rest_state());
        let mut least_scalar = f64::INFINITY;
        let mut least = [[f64::INFINITY; KERNELS.len()]; 5];
        for _ in 0..rounds {
            least_scalar = least_scalar.min(time(count, || scalar.substep()));
            for ((_, blueprint, squeeze), least) in blueprints.iter().zip(&mut least) {
                for (kernel, least) in KERNELS.iter().zip(least) {
                    let mut subject = Subject::new(blueprint, *kernel, *squeeze);
                    subject.substep();
                    *least = least.min(time(count, || subject.substep()));
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
        let mut scalar = ScalarLoop::new(&blueprint.springs, &blueprint.rest_state());
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
