//! Coupling with Rapier's rigid bodies: seen as shadows during substeps, answered with one hand-over per rigid step.
//!
//! Freezing rigid bodies for a frame and giving them one impulse at its end, as plugins usually do, explodes as soon as a
//! light deformable carries a heavy body. Shadows move with every substep, and keep the contacts that Rapier found between
//! their bodies. What they cannot know, that a body is held by joints, is measured: the response ratio ρ compares what
//! Rapier did with the last impulse to what a free body would have done.

pub mod attach;
pub mod handover;
pub mod memory;
pub mod nearest;
pub mod observe;
pub mod pressed;
pub mod ties;
