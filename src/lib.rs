//! Crash-grade deformable bodies for Rapier.
#![warn(missing_docs)]
#![forbid(unsafe_code)]

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
    pub use crate::body::{BuildError, Material, Net, NodeId, Spring, SpringId};
    pub use crate::record::Recorder;
    pub use crate::shape;
    pub use crate::solve::Integrator;
    pub use crate::world::{
        AttachmentHandle, Deformable, DeformableBuilder, DeformableHandle, DeformableParameters,
        DeformableWorld, Observer, Substeps,
    };
}
