//! Joints with limits, motors and springs take part between Rapier's steps: against the mechanics of what they hold.

mod chains;
mod motors;
mod soft;
mod stops;
mod swings;

use super::{Mode, block, cuboid};
use crate::support::weightless;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

const G: f64 = 9.81;

/// A scene, and what deformables got from colliders.
struct Stage {
    world: PhysicsWorld,
    set: DeformableWorld,
    ground: RigidBodyHandle,
    scales: Scales,
    /// Sum of the sizes of the coupling defect [J].
    defect: f64,
}

/// Impulse on deformables by contacts, and the time.
#[derive(Default)]
struct Scales {
    impulse: Vector,
    time: f64,
    /// Only of this one, if there is one.
    of: Option<ColliderHandle>,
}

impl Observer for Scales {
    fn substep(&mut self, s: &Substep) {
        self.time += s.h;
        let partner = self.of.map(Partner::Collider);
        let counts = |c: &&crumple::world::PairImpulse| partner.is_none_or(|p| p == c.partner);
        for c in s.contacts.iter().filter(counts) {
            self.impulse += c.impulse.as_vec3();
        }
    }
}

impl Stage {
    fn new(mode: Mode, gravity: f32) -> Self {
        let mut world = weightless(1.0 / 60.0);
        world.gravity = Vector::Y * -gravity;
        let ground = world.bodies.insert(RigidBodyBuilder::fixed());
        Self {
            world,
            set: mode.deformables(),
            ground,
            scales: Scales::default(),
            defect: 0.0,
        }
    }

    fn body(&mut self, at: Vector, half: [f32; 3], mass: f32) -> RigidBodyHandle {
        let body = RigidBodyBuilder::dynamic().translation(at).can_sleep(false);
        self.world.insert(body, cuboid(half, mass)).0
    }

    fn join(&mut self, body: RigidBodyHandle, joint: impl Into<GenericJoint>) {
        self.world.insert_impulse_joint(self.ground, body, joint);
    }

    fn step(&mut self) {
        let Self {
            world, set, scales, ..
        } = self;
        set.step_with(world, &(), &(), scales);
        self.defect += self.set.report().coupling_defect.abs();
    }

    /// The mean force of contacts on deformables over so many steps [N].
    fn force(&mut self, steps: usize) -> Vector {
        self.scales = Scales {
            of: self.scales.of,
            ..Scales::default()
        };
        for _ in 0..steps {
            self.step();
        }
        self.scales.impulse / self.scales.time as f32
    }

    fn insert(&mut self, mass: f32, young: f32, at: Vector, v: Vector) -> DeformableHandle {
        let block = block(mass, young).translation(at).linvel(v);
        self.set.insert(block).unwrap()
    }

    /// What the shadows did not foresee is at most so much [J].
    #[track_caller]
    fn foresaw(&self, joules: f64) {
        assert!(self.defect < joules, "coupling defect {} J", self.defect);
    }

    fn height(&self, body: RigidBodyHandle) -> f64 {
        self.world.bodies[body].translation().y.into()
    }
}

/// A hinge with limits and a motor that no deformable touches moves bit for bit as in Rapier with as short a step, while a
/// block lies on a box nearby.
#[test]
fn what_is_not_touched_is_left_alone() {
    let run = |beside: bool| {
        let mut stage = Stage::new(Mode::Shipped, G as f32);
        let flap = stage.body(Vector::X * 0.5, [0.5, 0.05, 0.3], 4.0);
        let hinge = RevoluteJointBuilder::new(Vector::Z)
            .local_anchor2(Vector::X * -0.5)
            .limits([-0.3, 0.4])
            .motor_position(0.5, 60.0, 0.1);
        stage.join(flap, hinge);
        let far = Vector::X * 10.0;
        let ground = RigidBodyBuilder::fixed().translation(far - Vector::Y * 0.5);
        stage.world.insert(ground, cuboid([1.0, 0.5, 1.0], 1.0));
        stage.body(far + Vector::Y * 0.1, [0.3, 0.1, 0.3], 5.0);
        if beside {
            stage.insert(10.0, 1e6, far + Vector::Y * 0.41, Vector::ZERO);
        } else {
            stage.world.integration_parameters.dt /= 4.0;
            stage
                .world
                .integration_parameters
                .normalized_contact_recycle_distance = 2e-3;
        }
        let poses = (0..120).map(|_| {
            for _ in 0..if beside { 1 } else { 4 } {
                stage.step();
            }
            let body = &stage.world.bodies[flap];
            let (x, q) = (body.translation(), body.rotation());
            [x.x, x.y, x.z, q.x, q.y, q.z, q.w].map(f32::to_bits)
        });
        poses.collect::<Vec<_>>()
    };
    assert_eq!(run(true), run(false));
}
