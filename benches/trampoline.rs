//! Ten boxes of 10 kg on a pinned sheet, side by side with Rapier's own cloth: same nodes, mass, border, boxes and drop.
//!
//! `cargo bench --bench trampoline --features scenario` prints a CSV: boxes still over the level they would have fallen to
//! with the sheet out of their way, the lowest node ever, milliseconds per frame of 1/60 s. Rapier's cloth has its default
//! material, which is not in N/m, and sags by metres; ours is shown with the springs of the scene `trampoline` and with springs
//! a tenth as stiff, which still sag by less.

use crumple::body::{BuildError, Net};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::scenario::speed::clock::{Clock, alone};
use crumple::shape::sheet_with_bending;

/// Side of a sheet \[m\].
const SIDE: f32 = 3.0;
/// Stiffness of every spring \[N/m\]: of the scene `trampoline`, and of a sheet that is softer but not as soft as Rapier's.
const STIFFNESSES: [f32; 2] = [2.0e4, 2.0e3];
/// Damping of a spring between two of the sheet's nodes, as a share of 2·√(k·m).
const DAMPING: f32 = 0.3;
/// Half the side of a box \[m\], its mass \[kg\], and how far it falls \[m\].
const HALF: f32 = 0.15;
/// Mass of a box \[kg\].
const BOX_MASS: f32 = 10.0;
/// Height of the boxes above the sheet \[m\].
const DROP: f32 = 0.05;
/// Distance of the middles of neighbouring boxes \[m\].
const SPACING: f32 = 0.45;
const NODES: usize = 30;
const FRAMES: usize = 300;
/// A box whose middle is lower is through: more than a metre under the pinned border \[m\].
const LOST: f32 = -1.0;

struct Outcome {
    held: usize,
    sag: f32,
    ms_per_frame: f64,
}

/// The sheet about the origin: squares with both diagonals, every spring alike, the border pinned.
fn net(mass: f32, stiffness: f32) -> Result<Net, BuildError> {
    // The thickness only tells how the mass is shared: every node by the cells about it.
    let mut net = sheet_with_bending(SIDE, SIDE, NODES, NODES, 1.0e-3, 0.0)?;
    let volume: f32 = net.nodes.iter().map(|n| n.volume).sum();
    for node in &mut net.nodes {
        node.mass = mass * node.volume / volume;
        node.volume = 0.0;
    }
    let inner = net.nodes.iter().map(|n| n.mass).fold(0.0, f32::max);
    for spring in &mut net.springs {
        spring.section = 0.0;
        spring.stiffness = stiffness;
        spring.damping = 2.0 * DAMPING * (stiffness * inner).sqrt();
    }
    Ok(net.pin_border())
}

/// Middles of the boxes over a sheet whose middle is at `x` \[m\].
fn places(x: f32) -> impl Iterator<Item = Vector> {
    (0..10).map(move |i| {
        let (column, row) = ((i % 5) as f32, (i / 5) as f32);
        Vector::new(
            x + SPACING * (column - 2.0),
            DROP + HALF,
            SPACING * (row - 0.5),
        )
    })
}

fn world() -> (PhysicsWorld, Vec<RigidBodyHandle>) {
    let mut world = PhysicsWorld::default();
    let boxes = places(0.0).map(|at| {
        let body = RigidBodyBuilder::dynamic().translation(at);
        let collider = ColliderBuilder::cuboid(HALF, HALF, HALF)
            .mass(BOX_MASS)
            .friction(0.5);
        world.insert(body, collider).0
    });
    let boxes = boxes.collect();
    (world, boxes)
}

fn held(world: &PhysicsWorld, boxes: &[RigidBodyHandle]) -> usize {
    let over = |b: &&RigidBodyHandle| world.bodies[**b].translation().y > LOST;
    boxes.iter().filter(over).count()
}

fn ours(mass: f32, stiffness: f32) -> Outcome {
    let (mut world, boxes) = world();
    let mut deformables = DeformableWorld::default();
    let net = net(mass, stiffness).expect("a sheet");
    let sheet = deformables
        .insert(DeformableBuilder::new(net))
        .expect("the sheet is stable");
    let (mut spent, mut sag) = (0.0, 0.0_f32);
    for _ in 0..FRAMES {
        let clock = Clock::start();
        deformables.step(&mut world);
        spent += clock.spent().as_secs_f64();
        sag = sag.max(-deformables[sheet].bounds().0.y as f32);
    }
    Outcome {
        held: held(&world, &boxes),
        sag,
        ms_per_frame: 1e3 * spent / FRAMES as f64,
    }
}

fn rapier(mass: f32, iterations: usize) -> Outcome {
    let (mut world, boxes) = world();
    world.integration_parameters.num_solver_iterations = iterations;
    let cell = SIDE / (NODES - 1) as f32;
    let origin = Vector::new(-0.5 * SIDE, 0.0, -0.5 * SIDE);
    let border = (0..NODES * NODES).filter(|i| {
        let (row, column) = (i / NODES, i % NODES);
        row % (NODES - 1) == 0 || column % (NODES - 1) == 0
    });
    let handle = world.insert_soft_body(
        SoftBodyBuilder::cloth(origin, Vector::X * cell, Vector::Z * cell, NODES, NODES)
            .mass(mass)
            .pinned_particles(border.map(|i| i as u32))
            .can_sleep(false),
    );
    let (mut spent, mut sag) = (0.0, 0.0_f32);
    for _ in 0..FRAMES {
        let clock = Clock::start();
        world.step();
        spent += clock.spent().as_secs_f64();
        let body = &world.soft_bodies[handle];
        for i in 0..NODES * NODES {
            sag = sag.max(-body.particle_position(i).y);
        }
    }
    Outcome {
        held: held(&world, &boxes),
        sag,
        ms_per_frame: 1e3 * spent / FRAMES as f64,
    }
}

fn main() {
    alone(table);
}

fn table() {
    println!("case,sheet_kg,boxes_held,max_sag_m,ms_per_frame");
    for mass in [10.0, 1.0] {
        let show = |case: &str, o: &Outcome| {
            let Outcome {
                held,
                sag,
                ms_per_frame,
            } = o;
            println!("\"{case}\",{mass},{held},{sag:.4},{ms_per_frame:.3}");
        };
        for iterations in [4, 16, 64] {
            let case = format!("rapier native, {iterations} iterations");
            show(&case, &rapier(mass, iterations));
        }
        for stiffness in STIFFNESSES {
            let case = format!("crumple, {stiffness} N/m");
            show(&case, &ours(mass, stiffness));
        }
    }
}
