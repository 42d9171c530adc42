//! Scenes as files.

mod check;
mod decode;
pub mod formula;
mod load;
pub mod model;
mod parse;
mod problem;
mod schema;
mod source;
mod tree;

pub use formula::{Formula, Variables};
pub use load::LoadOptions;
pub use model::{Scenario, reference};
pub use problem::{LoadError, Problem};
pub use schema::Entry;

#[cfg(test)]
mod tests;
