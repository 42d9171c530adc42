//! Bodies of tets through the same doors as bodies of springs.

use crate::support::{close, weightless};
use crumple::body::TetId;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::shape::{TetSplit, tet_box};
use crumple::world::DebugStyle;

fn mesh() -> TetMesh {
    tet_box(Vector::splat(0.4), 0.2, TetSplit::Six).unwrap()
}

const RUBBER: Solid = Solid::new(1.0e6, 0.4, 1000.0);

#[test]
fn what_can_be_asked_of_tets() {
    let mut deformables = DeformableWorld::default();
    let body = deformables
        .insert(DeformableBuilder::tets(mesh().quadratic(), RUBBER))
        .unwrap();
    let cube = &deformables[body];
    assert_eq!((cube.tet_count(), cube.spring_count()), (48, 0));
    assert_eq!((cube.node_count(), cube.solid()), (125, Some(&RUBBER)));
    assert!(cube.stress(TetId(47)).is_some() && cube.stress(TetId(48)).is_none());
    assert_eq!(cube.node_von_mises().len(), 125);
    close("mass", cube.mass(), 64.0, 1e-5);
    let mut world = weightless(1.0 / 60.0);
    deformables.step(&mut world);
    let report = deformables.report();
    assert_eq!(report.tet_updates, 48 * report.substeps[0].1 as u64);
    let mut lines = 0;
    deformables.debug_lines(&DebugStyle::default(), |_, _, _| lines += 1);
    assert_eq!(lines, 6 * 48);
}

/// A ray meets the surface, middle nodes included.
#[test]
fn rays_hit_tets() {
    let mut deformables = DeformableWorld::default();
    deformables
        .insert(DeformableBuilder::tets(mesh().quadratic(), RUBBER))
        .unwrap();
    let ray = Ray::new(Vector::new(0.05, 2.0, 0.03), Vector::new(0.0, -1.0, 0.0));
    let hit = deformables
        .cast_ray(&ray, 10.0, true, DeformableFilter::default())
        .unwrap();
    close("distance", hit.time_of_impact.into(), 1.8, 1e-5);
}

/// Twice the density at a constant stiffness allows √2 times the substep; a setter of masses does the same.
#[test]
fn the_stable_step_follows_masses_and_shape() {
    let step = |solid: Solid| {
        let body = DeformableBuilder::tets(mesh(), solid).build().unwrap();
        body.stable_step().h
    };
    let heavy = Solid {
        density: 2000.0,
        ..RUBBER
    };
    close("heavier", step(heavy), 2.0_f64.sqrt() * step(RUBBER), 1e-4);
    let mut body = DeformableBuilder::tets(mesh(), RUBBER).build().unwrap();
    let before = body.stable_step().h;
    for node in (0..body.node_count() as u32).map(NodeId) {
        let mass = body.node_mass(node).unwrap();
        body.set_node_mass(node, 2.0 * mass).unwrap();
    }
    close(
        "set heavier",
        body.stable_step().h,
        2.0_f64.sqrt() * before,
        1e-4,
    );
    // Rubber squeezed to a third is stiffer, and its waves have less way to go.
    let rubber = RUBBER.law(SolidLaw::NeoHookean);
    let mut body = DeformableBuilder::tets(mesh(), rubber).build().unwrap();
    let before = body.stable_step().h;
    for node in (0..body.node_count() as u32).map(NodeId) {
        let x = body.position(node).unwrap().as_vec3();
        body.set_position(node, Vector::new(x.x, x.y / 3.0, x.z));
    }
    assert!(body.stable_step().h < 0.7 * before);
}

#[test]
fn bad_solids_are_refused() {
    let error = |mesh: TetMesh, solid: Solid| {
        let built = DeformableWorld::default().insert(DeformableBuilder::tets(mesh, solid));
        built.unwrap_err().to_string()
    };
    let nu = Solid {
        poisson: 0.5,
        ..RUBBER
    };
    assert!(error(mesh(), nu).contains("Poisson"));
    let young = Solid {
        young: f64::NAN,
        ..RUBBER
    };
    assert!(error(mesh(), young).contains("young modulus is NaN"));
    let mut flat = mesh();
    flat.nodes[13].z = 1.0;
    assert!(error(flat, RUBBER).contains("flat or inverted"));
    let stiff = Solid::new(1.0e15, 0.3, 1.0);
    assert!(
        error(mesh(), stiff).starts_with("tet "),
        "{}",
        error(mesh(), stiff)
    );
    let builder = DeformableBuilder::tets(mesh(), RUBBER).material(Material::rubber());
    assert_eq!(builder.build().unwrap_err(), BuildError::MaterialForTets);
    let error = DeformableWorld::default()
        .insert(DeformableBuilder::tets(mesh(), RUBBER).integrator(Integrator::ExplicitEuler));
    assert!(
        matches!(error, Err(BuildError::NeverStableSolid { .. })),
        "{error:?}"
    );
    let builder = DeformableBuilder::tets(tet_box(Vector::ZERO, 0.1, TetSplit::Six), RUBBER);
    assert!(builder.build().is_err());
}

/// A body of tets blown up by a force beyond all measure is frozen and reported, and the step goes on.
#[test]
fn what_is_not_finite_is_frozen() {
    let mut deformables = DeformableWorld::default();
    let body = deformables
        .insert(DeformableBuilder::tets(mesh(), RUBBER).substeps(Substeps::Unchecked(1)))
        .unwrap();
    deformables[body].set_node_force(NodeId(0), Vector::new(f32::MAX, 0.0, 0.0));
    let mut world = weightless(1.0 / 60.0);
    for _ in 0..10 {
        deformables.step(&mut world);
    }
    assert!(deformables[body].is_frozen());
    assert!(deformables[body].positions().all(|x| x.is_finite()));
}

/// A tet body welded to a rigid one hangs from it.
#[test]
fn tets_are_attached_like_springs() {
    let mut world = PhysicsWorld::default();
    let anchor = world.insert_body(RigidBodyBuilder::fixed());
    let mut deformables = DeformableWorld::default();
    let solid = RUBBER.damping(20.0, 0.0);
    let body = deformables
        .insert(DeformableBuilder::tets(mesh(), solid))
        .unwrap();
    let top: Vec<NodeId> = (0..27)
        .filter(|&n| mesh().nodes[n].y > 0.19)
        .map(|n| NodeId(n as u32))
        .collect();
    let weld = deformables
        .attach(body, Attachment::weld(top), anchor, &world.bodies)
        .unwrap();
    for _ in 0..120 {
        deformables.step(&mut world);
    }
    let force = deformables.attachment_force(weld).unwrap().0.y;
    close("weight on the weld [N]", -force, 64.0 * 9.81, 0.01);
}

/// A body that is settled first does not move when the world begins.
#[cfg(feature = "statics")]
#[test]
fn a_settled_body_stays() {
    let beam = tet_box(Vector::new(1.0, 0.1, 0.1), 0.1, TetSplit::Six).unwrap();
    let lattice = crumple::shape::lattice(Vector::new(1.0, 0.1, 0.1), 0.1).unwrap();
    let rubber = Material::elastic(1.0e6, 1000.0);
    for builder in [
        DeformableBuilder::tets(beam.quadratic(), RUBBER),
        DeformableBuilder::new(lattice).material(rubber),
    ] {
        let gravity = Vector::new(0.0, -9.81, 0.0);
        let mut body = builder.pin(|x| x.x < -0.499).build().unwrap();
        body.settle(gravity).unwrap();
        let mut deformables = DeformableWorld::default();
        let body = deformables.insert(body).unwrap();
        let sag = deformables[body].bounds().0.y;
        assert!(sag < -0.1, "{sag}");
        let mut world = PhysicsWorld::default();
        for _ in 0..60 {
            deformables.step(&mut world);
        }
        close(
            "lowest point [m]",
            deformables[body].bounds().0.y,
            sag,
            1e-4,
        );
        let free = DeformableBuilder::tets(mesh(), RUBBER).build();
        assert!(free.unwrap().settle(gravity).is_err());
    }
}

/// What hangs on a spring of no stiffness hangs on nothing: the error says so, where it was once sought for in vain.
#[test]
fn a_spring_without_stiffness_supports_nothing() {
    let nodes = [0.0, -1.0, -2.0].map(|y| Node::new(Vector::Y * y, 1.0));
    let springs = vec![Spring::new(0, 1, 100.0), Spring::new(1, 2, 0.0)];
    let chain = DeformableBuilder::new(Net::new(nodes.into(), springs).pin(|x| x.y > -0.5));
    let settled = chain.build().unwrap().settle(Vector::Y * -9.81);
    assert!(
        matches!(
            settled,
            Err(crumple::solve::statics::StaticError::Supports { .. })
        ),
        "{settled:?}"
    );
}

/// A bar that hangs from its top: the mean stress is half of what the top bears, ρgL/2, and the recorder has it.
#[test]
fn stress_is_recorded() {
    let mesh = tet_box(Vector::new(0.2, 1.0, 0.2), 0.2, TetSplit::Six).unwrap();
    let solid = Solid::new(1.0e6, 0.0, 1000.0).damping(40.0, 0.0);
    let mut deformables = DeformableWorld::default();
    let bar = DeformableBuilder::tets(mesh, solid).pin(|x| x.y > 0.499);
    let bar = deformables.insert(bar).unwrap();
    let all: Vec<TetId> = (0..deformables[bar].tet_count() as u32)
        .map(TetId)
        .collect();
    let mut recorder = Recorder::new();
    recorder.begin(&deformables);
    assert!(
        recorder
            .follow_tets("none", &deformables, bar, &[TetId(9999)])
            .is_err()
    );
    let set = recorder
        .follow_tets("bar", &deformables, bar, &all)
        .unwrap();
    let mut world = PhysicsWorld::default();
    for _ in 0..60 {
        deformables.step_with(&mut world, &(), &(), &mut recorder);
    }
    let set = &recorder.tet_sets[set];
    assert!(set.times.len() > 100 && set.stresses[0].von_mises.abs() < 1.0);
    let last = set.stresses[set.stresses.len() - 1];
    let expected = 0.5 * 1000.0 * 9.81;
    close("mean stress [Pa]", last.cauchy[1][1], expected, 0.01);
    close("mean strain", last.strain[1][1], expected / 1.0e6, 0.01);
    let path = std::env::temp_dir().join("crumple-stress.csv");
    let record = recorder.body(bar).unwrap();
    recorder.write_history(record, &path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(
        text.lines().next().unwrap().contains("bar_stress_yy_pa"),
        "{text:.300}"
    );
}
