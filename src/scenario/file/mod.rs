//! Scenes as files: what is in a world, what happens to it, what is measured, and what must come out.
//!
//! A scene is a file that people write, in [RON](https://github.com/ron-rs/ron) or JSON, and its expectations stand in it:
//! a crash test is no test without its pass criteria, and whoever changes one has the other before their eyes.
//!
//! ```
//! use crumple::scenario::file::{LoadOptions, Scenario};
//! let text = r#"(
//!     about: "a soft block falls on a floor and a box on the block",
//!     variables: (height: 0.5, weight: "20 * 0.3^3 * 9.81"), // numbers by name, for formulas
//!     world: (duration: 2, gravity: (0, -9.81, 0)),           // s, m/s²
//!     materials: (foam: (young: 1e5, density: 20, viscosity: 500)), // Pa, kg/m³, Pa·s
//!     rigid: [
//!         (name: "floor", kind: Fixed, colliders: [(shape: HalfSpace(normal: (0, 1, 0)))]),
//!         (name: "box", translation: (0, "height + 0.4", 0), colliders: [(shape: Cuboid(half: (0.1, 0.05, 0.1)), mass: 2)]),
//!     ],
//!     deformables: [(
//!         name: "block",
//!         body: Lattice(size: (0.3, 0.3, 0.3), cell: 0.1),
//!         material: "foam",
//!         translation: (0, "height", 0),
//!     )],
//!     probes: [(name: "floor", of: Force(by: "floor", axis: Y), cfc: Cfc180)],
//!     expect: [
//!         (that: Peak("floor"), at_least: "2 * weight"),
//!         (that: Mean("floor"), over: (1.5, 2), equals: "weight + 2 * 9.81", within_share: 0.02),
//!         (that: Final(Position(of: "box", axis: Y)), at_least: 0.3, at_most: 0.35),
//!         (that: EnergyResidual, at_most: 0.01),
//!     ],
//! )"#;
//! let scene = Scenario::parse(text, "block.ron".as_ref(), &LoadOptions::default())?;
//! let outcome = scene.run()?;
//! println!("{outcome}"); // check, measured, bound, at which time, verdict
//! assert!(outcome.passed());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Keys
//! Every type in [`model`] is a record or a choice of the file, every field a key, with its unit and default. The same
//! reference comes from [`reference()`] and from `crumple keys`. In RON a record is `(key: value)`, a choice `Name`,
//! `Name(value)` or `Name(key: value)`; in JSON they are `{"key": value}`, `"Name"`, `{"Name": value}`. Lists and vectors
//! may be written with either kind of brackets.
//!
//! # Variables
//! Wherever a number stands, a text is a [formula]: `"speed"` is the variable, `"speed / 3.6"` something made of it. Both
//! RON and JSON take that as it is, an editor colours it, and it can't be mistaken, since no place for a number takes a
//! text. `--set speed=20` on the command line and [`LoadOptions::set`] change a variable. Variables may name each other in any
//! order; to set one that nothing names is a mistake. Where nodes are chosen (`pin`,
//! `parts`, attachments, probes), a formula of `x`, `y`, `z` says which, in the body's own frame, with `min_x` to `max_z`
//! for its corners (a node at 0.6 m is not above 0.6); forces and motions over time are numbers, formulas of `t`, or tables of `(t, value)`.
//!
//! # Shared parts
//! `include: ["parts/car.ron"]` puts the things of other files before the file's own; what stands in both (a variable, a
//! setting of the world) is taken from the including file. Files must lie in the scene's folder or below unless
//! [`LoadOptions::allow_outside`] says otherwise.
//!
//! # Mistakes
//! Loading tells everything that is wrong at once, each with file, line, column, the way to the key, and what was expected;
//! an unknown key or name comes with the nearest known one. What only shows when a body is built, such as a formula that
//! chooses no node, is a [`RunError`] that names the body, and so is a picture or an expectation after the end of
//! the run. Where `stop` ends it early, a span of time that it does not reach is not measured, and what is expected over it
//! is not met. An actuator that is not finite is left out, and fails the run.
//!
//! # Limits
//! What a scene asks for is checked before memory or time is spent on it. In all a scene has at most 64 files of 8 MiB, files
//! of meshes of 64 MiB each and 256 MiB together, 10⁶ nodes, 10⁵ colliders, 2·10⁶ points of shapes, 10⁸ substeps of a
//! deformable, 2·10⁷ samples of histories, of paths and of channels, 1000 pictures of 5·10⁷ nodes, and 2·10⁷ evaluations of
//! formulas that choose nodes; substeps are 1 ns and longer.
//!
//! # Tests
//! Every file of a folder as a test of its own, in `tests/scenes.rs` with `harness = false` and
//! [libtest-mimic](https://docs.rs/libtest-mimic), so that `cargo test wall` runs one and `cargo test -- --list` shows all:
//!
//! ```no_run
//! use crumple::scenario::file::{Scenario, scenes_in};
//! use libtest_mimic::{Arguments, Trial, run};
//!
//! fn main() {
//!     let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenes");
//!     let scenes = scenes_in(folder).expect("the folder of the scenes");
//!     let tests = scenes.into_iter().map(|(name, path)| {
//!         let load = move || Scenario::load(&path, &Default::default());
//!         let slow = load().is_ok_and(|scene| scene.slow);
//!         Trial::test(name, move || Ok(load()?.run()?.verdict()?)).with_ignored_flag(slow)
//!     });
//!     run(&Arguments::from_args(), tests.collect()).exit();
//! }
//! ```
//!
//! On the command line: `crumple run FILE`, `check FILE…`, `test FOLDER`, `sweep FILE --set speed=5..30:26`.

mod build;
mod check;
mod decode;
pub mod formula;
mod limits;
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
mod variables;
mod whole;

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
