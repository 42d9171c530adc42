//! Equilibria: where a body rests under dead loads, in `f64`.
//!
//! Newton's method on the potential energy E(x) − f·x, with the tangent factorised directly (`faer`: sparse Cholesky with
//! a fill-reducing order). Cholesky fails where the tangent is not positive; then a multiple of its diagonal is added, so
//! that every step goes downhill and what is found is a minimum, stable and not merely balanced. A step is
//! shortened until the energy falls. If that stalls, the load is put on in parts. Conjugate gradients would need
//! less memory on large solids, but thousands of steps on slender and nearly incompressible ones, which are
//! what statics is asked about.
//!
//! Springs and elements alike come in through [`Structure`].

mod error;
mod newton;
mod springs;
mod structure;
mod supports;
mod system;

pub use error::{Motion, StaticError};
pub use newton::{Equilibrium, Load, Statics};
pub use springs::SpringNet;
pub use structure::Structure;

#[cfg(test)]
mod tests;
