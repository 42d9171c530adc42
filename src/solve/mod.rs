//! Passes over arrays: spring forces, integration, contact rows, shadow bodies. This floor knows no collider and no rigid
//! body, only numbers, so it can be tested in `f64` against closed forms.

pub mod external;
pub mod fem;
pub mod forces;
pub(crate) mod gauge;
pub mod integrate;
pub mod kernel;
pub mod rows;
pub mod shadow;
pub mod solver;
pub mod springs;
pub mod stable;
#[cfg(feature = "statics")]
pub mod statics;
pub(crate) mod threads;
pub mod work;

pub use integrate::Integrator;
pub use kernel::{Kernel, roof};
pub use solver::Solver;
