//! V05: the energy balance of every shipped scene, by every scheme that conserves.

use crumple::prelude::*;
use crumple::scenario;

fn residuals(integrator: Integrator) {
    for scene in scenario::all() {
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
    residuals(Integrator::SymplecticEuler);
}

#[test]
#[ignore = "long: about a minute"]
fn v05_velocity_verlet() {
    residuals(Integrator::VelocityVerlet);
}

#[test]
#[ignore = "long: about a minute and a half"]
fn v05_rk4() {
    residuals(Integrator::Rk4);
}
