//! All tests of behaviour in one binary, so that the crate is linked once.

mod coupling;
mod support;
mod validation;
