//! Momentum and angular momentum of everything that collides.

use crate::support::weightless;
use crumple::math::{DMat3, DVec3};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape;
use crumple::world::RapierParts;

/// Momentum and angular momentum about the origin of a rigid body.
fn of_rigid(body: &RigidBody) -> (DVec3, DVec3) {
    let m = body.mass_properties().effective_world_inv_inertia;
    let w = DMat3::from_cols(
        DVec3::new(m.m11.into(), m.m12.into(), m.m13.into()),
        DVec3::new(m.m12.into(), m.m22.into(), m.m23.into()),
        DVec3::new(m.m13.into(), m.m23.into(), m.m33.into()),
    );
    let p = body.linvel().as_dvec3() * f64::from(body.mass());
    let spin = w.inverse() * body.angvel().as_dvec3();
    (p, body.center_of_mass().as_dvec3().cross(p) + spin)
}

/// Which way the world is stepped.
#[derive(Clone, Copy, PartialEq)]
enum Loop {
    /// By `DeformableWorld::step`.
    Ours,
    /// By hand, so that what Rapier's own step does to the rigid body while nothing pushes it can be left out: it turns a body
    /// that is no ball without conserving angular momentum (2e-3 in half a second of free flight at 7 rad/s and dt = 1/60).
    ByHand,
}

struct Outcome {
    /// Worst relative change of momentum and of angular momentum.
    worst: (f64, f64),
    /// Impulse between the bodies over the sum of their momenta.
    exchanged: f64,
}

/// A spinning block and a spinning rigid body meet off centre.
fn collide(
    block: DeformableBuilder,
    collider: ColliderBuilder,
    (mass, dt, spin): (f32, f32, f32),
    by: Loop,
) -> Outcome {
    let mut world = weightless(dt);
    let (rigid, _) = world.insert(
        RigidBodyBuilder::dynamic()
            .translation(Vector::new(0.5, 0.08, -0.05))
            .linvel(Vector::new(-3.0, 0.2, 0.1))
            .angvel(spin * Vector::new(0.5, -2.0, 1.0))
            .can_sleep(false),
        collider.mass(mass).friction(0.4),
    );
    let mut deformables = DeformableWorld::default();
    let block = deformables
        .insert(
            block
                .friction(0.4)
                .linvel(Vector::new(1.0, 0.0, 0.0))
                .angvel(spin * Vector::new(0.3, 1.0, -0.7)),
        )
        .unwrap();
    let of_block =
        |d: &DeformableWorld| (d[block].momentum(), d[block].angular_momentum(DVec3::ZERO));
    let (p0, l0) = of_rigid(&world.bodies[rigid]);
    let (p1, l1) = of_block(&deformables);
    // Of the two bodies, not of their sum, which a head-on collision could make small.
    let (p_scale, l_scale) = (p0.length() + p1.length(), l0.length() + l1.length());
    let (mut defect, mut worst) = ((DVec3::ZERO, DVec3::ZERO), (0.0_f64, 0.0_f64));
    for _ in 0..(0.2 / dt) as usize {
        let before = (of_rigid(&world.bodies[rigid]), of_block(&deformables));
        let mut own = (DVec3::ZERO, DVec3::ZERO);
        if by == Loop::Ours {
            deformables.step(&mut world);
        } else {
            deformables.before_step(&mut RapierParts::from(&mut world), &mut ());
            let a = of_rigid(&world.bodies[rigid]);
            world.step();
            let b = of_rigid(&world.bodies[rigid]);
            deformables.after_step(&mut RapierParts::from(&mut world));
            // What is pushed ends as its shadow does, and what Rapier did to it is made good with that.
            let given = of_rigid(&world.bodies[rigid]);
            if a == before.0 && given == b {
                own = (b.0 - a.0, b.1 - a.1);
            }
        }
        let after = (of_rigid(&world.bodies[rigid]), of_block(&deformables));
        defect.0 += after.0.0 + after.1.0 - before.0.0 - before.1.0 - own.0;
        defect.1 += after.0.1 + after.1.1 - before.0.1 - before.1.1 - own.1;
        worst.0 = worst.0.max(defect.0.length() / p_scale);
        worst.1 = worst.1.max(defect.1.length() / l_scale);
    }
    Outcome {
        worst,
        exchanged: (deformables[block].momentum() - p1).length() / p_scale,
    }
}

fn springs() -> DeformableBuilder {
    DeformableBuilder::new(shape::lattice(Vector::splat(0.4), 0.1))
        .material(Material::elastic(2.0e5, 200.0).viscosity(200.0))
}

fn collisions(by: Loop, masses: &[f32], shapes: &[(&str, ColliderBuilder)]) {
    collisions_of(springs, by, masses, shapes);
}

fn collisions_of(
    block: fn() -> DeformableBuilder,
    by: Loop,
    masses: &[f32],
    shapes: &[(&str, ColliderBuilder)],
) {
    let mut failures = String::new();
    for dt in [1.0 / 60.0, 1.0 / 240.0] {
        for &mass in masses {
            for spin in [0.0, 1.0, 5.0] {
                for (name, collider) in shapes {
                    let Outcome { worst, exchanged } =
                        collide(block(), collider.clone(), (mass, dt, spin), by);
                    let case = format!("{name} of {mass} kg, dt = {dt}, spin {spin}");
                    assert!(exchanged > 0.01, "{case}: they must meet, {exchanged}");
                    if worst.0 > 1e-5 || worst.1 > 1e-5 {
                        failures += &format!(
                            "\n{case}: momentum off by {:.2e}, angular momentum by {:.2e}, allowed 1e-5",
                            worst.0, worst.1
                        );
                    }
                }
            }
        }
    }
    assert!(failures.is_empty(), "{failures}");
}

/// V43: balls, which Rapier turns without losing angular momentum, of several masses and spins.
#[test]
fn v43_a_collision_conserves_momentum() {
    collisions(
        Loop::Ours,
        &[0.5, 10.0, 200.0],
        &[("ball", ColliderBuilder::ball(0.2))],
    );
}

fn all_shapes() -> [(&'static str, ColliderBuilder); 4] {
    [
        ("ball", ColliderBuilder::ball(0.2)),
        ("cube", ColliderBuilder::cuboid(0.2, 0.2, 0.2)),
        ("cuboid", ColliderBuilder::cuboid(0.2, 0.15, 0.25)),
        ("capsule", ColliderBuilder::capsule_y(0.2, 0.12)),
    ]
}

/// V43: any body, Rapier's own loss of angular momentum left out.
#[test]
fn v43_the_coupling_conserves_momentum() {
    collisions(Loop::ByHand, &[10.0, 200.0], &all_shapes());
}

/// V43: blocks of tets, of either kind.
#[test]
fn v43_tets() {
    fn mesh() -> TetMesh {
        shape::tet_box(Vector::splat(0.4), 0.1333, shape::TetSplit::Five).unwrap()
    }
    const SOLID: Solid = Solid::new(2.0e5, 0.3, 200.0).damping(0.0, 1e-3);
    let linear: fn() -> _ = || DeformableBuilder::tets(mesh(), SOLID);
    let quadratic: fn() -> _ =
        || DeformableBuilder::tets(mesh().quadratic(), SOLID.law(SolidLaw::NeoHookean));
    for block in [linear, quadratic] {
        collisions_of(block, Loop::ByHand, &[10.0], &all_shapes());
    }
}

/// V43: bodies much lighter than the deformable, which are thrown into a quick spin.
#[test]
fn v43_light_bodies() {
    collisions(Loop::ByHand, &[0.5], &all_shapes());
}
