//! Rigid parts carried by deformables: an engine in a net, and wheels on the joints of welded carriers.

use crate::fixtures::floored;
use crate::support::close;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Adds up what an attachment does to its deformable, downwards.
#[derive(Default)]
struct Scales {
    impulse: f64,
    time: f64,
}

impl Observer for Scales {
    fn substep(&mut self, s: &Substep) {
        self.time += s.h;
        self.impulse -= s.attachments.iter().map(|a| a.impulse.y).sum::<f64>();
    }
}

/// An engine ten times lighter or heavier than the net that carries it, dropped onto the floor.
#[test]
fn a_net_carries_a_rigid_part() {
    for ratio in [0.1, 1.0, 10.0] {
        let (mut world, _) = floored(1.0 / 60.0);
        let mut set = DeformableWorld::new();
        let net = lattice(Vector::new(0.8, 0.4, 0.8), 0.2).unwrap();
        let soft = set
            .insert(
                DeformableBuilder::new(net)
                    .material(Material::elastic(4.0e6, 200.0).viscosity(4.0e3))
                    .translation(Vector::new(0.0, 0.3, 0.0)),
            )
            .unwrap();
        let mass = set[soft].mass() as f32 * ratio;
        let (engine, _) = world.insert(
            RigidBodyBuilder::dynamic()
                .translation(Vector::new(0.0, 0.3, 0.0))
                .can_sleep(false),
            ColliderBuilder::cuboid(0.15, 0.1, 0.15)
                .mass(mass)
                .collision_groups(InteractionGroups::none()),
        );
        let middle: Vec<NodeId> = (0..set[soft].node_count() as u32)
            .map(NodeId)
            .filter(|&n| {
                let x = set[soft].position(n).unwrap();
                x.x.abs() < 0.21 && x.z.abs() < 0.21
            })
            .collect();
        let held = set.attach(soft, &middle, engine, &world.bodies).unwrap();
        let mut worst = 0.0_f64;
        for _ in 0..300 {
            set.step(&mut world);
            worst = worst.max(set.attachment_stretch(held, &world.bodies).unwrap());
        }
        assert!(worst < 1e-6, "ratio {ratio}: {worst:.3e} m off");
        let mut scales = Scales::default();
        for _ in 0..60 {
            set.step_with(&mut world, &(), &(), &mut scales);
        }
        let force = scales.impulse / scales.time;
        close(
            &format!("weight at ratio {ratio} [N]"),
            force,
            f64::from(mass) * 9.81,
            0.01,
        );
        let (v, w) = (
            world.bodies[engine].linvel().length(),
            world.bodies[engine].angvel().length(),
        );
        assert!(
            v < 0.01 && w < 0.02,
            "ratio {ratio}: still moves at {v} m/s, {w} rad/s"
        );
    }
}

/// Eight nodes of a block welded to a body that is lighter than they are, or heavier, in free flight and slowly turning:
/// nothing but that motion must be left after two seconds. A body of 1 g has a 10⁴th of their moment of inertia.
#[test]
fn a_light_body_turns_with_the_block_that_holds_it() {
    for (mass, speed) in [
        (25.0_f32, 0.0_f32),
        (2.5, 0.0),
        (2.5, 20.0),
        (0.05, 20.0),
        (0.001, 0.0),
        (0.001, 20.0),
    ] {
        let mut world = PhysicsWorld {
            gravity: Vector::ZERO,
            ..PhysicsWorld::default()
        };
        let mut set = DeformableWorld::new();
        let net = lattice(Vector::new(1.2, 0.4, 0.4), 0.4).unwrap();
        let block = set
            .insert(
                DeformableBuilder::new(net)
                    .material(Material::elastic(2.0e6, 80.0).viscosity(400.0))
                    .linvel(Vector::X * speed)
                    .angvel(Vector::new(0.0, 0.2, 0.1)),
            )
            .unwrap();
        let at = Vector::X * -0.6;
        let (body, _) = world.insert(
            RigidBodyBuilder::dynamic()
                .translation(at)
                .linvel(Vector::X * speed)
                .can_sleep(false),
            ColliderBuilder::cuboid(0.1, 0.1, 0.1)
                .mass(mass)
                .collision_groups(InteractionGroups::none()),
        );
        let end: Vec<NodeId> = (0..set[block].node_count() as u32)
            .map(NodeId)
            .filter(|&n| set[block].position(n).unwrap().x < -0.15)
            .collect();
        assert_eq!(end.len(), 8);
        set.attach(block, &end, body, &world.bodies).unwrap();
        let mut stored = 0.0_f64;
        for frame in 0..120 {
            set.step(&mut world);
            if frame >= 60 {
                stored = stored.max(set[block].energies().elastic);
            }
        }
        let e = set[block].energies();
        // Shares of the energy of its turning, with a radius of gyration of (1.2 m)/√12.
        let turning =
            0.5 * set[block].mass() * (0.2_f64.powi(2) + 0.1_f64.powi(2)) * 0.35_f64.powi(2);
        assert!(
            stored < 1.0e-2 * turning,
            "{mass} kg at {speed} m/s: {stored:.2e} of {turning:.2e} J"
        );
        assert!(
            e.work.push_out.abs() < 1.0e-3 * turning,
            "{:.2e} J",
            e.work.push_out
        );
        let w = world.bodies[body].angvel().length();
        assert!(
            (0.02..0.25).contains(&w),
            "{mass} kg at {speed} m/s: {w} rad/s"
        );
    }
}

/// A car: a lattice on four carriers, each welded to a corner and with a wheel on a revolute joint.
#[test]
fn a_lattice_rolls_on_rigid_wheels() {
    // All wheels and carriers together have 0.4, 1.6 and 10 times the mass of the chassis, carriers a quarter of the mass of the
    // nodes that are welded to them and more.
    let cars = [
        (5.0_f32, 400.0_f32),
        (5.0, 4.0e3),
        (20.0, 4.0e3),
        (128.0, 4.0e3),
    ];
    for (wheel_mass, viscosity) in cars {
        let (mut world, _) = floored(1.0 / 60.0);
        world.insert(
            RigidBodyBuilder::fixed().translation(Vector::new(20.0, -0.5, 0.0)),
            ColliderBuilder::cuboid(30.0, 0.499, 5.0),
        );
        let mut set = DeformableWorld::new();
        let net = lattice(Vector::new(2.0, 0.4, 1.2), 0.4).unwrap();
        let (speed, radius) = (4.0_f32, 0.3_f32);
        let chassis = set
            .insert(
                DeformableBuilder::new(net)
                    .material(Material::elastic(2.0e6, 80.0).viscosity(viscosity))
                    .translation(Vector::new(0.0, 0.7, 0.0))
                    .linvel(Vector::X * speed)
                    .collision_groups(InteractionGroups::none()),
            )
            .unwrap();
        let mut carriers = Vec::new();
        for (x, z) in [(-1.0, -0.6), (-1.0, 0.6), (1.0, -0.6), (1.0, 0.6)] {
            let at = Vector::new(x, 0.3, z);
            let moving = RigidBodyBuilder::dynamic()
                .translation(at)
                .linvel(Vector::X * speed)
                .can_sleep(false);
            let (carrier, _) = world.insert(
                moving.clone(),
                ColliderBuilder::cuboid(0.1, 0.1, 0.1)
                    .mass(wheel_mass / 2.0)
                    .collision_groups(InteractionGroups::none()),
            );
            let (wheel, _) = world.insert(
                moving.angvel(Vector::new(0.0, 0.0, -speed / radius)),
                ColliderBuilder::ball(radius).mass(wheel_mass).friction(0.9),
            );
            let axle = RevoluteJointBuilder::new(Vector::Z);
            world.impulse_joints.insert(carrier, wheel, axle, true);
            let corner: Vec<NodeId> = (0..set[chassis].node_count() as u32)
                .map(NodeId)
                .filter(|&n| {
                    let d = set[chassis].position(n).unwrap() - at.as_dvec3();
                    d.x.abs() < 0.45 && d.z.abs() < 0.45
                })
                .collect();
            assert!(corner.len() >= 8, "{}", corner.len());
            carriers.push(
                set.attach(chassis, &corner, carrier, &world.bodies)
                    .unwrap(),
            );
        }
        for _ in 0..60 {
            set.step(&mut world);
        }
        let height = set[chassis].center_of_mass().y;
        let (mut worst, mut fastest) = (0.0_f64, 0.0_f64);
        for _ in 0..240 {
            set.step(&mut world);
            for c in &carriers {
                worst = worst.max(set.attachment_stretch(*c, &world.bodies).unwrap());
            }
            fastest = fastest.max(set[chassis].linvel().x);
        }
        let (v, at) = (set[chassis].linvel(), set[chassis].center_of_mass());
        let shaking = set[chassis]
            .velocities()
            .map(|w| (w.as_dvec3() - v).length())
            .fold(0.0, f64::max);
        assert!(
            shaking < 0.02,
            "wheels of {wheel_mass} kg: nodes shake at {shaking:.3} m/s"
        );
        assert!(worst < 1e-6, "{worst:.3e} m off");
        assert!(fastest < 4.0 * 1.01, "gains speed: {fastest} m/s");
        close("speed after 5 s [m/s]", v.x, 4.0, 0.005);
        assert!(
            (at.y - height).abs() < 2e-3 && at.z.abs() < 0.02,
            "drifts to {at}"
        );
        assert!(v.y.abs() < 0.02 && v.z.abs() < 0.02, "{v}");
    }
}
