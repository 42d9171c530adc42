//! V05: the energy balance of every shipped scene, by every scheme that conserves. By the default scheme each scene's own
//! test asserts it too.

use crumple::prelude::*;
use crumple::scenario;

/// Scenes of a few seconds.
const SHORT: [&str; 4] = ["wall", "drop", "terrain", "cradle"];

fn residuals(integrator: Integrator, scenes: impl Fn(&str) -> bool) {
    for scene in scenario::all().iter().filter(|s| scenes(s.name)) {
        let mut run = scene.build(&scene.options).unwrap();
        run.deformables.params.integrator = integrator;
        run.finish(|_| {});
        let residual = scene.figures(&run).unwrap().get("energy_residual").unwrap();
        println!("{} by {}: {residual:.2e}", scene.name, integrator.name());
        assert!(
            residual <= 0.01,
            "{} by {}: residual {residual}, allowed .01",
            scene.name,
            integrator.name()
        );
    }
}

#[test]
fn v05_symplectic_euler() {
    residuals(Integrator::SymplecticEuler, |name| SHORT.contains(&name));
}

#[test]
#[ignore = "long: some minutes"]
fn v05_symplectic_euler_long() {
    residuals(Integrator::SymplecticEuler, |name| !SHORT.contains(&name));
}

#[test]
#[ignore = "long: some minutes"]
fn v05_velocity_verlet() {
    residuals(Integrator::VelocityVerlet, |_| true);
}

#[test]
#[ignore = "long: some minutes"]
fn v05_rk4() {
    residuals(Integrator::Rk4, |_| true);
}
