//! What contact costs a body at rest, from a thousand to a million nodes.
//!
//! `cargo bench --bench resting --features scenario` prints a CSV. Blocks of side³ nodes lie awake on the ground, which a
//! side² of them touch, and float without gravity where nothing is; both are stepped in turn, on one thread. What the first
//! takes longer is contact, and must grow with the nodes that touch, not with all of them.

use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario::speed::clock::{Clock, alone, median};

/// Distance of nodes \[m\].
const SPACING: f32 = 0.1;
const SIDES: [usize; 4] = [10, 22, 46, 100];
/// Steps of a frame each before anything is measured, and pairs of measurements.
const EARLIER: usize = 3;
const PAIRS: usize = 15;
/// Spring updates of a measurement, about.
const UPDATES: u64 = 40_000_000;

struct Scene {
    world: PhysicsWorld,
    deformables: DeformableWorld,
    body: DeformableHandle,
}

impl Scene {
    fn new(side: usize, rests: bool) -> Self {
        let mut world = PhysicsWorld::default();
        if rests {
            let ground = ColliderBuilder::new(SharedShape::halfspace(Vector::Y));
            world.insert(RigidBodyBuilder::fixed(), ground);
        } else {
            world.gravity = Vector::ZERO;
        }
        let size = SPACING * (side - 1) as f32;
        let mut deformables = DeformableWorld::default();
        deformables.params.expected_dt = 1.0 / 60.0;
        let net = lattice(Vector::splat(size), SPACING).expect("a lattice");
        let block = DeformableBuilder::new(net)
            .material(Material::elastic(1.0e6, 100.0).viscosity(300.0))
            .translation(Vector::Y * (0.5 * size))
            .can_sleep(false);
        let body = deformables.insert(block).expect("a sound body");
        Self {
            world,
            deformables,
            body,
        }
    }

    /// Microseconds per substep over some steps.
    fn measure(&mut self, steps: usize) -> f64 {
        let mut substeps = 0;
        let clock = Clock::start();
        for _ in 0..steps {
            self.deformables.step(&mut self.world);
            let report = self.deformables.report();
            substeps += report.substeps.iter().map(|(_, n)| n).sum::<usize>();
        }
        1e6 * clock.spent().as_secs_f64() / substeps as f64
    }
}

fn table() {
    println!(
        "nodes,touching,springs,us_per_substep,us_of_contact,ns_per_touching_node,share_of_substep"
    );
    for side in SIDES {
        let mut scenes = [Scene::new(side, true), Scene::new(side, false)];
        for scene in &mut scenes {
            scene.measure(EARLIER);
        }
        let [resting, _] = &scenes;
        let body = &resting.deformables[resting.body];
        let (nodes, springs) = (body.node_count(), body.spring_count());
        let touching = body.positions().filter(|x| x.y < 0.1 * SPACING).count();
        let updates = resting.deformables.report().spring_updates.max(1);
        let steps = (UPDATES / updates).max(1) as usize;
        let pairs: Vec<[f64; 2]> = (0..PAIRS)
            .map(|_| scenes.each_mut().map(|scene| scene.measure(steps)))
            .collect();
        let whole = median(pairs.iter().map(|p| p[0]));
        let contact = median(pairs.iter().map(|p| p[0] - p[1]));
        println!(
            "{nodes},{touching},{springs},{whole:.1},{contact:.2},{:.1},{:.4}",
            1e3 * contact / touching as f64,
            contact / whole
        );
    }
}

fn main() {
    alone(table);
}
