//! `wall`: the car into a fixed wall at 56 km/h, the full-width rigid barrier test.
//!
//! The speed and the figures are those of FMVSS 208 and of the New Car Assessment Program, so that they can be held
//! against real cars: 15.6 m/s, 0.5 to 0.7 m of crush, 20 g on the mean, standstill after 60 to 80 ms. Crates stand beside
//! the wall, some so close that the front's bulge pushes them, to show that one world holds both kinds of body.

mod figures;

pub use figures::{cabin_deceleration, wall_force};

use super::car::{self, Car};
use super::{Cast, Options, Run, Scene, SceneError};
use crate::math::{Real, Vector};
use crate::world::{DeformableWorld, Substeps};
use rapier3d::dynamics::{CoefficientCombineRule, RigidBodyBuilder};
use rapier3d::geometry::{ColliderBuilder, Group, InteractionGroups, InteractionTestMode};
use rapier3d::pipeline::PhysicsWorld;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "wall",
    about: "a car of 1300 kg with a rigid engine hits a rigid wall at 56 km/h, beside stacked crates",
    options: Options {
        dt: 1.0 / 240.0,
        duration: 0.150,
        safety: 0.9,
        cell: 0.1,
    },
    build,
    figures: figures::figures,
};

/// Speed of the car \[m/s\]: 56 km/h.
pub const SPEED: f64 = 56.0 / 3.6;
/// Distance of the front from the wall at the start \[m\].
pub const GAP: f64 = 0.03;
/// When pictures are taken \[s\].
pub const FRAMES: [f64; 6] = [0.0, 0.025, 0.050, 0.075, 0.100, 0.150];

/// Half the side of a crate, its mass, and where they stand: x \[m\], how many crates lie below, z \[m\]. The camera looks
/// from +z, so they stand on the other side.
const CRATE: Real = 0.22;
const CRATE_MASS: Real = 12.0;
const CRATES: [[Real; 3]; 8] = [
    [-0.30, 0.0, -1.115],
    [-0.76, 0.0, -1.115],
    [-0.30, 0.0, -1.60],
    [-0.76, 0.0, -1.60],
    [-0.53, 1.0, -1.085],
    [-0.30, 1.0, -1.60],
    [-0.76, 1.0, -1.60],
    [-0.53, 2.0, -1.36],
];

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    // The wheels roll, which nodes can't: a rolling resistance stands for the friction between car and ground.
    let (_, ground) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(-4.0, -0.5, 0.0)),
        ColliderBuilder::cuboid(10.0, 0.5, 6.0)
            .friction(0.015)
            .friction_combine_rule(CoefficientCombineRule::Min),
    );
    cast.rigid.push(("ground".into(), None, ground));
    let (_, wall) = world.insert(
        RigidBodyBuilder::fixed().translation(Vector::new(0.3, 0.9, 0.0)),
        ColliderBuilder::cuboid(0.3, 0.9, 1.9).friction(0.4),
    );
    cast.rigid.push(("wall".into(), None, wall));
    for (i, [x, level, z]) in CRATES.into_iter().enumerate() {
        let at = Vector::new(x, CRATE * (1.0 + 2.0 * level), z);
        let (body, collider) = world.insert(
            RigidBodyBuilder::dynamic().translation(at),
            ColliderBuilder::cuboid(CRATE, CRATE, CRATE)
                .mass(CRATE_MASS)
                .friction(0.5)
                .friction_combine_rule(CoefficientCombineRule::Max),
        );
        let name = format!("crate_{}", i + 1);
        cast.rigid.push((name, Some(body), collider));
    }

    let mut car = Car::new(options.cell)?;
    let (lo, hi) = car.net.bounds();
    let shift = Vector::new(-(GAP as Real) - hi.x, -lo.y, 0.0);
    let speed = Vector::new(SPEED as Real, 0.0, 0.0);
    let (cabin, carriers) = (car.cabin_nodes(), car.engine_nodes(options.cell));
    let front = car.nodes(|p| p.x > hi.x - 0.3 * options.cell as Real);
    cast.parts = std::mem::take(&mut car.parts);
    car.builder = car
        .builder
        .translation(shift)
        .linvel(speed)
        .friction(0.4)
        .substeps(Substeps::Auto {
            safety: options.safety,
            min_h: 1.0e-7,
        });
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    let handle = deformables.insert(car.builder)?;
    cast.deformables.push(("car".into(), handle));

    let half = car::ENGINE_HALF;
    let (engine, collider) = world.insert(
        RigidBodyBuilder::dynamic()
            .translation(shift + car::ENGINE_AT)
            .linvel(speed),
        ColliderBuilder::cuboid(half.x, half.y, half.z)
            .mass(car::ENGINE_MASS as Real)
            .friction(0.4)
            .collision_groups(InteractionGroups::new(
                car::ENGINE_GROUP,
                Group::ALL,
                InteractionTestMode::And,
            )),
    );
    cast.rigid.push(("engine".into(), Some(engine), collider));
    let mount = deformables.attach(handle, &carriers, engine, &world.bodies)?;
    cast.attachments.push(("engine_mount".into(), mount));

    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = FRAMES.to_vec();
    run.recorder
        .follow("cabin", &run.deformables, handle, cabin)?;
    run.recorder
        .follow("front", &run.deformables, handle, front)?;
    Ok(run)
}
