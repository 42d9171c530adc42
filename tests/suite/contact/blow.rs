//! What is struck within a substep meets what is next to it in that very substep, though it stood still when the substep
//! began and nothing thicker than 2 mm is there to catch it later.

use super::{Random, flat_field, grid_mesh};
use crate::support::{close, weightless};
use crumple::body::{Net, Node};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// Speed of what strikes \[m/s\], and the step \[s\]: 5 cm in a substep.
const SPEED: f32 = 50.0;
const DT: f32 = 1e-3;

fn plate(half_height: f32) -> ColliderBuilder {
    ColliderBuilder::cuboid(0.5, half_height, 0.5)
}

/// Meets deformables, but no other rigid body.
fn ghost(collider: ColliderBuilder) -> ColliderBuilder {
    collider.collision_groups(InteractionGroups::new(
        Group::GROUP_2,
        Group::ALL.difference(Group::GROUP_2),
        InteractionTestMode::And,
    ))
}

/// Nodes without springs, one substep per step.
fn nodes(list: impl IntoIterator<Item = (Vector, f32, Vector)>) -> DeformableBuilder {
    let nodes = list.into_iter().map(|(at, mass, linvel)| {
        let mut node = Node::new(at, mass);
        node.linvel = linvel;
        node
    });
    DeformableBuilder::new(Net::new(nodes.collect(), vec![])).substeps(Substeps::Fixed(1))
}

fn at_rest(x: f32, y: f32, mass: f32) -> (Vector, f32, Vector) {
    (Vector::new(x, y, 0.0), mass, Vector::ZERO)
}

/// A node that a rigid ball strikes, a centimetre over something thin.
#[test]
fn a_node_that_a_body_strikes_stays_over_a_thin_plate() {
    let grid = grid_mesh((-0.5, -0.5), (1.0, 1.0), (8, 8), TriMeshFlags::empty());
    let thin = [
        ("plate", plate(0.001)),
        ("mesh", grid),
        ("field", flat_field(1.0, 1.0, 0.1)),
        (
            "rounded",
            ColliderBuilder::round_cuboid(0.5, 0.0005, 0.5, 0.0005),
        ),
    ];
    for (name, thin) in thin {
        let mut random = Random(7);
        for round in 0..20 {
            let mut world = weightless(DT);
            world.insert(RigidBodyBuilder::fixed(), ghost(thin.clone()));
            let (gap, above) = (
                random.within(0.004, 0.03) as f32,
                random.within(0.0, 0.01) as f32,
            );
            let ball = RigidBodyBuilder::dynamic()
                .translation(Vector::Y * (gap + 0.02 + above))
                .linvel(Vector::Y * -SPEED);
            world.insert(ball, ghost(ColliderBuilder::ball(0.02).mass(0.01)));
            let mut deformables = DeformableWorld::default();
            let mass = random.within(0.001, 0.1) as f32;
            let struck = deformables
                .insert(nodes([at_rest(0.0, gap, mass)]))
                .unwrap();
            for step in 0..40 {
                deformables.step(&mut world);
                let y = deformables[struck].positions().next().unwrap().y;
                assert!(y > -1e-4, "{name}, round {round}, step {step}: {y}");
            }
        }
    }
}

/// A light plate that a heavy node strikes, with a light node right behind it.
#[test]
fn a_plate_that_a_node_strikes_does_not_pass_the_node_behind_it() {
    for (step, behind) in [0.004_f32, 0.01, 0.03].into_iter().enumerate() {
        let mut world = weightless(DT);
        let (plate, _) = world.insert(RigidBodyBuilder::dynamic(), plate(0.001).mass(0.01));
        let mut deformables = DeformableWorld::default();
        let striking = (Vector::Y * 0.005, 1.0, Vector::Y * -SPEED);
        let pair = deformables
            .insert(nodes([striking, at_rest(0.0, -behind, 0.01)]))
            .unwrap();
        for _ in 0..40 {
            deformables.step(&mut world);
            let y: Vec<f32> = deformables[pair].positions().map(|p| p.y).collect();
            let middle = world.bodies[plate].translation().y;
            assert!(
                y[0] > middle && y[1] < middle,
                "case {step}: {y:?} about {middle}"
            );
        }
    }
}

/// One thing strikes the next: a ball, a node, a light plate, a node, and a thin plate that holds them all.
#[test]
fn a_blow_goes_through_layers_and_nothing_through_anything() {
    let mut world = weightless(DT);
    world.insert(RigidBodyBuilder::fixed(), ghost(plate(0.001)));
    let (middle, _) = world.insert(
        RigidBodyBuilder::dynamic().translation(Vector::Y * 0.015),
        ghost(plate(0.001).mass(0.02)),
    );
    let (ball, _) = world.insert(
        RigidBodyBuilder::dynamic()
            .translation(Vector::Y * 0.05)
            .linvel(Vector::Y * -SPEED),
        ghost(ColliderBuilder::ball(0.02).mass(0.1)),
    );
    let mut deformables = DeformableWorld::default();
    let pair = deformables
        .insert(nodes([at_rest(0.0, 0.02, 0.01), at_rest(0.1, 0.008, 0.01)]))
        .unwrap();
    for step in 0..40 {
        deformables.step(&mut world);
        let y: Vec<f32> = deformables[pair].positions().map(|p| p.y).collect();
        let plate = world.bodies[middle].position();
        let over = plate.inverse() * deformables[pair].positions().next().unwrap();
        let under = plate.inverse() * deformables[pair].positions().nth(1).unwrap();
        assert!(y[1] > 0.0, "step {step}: {y:?}");
        assert!(over.y > 0.0 && under.y < 0.0, "step {step}: {over} {under}");
        assert!(world.bodies[ball].translation().y > y[0], "step {step}");
    }
}

/// A node is stopped by a wall, and a plate flies a centimetre behind it at the same speed.
#[test]
fn a_plate_that_flies_behind_a_node_is_stopped_by_it() {
    for behind in [0.004, 0.01, 0.03] {
        let mut world = weightless(DT);
        world.insert(RigidBodyBuilder::fixed(), ghost(plate(0.001)));
        let (flying, _) = world.insert(
            RigidBodyBuilder::dynamic()
                .translation(Vector::Y * (0.011 + behind))
                .linvel(Vector::Y * -SPEED),
            ghost(plate(0.001).mass(0.01)),
        );
        let mut deformables = DeformableWorld::default();
        let first = (Vector::Y * 0.011, 0.01, Vector::Y * -SPEED);
        let first = deformables.insert(nodes([first])).unwrap();
        for _ in 0..40 {
            deformables.step(&mut world);
            let y = deformables[first].positions().next().unwrap().y;
            let plate = world.bodies[flying].translation().y;
            assert!(y > 0.0 && plate > y, "{behind}: {y}, {plate}");
        }
    }
}

fn sheet_at(y: f32, mass: f32) -> Net {
    let mut net = sheet(0.4, 0.4, 5, 5, 1e-3).unwrap();
    for node in &mut net.nodes {
        node.position.y = y;
        node.mass = mass / 25.0;
        node.volume = 0.0;
    }
    for spring in &mut net.springs {
        spring.section = 0.0;
        spring.stiffness = 1e4;
        spring.damping = 1.0;
    }
    net
}

/// A sheet at rest is struck by a flying one, and another thin sheet is a centimetre below it, or a plate far below.
#[test]
fn a_sheet_that_a_sheet_strikes_stays_over_what_is_below() {
    for (below, dt) in [(0.01, DT), (0.3, 1.0 / 60.0)] {
        let mut world = weightless(dt);
        let mut deformables = DeformableWorld::default();
        if below > 0.1 {
            world.insert(RigidBodyBuilder::fixed(), plate(0.001));
        } else {
            let mut pinned = sheet_at(0.0, 0.1);
            for node in &mut pinned.nodes {
                node.pinned = true;
            }
            deformables.insert(DeformableBuilder::new(pinned)).unwrap();
        }
        let struck = deformables
            .insert(DeformableBuilder::new(sheet_at(below, 0.05)))
            .unwrap();
        let flying = deformables
            .insert(DeformableBuilder::new(sheet_at(below + 0.01, 1.0)).linvel(Vector::Y * -SPEED))
            .unwrap();
        for step in 0..20 {
            deformables.step(&mut world);
            for (name, handle) in [("struck", struck), ("flying", flying)] {
                let low = deformables[handle]
                    .positions()
                    .map(|p| p.y)
                    .fold(1.0, f32::min);
                assert!(low > -1e-3, "{name}, {below} m, step {step}: {low}");
            }
        }
    }
}

/// What lands fast is rubbed by what it lands on: by Coulomb's share of the impulse that stops it.
#[test]
fn a_node_that_lands_fast_is_slowed_by_friction() {
    for on_sheet in [true, false] {
        let mut world = weightless(DT);
        let mut deformables = DeformableWorld::default();
        if on_sheet {
            let mut pinned = sheet_at(0.0, 0.1);
            for node in &mut pinned.nodes {
                node.pinned = true;
            }
            let pinned = DeformableBuilder::new(pinned).friction(0.5);
            deformables.insert(pinned).unwrap();
        } else {
            world.insert(RigidBodyBuilder::fixed(), plate(0.001).friction(0.5));
        }
        let at = Vector::new(-0.06, 0.0137, 0.03);
        let flying = nodes([(at, 0.01, Vector::new(10.0, -10.0, 0.0))]).friction(0.5);
        let flying = deformables.insert(flying).unwrap();
        for _ in 0..8 {
            deformables.step(&mut world);
        }
        let v = deformables[flying].linvel();
        assert!(v.y.abs() < 1e-3, "on a sheet: {on_sheet}, {v}");
        close("speed along the surface", v.x, 5.0, 0.02);
    }
}
