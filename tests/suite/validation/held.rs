//! Attachments against closed forms: a pendulum, links, strengths.

use crate::fixtures::bead;
use crate::support::{close, weightless};
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::world::{AttachmentBroke, AttachmentImpulse};
use std::f64::consts::TAU;

/// V27: a rigid ball on a rope without mass, let go at 90°.
#[test]
fn v27_a_rigid_pendulum() {
    let mut world = PhysicsWorld::default();
    world.integration_parameters.dt = 1.0 / 240.0;
    let ball = RigidBodyBuilder::dynamic()
        .additional_mass(1.0)
        .translation(Vector::X)
        .can_sleep(false);
    let ball = world.insert_body(ball);
    let mut set = DeformableWorld::new();
    let n = 4;
    let nodes =
        (0..=n).map(|i| Node::new(Vector::X * (i as f32 / n as f32), 1e-3 / (n + 1) as f32));
    let springs = (0..n).map(|i| Spring::new(i, i + 1, 4.0e5 * n as f32).damping(4.0));
    let rope = set
        .insert(DeformableBuilder::new(Net::new(
            nodes.collect(),
            springs.collect(),
        )))
        .unwrap();
    set.attach(rope, &[NodeId(0)], AttachTo::World, &world.bodies)
        .unwrap();
    let tie = set
        .attach(rope, Attachment::pin([NodeId(n)]), ball, &world.bodies)
        .unwrap();
    let mut crossings = Vec::new();
    let (mut last, mut time, mut stretch) = (1.0, 0.0, 0.0_f64);
    while crossings.len() < 2 {
        set.step(&mut world);
        let at = world.bodies[ball].translation().as_dvec3();
        stretch = stretch.max(at.length() - 1.0);
        if (at.x < 0.0) != (last < 0.0) {
            crossings.push(time + last / (last - at.x) / 240.0);
        }
        (last, time) = (at.x, time + 1.0 / 240.0);
        assert!(time < 4.0, "it does not swing");
    }
    let t0 = TAU / 9.81_f64.sqrt();
    close(
        "T/T0 by the first quarter",
        4.0 * crossings[0] / t0,
        1.180341,
        2e-3,
    );
    close(
        "T/T0 by half a swing",
        2.0 * (crossings[1] - crossings[0]) / t0,
        1.180341,
        2e-3,
    );
    assert!(stretch < 1e-4, "stretches by {stretch:.3e}");
    assert!(set.attachment_stretch(tie, &world.bodies).unwrap() < 1e-6);
}
fn linked(
    mass: f32,
    link: Attachment,
    integrator: Integrator,
    to_body: bool,
) -> (
    PhysicsWorld,
    DeformableWorld,
    DeformableHandle,
    AttachmentHandle,
) {
    let mut world = weightless(1.0 / 60.0);
    let mut set = DeformableWorld::new();
    let builder = bead(mass)
        .substeps(Substeps::Fixed(64))
        .integrator(integrator);
    let soft = set.insert(builder).unwrap();
    let to = if to_body {
        AttachTo::Body(
            world.insert_body(
                RigidBodyBuilder::dynamic()
                    .additional_mass(3.0)
                    .can_sleep(false),
            ),
        )
    } else {
        AttachTo::World
    };
    let held = set.attach(soft, link, to, &world.bodies).unwrap();
    (world, set, soft, held)
}

/// A mass on a link swings at √(k/μ), and keeps its energy.
#[test]
fn a_link_has_its_frequency_and_keeps_its_energy() {
    for integrator in [
        Integrator::SymplecticEuler,
        Integrator::VelocityVerlet,
        Integrator::Rk4,
    ] {
        for (to_body, reduced) in [(false, 1.0), (true, 0.75)] {
            let (mut world, mut set, soft, _) = linked(
                1.0,
                Attachment::link([NodeId(0)], 400.0),
                integrator,
                to_body,
            );
            set[soft].set_linvel(Vector::X);
            let (mut last, mut crossings) = (0.0, Vec::new());
            for i in 1..=300 {
                set.step(&mut world);
                let v = set[soft].linvel().x - if to_body { 0.25 } else { 0.0 };
                if last * v < 0.0 {
                    crossings.push((f64::from(i) - v / (v - last)) / 60.0);
                }
                last = v;
                let e = set[soft].energies();
                let all = e.kinetic + e.elastic - e.work.rigid - e.work.push_out;
                close(
                    &format!("{integrator:?} {to_body} energy [J]"),
                    all,
                    0.5,
                    2e-3,
                );
            }
            let swings = (crossings.len() - 1) as f64 / 2.0;
            let period = (crossings.last().unwrap() - crossings[0]) / swings;
            close(
                "period [s]",
                period,
                TAU * (reduced / 400.0_f64).sqrt(),
                1e-3,
            );
        }
    }
}

#[test]
fn a_damped_link_comes_to_rest_where_it_must() {
    let link = Attachment::link([NodeId(0)], 1000.0).damping(20.0);
    let (mut world, mut set, soft, held) = linked(2.0, link, Integrator::SymplecticEuler, false);
    world.gravity = Vector::NEG_Y * 9.81;
    let mut lost = 0.0;
    for _ in 0..240 {
        set.step(&mut world);
        let now = set[soft].energies().work.damping;
        assert!(now >= lost, "the damper gives back {} J", lost - now);
        lost = now;
    }
    let stretch = 2.0 * 9.81 / 1000.0;
    close(
        "stretch [m]",
        set.attachment_stretch(held, &world.bodies).unwrap(),
        stretch,
        1e-4,
    );
    close(
        "energy in the link [J]",
        set[soft].energies().elastic,
        0.5 * 1000.0 * stretch * stretch,
        1e-3,
    );
    close("lost [J]", lost, 0.5 * 1000.0 * stretch * stretch, 5e-3);
    let e = set[soft].energies();
    assert!((e.balance()).abs() < 1e-3 * e.scale(), "{e:?}");
    assert!(set.detach(held));
    let e = set[soft].energies();
    assert!(
        (e.balance()).abs() < 1e-3 * e.scale() && e.elastic.abs() < 1e-9,
        "{e:?}"
    );
}

/// Keeps what breaks, and the sum of moments.
#[derive(Default)]
struct Watch(Vec<AttachmentBroke>, Option<AttachmentImpulse>);

impl Observer for Watch {
    fn substep(&mut self, s: &Substep) {
        self.1 = s.attachments.first().copied();
    }

    fn attachment_event(&mut self, event: &AttachmentBroke) {
        self.0.push(*event);
    }
}

/// A load that grows slowly breaks an attachment when it exceeds the strength, neither before nor later; then there is no
/// force any more.
#[test]
fn an_attachment_breaks_at_its_strength() {
    for hold in [
        Attachment::weld([NodeId(0)]),
        Attachment::pin([NodeId(0)]),
        Attachment::link([NodeId(0)], 1.0e5).damping(1000.0),
    ] {
        let mut world = weightless(1.0 / 1000.0);
        let mut set = DeformableWorld::new();
        let soft = set.insert(bead(1.0).substeps(Substeps::Fixed(10))).unwrap();
        let held = set
            .attach(soft, hold.strength(50.0), AttachTo::World, &world.bodies)
            .unwrap();
        let mut watch = Watch::default();
        let mut load = 0.0_f32;
        for i in 0..1100 {
            load = if i < 1000 {
                49.9 * i as f32 / 1000.0
            } else {
                49.9
            };
            set[soft].set_node_force(NodeId(0), Vector::X * load);
            set.step_with(&mut world, &(), &(), &mut watch);
            assert!(
                set.report().broken_attachments.is_empty(),
                "{i} {load} {:?}",
                set.attachment(held)
            );
        }
        assert!(watch.0.is_empty() && !set.attachment(held).unwrap().is_broken());
        close(
            "force [N]",
            set.attachment_force(held).unwrap().0.x,
            49.9,
            1e-3,
        );
        while watch.0.is_empty() && load < 60.0 {
            load += 0.01;
            set[soft].set_node_force(NodeId(0), Vector::X * load);
            set.step_with(&mut world, &(), &(), &mut watch);
        }
        close("load when it breaks [N]", load.into(), 50.0, 1e-3);
        close("force when it breaks [N]", watch.0[0].force.x, 50.0, 1e-3);
        assert_eq!(set.report().broken_attachments, [held]);
        assert!(set.attachment(held).unwrap().is_broken() && set.contains_attachment(held));
        for _ in 0..100 {
            set.step_with(&mut world, &(), &(), &mut watch);
        }
        assert_eq!(set.attachment_force(held).unwrap().0.length(), 0.0);
        assert_eq!(
            (watch.0.len(), set.report().broken_attachments.len()),
            (1, 0)
        );
        assert!(set[soft].linvel().x > 4.0);
        let e = set[soft].energies();
        assert!(e.balance().abs() < 2e-3 * e.scale(), "{e:?}");
    }
}

/// A couple on the nodes of a weld is a moment; it breaks by that alone.
#[test]
fn a_weld_breaks_by_its_moment() {
    let mut world = weightless(1.0 / 1000.0);
    let mut set = DeformableWorld::new();
    let nodes = vec![
        Node::new(Vector::ZERO, 1.0),
        Node::new(Vector::X, 1.0),
        Node::new(Vector::Z, 1.0),
    ];
    let springs = vec![
        Spring::new(0, 1, 1e3),
        Spring::new(1, 2, 1e3),
        Spring::new(0, 2, 1e3),
    ];
    let soft = set
        .insert(DeformableBuilder::new(Net::new(nodes, springs)))
        .unwrap();
    let weld = Attachment::weld((0..3).map(NodeId))
        .moment_strength(8.0)
        .strength(1.0);
    let held = set
        .attach(soft, weld, AttachTo::World, &world.bodies)
        .unwrap();
    let mut watch = Watch::default();
    for i in 0..2000 {
        let force = Vector::Y * (i as f32 * 0.005);
        set[soft].set_node_force(NodeId(0), -force);
        set[soft].set_node_force(NodeId(1), force);
        set.step_with(&mut world, &(), &(), &mut watch);
        if !watch.0.is_empty() {
            break;
        }
        close(
            "moment [N·m]",
            set.attachment(held).unwrap().moment.z,
            f64::from(force.y),
            if i > 100 { 1e-3 } else { 1.0 },
        );
        let tie = watch.1.unwrap();
        assert!(tie.impulse.length() < 1e-6 && tie.moment.z <= 0.0);
    }
    close(
        "moment when it breaks [N·m]",
        watch.0[0].moment.z,
        8.0,
        1e-3,
    );
}
