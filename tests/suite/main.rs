//! All tests of behaviour in one binary, so that the crate is linked once.

mod coupling;
mod support;
mod validation;

/// Every example ends in a check and is run here.
#[cfg(feature = "cli")]
#[path = "../../examples/integrators.rs"]
mod integrators;

#[cfg(feature = "cli")]
#[test]
fn the_integrators_example_holds() {
    integrators::main().unwrap();
}
