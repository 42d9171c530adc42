//! All tests of behaviour in one binary, so that the crate is linked once.

mod api;
mod bad_input;
mod contact;
mod coupling;
mod fixtures;
#[cfg(feature = "cli")]
mod scenes;
mod support;
mod validation;

/// Every example ends in a check and is run here.
#[cfg(feature = "cli")]
#[path = "../../examples/integrators.rs"]
#[allow(
    dead_code,
    reason = "its main reads the command line, the test calls what main calls"
)]
mod integrators;

#[cfg(feature = "cli")]
#[test]
fn the_integrators_example_holds() {
    integrators::draw(&std::env::temp_dir().join("crumple-integrators")).unwrap();
}

#[cfg(feature = "cli")]
#[path = "../../examples/accuracy.rs"]
#[allow(dead_code, reason = "as above")]
mod accuracy;

#[cfg(feature = "cli")]
#[test]
fn the_accuracy_example_holds() {
    accuracy::draw(&std::env::temp_dir().join("crumple-accuracy"), &[0.1]).unwrap();
}
