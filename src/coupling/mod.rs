//! Coupling with Rapier's rigid bodies: seen as shadows during substeps, answered with one hand-over per rigid step.
//!
//! Freezing rigid bodies for a frame and giving them one impulse at its end, as plugins usually do, explodes as soon as a
//! light deformable carries a heavy body. Shadows move with every substep, keep the contacts that Rapier found between
//! their bodies, and give way as Rapier's joints let them. What they can't know, such as how a soft joint answers,
//! is measured: the response ratio ρ compares what Rapier did with the last impulse to what the body would have done
//! without.

pub mod attach;
pub mod constraints;
pub mod flight;
pub mod handover;
pub mod linkage;
pub mod memory;
pub mod observe;
pub mod pivot;
pub mod ties;
