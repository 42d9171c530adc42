//! Crash-grade deformable bodies for Rapier: physical springs in, physical forces out.
//!
//! A [`DeformableWorld`](world::DeformableWorld) stands beside a Rapier world. Its bodies are [nets](body::Net) of point
//! masses and springs with constants in N/m, N·s/m and N, advanced in many substeps per step, in two-way contact with
//! Rapier's colliders, with every force and every joule accounted for. The README shows the scenes and the limits; beside it
//! `docs/` has a guide, the limits' conditions and measurements, and the tables of speed.
//!
//! ```
//! use crumple::prelude::*;
//! use crumple::rapier3d::prelude::*;
//!
//! let mut world = PhysicsWorld::default();
//! world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::cuboid(5.0, 0.1, 5.0));
//! let mut deformables = DeformableWorld::default();
//! let block = DeformableBuilder::new(lattice(Vector::splat(0.4), 0.1)) // m
//!     .material(Material::rubber())
//!     .translation(Vector::Y * 0.4);
//! let block = deformables.insert(block)?;
//! for _ in 0..60 {
//!     deformables.step(&mut world); // instead of world.step()
//! }
//! assert!((deformables[block].center_of_mass().y - 0.3).abs() < 0.02);
//! # Ok::<(), BuildError>(())
//! ```
//!
//! | To | see |
//! |---|---|
//! | make a body | [`DeformableBuilder`](world::DeformableBuilder), [`shape`], [`Material`](body::Material), [`Solid`](body::Solid) |
//! | read it, change it, draw it | [`Deformable`](world::Deformable) |
//! | fix it to others | [`Attachment`](world::Attachment) |
//! | measure forces, energies, histories | [`Recorder`](record::Recorder), [`Observer`](world::Observer) |
//! | step beside a loop of one's own | [`RapierParts`](world::RapierParts) |
//! | advance springs without a world | [`Solver`](solve::Solver) |
//!
//! Features, none by default: `import` reads meshes from OBJ, Gmsh and TetGen files, `scenario` has scenes and scene files,
//! `report` draws pictures and plots, `statics` finds equilibria, `serde-serialize` saves worlds, `parallel` uses threads,
//! `debug-render` draws lines through Rapier, `native-fem` has Rapier's finite elements for comparisons, `cli` is for the binary.
#![warn(missing_docs)]
// Only `solve::kernel::vector` and `solve::threads::team` may.
#![deny(unsafe_code)]

pub use rapier3d;

pub mod body;
mod contact;
mod coupling;
#[cfg(feature = "import")]
pub mod import;
pub mod law;
pub mod math;
pub mod record;
#[cfg(feature = "report")]
pub mod report;
#[cfg(feature = "scenario")]
pub mod scenario;
pub mod solve;
pub mod world;

/// Shape functions: lattice, sheet, rope and filled surfaces.
pub use body::shape;

/// Everything a scene needs. Clashes with nothing in Rapier's own prelude.
pub mod prelude {
    pub use crate::body::{
        BuildError, Feature, Material, Net, Node, NodeId, Solid, SolidLaw, Spring, SpringId,
        SurfacePoint, TetId, TetMesh,
    };
    pub use crate::record::Recorder;
    pub use crate::shape::{filled, lattice, rope, sheet};
    pub use crate::solve::{Integrator, Kernel};
    pub use crate::world::{
        AttachTo, Attachment, AttachmentHandle, Deformable, DeformableBuilder, DeformableFilter,
        DeformableHandle, DeformableHooks, DeformableOverlap, DeformableParameters,
        DeformableProjection, DeformableRayHit, DeformableWorld, NodeImpulse, Observer,
        PairContact, PairContext, Partner, RapierParts, RayHit, SpringEvent, SpringEventKind,
        Substep, Substeps, TouchEvent, TouchEventKind,
    };
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(doctest)]
#[doc = include_str!("../docs/guide.md")]
struct Guide;
