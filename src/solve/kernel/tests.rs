//! Kernels against the scalar pass, bit for bit, on nets without any order.

mod regular;

use super::vector::LANES;
use super::*;
use crate::body::Material;
use crate::body::adjacency::Adjacency;
use crate::body::net::Spring;
use crate::body::state::State;
use crate::solve::springs::Rows;
use crate::solve::{Integrator, Solver};
use proptest::prelude::*;
use std::collections::BTreeMap;

const KERNELS: [Kernel; 3] = [Kernel::Portable, Kernel::Avx2, Kernel::Avx512];

/// Numbers of a linear congruential generator, in [0, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> u32 {
        (self.next() * n as f64) as u32
    }

    fn chance(&mut self, p: f64) -> bool {
        self.next() < p
    }
}

/// A net whose springs have neither damping nor limits.
const SWINGING: Kind = Kind {
    nodes: 37,
    springs: 100,
    damped: false,
    limited: false,
};

#[derive(Clone, Copy, Debug)]
struct Kind {
    nodes: usize,
    springs: usize,
    damped: bool,
    limited: bool,
}

/// A net of springs between any two nodes of a box, some nodes in one place, some pinned, some springs broken before.
fn net(kind: Kind, seed: u64) -> (Vec<Spring>, State<f32>) {
    let mut r = Numbers(seed);
    let mut places: Vec<[f32; 3]> = Vec::new();
    for _ in 0..kind.nodes {
        let place = [0; 3].map(|_| r.next() as f32);
        let place = if !places.is_empty() && r.chance(0.1) {
            places[r.below(places.len()) as usize]
        } else {
            place
        };
        places.push(place);
    }
    let mut springs = Vec::new();
    while springs.len() < kind.springs {
        let (a, b) = (r.below(kind.nodes), r.below(kind.nodes));
        if a == b {
            continue;
        }
        let length = (0..3)
            .map(|k| (places[a as usize][k] - places[b as usize][k]).powi(2))
            .sum::<f32>()
            .sqrt();
        let mut spring = Spring::new(a, b, 100.0 + 900.0 * r.next() as f32)
            .rest_length(length * (0.9 + 0.2 * r.next() as f32) + 1e-3);
        if kind.damped && r.chance(0.7) {
            spring.damping = 0.1 * r.next() as f32;
        }
        if kind.limited && r.chance(0.6) {
            spring.yield_tension = 20.0 * r.next() as f32;
            spring.yield_compression = 20.0 * r.next() as f32;
            spring.hardening = if r.chance(0.5) { 50.0 } else { 0.0 };
        }
        if kind.limited && r.chance(0.2) {
            spring.break_strain = 0.2 * r.next() as f32;
        }
        if kind.limited && r.chance(0.1) {
            spring.break_force = 40.0 * r.next() as f32;
        }
        springs.push(spring);
    }
    let nodes = places.iter().map(|&place| {
        let inv_mass = if r.chance(0.1) {
            0.0
        } else {
            0.5 + r.next() as f32
        };
        (place, [0; 3].map(|_| r.next() as f32 - 0.5), inv_mass)
    });
    let nodes: Vec<_> = nodes.collect();
    let rest: Vec<f32> = springs.iter().map(|s| s.rest_length.unwrap()).collect();
    let mut state = State::new(nodes, rest);
    for broken in &mut state.broken {
        *broken = r.chance(0.05);
    }
    (springs, state)
}

/// A run, and all that must not depend on the kernel in it.
#[derive(Debug, PartialEq)]
struct Outcome {
    floats: Vec<u32>,
    broken: Vec<bool>,
    events: Vec<(u32, bool, u32, u32)>,
    /// The stable steps \[s\], bit by bit, and the springs that set them.
    steps: Vec<(u64, Option<u32>)>,
}

impl Outcome {
    fn first_difference(&self, other: &Self) -> Option<(usize, f32, f32)> {
        let both = self.floats.iter().zip(&other.floats).enumerate();
        let mut different = both.filter(|(_, (a, b))| a != b);
        let (i, (a, b)) = different.next()?;
        Some((i, f32::from_bits(*a), f32::from_bits(*b)))
    }
}

fn outcome(solver: &Solver<f32>, state: &State<f32>) -> Outcome {
    let nodes = state
        .particles
        .iter()
        .flat_map(|p| p.x.into_iter().chain(p.v));
    let forces = (0..state.particles.len()).map(|node| solver.forces.at(node));
    let three = |lanes: [f32; 4]| lanes.into_iter().take(3);
    let forces = forces.flat_map(|f| three(f.elastic).chain(three(f.damping)));
    let springs = state.rest.iter().chain(&state.flow).copied();
    let low = state.low.iter().flatten().copied();
    let events = solver.events.iter();
    Outcome {
        floats: nodes
            .chain(forces)
            .chain(springs)
            .chain(low)
            // Zeros of either sign are one.
            .map(|x| (x + 0.0).to_bits())
            .collect(),
        broken: state.broken.clone(),
        events: events
            .map(|e| (e.spring, e.broke, e.tension.to_bits(), e.energy.to_bits()))
            .collect(),
        steps: Vec::new(),
    }
}

/// A body and what advances it, with a kernel, or spring by spring.
fn start(
    (springs, state): &(Vec<Spring>, State<f32>),
    kernel: Option<Kernel>,
) -> (State<f32>, Solver<f32>) {
    let mut solver = Solver::new(springs, state);
    match kernel {
        Some(kernel) => solver.kernel = kernel,
        None => solver.table.rows = Rows::Never,
    }
    (state.clone(), solver)
}

fn run_net(
    net: &(Vec<Spring>, State<f32>),
    kernel: Option<Kernel>,
    integrator: Integrator,
    drag: f32,
) -> (Outcome, Solver<f32>) {
    let (mut state, mut solver) = start(net, kernel);
    solver.external.gravity = [0.0, -9.81, 0.0];
    solver.external.drag = drag;
    let mut steps = Vec::new();
    for _ in 0..40 {
        solver.substep(&mut state, integrator, 2e-3);
        assert_copies_agree(&solver, &state);
        let stable = solver.stable_step(&state, integrator);
        steps.push((stable.h.to_bits(), stable.spring));
    }
    let outcome = Outcome {
        steps,
        ..outcome(&solver, &state)
    };
    (outcome, solver)
}

/// Both copies of every spring are the same, and as the state has them.
fn assert_copies_agree(solver: &Solver<f32>, state: &State<f32>) {
    let Rows::Made(sell) = &solver.table.rows else {
        return;
    };
    let Some(limits) = &sell.limits else { return };
    let bits = |rest: f32, flow: f32| [rest.to_bits(), flow.to_bits()];
    let mut copies = BTreeMap::<[usize; 2], Vec<[u32; 2]>>::new();
    for (node, &row) in sell.layout.rows.iter().enumerate() {
        let lane = row as usize % LANES;
        for slot in sell.layout.slots(row as usize / LANES) {
            let far = sell.layout.far.row(slot, lane);
            if far != node {
                let found = bits(limits.rest[slot].0[lane], limits.flow[slot].0[lane]);
                copies.entry([node, far]).or_default().push(found);
            }
        }
    }
    let mut wanted = BTreeMap::<[usize; 2], Vec<[u32; 2]>>::new();
    let links = solver.table.links.iter().enumerate();
    for (i, link) in links.filter(|(i, _)| !state.broken[*i]) {
        for [from, to] in [[link.a, link.b], [link.b, link.a]] {
            let ends = [from as usize, to as usize];
            let spring = bits(state.rest[i], state.flow[i]);
            wanted.entry(ends).or_default().push(spring);
        }
    }
    assert_eq!(copies, wanted);
    let told = limits.telling.of(0..sell.layout.which.len());
    let mut told: Vec<usize> = told.map(|(_, _, spring)| spring).collect();
    told.sort_unstable();
    let whole = (0..state.broken.len()).filter(|i| !state.broken[*i]);
    assert_eq!(told, whole.collect::<Vec<_>>());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn every_kernel_gives_the_bits_of_the_scalar_pass(
        seed in any::<u64>(),
        nodes in 2_usize..80,
        per_node in 0.5..6.0_f64,
        damped in any::<bool>(),
        limited in any::<bool>(),
        drag in prop::sample::select(vec![0.0_f32, 0.3]),
        integrator in prop::sample::select(Integrator::ALL.to_vec()),
    ) {
        let springs = (nodes as f64 * per_node) as usize;
        let net = net(Kind { nodes, springs, damped, limited }, seed);
        let (reference, scalar) = run_net(&net, None, integrator, drag);
        let mut works = Vec::new();
        for kernel in KERNELS {
            let (outcome, solver) = run_net(&net, Some(kernel), integrator, drag);
            prop_assert!(outcome == reference, "{}: {:?}", kernel.name(), outcome.first_difference(&reference));
            works.push(solver.work);
        }
        // Sums over nodes and springs go in one order with every width, and in another one by one.
        prop_assert_eq!(works[1], works[2]);
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-5 * (1.0 + b.abs());
        for work in &works[..2] {
            prop_assert!(close(work.damping, scalar.work.damping));
            prop_assert!(close(work.plastic, scalar.work.plastic));
            prop_assert!(close(work.fracture, scalar.work.fracture));
            prop_assert!(close(work.external, scalar.work.external));
        }
    }
}

#[test]
fn kernels_may_take_turns() {
    let kind = Kind {
        nodes: 60,
        springs: 240,
        damped: true,
        limited: true,
    };
    let net = net(kind, 3);
    let (mut reference, _) = run_net(&net, None, Integrator::SymplecticEuler, 0.0);
    reference.steps.clear();
    let mut state = net.1.clone();
    let mut solver = Solver::new(&net.0, &state);
    solver.external.gravity = [0.0, -9.81, 0.0];
    for i in 0..40 {
        solver.kernel = KERNELS[i / 3 % 3];
        solver.substep(&mut state, Integrator::SymplecticEuler, 2e-3);
        assert_copies_agree(&solver, &state);
    }
    assert!(outcome(&solver, &state) == reference);
}

/// Room for damping forces comes and goes with them, and what stood there does not come back.
#[test]
fn drag_may_come_and_go() {
    let material = Material::elastic(1e5, 100.0);
    let nets = [
        net(SWINGING, 7),
        regular::regular_net([6, 4, 3], false, material, |x| 3.0 * x[1]),
    ];
    for net in nets {
        let run = |kernel: Option<Kernel>| {
            let (mut state, mut solver) = start(&net, kernel);
            for i in 0..30 {
                solver.external.drag = if i / 3 % 2 == 1 { 0.4 } else { 0.0 };
                solver.substep(&mut state, Integrator::SymplecticEuler, 1e-3);
                assert_eq!(solver.forces.damping.is_empty(), i / 3 % 2 == 0);
            }
            (outcome(&solver, &state), solver.work.damping)
        };
        let (reference, work) = run(None);
        assert!(work > 0.0);
        for kernel in KERNELS {
            let (outcome, other) = run(Some(kernel));
            assert!(outcome == reference, "{}", kernel.name());
            assert!((other - work).abs() < 1e-5 * work, "{other} {work}");
        }
    }
}

#[test]
fn the_random_nets_yield_and_break() {
    let kind = Kind {
        nodes: 60,
        springs: 240,
        damped: true,
        limited: true,
    };
    let net = net(kind, 1);
    let (end, _) = run_net(&net, Some(Kernel::Auto), Integrator::SymplecticEuler, 0.0);
    let broke = end.events.iter().filter(|e| e.1).count();
    assert!(broke > 5 && end.events.len() > broke + 20, "{broke}");
}

/// Flows that fall short of the last digit of rest lengths wait there, alike in every kernel.
#[test]
fn slow_flows_wait_for_a_digit_in_every_kernel() {
    let kind = Kind {
        nodes: 60,
        springs: 240,
        damped: true,
        limited: true,
    };
    let net = net(kind, 11);
    let run = |kernel: Option<Kernel>| {
        let (mut state, mut solver) = start(&net, kernel);
        let mut flowed = vec![0; net.0.len()];
        for _ in 0..200 {
            let before = state.flow.clone();
            solver.substep(&mut state, Integrator::SymplecticEuler, 1e-8);
            assert_copies_agree(&solver, &state);
            for (i, times) in flowed.iter_mut().enumerate() {
                *times += u32::from(state.flow[i] != before[i]);
            }
        }
        let plastic = solver.work.plastic;
        (outcome(&solver, &state), flowed, plastic)
    };
    let (reference, flowed, work) = run(None);
    let slow = flowed.iter().filter(|n| (5..100).contains(*n)).count();
    assert!(slow > 20, "{slow}");
    for kernel in KERNELS {
        let (outcome, again, other) = run(Some(kernel));
        assert!(outcome == reference, "{}", kernel.name());
        assert_eq!(again, flowed);
        assert!((other - work).abs() < 1e-5 * work, "{other} {work}");
    }
}

#[test]
fn a_node_force_is_applied_by_every_kernel() {
    let net = net(SWINGING, 5);
    let run = |kernel: Option<Kernel>| {
        let (mut state, mut solver) = start(&net, kernel);
        solver.external.node_forces = (0..37).map(|i| [i as f32, 1.0, -0.5]).collect();
        solver.substep(&mut state, Integrator::SymplecticEuler, 1e-3);
        outcome(&solver, &state)
    };
    let reference = run(None);
    for kernel in KERNELS {
        assert!(run(Some(kernel)) == reference, "{}", kernel.name());
    }
}

#[test]
fn what_is_not_finite_shows_in_the_speed() {
    let springs = [Spring::new(0, 1, 10.0).rest_length(1.0)];
    for bad in [f32::NAN, f32::INFINITY] {
        for kernel in KERNELS {
            let nodes = (0..40).map(|i| ([i as f32, 0.0, 0.0], [0.0; 3], 1.0));
            let mut state = State::new(nodes, [1.0]);
            let mut solver = Solver::new(&springs, &state);
            solver.kernel = kernel;
            solver.substep(&mut state, Integrator::SymplecticEuler, 1e-3);
            assert!(solver.speed_squared.is_finite());
            state.particles[7].v[1] = bad;
            solver.substep(&mut state, Integrator::SymplecticEuler, 1e-3);
            assert!(!solver.speed_squared.is_finite(), "{}", kernel.name());
        }
    }
}

#[test]
fn a_mesh_without_order_is_visited_along_itself() {
    // A rope of 3000 nodes numbered at random.
    let mut r = Numbers(9);
    let mut names: Vec<u32> = (0..3000).collect();
    for i in (1..3000).rev() {
        names.swap(i, r.below(i + 1) as usize);
    }
    let springs = (0..2999).map(|i| (i as u32, [names[i], names[i + 1]]));
    let rows = order::rows(&Adjacency::new(3000, springs));
    let mut place = vec![0; 3000];
    for (at, &node) in rows.iter().enumerate() {
        place[node as usize] = at as u32;
    }
    let apart = |i: usize| place[names[i] as usize].abs_diff(place[names[i + 1] as usize]);
    // All but those at the borders of windows, where rows of fewer springs go last, are neighbours.
    let near = (0..2999).filter(|&i| apart(i) <= 2).count();
    assert!(near > 2980, "{near}");
    let mut sorted = rows.clone();
    sorted.sort_unstable();
    assert!(sorted.iter().enumerate().all(|(i, &n)| i == n as usize));
}

#[test]
fn tables_too_short_are_refused() {
    let mut places = vector::Places::new(3).unwrap();
    places.push([2; LANES]);
    let rows = [[0.0_f32; 4]; 3];
    assert!(places.of(&rows).is_some());
    assert!(places.of(&rows[..2]).is_none());
    assert!(vector::Places::new(usize::MAX / 32).is_none());
}

#[test]
fn the_tables_are_lean() {
    use crate::body::{Blueprint, Material};
    use crate::math::Vector;
    use crate::shape::{TetSplit, lattice, tet_box};
    let elastic = Material::elastic(1e6, 100.0);
    let plastic = elastic.yielding(1e4, 1e4).viscosity(10.0);
    let bytes = |net, material| {
        let blueprint = Blueprint::resolve(net, |_| Some(material), None).unwrap();
        let mut state = blueprint.rest_state();
        let mut solver = Solver::new(&blueprint.springs, &state);
        solver.substep(&mut state, Integrator::SymplecticEuler, 1e-6);
        let springs = blueprint.springs.len();
        solver.table_bytes().map(|b| b as f64 / springs as f64)
    };
    let regular = || lattice(Vector::ONE, 0.05).unwrap();
    let tets = || tet_box(Vector::ONE, 0.1, TetSplit::Five).unwrap().springs();
    // Few constants are distinct in a regular net, and all are in one of tets.
    for (net, material, [hot, all]) in [
        (regular(), elastic, [4.0, 36.0]),
        (regular(), plastic, [7.0, 100.0]),
        (tets(), elastic, [10.0, 52.0]),
        (tets(), plastic, [18.0, 128.0]),
    ] {
        let found = bytes(net, material);
        println!("{found:?}");
        assert!(found[0] < hot && found[1] < all, "{found:?}");
    }
}
