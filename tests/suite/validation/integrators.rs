//! Growth, order and conservation of the integration schemes.

use crate::support::{close, weightless};
use crumple::body::{Net, Node, State};
use crumple::math::{DVec3, Scalar};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::solve::Solver;

/// A mass of 1 kg on a spring of 100 N/m whose other end is held, `x0` m out of rest.
struct Oscillator<S> {
    solver: Solver<S>,
    state: State<S>,
    rest: f64,
}

impl<S: Scalar> Oscillator<S> {
    fn new(damping: f32, rest: f32, x0: f64) -> Self {
        let spring = Spring::new(0, 1, 100.0).damping(damping).rest_length(rest);
        let zero = [S::ZERO; 3];
        let at = [S::of(f64::from(rest) + x0), S::ZERO, S::ZERO];
        let state = State::new(
            [(zero, zero, S::ZERO), (at, zero, S::ONE)],
            [S::of(rest.into())],
        );
        Self {
            solver: Solver::new(&[spring], &state),
            state,
            rest: rest.into(),
        }
    }

    fn run(&mut self, integrator: Integrator, h: f64, steps: usize) {
        for _ in 0..steps {
            self.solver.substep(&mut self.state, integrator, h);
        }
    }

    /// Displacement and velocity.
    fn now(&self) -> (f64, f64) {
        (self.state.local(1).x - self.rest, self.state.velocity(1).x)
    }

    fn energy(&self) -> f64 {
        let (x, v) = self.now();
        0.5 * (v * v + 100.0 * x * x)
    }
}

/// V01: growth per step of the complex modal amplitude |(s + c)·x + v|, s the oscillator's own eigenvalue.
#[test]
fn v01_explicit_euler_grows_as_it_must() {
    for (c, h, expected) in [
        (3.0, 0.01, 0.989950),
        (3.0, 0.03, 1.000000),
        (3.0, 0.035, 1.008712),
        (0.0, 0.01, 1.004988),
        (0.0, 0.035, 1.059481),
    ] {
        let mut o = Oscillator::<f64>::new(c, 1e3, 1.0);
        let c = f64::from(c);
        let amplitude = |(x, v): (f64, f64)| {
            let omega = (100.0 - 0.25 * c * c).sqrt();
            (0.5 * c * x + v).hypot(omega * x)
        };
        let before = amplitude(o.now());
        o.run(Integrator::ExplicitEuler, h, 100);
        let growth = (amplitude(o.now()) / before).powf(0.01);
        close(
            &format!("growth per step at c = {c}, h = {h}"),
            growth,
            expected,
            1e-6,
        );
    }
}

/// V02: error and order of the damped oscillator after 1 s.
#[test]
fn v02_orders_of_the_schemes() {
    let error = |integrator, h: f64| {
        let mut o = Oscillator::<f64>::new(1.0, 10.0, 1.0);
        o.run(integrator, h, (1.0 / h).round() as usize);
        let (x, v) = o.now();
        let omega = 99.75_f64.sqrt();
        let decay = (-0.5_f64).exp();
        let exact_x = decay * (omega.cos() + 0.5 / omega * omega.sin());
        let exact_v = -decay * 100.0 / omega * omega.sin();
        close("exact x(1)", exact_x, -0.52920882, 1e-7);
        close("exact v(1)", exact_v, 3.23979553, 1e-7);
        (x - exact_x).hypot((v - exact_v) / 10.0)
    };
    for (integrator, expected, order, order_tolerance) in [
        (Integrator::ExplicitEuler, 0.4031, 1.0, 0.05),
        (Integrator::SymplecticEuler, 0.03117, 1.0, 0.05),
        (Integrator::VelocityVerlet, 0.002151, 2.0, 0.05),
        (Integrator::Midpoint, 0.009908, 2.0, 0.05),
        (Integrator::Rk4, 4.95e-6, 4.0, 0.1),
    ] {
        let name = integrator.name();
        close(
            &format!("{name}: error at h = .01"),
            error(integrator, 0.01),
            expected,
            0.03,
        );
        let measured = (error(integrator, 1e-3) / error(integrator, 5e-4)).log2();
        assert!(
            (measured - order).abs() <= order_tolerance,
            "{name}: order {measured}, expected {order} to {order_tolerance}"
        );
    }
}

/// V03: energy of the undamped oscillator after 1e5 steps of ω·h = .1.
#[test]
fn v03_energy_of_the_undamped_oscillator() {
    let run = |integrator| {
        let mut o = Oscillator::<f64>::new(0.0, 5.0, 1.0);
        let initial = o.energy();
        let energies: Vec<f64> = (0..100_000)
            .map(|_| {
                o.run(integrator, 0.01, 1);
                o.energy() / initial
            })
            .collect();
        energies
    };
    close(
        "midpoint: E/E0",
        *run(Integrator::Midpoint).last().unwrap(),
        12.18,
        1e-3,
    );
    close(
        "RK4: E/E0",
        *run(Integrator::Rk4).last().unwrap(),
        0.99861,
        1e-3,
    );
    for (integrator, least, most) in [
        (Integrator::VelocityVerlet, 0.9975, 1.0),
        (Integrator::SymplecticEuler, 0.952381, 1.052632),
    ] {
        let energies = run(integrator);
        let low = energies.iter().copied().fold(f64::INFINITY, f64::min);
        let high = energies.iter().copied().fold(0.0, f64::max);
        assert!(
            low >= least - 1e-6 && high <= most + 1e-6,
            "{}: E/E0 in [{low}, {high}], must lie in [{least}, {most}]",
            integrator.name()
        );
        let mean = |window: &[f64]| window.iter().sum::<f64>() / window.len() as f64;
        close(
            &format!("{}: last window mean over the first", integrator.name()),
            mean(&energies[90_000..]) / mean(&energies[..10_000]),
            1.0,
            1e-3,
        );
    }
}

/// V03: the scheme of the textbook explodes.
#[test]
fn v03_explicit_euler_explodes() {
    let mut o = Oscillator::<f64>::new(0.0, 1e4, 1.0);
    let initial = o.energy();
    o.run(Integrator::ExplicitEuler, 0.01, 1000);
    close(
        "explicit Euler: E/E0 after 1000 steps",
        o.energy() / initial,
        1.01_f64.powi(1000),
        1e-3,
    );
    assert!(o.energy() / initial > 100.0);
}

/// V03: Verlet in single precision.
#[test]
fn v03_verlet_in_f32() {
    let mut o = Oscillator::<f32>::new(0.0, 5.0, 1.0);
    let initial = o.energy();
    for step in 0..100_000 {
        o.run(Integrator::VelocityVerlet, 0.01, 1);
        let ratio = o.energy() / initial;
        assert!(
            (0.997..=1.0001).contains(&ratio),
            "E/E0 = {ratio} at step {step}, must lie in [.997, 1.0001]"
        );
    }
}

/// V03: a body that has exploded is frozen, finite and reported.
#[test]
fn v03_an_explosion_is_frozen() {
    let net = Net::new(
        vec![
            Node::new(Vector::ZERO, 1.0).pinned(),
            Node::new(Vector::new(5.0, 0.0, 0.0), 1.0),
        ],
        vec![Spring::new(0, 1, 100.0)],
    );
    let mut world = weightless(0.01);
    let mut deformables = DeformableWorld::default();
    let handle = deformables
        .insert(
            DeformableBuilder::new(net)
                .integrator(Integrator::ExplicitEuler)
                .substeps(Substeps::Unchecked(1)),
        )
        .unwrap();
    deformables[handle].set_linvel_of(NodeId(1), Vector::new(10.0, 0.0, 0.0));
    let mut frozen_at = None;
    for step in 0..100_000 {
        deformables.step(&mut world);
        assert!(deformables.report().unstable.contains(&handle) || frozen_at.is_some());
        if deformables.report().frozen.contains(&handle) {
            frozen_at = Some(step);
            break;
        }
    }
    let body = &deformables[handle];
    assert!(
        frozen_at.is_some() && body.is_frozen(),
        "frozen at {frozen_at:?}"
    );
    for node in 0..2 {
        assert!(body.position(NodeId(node)).unwrap().is_finite());
        assert_eq!(body.linvel_of(NodeId(node)), Some(DVec3::ZERO));
    }
}

/// V04: a free spinning cube of 8 masses and 28 springs.
#[test]
fn v04_momentum_of_a_spinning_cube() {
    let corner = |i: u32, bit: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
    let nodes: Vec<Node> = (0..8)
        .map(|i| Node::new(Vector::new(corner(i, 0), corner(i, 1), corner(i, 2)), 1.0))
        .collect();
    let springs = (0..8)
        .flat_map(|a| (a + 1..8).map(move |b| Spring::new(a, b, 1000.0)))
        .collect::<Vec<_>>();
    assert_eq!(springs.len(), 28);
    let net = Net::new(nodes, springs);
    for integrator in [
        Integrator::SymplecticEuler,
        Integrator::VelocityVerlet,
        Integrator::Rk4,
        Integrator::Midpoint,
    ] {
        let mut world = weightless(0.02);
        let mut deformables = DeformableWorld::default();
        let handle = deformables
            .insert(
                DeformableBuilder::new(net.clone())
                    .linvel(Vector::new(1.0, 0.0, 0.0))
                    .angvel(Vector::new(1.0, 2.0, 3.0))
                    .integrator(integrator)
                    .substeps(Substeps::Unchecked(10)),
            )
            .unwrap();
        let about_com = |d: &Deformable| d.angular_momentum(d.center_of_mass());
        let (p, l) = (
            deformables[handle].momentum(),
            about_com(&deformables[handle]),
        );
        let (mut worst_p, mut worst_l) = (0.0_f64, 0.0_f64);
        for _ in 0..2000 {
            deformables.step(&mut world);
            let body = &deformables[handle];
            worst_p = worst_p.max((body.momentum() - p).length() / p.length());
            worst_l = worst_l.max((about_com(body) - l).length() / l.length());
        }
        let name = integrator.name();
        assert!(
            worst_p <= 2e-5,
            "{name}: momentum off by {worst_p:.3e}, allowed 2e-5"
        );
        if integrator == Integrator::Midpoint {
            close(
                "midpoint: drift of the angular momentum",
                worst_l,
                2e-3,
                0.05,
            );
        } else {
            assert!(
                worst_l <= 1e-5,
                "{name}: angular momentum off by {worst_l:.3e}, allowed 1e-5"
            );
        }
    }
}

/// A repeatable source of numbers in [0, 1).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }

    /// Between `low` and `high`, evenly in the logarithm.
    fn between(&mut self, low: f32, high: f32) -> f32 {
        low * (high / low).powf(self.roll())
    }
}

/// A net of 4 to 12 nodes of unequal mass, every two of them joined with a chance of 0.6 by a spring of any stiffness.
fn random_net(dice: &mut Dice, zeta: f32) -> Net {
    let n = 4 + (dice.roll() * 9.0) as u32;
    let nodes: Vec<Node> = (0..n)
        .map(|i| {
            let at = Vector::new(dice.roll(), dice.roll(), dice.roll());
            let node = Node::new(
                at + Vector::new(i as f32, 0.0, 0.0) * 0.2,
                dice.between(0.1, 10.0),
            );
            if dice.roll() < 0.1 {
                node.pinned()
            } else {
                node
            }
        })
        .collect();
    let mut springs = Vec::new();
    for a in 0..n {
        for b in a + 1..n {
            if b == a + 1 || dice.roll() < 0.6 {
                let k = dice.between(10.0, 1e5);
                let m = nodes[a as usize].mass.min(nodes[b as usize].mass);
                let c = 2.0 * zeta * dice.roll() * (k * m).sqrt();
                springs.push(Spring::new(a, b, k).damping(c));
            }
        }
    }
    Net::new(nodes, springs)
}

/// Energy of a body: kinetic at the time of the positions (symplectic Euler's velocities stand half a substep of `lead` s
/// back) and elastic.
fn energy(net: &Net, state: &State<f64>, lead: f64) -> f64 {
    let kinetic: f64 = net
        .nodes
        .iter()
        .enumerate()
        .filter(|(_, node)| !node.pinned)
        .map(|(i, node)| 0.5 * f64::from(node.mass) * state.velocity(i).length_squared())
        .sum();
    let springs: f64 = net
        .springs
        .iter()
        .zip(&state.rest)
        .map(|(s, rest)| {
            let [a, b] = s.nodes.map(|n| n as usize);
            let d = state.local(b) - state.local(a);
            let e = d.length() - rest;
            let rate = (state.velocity(b) - state.velocity(a)).dot(d) / d.length();
            f64::from(s.stiffness) * e * (0.5 * e - lead * rate)
        })
        .sum();
    kinetic + springs
}

/// Energy never grows at .95 of the substep that is reported as stable, once the fastest mode is known.
#[test]
fn the_reported_step_is_stable() {
    let mut dice = Dice(7);
    for case in 0..60 {
        for (integrator, zeta) in [
            (Integrator::SymplecticEuler, 0.0),
            (Integrator::SymplecticEuler, 0.5),
            (Integrator::SymplecticEuler, 4.0),
            (Integrator::Rk4, 0.0),
            (Integrator::Rk4, 1.0),
        ] {
            let net = random_net(&mut dice, zeta);
            let mut state = State::<f64>::new(
                net.nodes.iter().map(|node| {
                    let inv_mass = if node.pinned {
                        0.0
                    } else {
                        1.0 / f64::from(node.mass)
                    };
                    (node.position.as_dvec3().to_array(), [0.0; 3], inv_mass)
                }),
                net.springs.iter().map(|s| {
                    let [a, b] = s.nodes.map(|n| net.nodes[n as usize].position.as_dvec3());
                    a.distance(b)
                }),
            );
            let mut solver = Solver::new(&net.springs, &state);
            solver.learn(&mut state, integrator);
            let h = 0.95 * solver.stable_step(&state, integrator).h;
            assert!(h > 0.0, "net {case}: no stable step");
            // So slow that a node moves by 1e-7 m in a step: the net stays what it is.
            for particle in state.particles.iter_mut().filter(|p| p.inv_mass > 0.0) {
                particle.v = [(); 3].map(|()| 1e-7 / h * (f64::from(dice.roll()) - 0.5));
            }
            let lead = if integrator == Integrator::SymplecticEuler {
                0.5 * h
            } else {
                0.0
            };
            solver.substep(&mut state, integrator, h);
            let initial = energy(&net, &state, lead);
            let mut largest = initial;
            for _ in 0..2000 {
                solver.substep(&mut state, integrator, h);
                largest = largest.max(energy(&net, &state, lead));
            }
            let name = integrator.name();
            let growth = largest / initial;
            assert!(
                growth <= 1.0 + 1e-4,
                "net {case}, {name}, ζ up to {zeta}: energy grows to {growth} in 2000 steps of {h} s"
            );
        }
    }
}

/// The textbook's loop damps by drag, not by its springs: that makes explicit Euler stable below h = D/k too.
#[test]
fn drag_makes_explicit_euler_stable() {
    use crumple::body::{Net, Node};
    use crumple::rapier3d::prelude::{PhysicsWorld, Vector};
    let net = Net::new(
        vec![
            Node::new(Vector::ZERO, 1.0).pinned(),
            Node::new(Vector::new(2.0, 0.0, 0.0), 1.0),
        ],
        vec![Spring::new(0, 1, 100.0).rest_length(1.5)],
    );
    let mut world = PhysicsWorld {
        gravity: Vector::ZERO,
        ..PhysicsWorld::default()
    };
    let mut set = DeformableWorld::new();
    let body = set
        .insert(
            DeformableBuilder::new(net)
                .drag(3.0)
                .integrator(Integrator::ExplicitEuler),
        )
        .unwrap();
    let h = set[body].stable_step().h;
    assert!(h > 0.02 && h <= 0.03, "D/k is 0.03 s, the bound {h} s");
    for _ in 0..600 {
        set.step(&mut world);
    }
    let x = set[body].position(NodeId(1)).unwrap().x;
    assert!((x - 1.5).abs() < 1e-3, "at rest at 1.5 m, not {x} m");
}
