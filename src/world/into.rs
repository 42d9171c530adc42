//! What builders and worlds take: a thing, or the result that holds it, whose error comes out later.

use super::{Deformable, DeformableBuilder};
use crate::body::{BuildError, Net, TetMesh};

/// What a builder takes as a mesh of tets: a mesh, or the result of a shape function or an import.
pub trait IntoTetMesh {
    /// The mesh, or why there is none.
    fn into_tet_mesh(self) -> Result<TetMesh, BuildError>;
}

impl IntoTetMesh for TetMesh {
    fn into_tet_mesh(self) -> Result<TetMesh, BuildError> {
        Ok(self)
    }
}

impl IntoTetMesh for Result<TetMesh, BuildError> {
    fn into_tet_mesh(self) -> Result<TetMesh, BuildError> {
        self
    }
}

/// What a builder takes as a net: a net, or the result of a shape function.
pub trait IntoNet {
    /// The net, or why there is none.
    fn into_net(self) -> Result<Net, BuildError>;
}

impl IntoNet for Net {
    fn into_net(self) -> Result<Net, BuildError> {
        Ok(self)
    }
}

impl IntoNet for Result<Net, BuildError> {
    fn into_net(self) -> Result<Net, BuildError> {
        self
    }
}

/// What a world takes as a body: a builder, or a body that was built before.
pub trait IntoDeformable {
    /// The body, or why there is none.
    fn into_deformable(self) -> Result<Deformable, BuildError>;
}

impl IntoDeformable for Deformable {
    fn into_deformable(self) -> Result<Deformable, BuildError> {
        Ok(self)
    }
}

impl IntoDeformable for DeformableBuilder {
    fn into_deformable(self) -> Result<Deformable, BuildError> {
        self.build()
    }
}
