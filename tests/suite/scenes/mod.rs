//! The scenes of the catalog, held against the figures they are there for, and the command line that runs them.

mod cli;
mod drop;
mod ledger;
mod pile;
mod random;
mod recorder;
mod slalom;
mod wall;
