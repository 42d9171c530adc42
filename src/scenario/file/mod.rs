//! Scenes as files.

mod build;
mod check;
mod decode;
pub mod formula;
mod load;
pub mod model;
mod outcome;
mod parse;
mod problem;
mod reduce;
mod run;
mod schema;
mod source;
pub mod sweep;
mod tree;

pub use build::RunError;
pub use formula::{Formula, Variables};
pub use load::LoadOptions;
pub use model::{Scenario, reference};
pub use outcome::{Check, Failed, Outcome};
pub use problem::{LoadError, Problem};
pub use run::{ScenarioRun, Series};
pub use schema::Entry;
pub use source::{embedded_names, nearest_embedded, scenes_in};

#[cfg(test)]
mod tests;
