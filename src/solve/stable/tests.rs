//! The bound against modes that are known.

use super::*;
use crate::body::shape::{lattice, sheet};
use crate::body::{Blueprint, Material, Spring};
use crate::math::{DVec3, Vector};

/// The largest eigenvalue of M⁻¹K \[1/s²\] at rest, by the power method, from below.
fn fastest(blueprint: &Blueprint, state: &State<f64>) -> f64 {
    let nodes = state.particles.len();
    let mut u: Vec<DVec3> = (0..nodes)
        .map(|i| {
            DVec3::new(
                (i * 7 % 11) as f64 - 5.0,
                (i * 5 % 7) as f64 - 3.0,
                (i * 3 % 5) as f64 - 2.0,
            )
        })
        .collect();
    let mut found = 0.0;
    for _ in 0..3000 {
        let mut f = vec![DVec3::ZERO; nodes];
        for spring in &blueprint.springs {
            let [a, b] = spring.nodes.map(|n| n as usize);
            let d = (state.local(b) - state.local(a)).normalize();
            let pull = d * d.dot(u[b] - u[a]) * f64::from(spring.stiffness);
            f[a] -= pull;
            f[b] += pull;
        }
        for (f, p) in f.iter_mut().zip(&state.particles) {
            *f *= p.inv_mass;
        }
        found = f.iter().map(|f| f.length_squared()).sum::<f64>().sqrt();
        u = f.iter().map(|f| *f / found).collect();
    }
    found
}

#[test]
fn the_bound_closes_in_on_the_fastest_mode_and_stays_above() {
    let block = lattice(Vector::new(0.6, 0.4, 0.4), 0.1).unwrap();
    let cloth = sheet(1.0, 1.0, 10, 10, 2e-3).unwrap();
    let pinned = cloth.clone().pin(|x| x.x < -0.49);
    for (name, net) in [("block", block), ("cloth", cloth), ("pinned cloth", pinned)] {
        let blueprint = Blueprint::resolve(net, |_| Some(Material::rubber()), None).unwrap();
        let nodes = blueprint.nodes.iter().map(|n| {
            let w = if n.pinned {
                0.0
            } else {
                1.0 / f64::from(n.mass)
            };
            (n.position.as_dvec3().to_array(), [0.0; 3], w)
        });
        // As long as they are here, in `f64`, so that none resists sideways.
        let lengths = blueprint.springs.iter().map(|s| {
            let [a, b] = s
                .nodes
                .map(|n| blueprint.nodes[n as usize].position.as_dvec3());
            a.distance(b)
        });
        let mut state = State::<f64>::new(nodes, lengths);
        let undamped = blueprint.springs.iter().map(|s| s.damping(0.0));
        let mut solver = Solver::new(&undamped.collect::<Vec<_>>(), &state);
        let exact = 2.0 / fastest(&blueprint, &state).sqrt();
        let share = |solver: &Solver<f64>, state: &State<f64>| {
            solver.stable_step(state, Integrator::SymplecticEuler).h / exact
        };
        assert!(
            (0.8..0.87).contains(&share(&solver, &state)),
            "{name}: {}",
            share(&solver, &state)
        );
        solver.learn(&mut state, Integrator::SymplecticEuler);
        for look in 0..40 {
            let share = share(&solver, &state);
            assert!(
                (0.96..1.0 + 1e-9).contains(&share),
                "{name}: {share} at look {look}"
            );
            solver.review(&mut state, Integrator::SymplecticEuler);
        }
    }
}

fn chain(stiffness: &[f32]) -> (Solver<f64>, State<f64>) {
    let count = stiffness.len() + 1;
    let nodes = (0..count).map(|i| ([i as f64, 0.0, 0.0], [0.0; 3], 2.0));
    let state = State::new(nodes, vec![1.0; stiffness.len()]);
    let springs: Vec<Spring> = (0..)
        .zip(stiffness)
        .map(|(i, &k)| Spring::new(i, i + 1, k))
        .collect();
    (Solver::new(&springs, &state), state)
}

/// In a mode that has been learned every node has the same rate: which is the largest does not tell the culprit.
#[test]
fn the_spring_that_sets_the_step_is_named() {
    for culprit in 0..8 {
        let mut stiffness = [1000.0; 8];
        stiffness[culprit] = 1500.0;
        let (mut solver, mut state) = chain(&stiffness);
        for _ in 0..4 {
            solver.learn(&mut state, Integrator::SymplecticEuler);
            let step = solver.stable_step(&state, Integrator::SymplecticEuler);
            assert_eq!(step.spring, Some(culprit as u32));
        }
    }
}

#[test]
fn free_nodes_that_claim_not_to_swing_are_not_believed() {
    let (mut solver, mut state) = chain(&[1000.0, 3000.0, 500.0]);
    let sound = solver.stable_step(&state, Integrator::SymplecticEuler);
    for bad in [0.0, -1.0, f64::NAN] {
        state.particles[1].swing = bad;
        let found = solver.stable_step(&state, Integrator::SymplecticEuler);
        assert_eq!(found, sound, "{bad}");
    }
    let found = solver.review(&mut state, Integrator::SymplecticEuler);
    assert_eq!(found.h, sound.h);
}

/// The integration takes speeds below 1e-20 m/s for none, and a swing goes along with them.
#[test]
fn no_node_is_too_heavy_to_swing() {
    let (mut solver, mut state) = chain(&[1000.0, 3000.0, 500.0]);
    state.set_inv_mass(1, 1e-30);
    solver.learn(&mut state, Integrator::SymplecticEuler);
    assert!(state.particles.iter().all(|p| p.swing > 1e-15));
}

/// However it is folded, by rows as one by one: it may be straight before the next look.
#[test]
fn a_folded_chain_has_the_step_of_a_straight_one() {
    let springs: Vec<Spring> = (0..5)
        .map(|i| Spring::new(i, i + 1, 1e5).damping(3.0))
        .collect();
    let folds: [[[f64; 3]; 6]; 2] = [
        [0.0, 1.0, 2.0, 3.0, 4.0, 5.0].map(|x| [x, 0.0, 0.0]),
        [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 1.0, 1.0],
            [1.0, 0.0, 1.0],
            [0.0, 0.0, 1.0],
        ],
    ];
    let steps = folds.map(|places| {
        let nodes = places.map(|x| (x.map(|x| x as f32), [0.0; 3], 500.0));
        let mut state = State::<f32>::new(nodes, [1.0; 5]);
        let mut solver = Solver::new(&springs, &state);
        let one_by_one = solver.stable_step(&state, Integrator::SymplecticEuler).h;
        solver.make_ready(&state);
        let by_rows = solver.review(&mut state, Integrator::SymplecticEuler).h;
        [one_by_one, by_rows]
    });
    let [[a, b], [c, d]] = steps;
    assert!(a == b && c == d, "{steps:?}");
    // The ends have one spring, whose direction is found by an eigenvalue.
    assert!((c / a - 1.0).abs() < 1e-5, "{steps:?}");
}
