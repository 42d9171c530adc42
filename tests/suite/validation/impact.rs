//! Impact of bars and oscillators on walls and rigid bodies.

use crate::support::{bar, close, weightless};
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::world::Substep;

/// Sums the impulse of all colliders on deformables along x, substep by substep.
#[derive(Default)]
struct Impulses {
    /// End of the substep, its length, impulse.
    samples: Vec<(f64, f64, f64)>,
    /// Tension of spring 0 after the substep.
    tension: Vec<f64>,
    /// Velocity of the centre of mass.
    velocity: Vec<f64>,
}

impl Observer for Impulses {
    fn substep(&mut self, s: &Substep) {
        let j = s.contacts.iter().map(|c| c.impulse.x).sum();
        self.samples.push((s.time, s.h, j));
        let body = &s.deformables[0].1;
        self.tension.push(body.tension(SpringId(0)).unwrap());
        self.velocity.push(body.linvel().x);
    }
}

/// V28: a mass on a spring and damper behind a nearly massless front node.
#[test]
fn v28_restitution_of_a_damped_oscillator() {
    for (zeta, expected) in [(0.1, 0.743), (0.2, 0.571)] {
        let damping = 2.0 * zeta * (1000.0_f32).sqrt();
        let net = Net::new(
            vec![
                Node::new(Vector::ZERO, 1e-3),
                Node::new(Vector::new(1.0, 0.0, 0.0), 1.0),
            ],
            vec![Spring::new(0, 1, 1000.0).damping(damping)],
        );
        let mut world = weightless(1e-3);
        world.insert(
            RigidBodyBuilder::fixed().translation(Vector::new(-1.0, 0.0, 0.0)),
            ColliderBuilder::cuboid(1.0, 1.0, 1.0),
        );
        let mut deformables = DeformableWorld::default();
        deformables
            .insert(
                DeformableBuilder::new(net)
                    .translation(Vector::new(1e-4, 0.0, 0.0))
                    .linvel(Vector::new(-1.0, 0.0, 0.0)),
            )
            .unwrap();
        let mut seen = Impulses::default();
        for _ in 0..300 {
            deformables.step_with(&mut world, &(), &(), &mut seen);
        }
        let last = seen
            .samples
            .iter()
            .rposition(|s| s.2 != 0.0)
            .expect("contact");
        close(
            &format!("e at zeta = {zeta}"),
            seen.velocity[last],
            expected,
            0.01,
        );
    }
}

/// V30: Saint-Venant's bar on a fixed wall.
#[test]
fn v30_bar_on_a_wall() {
    let (n, transit) = (50, 1.0 / 44.72136);
    let h = 0.5 * 2.0 / (4.0_f64 * 20_000.0 * 50.0 * 50.0 / 10.0).sqrt();
    let dt = 1e-3_f64;
    let mut world = weightless(dt as f32);
    world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(-1.0, 0.0, 0.0)),
        ColliderBuilder::cuboid(1.0, 1.0, 1.0),
    );
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = dt;
    let handle = deformables
        .insert(
            DeformableBuilder::new(bar(n, 1.0, 20_000.0, 10.0))
                .linvel(Vector::new(-1.0, 0.0, 0.0))
                .substeps(Substeps::Fixed((dt / h).round() as usize)),
        )
        .unwrap();
    let initial = deformables[handle].energies().balance();
    let mut seen = Impulses::default();
    for _ in 0..60 {
        deformables.step_with(&mut world, &(), &(), &mut seen);
    }
    let last = seen
        .samples
        .iter()
        .rposition(|s| s.2 != 0.0)
        .expect("contact");
    let e = seen.velocity[last];
    assert!(e >= 0.97, "restitution {e}, must be at least .97");
    close(
        "contact time over 2L/c",
        seen.samples[last].0,
        2.0 * transit * 1.010,
        0.02,
    );
    let plateau: Vec<f64> = seen
        .samples
        .iter()
        .zip(&seen.tension)
        .filter(|(s, _)| s.0 > 0.3 * transit && s.0 < 1.7 * transit)
        .map(|(_, t)| -t)
        .collect();
    let mean = plateau.iter().sum::<f64>() / plateau.len() as f64;
    close("mean force in the first spring [N]", mean, 447.214, 0.01);
    let impulse: f64 = seen.samples.iter().map(|s| s.2).sum();
    close("impulse [N·s]", impulse, 10.0 * (1.0 + e), 1e-4);
    let end = deformables[handle].energies();
    assert!(
        (end.balance() - initial).abs() < 0.01 * initial,
        "energy {} against {initial}: {end:?}",
        end.balance()
    );
}

/// V32: a rigid Rapier mass strikes the free end of a bar that is held at its other end.
#[test]
fn v32_rigid_mass_on_a_bar() {
    let n = 100;
    let transit = 1.0 / 44.72136_f64;
    // Node 0 is the struck end, the last node is held.
    let mut net = bar(n, 1.0, 20_000.0, 10.0);
    net.nodes[n].pinned = true;
    let v0 = 1.0;
    let dt = 2.5e-4_f64;
    let mut world = weightless(dt as f32);
    let (ball, _) = world.insert(
        RigidBodyBuilder::dynamic()
            .translation(Vector::new(-0.5001, 0.0, 0.0))
            .linvel(Vector::new(v0, 0.0, 0.0))
            .can_sleep(false),
        ColliderBuilder::cuboid(0.5, 0.5, 0.5)
            .density(0.0)
            .mass(10.0),
    );
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = dt;
    deformables
        .insert(DeformableBuilder::new(net).substeps(Substeps::Fixed(8)))
        .unwrap();
    let mut seen = Impulses::default();
    let mut speed = Vec::new();
    for _ in 0..(5.0 * transit / dt) as usize {
        deformables.step_with(&mut world, &(), &(), &mut seen);
        speed.push((deformables.time(), f64::from(world.bodies[ball].linvel().x)));
    }
    let first = seen.samples.iter().find(|s| s.2 != 0.0).expect("contact").0;
    let at = |t: f64| {
        let i = speed.iter().position(|s| s.0 >= t).unwrap();
        let ((t0, v0), (t1, v1)) = (speed[i - 1], speed[i]);
        v0 + (v1 - v0) * (t - t0) / (t1 - t0)
    };
    close("v(L/c)", at(first + transit), 0.367879, 0.02);
    close("v(1.9 L/c)", at(first + 1.9 * transit), 0.149569, 0.02);
    // The first stretch of .05 L/c without impulse begins at the separation.
    let mut separated = f64::NAN;
    let mut last = first;
    for (t, _, j) in &seen.samples {
        if *j != 0.0 {
            if t - last > 0.05 * transit {
                break;
            }
            last = *t;
        }
        separated = last;
    }
    close(
        "first separation over L/c",
        (separated - first) / transit,
        3.0677,
        0.02,
    );
    close("velocity then", at(separated + 2.0 * dt), -0.68762, 0.02);
    let peak = seen.tension.iter().fold(0.0_f64, |p, t| p.max(-t));
    close("peak force over ρcAv", peak / 447.214, 2.44, 0.03);
}
