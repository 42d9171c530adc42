//! One-dimensional networks: frequencies, hanging chains, waves.

use crate::support::{Random, bar, close, weightless};
use crumple::body::{Net, Node, State};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::solve::Solver;
use std::f64::consts::PI;

/// V06: mode j of ten masses between two walls, by the time of many zero crossings.
#[test]
fn v06_frequencies_of_a_chain() {
    let h = 5e-4;
    for integrator in [
        Integrator::SymplecticEuler,
        Integrator::VelocityVerlet,
        Integrator::Rk4,
    ] {
        for j in 1..=10_u32 {
            let shape = |i: usize| (f64::from(j) * PI * i as f64 / 11.0).sin();
            let springs: Vec<Spring> = (0..11)
                .map(|i| Spring::new(i, i + 1, 1000.0).rest_length(1.0))
                .collect();
            let nodes = (0..12).map(|i| {
                let held = i == 0 || i == 11;
                let v = if held { 0.0 } else { shape(i) as f32 };
                (
                    [i as f32, 0.0, 0.0],
                    [v, 0.0, 0.0],
                    if held { 0.0 } else { 10.0 },
                )
            });
            let mut state = State::<f32>::new(nodes, [1.0; 11]);
            let mut solver = Solver::new(&springs, &state);
            let q = |state: &State<f32>| -> f64 {
                (1..11)
                    .map(|i| shape(i) * (state.local(i).x - i as f64))
                    .sum()
            };
            let (mut last, mut crossings) = (0.0, Vec::new());
            for step in 1..=6000 {
                solver.substep(&mut state, integrator, h);
                let now = q(&state);
                if last < 0.0 && now >= 0.0 {
                    crossings.push((f64::from(step) - now / (now - last)) * h);
                }
                last = now;
            }
            let periods = crossings.len() - 1;
            let measured = periods as f64 / (crossings[periods] - crossings[0]);
            // Leapfrog runs fast: sin(½ω̃h) = ½ωh. The phase error of RK4 is (ωh)⁴/120.
            let own = match integrator {
                Integrator::Rk4 => measured,
                _ => (PI * measured * h).sin() / (PI * h),
            };
            let expected = 100.0 / PI * (f64::from(j) * PI / 22.0).sin();
            close(
                &format!("{}: f_{j} [Hz]", integrator.name()),
                own,
                expected,
                1e-3,
            );
        }
    }
}

/// V08: ten masses on ten springs.
#[test]
fn v08_hanging_chain() {
    let mut nodes = vec![Node::new(Vector::ZERO, 1.0).pinned()];
    nodes.extend((1..=10).map(|i| Node::new(Vector::new(0.0, -0.1 * i as f32, 0.0), 0.1)));
    let springs = (0..10).map(|i| Spring::new(i, i + 1, 1000.0)).collect();
    let mut world = PhysicsWorld::default();
    let mut deformables = DeformableWorld::default();
    let chain = deformables
        .insert(DeformableBuilder::new(Net::new(nodes, springs)).drag(3.0))
        .unwrap();
    for _ in 0..180 {
        deformables.step(&mut world);
    }
    let body = &deformables[chain];
    let y = |i: u32| body.position(NodeId(i)).unwrap().y;
    let total = 0.053955;
    for j in 1..=10_u32 {
        let rest = f64::from(
            body.blueprint().springs[j as usize - 1]
                .rest_length
                .unwrap(),
        );
        let stretch = y(j - 1) - y(j) - rest;
        let expected = f64::from(11 - j) * 0.1 * 9.81 / 1000.0;
        assert!(
            (stretch - expected).abs() <= 1e-4 * total,
            "stretch of spring {j}: {stretch} m, expected {expected} m to 1e-4 of {total} m"
        );
    }
    close("total stretch [m]", -y(10) - 1.0, total, 1e-4);
}

/// V08: a catenary of 100 links, let go as a V.
#[test]
fn v08_catenary() {
    let n = 100;
    let nodes = (0..=n)
        .map(|i| {
            let s = i as f32 / n as f32 * 10.0;
            let down = 0.6 * s.min(10.0 - s);
            let node = Node::new(Vector::new(0.8 * s - 4.0, -down, 0.0), 0.1);
            if i == 0 || i == n {
                node.pinned()
            } else {
                node
            }
        })
        .collect();
    let springs = (0..n)
        .map(|i| Spring::new(i, i + 1, 6.0e6).rest_length(0.1).damping(150.0))
        .collect();
    let mut world = PhysicsWorld::default();
    let mut deformables = DeformableWorld::default();
    let chain = deformables
        .insert(DeformableBuilder::new(Net::new(nodes, springs)).drag(0.4))
        .unwrap();
    for _ in 0..480 {
        deformables.step(&mut world);
    }
    let body = &deformables[chain];
    let fastest = body.velocities().map(|v| v.length()).fold(0.0, f32::max);
    assert!(fastest < 1e-2, "still moving at {fastest} m/s");
    let sag = -body.position(NodeId(n / 2)).unwrap().y;
    close("sag [m]", sag, 2.654375, 1e-3);
}

/// V09: a raised-cosine velocity pulse sent into the bar at one end runs to the free end and doubles there.
#[test]
fn v09_pulse_in_a_bar() {
    let (n, c) = (100, 44.72136_f64);
    let dt = 1e-4_f64;
    let mut net = bar(n, 1.0, 20_000.0, 10.0);
    net.nodes[0].pinned = true;
    let mut world = weightless(dt as f32);
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = dt;
    let handle = deformables
        .insert(DeformableBuilder::new(net).substeps(Substeps::Fixed(1)))
        .unwrap();
    let duration = 0.2 / c;
    // Integral of ½·(1 − cos(2πt/T))·1 m/s.
    let pushed = |t: f64| {
        let t = t.min(duration);
        0.5 * (t - duration / (2.0 * PI) * (2.0 * PI * t / duration).sin())
    };
    let mut speed = Vec::new();
    for step in 1..=400 {
        let to = pushed(f64::from(step) * dt);
        deformables[handle].set_kinematic_target(NodeId(0), Vector::new(to as f32, 0.0, 0.0));
        deformables.step(&mut world);
        // The velocity of symplectic Euler stands half a substep back.
        let t = (f64::from(step) - 0.5) * dt;
        speed.push((
            t,
            deformables[handle].linvel_of(NodeId(n as u32)).unwrap().x,
        ));
    }
    let top = (1..speed.len() - 1)
        .max_by(|&a, &b| speed[a].1.total_cmp(&speed[b].1))
        .unwrap();
    let (a, b, d) = (speed[top - 1].1, speed[top].1, speed[top + 1].1);
    let offset = 0.5 * (a - d) / (a - 2.0 * b + d);
    let arrival = speed[top].0 + offset * dt - 0.5 * duration;
    let peak = b - 0.25 * (a - d) * offset;
    close("arrival of the peak [s]", arrival, 1.0 / c, 0.005);
    assert!(
        (peak - 2.0).abs() <= 0.05,
        "free end: {peak} times the pulse, expected 2 ± .05"
    );
}

/// Ropes that are thrown with their nodes flying about fold and straighten within a step. Springs in line make the fastest
/// mode, and with overdamped ones the substep of the folded rope was once too long for the straight one: dampers then gave
/// energy instead of taking it.
#[test]
fn a_whipped_rope_only_loses_energy() {
    let (stiffness, mass, length) = (1e5_f32, 3e-4_f32, 0.04);
    let viscosity = 3.0 * 2.0 * (stiffness * mass).sqrt();
    for (speed, seed) in [10.0, 30.0]
        .into_iter()
        .flat_map(|v| (0..40).map(move |s| (v, s)))
    {
        let mut random = Random(seed * 17 + 3);
        let mut at = Vector::ZERO;
        let nodes = (0..6).map(|_| {
            let mut node = Node::new(at, mass);
            node.linvel = random.direction() * speed;
            at += random.direction() * length;
            node
        });
        let nodes = nodes.collect();
        let springs = (0..5).map(|i| Spring::new(i, i + 1, stiffness).damping(viscosity));
        let mut world = weightless(1.0 / 60.0);
        let mut deformables = DeformableWorld::default();
        let rope = DeformableBuilder::new(Net::new(nodes, springs.collect()));
        let rope = deformables.insert(rope).unwrap();
        let energy = |deformables: &DeformableWorld| {
            let e = deformables[rope].energies();
            e.kinetic + e.elastic
        };
        let first = energy(&deformables);
        for step in 0..6 {
            deformables.step(&mut world);
            let now = energy(&deformables);
            assert!(
                now <= 1.001 * first,
                "seed {seed} at {speed} m/s, step {step}: {first} J became {now} J"
            );
        }
    }
}
