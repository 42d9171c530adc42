//! Soft bodies of Rapier's own.

use super::super::model::SoftBody;
use super::{Places, vector};
use crate::math::{Real, Vector};
use rapier3d::dynamics::{SoftBodyBuilder, SoftBodyCellModel, SoftBodyHandle, SoftBodyMaterial};
use rapier3d::pipeline::PhysicsWorld;

/// Puts in a soft body; none of them falls asleep.
pub(super) fn insert(body: &SoftBody, world: &mut PhysicsWorld) -> SoftBodyHandle {
    let size = vector(body.size);
    let counts = (size / body.cell as Real).round().max(Vector::ONE) + Vector::ONE;
    let [nx, ny, nz] = counts.to_array().map(|n| n as usize);
    let middle = vector(body.translation);
    let builder = SoftBodyBuilder::cuboid(middle, 0.5 * size, nx, ny, nz)
        .cell_model(SoftBodyCellModel::Corotational)
        .material(SoftBodyMaterial {
            young_modulus: body.young as Real,
            poisson_ratio: body.poisson as Real,
            elastic_damping_ratio: body.damping_ratio as Real,
            ..SoftBodyMaterial::default()
        })
        .mass(body.mass as Real)
        .can_sleep(false);
    let own: Vec<Vector> = builder
        .particle_positions()
        .iter()
        .map(|p| *p - middle)
        .collect();
    let places = Places::around(own.iter().copied());
    let holds = |at: Vector| body.pin.as_ref().is_some_and(|r| places.holds(&r.0, at));
    let pinned = (0..).zip(own).filter(|(_, at)| holds(*at));
    let pinned: Vec<u32> = pinned.map(|(i, _)| i).collect();
    world.insert_soft_body(builder.pinned_particles(pinned))
}
