//! A rigid body that hangs on pinned nodes: these give way to nothing, and from the third on hold it more than once.
//!
//! Symptom: the forces of their attachments added up to 1.1 times the weight, with up to 15 % of it sideways. Cause: tie
//! after tie, loads that only strain the body were handed to and fro and left there.

use crumple::body::{Net, Node};
use crumple::math::DVec3;
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;

/// The corners of a box of 0.2 m, every second one of the other face first, so that few of them hold it firmly.
const CORNERS: [[f32; 3]; 8] = [
    [-0.1, 0.1, -0.1],
    [0.1, 0.1, 0.1],
    [0.1, 0.1, -0.1],
    [-0.1, 0.1, 0.1],
    [-0.1, -0.1, 0.1],
    [0.1, -0.1, -0.1],
    [0.1, -0.1, 0.1],
    [-0.1, -0.1, -0.1],
];

/// Like nothing in particular.
const ASKEW: [[f32; 3]; 8] = [
    [-0.1, 0.1, -0.07],
    [0.13, 0.11, 0.1],
    [0.02, 0.3, -0.1],
    [-0.2, 0.1, 0.05],
    [-0.1, -0.04, 0.1],
    [0.1, -0.2, -0.1],
    [0.3, -0.1, 0.01],
    [-0.1, 0.0, -0.4],
];

/// A box of 8 kg, nodes, and attachments between them.
struct Hung {
    world: PhysicsWorld,
    set: DeformableWorld,
    load: RigidBodyHandle,
    nodes: DeformableHandle,
    places: Vec<Vector>,
    bonds: Vec<AttachmentHandle>,
}

/// What attachments did to a body, in all.
#[derive(Default)]
struct Sum {
    impulse: DVec3,
    time: f64,
}

impl Observer for Sum {
    fn substep(&mut self, s: &Substep) {
        self.impulse -= s.attachments.iter().map(|a| a.impulse).sum::<DVec3>();
        self.time += s.h;
    }
}

impl Hung {
    /// The first `pinned` places are those of pinned nodes, the others have nodes of 0.5 kg.
    fn new(places: &[[f32; 3]], pinned: usize, bonds: Vec<Attachment>) -> Self {
        let mut world = PhysicsWorld::default();
        let shape = ColliderBuilder::cuboid(0.1, 0.1, 0.1).density(1000.0);
        let (load, _) = world.insert(
            RigidBodyBuilder::dynamic().can_sleep(false),
            shape.collision_groups(InteractionGroups::none()),
        );
        let places: Vec<Vector> = places.iter().map(|p| Vector::from_array(*p)).collect();
        let node = |(i, x): (usize, &Vector)| {
            let node = Node::new(*x, 0.5);
            if i < pinned { node.pinned() } else { node }
        };
        let net = Net::new(places.iter().enumerate().map(node).collect(), vec![]);
        let mut set = DeformableWorld::new();
        let nodes = set.insert(DeformableBuilder::new(net)).unwrap();
        let attach = |bond| set.attach(nodes, bond, load, &world.bodies).unwrap();
        let bonds = bonds.into_iter().map(attach).collect();
        Self {
            world,
            set,
            load,
            nodes,
            places,
            bonds,
        }
    }

    fn step(&mut self, seconds: f32) {
        for _ in 0..(seconds * 60.0).round() as usize {
            self.set.step(&mut self.world);
        }
    }

    fn mass(&self) -> f64 {
        self.world.bodies[self.load].mass().into()
    }

    /// Every reading of a second against the weight: all forces together, and their moments about the centre of the box.
    #[track_caller]
    fn bears_the_weight(&mut self, name: &str) {
        let weight = self.mass() * 9.81;
        for _ in 0..60 {
            self.step(1.0 / 60.0);
            let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
            for bond in &self.bonds {
                let (f, m) = self.set.attachment_force(*bond).unwrap();
                let state = self.set.attachment(*bond).unwrap();
                let about_center = state.moment + state.pivot.cross(f);
                assert!((m - about_center).length() < 1e-4 * weight, "{name}: {m}");
                (force, moment) = (force + f, moment + m);
            }
            let (force, moment) = (force / weight - DVec3::Y, moment / weight);
            assert!(force.length() < 1e-3, "{name}: force off by {force}");
            assert!(moment.length() < 1e-4, "{name}: {moment} m");
        }
    }

    /// Sets all pinned nodes this much off.
    fn lead(&mut self, by: Vector) {
        for (i, place) in (0..).zip(&self.places) {
            let node = NodeId(i);
            if self.set[self.nodes].blueprint().nodes[i as usize].pinned {
                assert!(self.set[self.nodes].set_kinematic_target(node, *place + by));
            }
        }
    }
}

/// The nodes of these numbers.
fn ids(numbers: std::ops::Range<u32>) -> impl Iterator<Item = NodeId> {
    numbers.map(NodeId)
}

#[test]
fn pinned_nodes_bear_the_weight() {
    for (name, places) in [("corners", CORNERS), ("askew", ASKEW)] {
        for n in [2, 3, 4, 8] {
            if n == 2 && places == ASKEW {
                continue; // These it would turn about.
            }
            let all = ids(0..n);
            let mut hung = Hung::new(&places[..n as usize], 8, vec![Attachment::weld(all)]);
            hung.step(1.0);
            hung.bears_the_weight(&format!("{n} {name}"));
            let at = hung.world.bodies[hung.load].translation();
            assert!(at.length() < 1e-6, "{n} {name}: moved to {at}");
        }
    }
}

#[test]
fn all_kinds_of_attachment_bear_it_together() {
    let weld = |numbers| Attachment::weld(ids(numbers));
    let pin = |numbers| Attachment::pin(ids(numbers));
    let cases = [
        ("two welds", 8, vec![weld(0..4), weld(4..8)]),
        ("that share", 8, vec![weld(0..6), weld(4..8)]),
        ("weld and pin", 8, vec![weld(0..5), pin(5..8)]),
        ("half pinned", 4, vec![weld(0..8)]),
        ("one pinned", 3, vec![weld(0..2), weld(2..8)]),
        ("pinned in part", 4, vec![weld(0..4), pin(3..5)]),
        ("pins", 8, vec![pin(0..2), pin(2..5), pin(5..8)]),
    ];
    for (name, pinned, bonds) in cases {
        let mut hung = Hung::new(&CORNERS, pinned, bonds);
        hung.step(1.0);
        hung.bears_the_weight(name);
    }
}

/// At a constant velocity, then with an acceleration, which takes until the second frame to be known.
#[test]
fn nodes_on_their_way_bear_it_too() {
    let (v, a) = (Vector::new(0.5, 0.2, -0.1), Vector::new(3.0, 1.0, -2.0));
    for (name, places) in [("corners", CORNERS), ("askew", ASKEW)] {
        for n in [3, 4, 8] {
            let mut hung = Hung::new(&places[..n], 8, vec![Attachment::weld(ids(0..n as u32))]);
            let mut way = Vector::ZERO;
            for _ in 0..60 {
                way += v / 60.0;
                hung.lead(way);
                hung.step(1.0 / 60.0);
            }
            let weight = hung.mass() * 9.81;
            for _ in 0..30 {
                way += v / 60.0;
                hung.lead(way);
                hung.step(1.0 / 60.0);
                let (force, _) = hung.set.attachment_force(hung.bonds[0]).unwrap();
                let off = force / weight - DVec3::Y;
                assert!(off.length() < 1e-3, "{n} {name}: {off}");
            }
            let mut sum = Sum::default();
            for i in 1..=30 {
                let t = i as f32 / 60.0;
                hung.lead(way + v * t + a * (0.5 * t * t));
                hung.set.step_with(&mut hung.world, &(), &(), &mut sum);
            }
            // Velocities stand half a substep, here of 1/240 s, before positions.
            let share = 1.0 - 0.5 / 240.0 / sum.time;
            let expected = hung.mass() * (DVec3::Y * 9.81 + a.as_dvec3() * share);
            let off = (sum.impulse / sum.time - expected) / weight;
            assert!(off.length() < 1e-3, "{n} {name}: {off} in the mean");
        }
    }
}

/// What is nearly too much holds, and a little more does not.
#[test]
fn they_break_at_their_strength() {
    for (share, holds) in [(1.002, true), (0.998, false)] {
        let weight = 8.0 * 9.81;
        let weld = Attachment::weld(ids(0..8)).strength(weight * share);
        let mut hung = Hung::new(&ASKEW, 8, vec![weld]);
        hung.step(1.0);
        let broken = hung
            .set
            .attachment(hung.bonds[0])
            .is_none_or(|a| a.is_broken());
        assert_eq!(broken, !holds, "{share} of the weight");
    }
}
