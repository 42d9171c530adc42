//! Forces from outside.

use crate::fixtures::{bead, height};
use crate::support::{close, weightless};
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

#[test]
fn a_step_force_acts_for_one_step_and_a_force_until_changed() {
    for integrator in Integrator::ALL {
        for dt in [1.0 / 60.0, 1.0 / 240.0] {
            let mut world = weightless(dt);
            let mut set = DeformableWorld::new();
            set.params.integrator = integrator;
            let handle = set.insert(bead(2.0)).unwrap();
            let gain = f64::from(dt) * 30.0 / 2.0;
            let velocity = |set: &DeformableWorld| set[handle].linvel().x;
            assert!(set[handle].add_step_force(NodeId(0), Vector::X * 10.0));
            assert!(set[handle].add_step_force(NodeId(0), Vector::X * 20.0));
            set.step(&mut world);
            close("one frame", velocity(&set), gain, 1e-4);
            set.step(&mut world);
            close("once means once", velocity(&set), gain, 1e-4);
            assert!(set[handle].set_node_force(NodeId(0), Vector::X * 30.0));
            set.step(&mut world);
            close("two frames", velocity(&set), 2.0 * gain, 1e-4);
            set.step(&mut world);
            close("three frames", velocity(&set), 3.0 * gain, 1e-4);
            set[handle].add_step_force(NodeId(0), Vector::X * -30.0);
            set.step(&mut world);
            close("both add up", velocity(&set), 3.0 * gain, 1e-4);
            assert!(set[handle].set_node_force(NodeId(0), Vector::ZERO));
            set.step(&mut world);
            close("taken away", velocity(&set), 3.0 * gain, 1e-4);
            // Explicit Euler really gains energy.
            if integrator != Integrator::ExplicitEuler {
                let e = set[handle].energies();
                close("work", e.work.external, e.kinetic, 1e-4);
            }
        }
    }
}

/// Wind on a hanging-free sheet: every node ends at the speed where drag carries its weight.
#[test]
fn wind_blows_a_sheet_to_its_terminal_velocity() {
    let mut world = PhysicsWorld::default();
    let mut set = DeformableWorld::new();
    let drag = 0.4_f32;
    let wind = Vector::new(5.0, 1.0, 0.0);
    let handle = set
        .insert(
            DeformableBuilder::new(sheet(1.0, 1.0, 5, 5, 0.002))
                .material(Material::rubber())
                .force_field(move |_: NodeId, _: Vector, v: Vector, _: f64| (wind - v) * drag),
        )
        .unwrap();
    for _ in 0..240 {
        set.step(&mut world);
    }
    let body = &set[handle];
    let weight = DVec3::Y * -9.81 * body.mass() / (25.0 * f64::from(drag));
    let error = (body.linvel() - (wind.as_dvec3() + weight)).length();
    assert!(error < 2e-3, "{} is off by {error}", body.linvel());
}

/// A field is told where, how fast, which node, and the time of the world; also of a body that slept through some of it.
#[test]
fn a_field_is_told_the_time_of_the_world() {
    let mut world = weightless(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let gust = |_: NodeId, _: Vector, _: Vector, t: f64| {
        if t > 0.5 { Vector::X } else { Vector::ZERO }
    };
    let first = set.insert(bead(1.0).force_field(gust)).unwrap();
    let off = set
        .insert(bead(1.0).force_field(gust).enabled(false))
        .unwrap();
    for _ in 0..15 {
        set.step(&mut world);
    }
    set[off].set_enabled(true);
    let late = set.insert(bead(1.0).force_field(gust)).unwrap();
    for _ in 0..30 {
        set.step(&mut world);
    }
    let expected = set.time() - 0.5;
    for handle in [first, off, late] {
        let v = set[handle].linvel().x;
        assert!((v - expected).abs() < 0.01, "{v} against {expected}");
    }
}

#[test]
fn gravity_scales() {
    for scale in [0.0, 1.0, -1.0, 2.5] {
        let mut world = PhysicsWorld::default();
        let mut set = DeformableWorld::new();
        let handle = set
            .insert(bead(3.0).gravity_scale(scale).substeps(Substeps::Fixed(4)))
            .unwrap();
        for _ in 0..30 {
            set.step(&mut world);
        }
        let (y, v) = height(&set[handle]);
        let (g, t) = (-9.81 * f64::from(scale), set.time());
        assert!((v - g * t).abs() < 1e-4 * (1.0 + g.abs()));
        assert!((y - 0.5 * g * t * t).abs() < 0.01 * g.abs() * t * t + 1e-9);
    }
}

/// A force −D·v lets the speed decay as exp(−D·t/m), to the order of the scheme.
#[test]
fn drag_decays() {
    for (integrator, tolerance) in [
        (Integrator::SymplecticEuler, 1.02 * 0.5 * 9.0 / 240.0),
        (Integrator::Rk4, 1e-5),
    ] {
        let mut world = weightless(1.0 / 60.0);
        let mut set = DeformableWorld::new();
        let body = bead(2.0)
            .drag(6.0)
            .integrator(integrator)
            .linvel(Vector::X)
            .substeps(Substeps::Fixed(4));
        let handle = set.insert(body).unwrap();
        for _ in 0..60 {
            set.step(&mut world);
        }
        let t = set.time();
        close(
            "speed",
            set[handle].linvel().x,
            (-3.0 * t).exp(),
            tolerance * t,
        );
        let e = set[handle].energies();
        close(
            "all of it is dissipated",
            e.dissipated() + e.kinetic,
            1.0,
            1e-2,
        );
    }
}

/// Every stage of a scheme sees the field at its own time: under a force sin(ωt) each keeps its order.
#[test]
fn a_field_that_changes_with_time_keeps_the_order_of_the_scheme() {
    let omega = 10.0_f64;
    let error = |integrator, n: usize| {
        let mut world = weightless(1.0);
        let mut set = DeformableWorld::new();
        let push =
            move |_: NodeId, _: Vector, _: Vector, t: f64| Vector::X * (omega * t).sin() as f32;
        let body = bead(1.0).force_field(push).integrator(integrator);
        let body = set.insert(body.substeps(Substeps::Fixed(n))).unwrap();
        set.params.review_interval = 1.0;
        set.step(&mut world);
        assert_eq!(set.report().substeps, [(body, n)]);
        let x = set[body].position(NodeId(0)).unwrap().x;
        (x - (1.0 / omega - omega.sin() / (omega * omega))).abs()
    };
    // Substeps short enough for the order to show, and long enough for more error than f32 makes by itself.
    for (integrator, order, n) in [
        (Integrator::VelocityVerlet, 2.0, 20),
        (Integrator::Midpoint, 2.0, 20),
        (Integrator::Rk4, 4.0, 8),
    ] {
        let measured = (error(integrator, n) / error(integrator, 2 * n)).log2();
        assert!(
            (measured - order).abs() < 0.15,
            "{integrator:?}: order {measured}"
        );
    }
}

/// What hangs from pinned nodes has the energy of gravity of those that fall, from where each was let go, and nobody has worked on it.
#[test]
fn gravity_counts_from_where_nodes_were_let_go() {
    let is_top = |x: Vector| x.y > 0.49;
    let tower = || {
        DeformableBuilder::new(lattice(Vector::new(0.2, 1.0, 0.2), 0.1))
            .material(Material::elastic(1.0e5, 500.0).viscosity(1.0e3))
            .translation(Vector::Y * 3.0)
    };
    let mut world = PhysicsWorld::default();
    let mut set = DeformableWorld::default();
    let built = set.insert(tower().pin(is_top)).unwrap();
    let told = set.insert(tower()).unwrap();
    let nodes = |set: &DeformableWorld| (0..set[told].node_count() as u32).map(NodeId);
    for node in nodes(&set) {
        let at = set[told].position(node).unwrap().as_vec3();
        set[told].set_pinned(node, is_top(at - Vector::Y * 3.0));
    }
    let start: Vec<f64> = set[built].positions().map(|x| x.y.into()).collect();
    let fallen = |set: &DeformableWorld, body: DeformableHandle| {
        let body = &set[body];
        let gone = |(k, node): (usize, NodeId)| {
            let mass = f64::from(body.node_mass(node).unwrap());
            mass * 9.81 * (body.position(node).unwrap().y - start[k])
        };
        nodes(set).enumerate().map(gone).sum::<f64>()
    };
    for _ in 0..60 {
        set.step(&mut world);
    }
    for body in [built, told] {
        let (energies, expected) = (set[body].energies(), fallen(&set, body));
        assert!(expected < -0.1, "it sags");
        close("energy of gravity [J]", energies.gravity, expected, 1e-4);
        assert!(energies.work.external.abs() < 1e-6, "{:?}", energies.work);
    }
    // Who pins a node at rest, or lets it go, or weighs it, does no work against gravity.
    let hung = set[built].energies().gravity;
    let work = |set: &DeformableWorld| set[built].energies().work.external;
    let low = nodes(&set).next_back().unwrap();
    set[built].set_pinned(low, true);
    close("pinned [J]", set[built].energies().gravity, hung, 1e-9);
    set[built].set_node_mass(low, 3.0).unwrap();
    set[built].set_pinned(low, false);
    close("let go [J]", set[built].energies().gravity, hung, 1e-9);
    let before = work(&set);
    set.step(&mut world);
    let mut heavier = world.gravity;
    heavier *= 2.0;
    world.gravity = heavier;
    set.step(&mut world);
    // Twice the gravity is twice the energy of what has fallen: that is work from outside.
    close("work [J]", work(&set) - before, hung, 0.05);
}
