//! Contact of deformables with Rapier's colliders: which colliders can be met, how far a point is from each, and the rows
//! that follow. And contact of deformables with each other.

pub mod beside;
pub mod candidates;
pub mod closest;
pub mod cone;
pub mod distance;
pub mod encounter;
pub mod feature;
pub mod form;
pub mod nodes;
pub mod roll;
pub mod site;
pub mod solid_nodes;
pub mod soup;
pub mod soup_nodes;
pub mod target;
pub mod touches;
pub mod tree;
pub mod watch;
