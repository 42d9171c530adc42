//! What is led from target to target, frame by frame, and what lies on it or hangs on it.

use crate::support::close;
use crumple::body::{Net, Node, Spring};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

const AMPLITUDE: f64 = 0.05;
const OMEGA: f64 = 8.0;
const MASS: f64 = 7.2;

fn height(t: f64) -> f64 {
    AMPLITUDE * (1.0 - (OMEGA * t).cos())
}

/// Smallest and largest mean force along y of 1/240 s, after the first second \[N\].
struct Press {
    least: f64,
    most: f64,
    impulse: f64,
    time: f64,
}

impl Press {
    fn new() -> Self {
        Self {
            least: f64::INFINITY,
            most: 0.0,
            impulse: 0.0,
            time: 0.0,
        }
    }
}

impl Observer for Press {
    fn substep(&mut self, s: &Substep) {
        let contacts = s.contacts.iter().map(|c| c.impulse.y);
        let ties = s.attachments.iter().map(|a| a.impulse.y);
        self.impulse += contacts.chain(ties).sum::<f64>();
        self.time += s.h;
        if self.time >= 1.0 / 240.0 {
            let force = self.impulse / self.time;
            (self.impulse, self.time) = (0.0, 0.0);
            if s.time > 1.0 {
                (self.least, self.most) = (self.least.min(force), self.most.max(force));
            }
        }
    }
}

/// At 60 frames a second, in which it moves by up to 7 mm: it presses what lies on it, or is welded to it, by m·(g ± a·ω²).
#[test]
fn a_platform_that_swings_carries_by_its_acceleration() {
    for (welded, by_velocity) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut world = PhysicsWorld::default();
        let start = Vector::new(0.0, -0.1, 0.0);
        let body = if by_velocity {
            RigidBodyBuilder::kinematic_velocity_based()
        } else {
            RigidBodyBuilder::kinematic_position_based()
        };
        let body = body.translation(start);
        let (platform, _) = world.insert(body, ColliderBuilder::cuboid(1.0, 0.1, 1.0));
        let mut set = DeformableWorld::default();
        let net = lattice(Vector::new(0.3, 0.2, 0.3), 0.1).unwrap();
        let soft = Material::elastic(2e6, 400.0).viscosity(1e4);
        let at = Vector::Y * 0.1;
        let block = DeformableBuilder::new(net).material(soft).translation(at);
        let block = set.insert(block).unwrap();
        close("mass [kg]", set[block].mass(), MASS, 1e-3);
        if welded {
            let places = set[block].positions().enumerate();
            let lowest = places.filter(|(_, p)| p.y < 0.01);
            let nodes: Vec<NodeId> = lowest.map(|(i, _)| NodeId(i as u32)).collect();
            let weld = Attachment::weld(nodes);
            set.attach(block, weld, platform, &world.bodies).unwrap();
        }
        let mut press = Press::new();
        for frame in 1..=180 {
            let to = height(f64::from(frame) / 60.0);
            let way = to - height(f64::from(frame - 1) / 60.0);
            let linvel = Vector::Y * (60.0 * way) as f32;
            if by_velocity {
                world.bodies[platform].set_linvel(linvel, true);
            } else {
                let to = start + Vector::Y * to as f32;
                world.bodies[platform].set_next_kinematic_translation(to);
            }
            set.step_with(&mut world, &(), &(), &mut press);
        }
        let swing = AMPLITUDE * OMEGA * OMEGA;
        close("least force [N]", press.least, MASS * (9.81 - swing), 0.01);
        close("largest force [N]", press.most, MASS * (9.81 + swing), 0.01);
    }
}

/// Turned about a point at its rim, with its collider about the axle: the block on it feels the axle stand.
#[test]
fn a_carousel_that_is_held_at_its_rim_turns_about_its_axle() {
    let mut world = PhysicsWorld::default();
    let body =
        RigidBodyBuilder::kinematic_position_based().translation(Vector::new(1.0, -0.1, 0.0));
    let disc = ColliderBuilder::cylinder(0.1, 1.0).translation(Vector::X * -1.0);
    let (carousel, _) = world.insert(body, disc);
    let mut set = DeformableWorld::default();
    let net = lattice(Vector::splat(0.2), 0.1).unwrap();
    let soft = Material::elastic(2e6, 400.0).viscosity(1e4);
    let block = DeformableBuilder::new(net).material(soft);
    let block = set.insert(block.translation(Vector::Y * 0.1)).unwrap();
    let mut press = Press::new();
    for frame in 1..=180 {
        let turn = Rotation::from_rotation_y(3.0 * frame as f32 / 60.0);
        let at = turn * Vector::X - Vector::Y * 0.1;
        let next = Pose::from_parts(at, turn);
        world.bodies[carousel].set_next_kinematic_position(next);
        set.step_with(&mut world, &(), &(), &mut press);
    }
    let weight = set[block].mass() * 9.81;
    close("least force [N]", press.least, weight, 0.01);
    close("largest force [N]", press.most, weight, 0.01);
    let at = set[block].center_of_mass();
    assert!(at.x.hypot(at.z) < 1e-4, "{at}");
    assert!(set[block].angular_momentum(at).y > 0.0, "it turns along");
}

/// A bead that hangs on a led node by a spring of 16 Hz.
#[test]
fn a_led_node_pulls_by_its_acceleration() {
    let mut world = PhysicsWorld::default();
    let nodes = vec![
        Node::new(Vector::Y, 1.0).pinned(),
        Node::new(Vector::ZERO, 1.0),
    ];
    let spring = Spring::new(0, 1, 1e4).damping(20.0);
    let body = DeformableBuilder::new(Net::new(nodes, vec![spring]));
    let body = body.substeps(Substeps::Fixed(50));
    let mut set = DeformableWorld::default();
    let body = set.insert(body).unwrap();
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for frame in 1..=180 {
        let to = Vector::Y * (1.0 + height(f64::from(frame) / 60.0) as f32);
        assert!(set[body].set_kinematic_target(NodeId(0), to));
        set.step(&mut world);
        if frame > 60 {
            let force = set[body].tension(SpringId(0)).unwrap();
            (least, most) = (least.min(force), most.max(force));
        }
    }
    // What the spring of ω₀ = 100/s and ζ = 0.1 has of m·(g + a), besides its damper.
    let ratio = OMEGA / 100.0;
    let (spring, damper) = (1.0 - ratio * ratio, 0.2 * ratio);
    let gain = 1.0 / (spring * spring + damper * damper).sqrt();
    let swing = AMPLITUDE * OMEGA * OMEGA * gain;
    close("least force [N]", least, 9.81 - swing, 0.03);
    close("largest force [N]", most, 9.81 + swing, 0.03);
}

/// A block on a platform whose velocity is set before every frame, so that it speeds up by 2 m/s²: friction of 0.5 holds it. Symptom: it
/// slipped by (a·Δt)²/2μg at every jump of the velocity, 6.4 mm in a second.
#[test]
fn a_platform_that_is_driven_faster_carries_a_block() {
    for multiple in [false, true] {
        let mut world = PhysicsWorld::default();
        let body = RigidBodyBuilder::kinematic_velocity_based().translation(Vector::Y * -0.1);
        let ground = ColliderBuilder::cuboid(2.0, 0.1, 1.0).friction(0.5);
        let (platform, _) = world.insert(body, ground);
        if multiple {
            // What is awake beside it has Rapier stepped at 1/240 s.
            let aside = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.1, 0.28));
            world.insert(
                aside.can_sleep(false),
                ColliderBuilder::ball(0.1).friction(0.5),
            );
        }
        let mut set = DeformableWorld::default();
        let net = lattice(Vector::new(0.3, 0.2, 0.3), 0.1).unwrap();
        let soft = Material::elastic(2e6, 400.0).viscosity(1e4);
        let block = DeformableBuilder::new(net).material(soft).friction(0.5);
        let block = set.insert(block.translation(Vector::Y * 0.1)).unwrap();
        let place = |world: &PhysicsWorld, set: &DeformableWorld| {
            set[block].center_of_mass().x - f64::from(world.bodies[platform].translation().x)
        };
        let mut slip = 0.0;
        for frame in 1..=60 {
            if frame == 10 {
                slip = place(&world, &set);
            }
            let linvel = Vector::X * 2.0 * frame as f32 / 60.0;
            world.bodies[platform].set_linvel(linvel, true);
            set.step(&mut world);
            assert_eq!(world.bodies[platform].linvel(), linvel);
        }
        slip -= place(&world, &set);
        assert_eq!(set.report().rigid_steps, if multiple { 4 } else { 1 });
        assert!(slip.abs() < 1e-5, "{slip} m");
    }
}
