//! From a [`Scenario`] to worlds that can be stepped.

mod acts;
mod alike;
mod ball;
mod deformables;
mod filter;
mod joints;
mod nodes;
mod rigid;
mod shapes;
mod soft_bodies;
mod terrain;

use super::super::{Cast, Options, Run};
use super::check::FARTHEST;
use super::model::{Scenario, Scheme, Substepping};
use crate::body::BuildError;
use crate::import::ImportError;
use crate::math::{DVec3, Pose, Real, Vector, wide};
use crate::record::{RecordError, SignalError};
use crate::solve::Integrator;
use crate::world::{AttachError, DeformableWorld, Substeps};
pub(super) use nodes::{Places, selected};
use rapier3d::pipeline::PhysicsWorld;
use std::path::PathBuf;

/// Why a scene that could be read can't be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// A deformable can't be built.
    #[error("deformable `{name}`: {source}")]
    Deformable {
        /// Which.
        name: String,
        /// Why.
        source: Box<BuildError>,
    },
    /// A mesh can't be read.
    #[error("`{name}`: {source}")]
    Mesh {
        /// The body that wants it.
        name: String,
        /// Why.
        source: Box<ImportError>,
    },
    /// A point of a file of a mesh lies too far out.
    #[error(
        "`{name}`: point {} of its mesh is ({}, {}, {}), it must be at most 1e6 m from 0 along every axis",
        point + 1, at.x, at.y, at.z
    )]
    Far {
        /// The body that wants it.
        name: String,
        /// Which point, counted from 0.
        point: usize,
        /// Where it is \[m\].
        at: DVec3,
    },
    /// A collider's shape can't be made.
    #[error("a collider of `{name}`: {what}")]
    Shape {
        /// The rigid body.
        name: String,
        /// Why.
        what: &'static str,
    },
    /// More than a scene may have, which showed only when it was built.
    #[error("`{name}`: with it there are {value:.0} {what}, at most {most} are possible")]
    TooMany {
        /// The body.
        name: String,
        /// Of what.
        what: &'static str,
        /// How many.
        value: f64,
        /// How many there may be.
        most: f64,
    },
    /// Nodes can't be attached.
    #[error("attachment `{name}`: {source}")]
    Attachment {
        /// Which.
        name: String,
        /// Why.
        source: AttachError,
    },
    /// A formula selects no node, or no tet.
    #[error("{what}: {formula:?} selects nothing of `{body}`")]
    Nothing {
        /// What wants nodes.
        what: &'static str,
        /// The formula.
        formula: String,
        /// The deformable.
        body: String,
    },
    /// Something can't be done to a body of this kind.
    #[error("`{name}`: {what}")]
    Unfit {
        /// The body.
        name: String,
        /// What can't be done, and to what it can.
        what: &'static str,
    },
    /// Something is to be looked at after the end of the run.
    #[error("{what}: {time} s is after the end of the run at {end} s")]
    Late {
        /// The key, like `expect[2]`.
        what: String,
        /// When \[s\].
        time: f64,
        /// When the run ends \[s\].
        end: f64,
    },
    /// Something can't be recorded.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A channel can't be evaluated.
    #[error("{channel}: {source}")]
    Signal {
        /// The channel.
        channel: String,
        /// Why.
        source: SignalError,
    },
}

impl Scenario {
    /// The options that stand for this scene's in a [`Run`].
    fn options(&self) -> Options {
        let safety = match self.world.substeps {
            Substepping::Auto { safety, .. } => safety,
            _ => 1.0,
        };
        Options {
            dt: self.world.dt,
            duration: self.world.duration,
            safety,
            cell: self.variables.get("cell").copied().unwrap_or(0.0),
        }
    }

    /// Builds both worlds, with a recorder that has begun.
    ///
    /// # Errors
    /// [`RunError`]: bodies that can't be built or are not stable, meshes that can't be read, nodes that are not there.
    pub fn build(&self) -> Result<Run, RunError> {
        build(self)
    }
}

/// Everything in the order of the file, since handles and sums follow it.
fn build(scene: &Scenario) -> Result<Run, RunError> {
    let mut world = PhysicsWorld {
        gravity: vector(scene.world.gravity),
        ..PhysicsWorld::default()
    };
    let mut cast = Cast::default();
    let mut deformables = DeformableWorld::default();
    let params = &mut deformables.params;
    params.expected_dt = scene.world.dt;
    params.substeps = substeps(&scene.world.substeps);
    params.integrator = scheme(&scene.world.integrator);
    params.max_rigid_dt = scene.world.max_rigid_dt;
    params.passes = scene.world.passes;
    let mut frames = Vec::new();
    for body in &scene.deformables {
        let frame = deformables::insert(body, scene, &mut deformables, &mut cast)?;
        frames.push((body.name.as_str(), frame));
    }
    for rigid in &scene.rigid {
        let frame = rigid.frame.as_deref();
        let frame = frames.iter().find(|(name, _)| Some(*name) == frame);
        let frame = frame.map_or(Pose::IDENTITY, |(_, pose)| *pose);
        rigid::insert(rigid, frame, &mut world, &mut cast)?;
    }
    for body in &scene.soft_bodies {
        soft_bodies::insert(body, &mut world);
    }
    let joints = joints::insert(scene, &mut world, &cast);
    deformables::attach(scene, &mut deformables, &world, &mut cast)?;
    let hooks = filter::install(scene, &mut world, &mut deformables, &cast);
    let mut run = Run::new(world, deformables, cast, &scene.options());
    if let Some(hooks) = hooks {
        run.hooks = hooks;
    }
    run.recorder.sampling.history = scene.world.history;
    run.recorder.sampling.energy = scene.world.energy;
    for set in &scene.sets {
        if let Some(body) = run.cast.deformable(&set.of) {
            let soft = &run.deformables;
            let nodes = selected(&soft[body], Some(&set.nodes), "a set", &set.of)?;
            run.recorder.follow(&set.name, soft, body, nodes)?;
        }
    }
    run.view = vector(scene.view);
    run.frame_times = match scene.frames.as_slice() {
        [] => vec![0.0, scene.world.duration],
        times => times.to_vec(),
    };
    let acts = acts::prepare(scene, &run, &joints)?;
    if !acts.is_empty() {
        run.lead = Some(Box::new(move |run| {
            acts.iter().for_each(|(_, act)| act.end(run));
            for (i, act) in &acts {
                if !act.apply(run) && run.fault.is_none() {
                    let from = run.steps as f64 * run.options.dt;
                    let what = format!("actuators[{i}] is not finite in the step from {from} s");
                    run.fault = Some(what);
                }
            }
        }));
    }
    Ok(run)
}

/// Numbers of a scene as Rapier wants them.
pub(super) fn vector(v: [f64; 3]) -> Vector {
    Vector::from_array(v.map(|x| x as Real))
}

pub(super) fn substeps(substeps: &Substepping) -> Substeps {
    match *substeps {
        Substepping::Auto { safety, min_h } => Substeps::Auto { safety, min_h },
        Substepping::Fixed(n) => Substeps::Fixed(n),
        Substepping::Unchecked(n) => Substeps::Unchecked(n),
    }
}

pub(super) fn scheme(scheme: &Scheme) -> Integrator {
    match scheme {
        Scheme::ExplicitEuler => Integrator::ExplicitEuler,
        Scheme::SymplecticEuler => Integrator::SymplecticEuler,
        Scheme::VelocityVerlet => Integrator::VelocityVerlet,
        Scheme::Midpoint => Integrator::Midpoint,
        Scheme::Rk4 => Integrator::Rk4,
    }
}

/// A surface of a scene.
pub(super) fn surface(
    mesh: &super::model::Mesh,
    name: &str,
) -> Result<crate::body::Surface, RunError> {
    use super::model::Mesh;
    let failed = |source| RunError::Mesh {
        name: name.into(),
        source: Box::new(source),
    };
    match mesh {
        Mesh::Hatchback => crate::import::hatchback().map_err(failed),
        Mesh::File(path) => {
            let surface = crate::import::obj::load(path).map_err(failed)?;
            within_reach(surface.vertices.iter().map(|v| wide(*v)), name)?;
            Ok(surface)
        }
        Mesh::Ball {
            radius,
            around,
            rings,
        } => Ok(ball::ball(*radius as Real, *around as u32, *rings as u32)),
        Mesh::Points {
            vertices,
            triangles,
        } => {
            let vertices = vertices.iter().copied().map(vector).collect();
            Ok(crate::body::Surface::new(vertices, triangles.clone()))
        }
    }
}

/// A mesh of tets of a scene.
pub(super) fn tets(path: &PathBuf, name: &str) -> Result<crate::body::TetMesh, RunError> {
    let gmsh = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("msh"));
    let mesh = match gmsh {
        true => crate::import::msh::load(path),
        false => crate::import::tetgen::load(path),
    };
    let mesh = mesh.map_err(|source| RunError::Mesh {
        name: name.into(),
        source: Box::new(source),
    })?;
    within_reach(mesh.nodes.iter().copied(), name)?;
    Ok(mesh)
}

/// Points of files, which no key bounds.
fn within_reach(points: impl Iterator<Item = DVec3>, name: &str) -> Result<(), RunError> {
    // NaN is refused as the mesh is read.
    let mut far = points
        .enumerate()
        .filter(|(_, p)| p.abs().max_element() > FARTHEST);
    far.next().map_or(Ok(()), |(point, at)| {
        Err(RunError::Far {
            name: name.into(),
            point,
            at,
        })
    })
}
