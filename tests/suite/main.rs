//! All tests of behaviour in one binary, so that the crate is linked once.

mod coupling;
#[cfg(feature = "cli")]
mod scenes;
mod support;
mod validation;
