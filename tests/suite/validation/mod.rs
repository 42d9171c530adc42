//! Closed forms and discrete references.

mod chains;
mod crash;
mod impact;
mod integrators;
mod lattice;
mod slope;
