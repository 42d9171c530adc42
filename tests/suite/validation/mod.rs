//! Closed forms and discrete references.

mod bars;
mod chains;
mod cloth;
mod crash;
mod fracture;
mod held;
mod impact;
mod integrators;
mod lattice;
mod ledger;
mod momentum;
mod plastic;
mod slope;
mod solid_impact;
mod solid_motion;
mod solids;
