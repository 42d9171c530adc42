//! The beam of the scene `cantilever` as a soft body of Rapier's own: 2 × 0.2 × 0.2 m, E = 12 MPa, ν = 0, 8 kg, clamped at
//! one end.

use crumple::rapier3d::prelude::*;
use std::time::Instant;

/// Deflection of its tip under its own weight by Timoshenko's theory \[m\].
pub const THEORY: f64 = 0.049442;

/// Half the length \[m\].
const HALF: f32 = 1.0;

/// How far the tip has sunk after so many frames of 1/60 s \[m\], and milliseconds per frame. `cell` is the distance of nodes \[m\],
/// `linear` the most iterations of the conjugate gradient, which only finite elements make.
pub fn rapier(cell: f32, solver: SoftBodySolver, linear: usize, frames: usize) -> (f64, f64) {
    let mut world = PhysicsWorld::default();
    world
        .integration_parameters
        .soft_bodies
        .fem
        .max_linear_iterations = linear;
    let size = Vector::new(2.0 * HALF, 0.2, 0.2);
    let [nx, ny, nz] = (size / cell).to_array().map(|n| n.round() as usize + 1);
    let builder = SoftBodyBuilder::cuboid(Vector::ZERO, 0.5 * size, nx, ny, nz)
        .cell_model(SoftBodyCellModel::Corotational)
        .material(SoftBodyMaterial {
            young_modulus: 1.2e7,
            poisson_ratio: 0.0,
            ..SoftBodyMaterial::default()
        })
        .solver(solver)
        .mass(8.0)
        // Twice the first angular frequency, so that it comes to rest without swinging.
        .linear_damping(35.0)
        .can_sleep(false);
    let ends = |side: f32| -> Vec<u32> {
        let places = (0..).zip(builder.particle_positions());
        places
            .filter(|(_, x)| side * x.x > HALF - 1e-4)
            .map(|(i, _)| i)
            .collect()
    };
    let (clamped, tip) = (ends(-1.0), ends(1.0));
    let handle = world.insert_soft_body(builder.pinned_particles(clamped));
    let mean = |world: &PhysicsWorld| {
        let body = &world.soft_bodies[handle];
        let each = tip
            .iter()
            .map(|&i| f64::from(body.particle_position(i as usize).y));
        each.sum::<f64>() / tip.len() as f64
    };
    let before = mean(&world);
    let start = Instant::now();
    for _ in 0..frames {
        world.step();
    }
    let ms = 1e3 * start.elapsed().as_secs_f64() / frames as f64;
    (before - mean(&world), ms)
}
