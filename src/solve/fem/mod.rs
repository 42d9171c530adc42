//! Finite elements: tetrahedra with a lumped mass, total Lagrangian.
//!
//! Gradients are taken at rest, once: F = Σ x⊗∇N, P(F), f = −Σ w·P·∇N at each integration point. Nothing is
//! rebuilt as the body moves, large turns cost nothing, and what an element needs (nodes, inverse Jacobian, weight) lies
//! in one flat array read front to back, as many elements side by side as the processor's vectors have lanes, see
//! [`super::kernel`]. The loop is compiled once per kind of element and law;
//! no element looks at its own kind. Forces on nodes sum exactly to zero but for rounding, because the gradients of the shape functions do.
//!
//! **The element to prefer is the quadratic tet**, ten nodes and four points. Linear tets bend by a jagged constant
//! strain: 30 % of the deflection of a beam two cells thick, and near incompressibility they lock. The quadratic tet
//! has complete quadratic displacements, so a curvature is represented exactly; with four points it has no mode without
//! strain energy. It keeps a plain force loop without neighbours. Lumping is that of Hinton, Rock & Zienkiewicz (1976):
//! row sums would give corners a negative mass. Averaged nodal pressures on linear tets (Bonet & Burton 1998)
//! would cure the volume but not the bending and need a second pass over nodes; selective integration has no meaning on a
//! constant-strain tet.
//!
//! Edges may be curved, to follow a boundary. Four points integrate the gradients of a curved element only nearly: the
//! stress of a linear field is still exact, but its forces are out of balance by about (sagitta/length)² of the
//! stress. Edges inside a body should be straight.

mod blocks;
mod bound;
mod eigen;
mod elements;
mod gather;
mod kernel;
mod mass;
mod model;
mod part;
mod pass;
mod stiffness;
mod stress;

pub use blocks::{Block, Blocks};
pub use bound::{Moments, Rates};
pub use elements::{Basis, Elements, Linear, Quadratic};
pub use mass::lumped_volumes;
pub use model::Model;
pub use part::Part;
pub use pass::energy;
pub use stress::{Stress, stresses};

#[cfg(test)]
mod tests;
