//! Daily use: everything a user of Rapier expects to be able to do between two steps.

mod attach;
mod bitwise;
mod brute;
mod debug;
mod events;
mod forces;
mod frames;
mod handles;
mod hooks;
mod kinematic;
mod overlaps;
mod queries;
mod rides;
mod rigid;
mod settings;
mod sleep;
#[cfg(feature = "cli")]
mod snapshots;
mod solids;
mod state;
#[cfg(all(feature = "parallel", feature = "scenario"))]
mod threads;
mod time;
mod units;
mod wake;
