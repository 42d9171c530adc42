//! `terrain`: a rubber ball rolls down a bumpy height field, and its twin down a triangle mesh of the same surface.
//!
//! The two shapes are different code with the same triangles, so the balls must take the same way until rounding has had
//! time to grow. The ground is a valley with sides higher than a ball can climb, and longer than the balls roll: a node
//! that has no ground below it has gone through, or its ball has left the way, and both are failures.

use super::{Cast, Figures, Options, Run, Scene, SceneError};
use crate::body::{Group, Material, Surface};
use crate::math::{DVec3, Pose, Real, Vector};
use crate::record::BodyRecord;
use crate::shape::filled;
use crate::world::{DeformableBuilder, DeformableWorld, Substeps};
use rapier3d::dynamics::RigidBodyBuilder;
use rapier3d::geometry::{ColliderBuilder, ColliderHandle};
use rapier3d::parry::query::Ray;
use rapier3d::parry::shape::HeightField;
use rapier3d::parry::utils::Array2;
use rapier3d::pipeline::PhysicsWorld;
use std::f32::consts::PI;

/// The scene.
pub const SCENE: Scene = Scene {
    name: "terrain",
    about: "a rubber ball rolls down a bumpy height field, its twin down a mesh of the same surface",
    options: Options {
        dt: 1.0 / 60.0,
        duration: 3.0,
        safety: 0.9,
        cell: 0.1,
    },
    build,
    figures,
};

/// Length and width of a path, and side of its cells \[m\].
const LENGTH: Real = 9.0;
const WIDTH: Real = 2.4;
const CELL: Real = 0.15;
/// Fall of the path \[1\].
const FALL: Real = 0.18;
/// Radius of the balls \[m\].
const RADIUS: Real = 0.3;
/// Where the balls start along the path \[m\], and how high above it \[m\].
const START: Real = -3.6;
const GAP: Real = 0.01;
/// Where the paths lie across \[m\].
const ASIDE: Real = 1.3;
/// How deep a node may lie below the ground before it counts as through \[m\].
const THROUGH: f64 = 1.0e-3;
/// Until when the twins are compared closely \[s\].
const EARLY: f64 = 1.0;

/// Soft foam rubber, of the loss factor of a tyre.
fn foam_rubber() -> Material {
    Material::elastic(0.6e6, 200.0).viscosity(1.0e3)
}

/// Height of the ground \[m\]: a slope with waves along and across, and sides that lead back to the middle.
fn height(x: Real, z: Real) -> Real {
    let waves = 0.04 * (3.1 * x).sin() + 0.02 * (6.3 * x + 1.0).sin() * (4.0 * z).cos();
    -FALL * x + waves + 0.12 * z * z
}

/// The height field, and the same triangles over shared vertices.
fn grounds() -> (Array2<Real>, Vector, Vec<Vector>, Vec<[u32; 3]>) {
    let count = |side: Real| (side / CELL).round() as usize + 1;
    let (rows, columns) = (count(WIDTH), count(LENGTH));
    let scale = Vector::new(LENGTH, 1.0, WIDTH);
    let at = |i: usize, n: usize, side: Real| (i as Real / (n - 1) as Real - 0.5) * side;
    let mut heights = Array2::repeat(rows, columns, 0.0);
    for i in 0..rows {
        for j in 0..columns {
            heights[(i, j)] = height(at(j, columns, LENGTH), at(i, rows, WIDTH));
        }
    }
    let field = HeightField::new(heights.clone(), scale);
    let index = |x: Real, side: Real, n: usize| ((x / side + 0.5) * (n - 1) as Real).round() as u32;
    let mut vertices = vec![Vector::ZERO; rows * columns];
    let triangles = field.triangles().map(|t| {
        [t.a, t.b, t.c].map(|p| {
            let id = index(p.z, WIDTH, rows) * columns as u32 + index(p.x, LENGTH, columns);
            vertices[id as usize] = p;
            id
        })
    });
    let triangles = triangles.collect();
    (heights, scale, vertices, triangles)
}

/// A ball of rings of quads, its quarters by turns in a group of their own: one sees how it rolls.
fn ball(radius: Real) -> Surface {
    const AROUND: u32 = 24;
    const RINGS: u32 = 12;
    let mut vertices = vec![
        Vector::new(0.0, radius, 0.0),
        Vector::new(0.0, -radius, 0.0),
    ];
    for ring in 1..RINGS {
        let (sin, cos) = (PI * ring as Real / RINGS as Real).sin_cos();
        for i in 0..AROUND {
            let (s, c) = (2.0 * PI * i as Real / AROUND as Real).sin_cos();
            vertices.push(radius * Vector::new(sin * s, cos, sin * c));
        }
    }
    let at = |ring: u32, i: u32| match ring {
        0 => 0,
        RINGS => 1,
        _ => 2 + (ring - 1) * AROUND + i % AROUND,
    };
    let (mut triangles, mut groups) = (Vec::new(), Vec::new());
    for quarter in 0..4 {
        for half in 0..2 {
            let first = triangles.len();
            for i in quarter * AROUND / 4..(quarter + 1) * AROUND / 4 {
                for ring in half * RINGS / 2..(half + 1) * RINGS / 2 {
                    let [a, b, c, d] = [
                        at(ring, i),
                        at(ring + 1, i),
                        at(ring + 1, i + 1),
                        at(ring, i + 1),
                    ];
                    let quad = [[a, b, c], [a, c, d]].into_iter();
                    triangles.extend(quad.filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]));
                }
            }
            groups.push(Group {
                name: ["lamp", "tyre"][((quarter + half) % 2) as usize].into(),
                triangles: first..triangles.len(),
            });
        }
    }
    Surface {
        vertices,
        triangles,
        groups,
    }
}

fn build(options: &Options) -> Result<Run, SceneError> {
    let mut world = PhysicsWorld::default();
    let mut cast = Cast::default();
    let (heights, scale, vertices, triangles) = grounds();
    let mesh = ColliderBuilder::trimesh(vertices, triangles);
    let mesh = mesh.map_err(|_| SceneError::Missing("mesh of the ground"))?;
    let field = ColliderBuilder::heightfield(heights, scale);
    let surface = ball(RADIUS);
    let net = filled(&surface, options.cell as Real)?;
    cast.parts = surface
        .groups
        .into_iter()
        .map(|g| (g.name, g.triangles))
        .collect();
    let mut deformables = DeformableWorld::default();
    deformables.params.expected_dt = options.dt;
    for (ground, name, collider, z) in [
        ("field", "on_field", field, ASIDE),
        ("mesh", "on_mesh", mesh, -ASIDE),
    ] {
        let (_, collider) = world.insert(
            RigidBodyBuilder::fixed().translation(Vector::new(0.0, 0.0, z)),
            collider.friction(0.8),
        );
        cast.rigid.push((ground.into(), None, collider));
        // Along the normal of the slope, so that it lands where it is.
        let above = (RADIUS + GAP) * (1.0 + FALL * FALL).sqrt() + 0.03;
        let at = Vector::new(START, height(START, 0.0) + above, z);
        let handle = deformables.insert(
            DeformableBuilder::new(net.clone())
                .material(foam_rubber())
                .translation(at)
                .friction(0.8)
                .substeps(Substeps::Auto {
                    safety: options.safety,
                    min_h: 1.0e-7,
                }),
        )?;
        cast.deformables.push((name.into(), handle));
    }
    let mut run = Run::new(world, deformables, cast, options);
    run.frame_times = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
        .into_iter()
        .map(|share: f64| share * options.duration)
        .collect();
    run.view = Vector::new(0.25, 0.55, 1.0);
    run.recorder.sampling.history = 5.0e-3;
    run.recorder.sampling.energy = 1.0e-2;
    Ok(run)
}

/// A ball, its record and its ground.
struct Path<'a> {
    record: &'a BodyRecord,
    ground: ColliderHandle,
    positions: Vec<Vector>,
}

fn path<'a>(run: &'a Run, ball: &str, ground: &str) -> Result<Path<'a>, SceneError> {
    let handle = run.cast.deformable(ball);
    let body = handle.and_then(|h| run.deformables.get(h));
    let record = handle.and_then(|h| run.recorder.body(h));
    let ground = run.cast.collider(ground);
    Ok(Path {
        record: record.ok_or(SceneError::Missing("ball"))?,
        ground: ground.ok_or(SceneError::Missing("ground"))?,
        positions: body
            .ok_or(SceneError::Missing("ball"))?
            .positions()
            .collect(),
    })
}

impl Path<'_> {
    /// Length of the way of the centre of mass \[m\].
    fn length(&self) -> f64 {
        let way = self.record.center.positions.windows(2);
        way.map(|p| p[0].distance(p[1])).sum()
    }

    fn speed(&self) -> f64 {
        self.record
            .center
            .velocities
            .last()
            .map_or(0.0, |v| v.length())
    }

    /// The most that kinetic, elastic and potential energy together ever were above the start \[J\].
    fn gain(&self) -> f64 {
        let sum = self.record.ledger.iter().map(|s| {
            let e = &s.energies;
            e.kinetic + e.elastic + e.gravity
        });
        let sums: Vec<f64> = sum.collect();
        let first = sums.first().copied().unwrap_or(0.0);
        sums.iter().fold(0.0, |most, s| most.max(s - first))
    }

    /// Nodes more than a millimetre below the ground, or with no ground on their vertical at all.
    fn through(&self, run: &Run) -> usize {
        let Some(ground) = run.world.colliders.get(self.ground) else {
            return self.positions.len();
        };
        let pose: &Pose = ground.position();
        let below = |p: &&Vector| {
            let high = Vector::new(p.x, 10.0, p.z);
            let hit = ground
                .shape()
                .cast_ray(pose, &Ray::new(high, -Vector::Y), 20.0, false);
            hit.is_none_or(|t| f64::from(p.y) < f64::from(high.y - t) - THROUGH)
        };
        self.positions.iter().filter(below).count()
    }
}

/// The largest distance between the two ways, each from its own start, until a time \[m\].
fn apart(a: &Path<'_>, b: &Path<'_>, until: f64) -> f64 {
    let start = |p: &Path<'_>| p.record.center.positions.first().copied();
    let (Some(a0), Some(b0)) = (start(a), start(b)) else {
        return 0.0;
    };
    let centers = (&a.record.center, &b.record.center);
    let both = centers.0.positions.iter().zip(&centers.1.positions);
    let gap = |(x, y): (&DVec3, &DVec3)| ((*x - a0) - (*y - b0)).length();
    both.zip(&centers.0.times)
        .filter(|(_, t)| **t <= until)
        .map(|(p, _)| gap(p))
        .fold(0.0, f64::max)
}

fn figures(run: &Run) -> Result<Figures, SceneError> {
    let field = path(run, "on_field", "field")?;
    let mesh = path(run, "on_mesh", "mesh")?;
    let mut f = Figures::default();
    f.add(
        "field_rolled_m",
        "rolled, height field",
        field.length(),
        "m",
    );
    f.add("mesh_rolled_m", "rolled, mesh", mesh.length(), "m");
    f.add(
        "field_speed_mps",
        "speed, height field",
        field.speed(),
        "m/s",
    );
    f.add("mesh_speed_mps", "speed, mesh", mesh.speed(), "m/s");
    let early = apart(&field, &mesh, EARLY);
    f.add(
        "apart_early_m",
        "ways apart in the first second",
        early,
        "m",
    );
    let all = apart(&field, &mesh, f64::INFINITY);
    f.add("apart_m", "ways apart at the most", all, "m");
    let gain = field.gain().max(mesh.gain());
    f.add("gained_j", "energy above the start", gain, "J");
    let through = (field.through(run) + mesh.through(run)) as f64;
    f.add("nodes_through", "nodes below the ground", through, "");
    let depth = run.recorder.max_depth();
    f.add("max_penetration_m", "deepest node", depth, "m");
    let closure = run.recorder.momentum_closure();
    f.add("momentum_closure", "momentum closure", closure, "");
    run.common_figures(&mut f);
    Ok(f)
}
