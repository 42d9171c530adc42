//! The scenes of the catalog, held against the figures they are there for, and the command line that runs them.

mod cantilever;
mod cli;
mod cradle;
mod drop;
mod files;
mod gripper;
mod ledger;
mod pile;
mod pole;
mod random;
mod recorder;
mod rubber_drop;
mod slalom;
mod sweeps;
mod terrain;
mod thin_plate;
mod trampoline;
mod wall;
