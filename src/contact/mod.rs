//! Contact of nodes with Rapier's colliders: which colliders can be met, how far a node is from each, and the rows that
//! follow. And contact of deformables with each other.

pub mod candidates;
pub mod distance;
pub mod encounter;
pub mod target;
