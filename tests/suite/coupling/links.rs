//! Links: springs and dampers between nodes and what they are attached to, at any stiffness.

use crate::fixtures::floored;
use crate::support::{close, weightless};
use crumple::body::{Net, Node, Spring};
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::world::Energies;

const SCHEMES: [Integrator; 3] = [
    Integrator::SymplecticEuler,
    Integrator::VelocityVerlet,
    Integrator::Rk4,
];

/// How far the first node has been from the origin.
#[derive(Default)]
struct Farthest(f64);

impl Observer for Farthest {
    fn substep(&mut self, s: &Substep) {
        let mut bodies = s.deformables.iter();
        if let Some(x) = bodies.find_map(|(_, body)| body.position(NodeId(0))) {
            self.0 = self.0.max(x.length());
        }
    }
}

/// A bead of 1 kg flies at 1 m/s when it is linked to the world where it is, or is told to while it rests there: it swings by
/// v/ω, however little of a period a substep sees, and with no more than its energy.
#[test]
fn what_moves_when_it_is_linked_swings_by_its_own_energy() {
    for told in [false, true] {
        for stiffness in [1e4_f32, 1e5, 1e6, 1e7] {
            let mut world = weightless(1.0 / 60.0);
            let mut set = DeformableWorld::default();
            let net = Net::new(vec![Node::new(Vector::ZERO, 1.0)], vec![]);
            let linvel = if told { Vector::ZERO } else { Vector::X };
            let bead = DeformableBuilder::new(net).can_sleep(false).linvel(linvel);
            let bead = set.insert(bead).unwrap();
            let link = Attachment::link([NodeId(0)], stiffness);
            set.attach(bead, link, AttachTo::World, &world.bodies)
                .unwrap();
            if told {
                set.step(&mut world);
                let body = set.get_mut(bead).unwrap();
                assert!(body.set_linvel_of(NodeId(0), Vector::X));
            }
            let start = set[bead].energies();
            let mut farthest = Farthest::default();
            for _ in 0..60 {
                set.step_with(&mut world, &(), &(), &mut farthest);
            }
            let swing = 1.0 / f64::from(stiffness).sqrt();
            close("swing [m]", farthest.0, swing, 0.02);
            let end = set[bead].energies();
            let energy = end.kinetic + end.elastic;
            assert!(energy < 0.5001, "{told} {stiffness}: {energy} J");
            let off = end.balance() - start.balance();
            assert!(off.abs() < 1e-4, "{told} {stiffness}: {off} J");
        }
    }
}

/// A link that is stiffer than substeps see, in substeps that change every fifth time.
#[test]
fn substeps_that_change_are_no_pump() {
    for ratio in [0.25_f32, 0.5, 0.95] {
        let mut world = weightless(1.0 / 60.0);
        let mut set = DeformableWorld::default();
        let net = Net::new(vec![Node::new(Vector::ZERO, 1.0)], vec![]);
        let bead = DeformableBuilder::new(net).can_sleep(false);
        let bead = set.insert(bead.linvel(Vector::X)).unwrap();
        let link = Attachment::link([NodeId(0)], 1e6);
        set.attach(bead, link, AttachTo::World, &world.bodies)
            .unwrap();
        set.step(&mut world);
        let start = set[bead].energies();
        let held = start.kinetic + start.elastic;
        for i in 0..200 {
            let share = if i / 5 % 2 == 0 { ratio } else { 1.0 };
            world.integration_parameters.dt = share / 60.0;
            set.step(&mut world);
            let now = set[bead].energies();
            let energy = now.kinetic + now.elastic;
            assert!(energy < 1.01 * held, "{ratio}: {energy} of {held} J in {i}");
            let off = now.balance() - start.balance();
            assert!(off.abs() < 1e-4 * held, "{ratio}: {off} J");
        }
    }
}

/// Two beads on a spring, one of which is linked to the world, undamped.
#[test]
fn the_books_of_links_close_by_every_scheme() {
    for scheme in SCHEMES {
        for stiffness in [2e3, 1e5] {
            let nodes = vec![
                Node::new(Vector::ZERO, 1.0),
                Node::new(Vector::X * 0.5, 1.0),
            ];
            let net = Net::new(nodes, vec![Spring::new(0, 1, 1e3)]);
            let mut world = weightless(1.0 / 60.0);
            let mut set = DeformableWorld::default();
            let builder = DeformableBuilder::new(net)
                .integrator(scheme)
                .substeps(Substeps::Fixed(16))
                .can_sleep(false);
            let body = set.insert(builder).unwrap();
            let link = Attachment::link([NodeId(0)], stiffness);
            set.attach(body, link, AttachTo::World, &world.bodies)
                .unwrap();
            set.get_mut(body)
                .unwrap()
                .set_linvel_of(NodeId(1), Vector::X);
            set.step(&mut world);
            let start = set[body].energies();
            let held = |e: &Energies| e.kinetic + e.elastic;
            for _ in 0..300 {
                set.step(&mut world);
            }
            let end = set[body].energies();
            let what = scheme.name();
            let off = end.balance() - start.balance();
            assert!(off.abs() < 2e-3 * held(&start), "{what}: {off} J");
            close(what, held(&end), held(&start), 0.01);
            assert!(
                end.work.push_out.abs() < 2e-3,
                "{what}: {}",
                end.work.push_out
            );
        }
    }
}

/// A block of 8 kg hangs by links on a body of 8 kg, which is fixed, on a joint, or on the floor.
#[test]
fn what_hangs_by_stiff_links_hangs_still() {
    let mut cases: Vec<_> = SCHEMES.map(|s| ("fixed", s, 0.0_f32)).to_vec();
    cases.extend([("joint", Integrator::SymplecticEuler, 300.0)]);
    cases.extend([("floor", Integrator::SymplecticEuler, 300.0)]);
    for (on, scheme, viscosity) in cases {
        for stiffness in [1e4_f32, 1e5, 1e6, 1e7] {
            let (mut world, _) = floored(1.0 / 60.0);
            let nothing = InteractionGroups::none();
            let at = Vector::Y * 2.0;
            let carrier = match on {
                "fixed" => world.insert_body(RigidBodyBuilder::fixed().translation(at)),
                _ => {
                    let body = RigidBodyBuilder::dynamic().translation(at).can_sleep(false);
                    let shape = ColliderBuilder::cuboid(0.3, 0.05, 0.3).mass(8.0);
                    world.insert(body, shape).0
                }
            };
            if on == "joint" {
                let ground = world.insert_body(RigidBodyBuilder::fixed().translation(at));
                let up = Vector::Y * 0.3;
                let joint = SphericalJointBuilder::new()
                    .local_anchor1(up)
                    .local_anchor2(up);
                world.insert_impulse_joint(ground, carrier, joint);
            } else if on == "floor" {
                for x in [-0.25, 0.25] {
                    let post = ColliderBuilder::cuboid(0.02, 0.98, 0.3);
                    let under = RigidBodyBuilder::fixed().translation(Vector::new(x, 0.97, 0.0));
                    world.insert(under, post);
                }
            }
            let mut set = DeformableWorld::default();
            let block = DeformableBuilder::new(lattice(Vector::new(0.2, 0.4, 0.2), 0.1))
                .material(Material::elastic(1e5, 500.0).viscosity(viscosity))
                .translation(at - Vector::Y * 0.2)
                .collision_groups(nothing)
                .integrator(scheme)
                .can_sleep(false);
            let block = set.insert(block).unwrap();
            let body = &set[block];
            let top = (0..body.node_count() as u32).map(NodeId);
            let top: Vec<_> = top
                .filter(|n| body.position(*n).unwrap().y > 2.0 - 1e-3)
                .collect();
            assert_eq!(top.len(), 9);
            let link = Attachment::link(top, stiffness);
            let link = set.attach(block, link, carrier, &world.bodies).unwrap();
            let what = format!("{on} {} {stiffness}", scheme.name());
            let mut force = 0.0;
            for i in 0..360 {
                set.step(&mut world);
                let speeds = set[block].velocities().map(|v| v.length());
                let fastest = speeds.fold(0.0, f32::max);
                let settled = viscosity > 0.0 && i > 300;
                let most = if settled { 2e-3 } else { 0.6 };
                assert!(fastest < most, "{what}: {fastest} m/s in step {i}");
                if i >= 180 {
                    force -= set.attachment_force(link).unwrap().0.y / 180.0;
                }
            }
            let weight = set[block].mass() * 9.81;
            close(
                &what,
                force,
                weight,
                if viscosity > 0.0 { 1e-3 } else { 0.01 },
            );
        }
    }
}

/// Nodes stay where they are attached on a body of which the centre of mass moves.
#[test]
fn anchors_stay_where_they_are_on_the_body() {
    type Change = fn(&mut PhysicsWorld, RigidBodyHandle);
    let changes: [(&str, Change); 3] = [
        ("a collider more", |world, body| {
            let far = ColliderBuilder::ball(0.1)
                .mass(3.0)
                .translation(Vector::X * 2.0);
            world.insert_collider(far, Some(body));
        }),
        ("a collider less", |world, body| {
            let last = world.bodies[body].colliders()[1];
            world.remove_collider(last);
        }),
        ("other mass", |world, body| {
            let mass = MassProperties::new(Vector::X, 2.0, Vector::ONE);
            let body = world.bodies.get_mut(body).unwrap();
            body.set_additional_mass_properties(mass, true);
        }),
    ];
    for (what, change) in changes {
        for hold in ["weld", "pin", "link"] {
            let mut world = weightless(1.0 / 60.0);
            let nothing = InteractionGroups::none();
            let ball = |x: f32| {
                let ball = ColliderBuilder::ball(0.1).mass(1.0);
                ball.translation(Vector::X * x).collision_groups(nothing)
            };
            let body = world.insert(RigidBodyBuilder::dynamic().can_sleep(false), ball(0.0));
            world.insert_collider(ball(1.0), Some(body.0));
            let mut set = DeformableWorld::default();
            let net = Net::new(vec![Node::new(Vector::ZERO, 1.0)], vec![]);
            let bead = DeformableBuilder::new(net).can_sleep(false);
            let bead = set.insert(bead).unwrap();
            let attachment = match hold {
                "weld" => Attachment::weld([NodeId(0)]),
                "pin" => Attachment::pin([NodeId(0)]),
                _ => Attachment::link([NodeId(0)], 1e5),
            };
            set.attach(bead, attachment, body.0, &world.bodies).unwrap();
            for i in 0..60 {
                if i == 20 {
                    change(&mut world, body.0);
                }
                set.step(&mut world);
            }
            let node = set[bead].position(NodeId(0)).unwrap().as_vec3();
            let on_body = world.bodies[body.0].position().inverse() * node;
            let speed = world.bodies[body.0].linvel().length();
            assert!(on_body.length() < 1e-5, "{what}, {hold}: at {on_body}");
            assert!(speed < 1e-5, "{what}, {hold}: {speed} m/s");
        }
    }
}

/// A bead on a damped link of a body, both turning freely about their common centre: the link stretches until it bears the
/// bead, and then nothing in it moves, so nothing is lost any more.
#[test]
fn a_damped_link_takes_no_spin_from_what_turns_as_a_whole() {
    for damping in [5.0_f32, 50.0] {
        let (spin, lever) = (20.0_f32, 0.2_f32);
        let mut world = weightless(1.0 / 240.0);
        let shape = ColliderBuilder::cuboid(0.05, 0.05, 0.05).mass(2.0);
        let body = RigidBodyBuilder::dynamic().angvel(Vector::Z * spin);
        let (body, _) = world.insert(body.can_sleep(false), shape);
        let mut set = DeformableWorld::default();
        let net = Net::new(vec![Node::new(Vector::X * lever, 0.5)], vec![]);
        let bead = DeformableBuilder::new(net).linvel(Vector::Y * (spin * lever));
        let bead = set.insert(bead).unwrap();
        let link = Attachment::link([NodeId(0)], 2e3).damping(damping);
        set.attach(bead, link, body, &world.bodies).unwrap();
        let now = |set: &DeformableWorld, world: &PhysicsWorld| {
            let rigid = &world.bodies[body];
            let (at, v) = (rigid.center_of_mass().as_dvec3(), rigid.linvel().as_dvec3());
            let inertia = f64::from(rigid.mass_properties().local_mprops.principal_inertia().z);
            let own = inertia * f64::from(rigid.angvel().z);
            own + (2.0 * at.cross(v)).z + set[bead].angular_momentum(DVec3::ZERO).z
        };
        let start = now(&set, &world);
        for _ in 0..480 {
            set.step(&mut world);
        }
        let settled = set[bead].energies().dissipated();
        for _ in 0..480 {
            set.step(&mut world);
        }
        let lost = set[bead].energies().dissipated() - settled;
        let energy = 0.5 * start * f64::from(spin);
        assert!(
            lost.abs() < 1e-3 * energy,
            "{damping}: lost {lost} of {energy} J"
        );
        close("angular momentum [N·m·s]", now(&set, &world), start, 1e-3);
    }
}
