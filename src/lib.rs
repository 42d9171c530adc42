//! Crash-grade deformable bodies for Rapier: physical springs in, physical forces out.
//!
//! A [`DeformableWorld`](world::DeformableWorld) stands beside a Rapier world. Its bodies are [nets](body::Net) of point
//! masses and springs with constants in N/m, N·s/m and N, advanced in many substeps per step, in two-way contact with
//! Rapier's colliders, with every force and every joule accounted for. The README shows the shortest example, the scenes
//! and the limits.
#![warn(missing_docs)]
// Only `solve::kernel::vector` may.
#![deny(unsafe_code)]

pub use rapier3d;

pub mod body;
pub mod contact;
pub mod coupling;
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
