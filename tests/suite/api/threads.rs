//! Results don't depend on threads: not on how many there are, nor on whether there are any.

use crate::fixtures::floored;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario::speed::subject::shuffled;
use crumple::shape::{TetSplit, tet_box_of_cells};

/// What there is to see after some steps: the bits of the state and of the sums of work, the last report, what an observer saw.
#[derive(Debug, PartialEq)]
struct Seen {
    hash: u64,
    work: Vec<u64>,
    report: String,
    events: String,
}

/// Observes springs that flow and break.
#[derive(Default)]
struct Diary(Vec<String>);

impl Observer for Diary {
    fn substep(&mut self, _: &Substep) {}
    fn event(&mut self, event: &SpringEvent) {
        self.0.push(format!("{event:?}"));
    }
}

fn run(mut scene: (PhysicsWorld, DeformableWorld), steps: usize, diary: Option<Diary>) -> Seen {
    let (world, deformables) = (&mut scene.0, &mut scene.1);
    let mut diary = diary;
    for _ in 0..steps {
        match &mut diary {
            Some(diary) => deformables.step_with(world, &(), &(), diary),
            None => deformables.step(world),
        }
    }
    let work = |b: &Deformable| {
        let (e, w) = (b.energies(), b.energies().work);
        [
            w.damping, w.plastic, w.fracture, w.external, e.elastic, e.kinetic,
        ]
        .map(f64::to_bits)
    };
    Seen {
        hash: deformables.state_hash(),
        work: deformables.iter().flat_map(|(_, b)| work(b)).collect(),
        report: format!("{:?}", deformables.report()),
        events: format!("{:?}", diary.map(|d| d.0)),
    }
}

/// The same for 1, 2, 3 and 5 threads of a pool of its own, for Rayon's global pool, and for a world that is observed.
fn check(steps: usize, scene: impl Fn() -> (PhysicsWorld, DeformableWorld) + Sync) -> Seen {
    let pool = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
    };
    let alone = pool(1).install(|| run(scene(), steps, None));
    let seen = pool(1).install(|| run(scene(), steps, Some(Diary::default())));
    assert_eq!(alone.hash, seen.hash);
    assert_eq!(alone.work, seen.work);
    for threads in [2, 3, 5] {
        let pool = pool(threads);
        let shared = pool.install(|| run(scene(), steps, None));
        assert_eq!(alone, shared, "{threads} threads");
        let shared = pool.install(|| run(scene(), steps, Some(Diary::default())));
        assert_eq!(seen, shared, "{threads} threads, observed");
    }
    assert_eq!(alone, run(scene(), steps, None), "the global pool");
    seen
}

fn world(gravity: bool) -> (PhysicsWorld, DeformableWorld) {
    let (mut world, _) = floored(1.0 / 240.0);
    if !gravity {
        world.gravity = Vector::ZERO;
    }
    (world, DeformableWorld::new())
}

fn brittle() -> Material {
    let mut material = Material::elastic(2.0e6, 300.0)
        .viscosity(50.0)
        .yielding(2.0e4, 0.1);
    material.break_strain = 0.15;
    material
}

#[test]
fn a_lattice_that_flows_and_breaks() {
    let seen = check(3, || {
        let (world, mut deformables) = world(true);
        let block = DeformableBuilder::new(lattice(Vector::new(1.0, 0.6, 0.6), 0.04))
            .material(brittle())
            .translation(Vector::new(0.0, 0.31, 0.0))
            .linvel(Vector::new(25.0, -5.0, 0.0))
            .pin(|x| x.x < -0.49);
        let block = deformables.insert(block).unwrap();
        assert!(deformables[block].spring_count() > 30_000);
        (world, deformables)
    });
    assert!(seen.events.contains("YieldBegan") && seen.events.contains("Broke"));
}

#[test]
fn a_mesh_without_order_that_flows_and_breaks() {
    let seen = check(3, || {
        let (world, mut deformables) = world(true);
        let mesh = tet_box_of_cells(Vector::ONE, [14; 3], TetSplit::Six).unwrap();
        let block = DeformableBuilder::new(shuffled(&mesh.springs()))
            .material(brittle())
            .translation(Vector::new(0.0, 0.51, 0.0))
            .linvel(Vector::new(25.0, -5.0, 0.0))
            .pin(|x| x.x < -0.49);
        deformables.insert(block).unwrap();
        (world, deformables)
    });
    assert!(seen.events.contains("YieldBegan") && seen.events.contains("Broke"));
}

#[test]
fn a_mesh_without_damping() {
    check(3, || {
        let (world, mut deformables) = world(true);
        let mesh = tet_box_of_cells(Vector::ONE, [14; 3], TetSplit::Six).unwrap();
        let block = DeformableBuilder::new(shuffled(&mesh.springs()))
            .material(Material::elastic(2.0e6, 300.0))
            .translation(Vector::new(0.0, 0.51, 0.0))
            .linvel(Vector::new(2.0, -5.0, 0.0));
        deformables.insert(block).unwrap();
        (world, deformables)
    });
}

#[test]
fn a_cloth_in_the_wind() {
    for integrator in Integrator::ALL {
        check(2, || {
            let (world, mut deformables) = world(true);
            let cloth = DeformableBuilder::new(sheet(1.0, 1.0, 64, 64, 1e-3))
                .material(Material::elastic(1.0e6, 1000.0).viscosity(20.0))
                .integrator(integrator)
                .translation(Vector::new(0.0, 1.0, 0.0))
                .force_field(|_: NodeId, x: Vector, v: Vector, t: f64| {
                    1e-3 * (Vector::new((9.0 * x.z).sin(), 1.0, t as f32) - v)
                })
                .pin(|x| x.x < -0.499);
            let cloth = deformables.insert(cloth).unwrap();
            assert!(deformables[cloth].spring_count() > 12_000);
            (world, deformables)
        });
    }
}

#[test]
fn finite_elements() {
    let damped = [(0.3, 1e-4), (0.3, 0.0), (0.0, 1e-4), (0.0, 0.0)];
    let linear = damped.map(|damping| (false, damping));
    for (quadratic, (alpha, beta)) in linear.into_iter().chain([(true, damped[0])]) {
        check(2, || {
            let (world, mut deformables) = world(true);
            let mesh = tet_box_of_cells(Vector::splat(0.6), [9; 3], TetSplit::Six).unwrap();
            let mesh = if quadratic { mesh.quadratic() } else { mesh };
            let rubber = Solid::new(2.0e5, 0.4, 1000.0)
                .law(SolidLaw::NeoHookean)
                .damping(alpha, beta);
            let block = DeformableBuilder::tets(mesh, rubber)
                .translation(Vector::new(0.0, 0.301, 0.0))
                .linvel(Vector::new(0.3, -3.0, 0.0));
            deformables.insert(block).unwrap();
            (world, deformables)
        });
    }
}

/// Many groups of their own and one pair that meets; one body has a force field that is no number.
#[test]
fn many_bodies_of_which_one_is_sick() {
    let seen = check(6, || {
        let (mut world, mut deformables) = world(true);
        for i in 0..40 {
            let at = Vector::new(i as f32, 0.2, 0.0);
            let cells = 2 + i % 4;
            let mut block = DeformableBuilder::new(lattice(Vector::splat(0.3), 0.3 / cells as f32))
                .material(brittle())
                .translation(at)
                .linvel(Vector::new(0.0, -1.0 - 0.1 * i as f32, 0.0));
            if i == 17 {
                block = block.force_field(|node: NodeId, _: Vector, _: Vector, t: f64| {
                    Vector::X
                        * if node.0 == 3 && t > 0.01 {
                            f32::NAN
                        } else {
                            0.0
                        }
                });
            }
            deformables.insert(block).unwrap();
            if i % 3 == 0 {
                world.insert(
                    RigidBodyBuilder::dynamic().translation(at + Vector::Y * 0.3),
                    ColliderBuilder::cuboid(0.1, 0.1, 0.1),
                );
            }
        }
        (world, deformables)
    });
    assert!(!seen.report.is_empty());
}

/// The report of the step in which a body is frozen says so, and no other is.
#[test]
fn a_sick_body_among_many_is_frozen_alone() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build();
    pool.unwrap().install(|| {
        let (mut world, mut deformables) = world(true);
        let handles: Vec<_> = (0..40)
            .map(|i| {
                let block = DeformableBuilder::new(lattice(Vector::splat(0.3), 0.06))
                    .material(Material::rubber())
                    .translation(Vector::new(i as f32, 0.2, 0.0))
                    .force_field(move |_: NodeId, _: Vector, _: Vector, t: f64| {
                        Vector::X * if i == 17 && t > 0.01 { f32::NAN } else { 0.0 }
                    });
                deformables.insert(block).unwrap()
            })
            .collect();
        let mut frozen = Vec::new();
        for _ in 0..6 {
            deformables.step(&mut world);
            frozen.extend(deformables.report().frozen.clone());
        }
        assert_eq!(frozen, [handles[17]]);
        assert!(
            deformables
                .iter()
                .all(|(_, b)| b.positions().all(|x| x.is_finite()))
        );
    });
}
