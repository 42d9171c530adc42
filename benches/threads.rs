//! What threads gain: 1…N of them on one body, and on many bodies.
//!
//! `cargo bench --bench threads --features scenario,parallel` prints two CSV tables. Times are by the clock on the wall, and
//! those of a row are measured in turn, and the shortest of some rounds count, because whatever else the machine does can only
//! add to them. `-- one` or `-- many` prints one of them, a number says how many rounds.

use crumple::body::Blueprint;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario::speed::subject::{Subject, shuffled};
use crumple::scenario::speed::threads::Pool;
use crumple::shape::{TetSplit, tet_box_of_cells};
use crumple::solve::{Integrator, Kernel, Solver, fem};
use std::sync::Arc;

/// Least time of a measurement \[s\].
const LONG: f64 = 0.05;

fn threads() -> Vec<usize> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    let mut list: Vec<usize> = std::iter::successors(Some(1), |n| Some(2 * n))
        .take_while(|&n| n < all)
        .collect();
    list.push(all);
    list
}

/// Prints per number of threads the rate of its shortest time, and its ratio to that of one thread.
fn rows(name: &str, updates: f64, rounds: usize, mut time: impl FnMut(&Pool) -> f64) {
    let pools: Vec<(usize, Pool)> = threads().into_iter().map(|n| (n, Pool::new(n))).collect();
    let mut least = vec![f64::INFINITY; pools.len()];
    for _ in 0..rounds {
        let times: Vec<f64> = pools.iter().map(|(_, pool)| time(pool)).collect();
        for (i, t) in times.iter().enumerate() {
            least[i] = least[i].min(*t);
        }
    }
    for (i, (n, _)) in pools.iter().enumerate() {
        let rate = 1e-6 * updates / least[i];
        println!("{name},{n},{rate:.0},{:.2}", least[0] / least[i]);
    }
}

fn spring_bodies() -> Vec<(&'static str, Net)> {
    let tets = |cells| {
        let mesh = tet_box_of_cells(Vector::ONE, [cells; 3], TetSplit::Six).expect("a box");
        shuffled(&mesh.springs())
    };
    let side = |n: f32| lattice(Vector::ONE, 1.0 / (n - 1.0)).expect("a lattice");
    vec![
        ("lattice", side(11.0)),
        ("lattice", side(20.0)),
        ("lattice", side(50.0)),
        ("mesh without order", tets(11)),
        ("mesh without order", tets(20)),
        ("mesh without order", tets(46)),
    ]
}

/// One body on its own, substep by substep.
fn one(rounds: usize) {
    println!("body,elements,material,threads,million_updates_per_s,speedup");
    let elastic = Material::elastic(1e6, 100.0);
    let mut plastic = elastic.yielding(1e4, 0.0);
    plastic.break_strain = 0.5;
    for (name, net) in spring_bodies() {
        for (material_name, material, squeeze) in [
            ("plain", elastic, 0.0),
            ("yield and break", plastic, 0.0),
            ("all flowing", plastic, 0.03),
        ] {
            let blueprint = Blueprint::resolve(net.clone(), |_| Some(material), None);
            let blueprint = blueprint.expect("a blueprint");
            let springs = blueprint.springs.len();
            let count = 100_000 / springs + 1;
            let name = format!("{name},{springs},{material_name}");
            rows(&name, springs as f64, rounds, |pool| {
                let mut subject = Subject::new(&blueprint, Kernel::Auto, squeeze);
                pool.install(|| subject.substep());
                pool.per_call(LONG, count, || subject.substep())
            });
        }
    }
    for quadratic in [false, true] {
        let mesh = tet_box_of_cells(Vector::ONE, [12; 3], TetSplit::Six).expect("a box");
        let mesh = if quadratic { mesh.quadratic() } else { mesh };
        let solid = Solid::new(1e6, 0.4, 1000.0).law(SolidLaw::NeoHookean);
        let model = Arc::new(fem::Model::<f32>::new(&mesh, solid).expect("a model"));
        let places = mesh.nodes.iter().map(|x| x.as_vec3().to_array());
        let nodes = places.map(|x| (x, [0.0; 3], 1.0));
        let mut state = crumple::body::State::new(nodes, []);
        let part = fem::Part::new(model.clone(), &vec![1.0; mesh.nodes.len()]);
        let mut solver = Solver::new(&[], &state).with_elements(part);
        let tets = model.element_count();
        let name = ["linear tets", "quadratic tets"][usize::from(quadratic)];
        let name = format!("{name},{tets},neo-Hookean");
        rows(&name, tets as f64, rounds, |pool| {
            let mut substep = || solver.substep(&mut state, Integrator::SymplecticEuler, 1e-6);
            pool.install(&mut substep);
            pool.per_call(LONG, 3, substep)
        });
    }
}

/// Blocks beside each other on the ground, each a group of its own, by steps of the world.
fn many(rounds: usize) {
    println!("bodies,springs,threads,million_updates_per_s,speedup");
    for bodies in [1, 10, 100, 1000] {
        let mut world = PhysicsWorld::default();
        let floor = RigidBodyBuilder::fixed().translation(Vector::new(0.0, -0.5, 0.0));
        world.insert(floor, ColliderBuilder::cuboid(2e3, 0.5, 5.0));
        world.integration_parameters.dt = 1.0 / 240.0;
        let mut deformables = DeformableWorld::default();
        deformables.params.sleep_speed = 0.0;
        for i in 0..bodies {
            let block = DeformableBuilder::new(lattice(Vector::splat(0.4), 0.1))
                .material(Material::elastic(5.0e5, 100.0).viscosity(500.0))
                .translation(Vector::new(i as f32, 0.2, 0.0));
            deformables.insert(block).expect("the block is stable");
        }
        let springs: usize = deformables.iter().map(|(_, b)| b.spring_count()).sum();
        deformables.step(&mut world);
        let updates = deformables.report().spring_updates as f64;
        let name = format!("{bodies},{springs}");
        rows(&name, updates, rounds, |pool| {
            pool.per_call(LONG, 1, || deformables.step(&mut world))
        });
    }
}

fn main() {
    let asked: Vec<String> = std::env::args().collect();
    let wants = |what: &str| asked.iter().any(|a| a == what);
    let rounds = asked.iter().find_map(|a| a.parse().ok()).unwrap_or(7);
    if !wants("many") {
        one(rounds);
    }
    if !wants("one") {
        many(rounds);
    }
}
