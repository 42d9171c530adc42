//! Cars: lattices of 1 t on light carriers, with wheels or feet on Rapier's joints.

use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::world::RapierParts;

/// What the lattice stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum On {
    Cylinders,
    Balls,
    /// On fixed joints, as heavy as their carriers \[kg\].
    Feet(f32),
}

/// A corner of a car.
struct Corner {
    carrier: RigidBodyHandle,
    wheel: RigidBodyHandle,
    joint: ImpulseJointHandle,
}

struct Car {
    world: PhysicsWorld,
    set: DeformableWorld,
    body: DeformableHandle,
    corners: Vec<Corner>,
}

impl Car {
    /// At a speed \[m/s\], on carriers of 20 kg with wheels of 20 kg; with an engine, but on feet.
    fn new(speed: f32, on: On) -> Self {
        let mut world = PhysicsWorld::default();
        let road = ColliderBuilder::cuboid(60.0, 0.5, 10.0).friction(0.8);
        let ground = RigidBodyBuilder::fixed().translation(Vector::Y * -0.5);
        world.insert(ground, road);
        let mut set = DeformableWorld::default();
        let (at, velocity) = (Vector::Y * 0.75, Vector::X * speed);
        let none = InteractionGroups::none();
        let chassis = DeformableBuilder::new(lattice(Vector::new(3.6, 0.8, 1.6), 0.2))
            .material(Material::car_body())
            .collision_groups(none)
            .translation(at)
            .linvel(velocity);
        let body = set.insert(chassis).unwrap();
        let rigid = |at| {
            let builder = RigidBodyBuilder::dynamic().translation(at).linvel(velocity);
            builder.can_sleep(false)
        };
        let mut carry = |world: &mut PhysicsWorld, part, center: Vector, half: DVec3| {
            let nodes = (0..set[body].node_count() as u32).map(NodeId);
            let is_in = |n: &NodeId| {
                let off = set[body].position(*n).unwrap() - center.as_dvec3();
                off.abs().cmplt(half).all()
            };
            let nodes: Vec<NodeId> = nodes.filter(is_in).collect();
            assert!(nodes.len() > 5);
            set.attach(body, &nodes, part, &world.bodies).unwrap();
        };
        if !matches!(on, On::Feet(_)) {
            let engine = ColliderBuilder::cuboid(0.3, 0.25, 0.35).collision_groups(none);
            let (engine, _) = world.insert(rigid(at), engine.mass(150.0));
            carry(&mut world, engine, at, DVec3::new(0.31, 0.26, 0.36));
        }
        let mut corners = Vec::new();
        for (x, z) in [(-1.2, -0.8), (-1.2, 0.8), (1.2, -0.8), (1.2, 0.8_f32)] {
            let hub = at + Vector::new(x, -0.4, z);
            let mass = match on {
                On::Feet(mass) => mass,
                _ => 20.0,
            };
            let carrier = ColliderBuilder::cuboid(0.1, 0.1, 0.1).collision_groups(none);
            let (carrier, _) = world.insert(rigid(hub), carrier.mass(mass));
            carry(&mut world, carrier, hub, DVec3::new(0.21, 0.05, 0.21));
            let axle = Vector::X * std::f32::consts::FRAC_PI_2;
            let (arm, spin, shape) = match on {
                On::Balls => (Vector::Z, 1.0, ColliderBuilder::ball(0.35)),
                On::Cylinders => (
                    Vector::Z,
                    1.0,
                    ColliderBuilder::cylinder(0.08, 0.35).rotation(axle),
                ),
                On::Feet(_) => (-Vector::Y, 0.0, ColliderBuilder::cuboid(0.2, 0.2, 0.2)),
            };
            let out = arm * (0.15 * if arm == Vector::Z { z.signum() } else { 1.0 });
            let builder = rigid(hub + out).angvel(Vector::Z * (-spin * speed / 0.35));
            let (wheel, _) = world.insert(builder, shape.mass(mass).friction(0.8));
            let joint: GenericJoint = match on {
                On::Feet(_) => FixedJointBuilder::new().local_anchor1(out).into(),
                _ => RevoluteJointBuilder::new(Vector::Z)
                    .local_anchor1(out)
                    .contacts_enabled(false)
                    .into(),
            };
            let joint = world.insert_impulse_joint(carrier, wheel, joint);
            corners.push(Corner {
                carrier,
                wheel,
                joint,
            });
        }
        Self {
            world,
            set,
            body,
            corners,
        }
    }

    fn run(&mut self, frames: usize) {
        (0..frames).for_each(|_| self.set.step(&mut self.world));
    }

    /// By how much the farthest wheel is off its carrier \[m\].
    fn gap(&self) -> f32 {
        let off = |c: &Corner| {
            let [a, b] = [c.carrier, c.wheel].map(|b| self.world.bodies[b].translation());
            ((a - b).length() - 0.15).abs()
        };
        self.corners.iter().map(off).fold(0.0, f32::max)
    }
}

/// Rapier leaves hinges in error by what its iterations do not get to, and nodes followed their carriers. Parked, the car took up
/// 1,710 J in 2 s, at 20 m/s 32 kJ on balls and 86 kJ on cylinders.
#[test]
fn a_car_stands_and_rolls_on_light_carriers() {
    let cases = [
        (0.0, On::Cylinders, 10.0),
        (20.0, On::Balls, 200.0),
        (20.0, On::Cylinders, 300.0),
    ];
    for (speed, on, most) in cases {
        let mut car = Car::new(speed, on);
        let y = car.set[car.body].center_of_mass().y;
        car.run(120);
        let soft = &car.set[car.body];
        let (e, v) = (soft.energies(), soft.linvel());
        let what = format!("{speed} m/s, {on:?}");
        assert!(e.dissipated() < most, "{what}: {} J", e.dissipated());
        assert!(e.work.rigid < most, "{what}: {} J", e.work.rigid);
        // Rapier's wheels roll off by themselves: the same car as a rigid body is at 0.11 m/s by then.
        assert!((v.x - f64::from(speed)).abs() < 0.2, "{what}: {v}");
        // Light wheels sink into Rapier's contacts by up to a centimetre under a heavy car.
        let sunk = y - soft.center_of_mass().y;
        assert!((-2e-3..1e-2).contains(&sunk), "{what}: {sunk} m");
        assert!(car.gap() < 1e-4, "{what}: {} m", car.gap());
        for (bond, _) in car.set.attachments() {
            let stretch = car.set.attachment_stretch(bond, &car.world.bodies);
            assert!(stretch.unwrap() < 2.5e-3, "{what}: {stretch:?}");
        }
    }
}

/// In the third second the lattice took up 1.8 kJ on feet of 20 kg, and 128 kJ on feet of 5 kg.
#[test]
fn a_car_stands_on_feet_on_fixed_joints() {
    for mass in [20.0, 5.0] {
        let mut car = Car::new(0.0, On::Feet(mass));
        car.run(120);
        let before = car.set[car.body].energies();
        car.run(60);
        let after = car.set[car.body].energies();
        let taken = after.dissipated() - before.dissipated();
        assert!(taken < 0.5, "{mass} kg: {taken} J");
        let given = after.work.rigid - before.work.rigid;
        assert!(given.abs() < 0.5, "{mass} kg: {given} J");
        let speeds = car.set[car.body].velocities().map(|v| v.length());
        let fastest = speeds.fold(0.0, f32::max);
        assert!(fastest < 5e-3, "{mass} kg: {fastest} m/s");
    }
}

/// Saved and restored in mid-run it goes on bit for bit.
#[test]
#[cfg(feature = "serde-serialize")]
fn a_car_rolls_on_after_it_was_restored() {
    let mut car = Car::new(10.0, On::Cylinders);
    car.run(20);
    let bytes = car.set.save(&car.world).unwrap();
    let (mut set, mut world) = DeformableWorld::load(&bytes).unwrap();
    for _ in 0..20 {
        car.set.step(&mut car.world);
        set.step(&mut world);
    }
    assert_eq!(car.set.state_hash(), set.state_hash());
    for (handle, body) in car.world.bodies.iter() {
        assert_eq!(body.position(), world.bodies[handle].position());
    }
}

/// One who owns the loop and steps at 240 Hz.
#[test]
fn a_car_stands_in_a_loop_of_its_own() {
    let mut car = Car::new(0.0, On::Cylinders);
    car.world.integration_parameters.dt = 1.0 / 240.0;
    for _ in 0..240 {
        car.set
            .before_step(&mut RapierParts::from(&mut car.world), &mut ());
        car.world.step();
        car.set.after_step(&mut RapierParts::from(&mut car.world));
    }
    let e = car.set[car.body].energies();
    assert!(e.dissipated() < 10.0, "{} J", e.dissipated());
    assert!(e.work.rigid < 10.0, "{} J", e.work.rigid);
}

/// Wheels that are let go roll on beside the car, which falls: none of them is turned by what its shadow was off.
#[test]
fn wheels_that_are_let_go_roll_on() {
    let mut car = Car::new(10.0, On::Cylinders);
    car.run(30);
    for corner in &car.corners {
        let joint = car.world.impulse_joints.get_mut(corner.joint, false);
        joint.unwrap().data.set_enabled(false);
    }
    let spins: Vec<f32> = car
        .corners
        .iter()
        .map(|c| car.world.bodies[c.wheel].angvel().z)
        .collect();
    car.run(3);
    for (corner, before) in car.corners.iter().zip(spins) {
        let wheel = &car.world.bodies[corner.wheel];
        assert!((wheel.angvel().z / before - 1.0).abs() < 0.02);
        let axle = *wheel.rotation() * Vector::Z;
        assert!(axle.z > 0.999, "{axle}");
    }
}
