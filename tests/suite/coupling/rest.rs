//! Scenes that come to rest.

use super::{Mode, block, cuboid, floor};
use crate::support::close;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Height over time of a body, and when it fell asleep.
struct Watch {
    heights: Vec<f32>,
    asleep_at: Option<usize>,
    woke_again: bool,
    tilt: f32,
    /// Largest mechanical energy over that at the start.
    gain: f64,
}

/// Kinetic, elastic and potential energy of everything [J].
fn energy(world: &PhysicsWorld, deformables: &DeformableWorld) -> f64 {
    let soft: f64 = deformables
        .iter()
        .map(|(_, b)| {
            let e = b.energies();
            e.kinetic + e.elastic + b.mass() * 9.81 * b.center_of_mass().y
        })
        .sum();
    let rigid: f64 = world
        .bodies
        .iter()
        .filter(|(_, b)| b.is_dynamic())
        .map(|(_, b)| {
            f64::from(b.kinetic_energy()) + f64::from(b.mass() * 9.81 * b.center_of_mass().y)
        })
        .sum();
    soft + rigid
}

impl Watch {
    fn run(
        world: &mut PhysicsWorld,
        deformables: &mut DeformableWorld,
        body: RigidBodyHandle,
        frames: usize,
    ) -> Self {
        let mut watch = Self {
            heights: Vec::new(),
            asleep_at: None,
            woke_again: false,
            tilt: 0.0,
            gain: 0.0,
        };
        let start = energy(world, deformables);
        for frame in 0..frames {
            deformables.step(world);
            watch.gain = watch.gain.max(energy(world, deformables) / start - 1.0);
            let rb = &world.bodies[body];
            watch.heights.push(rb.translation().y);
            let up = *rb.rotation() * Vector::Y;
            watch.tilt = watch.tilt.max(up.y.clamp(-1.0, 1.0).acos());
            if rb.is_sleeping() {
                watch.asleep_at.get_or_insert(frame);
            } else if watch.asleep_at.is_some() {
                watch.woke_again = true;
            }
        }
        watch
    }

    fn height(&self) -> f64 {
        f64::from(self.heights[self.heights.len() - 1])
    }

    /// Spread of the heights over the last `frames`.
    fn jitter(&self, frames: usize) -> f32 {
        let tail = &self.heights[self.heights.len() - frames..];
        let max = tail.iter().copied().fold(f32::MIN, f32::max);
        let min = tail.iter().copied().fold(f32::MAX, f32::min);
        max - min
    }

    #[track_caller]
    fn assert_no_gain(&self, mode: Mode) {
        assert!(
            self.gain < 1e-3,
            "{mode:?}: energy grew by {:.2e} of what it was",
            self.gain
        );
    }

    #[track_caller]
    fn assert_asleep(&self, mode: Mode) {
        assert!(
            self.asleep_at.is_some() && !self.woke_again,
            "{mode:?}: asleep at frame {:?}, woke again: {}, jitter {:.2e} m",
            self.asleep_at,
            self.woke_again,
            self.jitter(60)
        );
        assert!(
            self.jitter(60) <= 2e-4,
            "{mode:?}: jitter {} m, at most .2 mm",
            self.jitter(60)
        );
    }
}

/// A 1 kg box of 24 cm on a 10 kg block, E = .2 MPa.
#[test]
fn light_box_rests_on_a_block() {
    let mut heights = Vec::new();
    for mode in Mode::BOTH {
        let mut world = floor();
        let mut deformables = mode.deformables();
        deformables
            .insert(block(10.0, 2e5).translation(Vector::new(0.0, 0.2, 0.0)))
            .unwrap();
        let (body, _) = world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.53, 0.0)),
            cuboid([0.12; 3], 1.0),
        );
        let watch = Watch::run(&mut world, &mut deformables, body, 240);
        watch.assert_no_gain(mode);
        watch.assert_asleep(mode);
        assert!(watch.tilt < 0.01, "{mode:?}: tilt {}", watch.tilt);
        heights.push(watch.height());
    }
    close("rest height [m]", heights[0], heights[1], 0.03);
}

/// A 100 kg box of 30 cm let go on a 1 kg block, E = .2 MPa: it bounces, and does not gain.
#[test]
fn heavy_box_on_a_light_block() {
    let mut ranges = Vec::new();
    for mode in Mode::BOTH {
        let mut world = floor();
        let mut deformables = mode.deformables();
        deformables
            .insert(block(1.0, 2e5).translation(Vector::new(0.0, 0.2, 0.0)))
            .unwrap();
        let (body, _) = world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.56, 0.0)),
            cuboid([0.15; 3], 100.0),
        );
        let watch = Watch::run(&mut world, &mut deformables, body, 240);
        watch.assert_no_gain(mode);
        let highest = watch.heights.iter().copied().fold(f32::MIN, f32::max);
        assert!(
            highest < 0.5605,
            "{mode:?}: rose to {highest} m, let go at .56 m"
        );
        assert!(watch.tilt < 0.05, "{mode:?}: tilt {}", watch.tilt);
        ranges.push((watch.height(), f64::from(watch.jitter(60))));
    }
    close("height at 4 s [m]", ranges[0].0, ranges[1].0, 0.03);
    close(
        "range of the bounce in the fourth second [m]",
        ranges[0].1,
        ranges[1].1,
        0.03,
    );
}

/// Five rigid boxes of 5 kg and five soft ones of 5 kg, E = 1 MPa, one upon the other.
#[test]
fn stack_of_rigid_and_soft() {
    let mut heights = Vec::new();
    for mode in Mode::BOTH {
        let mut world = floor();
        let mut deformables = mode.deformables();
        let mut top = RigidBodyHandle::invalid();
        for i in 0..5 {
            let y = i as f32 * 0.702;
            deformables
                .insert(block(5.0, 1e6).translation(Vector::new(0.0, y + 0.2005, 0.0)))
                .unwrap();
            top = world
                .insert(
                    RigidBodyBuilder::dynamic().translation(Vector::new(0.0, y + 0.5515, 0.0)),
                    cuboid([0.2, 0.15, 0.2], 5.0),
                )
                .0;
        }
        let watch = Watch::run(&mut world, &mut deformables, top, 360);
        watch.assert_no_gain(mode);
        watch.assert_asleep(mode);
        heights.push(watch.height());
    }
    close("height of the top [m]", heights[0], heights[1], 0.03);
}

/// A box of .5 kg, 24 × 10 × 24 cm, between the floor and a 20 kg block, E = .1 MPa.
#[test]
fn light_box_under_a_block() {
    let mut heights = Vec::new();
    for mode in Mode::BOTH {
        let mut world = floor();
        let mut deformables = mode.deformables();
        deformables
            .insert(block(20.0, 1e5).translation(Vector::new(0.0, 0.302, 0.0)))
            .unwrap();
        let (body, _) = world.insert(
            RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.0501, 0.0)),
            cuboid([0.12, 0.05, 0.12], 0.5),
        );
        let watch = Watch::run(&mut world, &mut deformables, body, 240);
        watch.assert_no_gain(mode);
        watch.assert_asleep(mode);
        heights.push(watch.height());
    }
    close("height [m]", heights[0], heights[1], 0.03);
}

/// A 4 kg block, E = .2 MPa, on a kinematic platform that goes to and fro by 1 m in 4 s, μ = .5 on both sides.
#[test]
fn ride_on_a_platform() {
    for mode in Mode::BOTH {
        let mut world = PhysicsWorld::default();
        let (platform, _) = world.insert(
            RigidBodyBuilder::kinematic_position_based().translation(Vector::new(0.0, -0.1, 0.0)),
            ColliderBuilder::cuboid(1.0, 0.1, 1.0).friction(0.5),
        );
        let mut deformables = mode.deformables();
        let rider = deformables
            .insert(block(4.0, 2e5).translation(Vector::new(0.0, 0.2, 0.0)))
            .unwrap();
        let (mut slip, mut start) = (0.0_f64, None);
        for frame in 0..300 {
            let t = frame as f32 / 60.0;
            // Half a second to settle, then x = ½(1 − cos(πt/2)).
            let x = 0.5 * (1.0 - ((t - 0.5).max(0.0) * std::f32::consts::FRAC_PI_2).cos());
            world.bodies[platform].set_next_kinematic_translation(Vector::new(x, -0.1, 0.0));
            deformables.step(&mut world);
            let relative = deformables[rider].center_of_mass().x
                - f64::from(world.bodies[platform].translation().x);
            if t >= 0.5 {
                slip = slip.max((relative - *start.get_or_insert(relative)).abs());
            }
        }
        assert!(slip <= 0.015, "{mode:?}: slip {slip} m, at most 15 mm");
    }
}

/// What rests on a soft block, however heavy, is no defect of the coupling.
#[test]
fn a_heavy_box_at_rest_has_no_defect() {
    let mut world = PhysicsWorld::default();
    world.integration_parameters.dt = 1.0 / 60.0;
    let ground = RigidBodyBuilder::fixed().translation(Vector::Y * -0.5);
    world.insert(ground, ColliderBuilder::cuboid(5.0, 0.5, 5.0));
    let load = RigidBodyBuilder::dynamic().translation(Vector::Y * 0.62);
    let shape = ColliderBuilder::cuboid(0.2, 0.1, 0.2).mass(1000.0);
    world.insert(load.can_sleep(false), shape);
    let mut set = DeformableWorld::default();
    let block = DeformableBuilder::new(lattice(Vector::splat(0.5), 0.25))
        .material(Material::elastic(1e7, 300.0).viscosity(5e5))
        .translation(Vector::Y * 0.25)
        .can_sleep(false);
    set.insert(block).unwrap();
    let mut defect = 0.0;
    for i in 0..600 {
        set.step(&mut world);
        if i >= 540 {
            defect += set.report().coupling_defect;
        }
    }
    assert!(defect.abs() < 1e-2, "{defect} J in a second");
}

/// Symptom: a disc on a cloth of 20 mm that lay on a floor sank through the cloth's thickness in 5 s. Cause: nodes were moved out of the
/// disc into the floor, and the disc fell after them.
#[test]
fn a_thick_cloth_on_a_floor_bears_what_lies_on_it() {
    for (name, shape) in [
        ("disc", ColliderBuilder::cylinder(0.1, 0.1)),
        ("box", cuboid([0.1; 3], 3.0)),
        ("cone", ColliderBuilder::cone(0.1, 0.1)),
    ] {
        for nodes in [8, 11, 16] {
            let mut world = floor();
            let body = RigidBodyBuilder::dynamic()
                .translation(Vector::new(0.05, 0.12, -0.05))
                .can_sleep(false);
            let (body, _) = world.insert(body, shape.clone().density(3000.0).friction(0.5));
            let mut deformables = DeformableWorld::default();
            let cloth = crumple::shape::sheet(3.0, 3.0, nodes, nodes, 0.004).unwrap();
            let cloth = DeformableBuilder::new(cloth)
                .material(Material::elastic(1e6, 400.0).viscosity(3e3))
                .thickness(0.02)
                .can_sleep(false)
                .translation(Vector::Y * 0.01);
            let cloth = deformables.insert(cloth).unwrap();
            for _ in 0..240 {
                deformables.step(&mut world);
            }
            let sunk = 0.12 - world.bodies[body].translation().y;
            let what = format!("{name}, {nodes} nodes a side");
            assert!(sunk.abs() < 1e-4, "{what}: sunk by {sunk} m");
            let lowest = deformables[cloth].positions().map(|p| p.y);
            let lowest = lowest.fold(f32::INFINITY, f32::min);
            assert!(lowest > 0.0098, "{what}: a node at {lowest} m");
        }
    }
}

/// Stacks of rigid boxes that can't sleep, on a block so stiff that a box alone would swing on it within two of Rapier's steps.
/// Rapier's contacts give way to what changes in a step, and the block pressed that back: four boxes rocked, and crept 4 mm/s.
#[test]
fn a_stack_on_a_stiff_block_stays_where_it_is() {
    for count in [2, 4] {
        let mut world = floor();
        let mut deformables = DeformableWorld::new();
        let block = DeformableBuilder::new(lattice(Vector::new(0.3, 0.1, 0.3), 0.1))
            .material(Material::elastic(5e6, 300.0).viscosity(1e4))
            .translation(Vector::Y * 0.05)
            .can_sleep(false);
        deformables.insert(block).unwrap();
        let boxes: Vec<_> = (0..count)
            .map(|i| {
                let body = RigidBodyBuilder::dynamic()
                    .can_sleep(false)
                    .translation(Vector::Y * (0.151 + 0.1 * i as f32));
                let shape = ColliderBuilder::cuboid(0.1, 0.05, 0.1).density(500.0);
                world.insert(body, shape).0
            })
            .collect();
        let sideways = |world: &PhysicsWorld| {
            let off = boxes.iter().map(|b| world.bodies[*b].translation());
            off.map(|t| Vector::new(t.x, 0.0, t.z)).collect::<Vec<_>>()
        };
        let run = |deformables: &mut DeformableWorld, world: &mut PhysicsWorld, seconds: usize| {
            (0..60 * seconds).for_each(|_| deformables.step(world));
        };
        run(&mut deformables, &mut world, 2);
        let before = sideways(&world);
        run(&mut deformables, &mut world, 4);
        for (old, new) in before.iter().zip(sideways(&world)) {
            let crept = (new - *old).length();
            assert!(crept < 1e-4, "{count} boxes: {crept} m in 4 s");
        }
        let top = world.bodies[*boxes.last().unwrap()].translation();
        let height = 0.05 + 0.1 * count as f32;
        assert!((top.y - height).abs() < 0.005 * count as f32, "{top}");
    }
}
