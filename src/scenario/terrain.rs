//! `terrain`: a rubber ball rolls down a bumpy height field, and its twin down a triangle mesh of the same surface.
//!
//! The two shapes are different code with the same triangles, so the balls must take the same way until rounding has had
//! time to grow. The ground is a valley with sides higher than a ball can climb, and longer than the balls roll: a node
//! that has no ground below it has gone through, or its ball has left the way, and both are failures.

use super::{Figures, Options, Run, Scene, SceneError};
use crate::math::{DVec3, Pose, Vector};
use crate::record::BodyRecord;
use rapier3d::geometry::ColliderHandle;
use rapier3d::parry::query::Ray;

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

/// How deep a node may lie below the ground before it counts as through \[m\].
const THROUGH: f64 = 1.0e-3;
/// Until when the twins are compared closely \[s\].
const EARLY: f64 = 1.0;

fn build(options: &Options) -> Result<Run, SceneError> {
    super::from_file("terrain", options)
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
