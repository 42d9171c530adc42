//! Every scene file of the catalog is a test of its own: `cargo test --features cli pendulum` runs one.

use crumple::scenario::file::{Scenario, scenes_in};
use libtest_mimic::{Arguments, Trial, run};

fn main() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenes");
    let scenes = scenes_in(folder).expect("the folder of the scenes");
    let tests = scenes.into_iter().map(|(name, path)| {
        let load = move || Scenario::load(&path, &Default::default());
        let slow = load().is_ok_and(|scene| scene.slow);
        Trial::test(name, move || Ok(load()?.run()?.verdict()?)).with_ignored_flag(slow)
    });
    run(&Arguments::from_args(), tests.collect()).exit();
}
