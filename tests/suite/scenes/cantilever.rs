//! One beam four ways over the same nodes.

use crate::support::close;
use crumple::scenario::{self, cantilever};

#[test]
fn the_recommended_element_bends_as_the_beam_does() {
    let scene = scenario::find("cantilever").unwrap();
    let mut run = scene.build(&scene.options).unwrap();
    run.finish(|_| {});
    let f = scene.figures(&run).unwrap();
    let get = |key: &str| f.get(key).unwrap();
    for path in &cantilever::PATHS {
        let reference = get(&format!("reference_{}_m", path.name));
        close(path.name, reference, path.reference, 1e-12);
        assert!(get(&format!("ms_per_frame_{}", path.name)) > 0.0);
    }
    close(
        "quadratic",
        get("tip_quadratic_m"),
        get("reference_quadratic_m"),
        0.02,
    );
    // V11's discrete answer of a calibrated lattice of these nodes.
    close("lattice", get("tip_lattice_m"), -0.03977, 5e-3);
    // Linear tets of the same nodes are far too stiff; that is why they are not recommended.
    let error =
        |path: &str| 1.0 - get(&format!("tip_{path}_m")) / get(&format!("reference_{path}_m"));
    assert!(
        error("linear") > 5.0 * error("quadratic").abs(),
        "{}",
        error("linear")
    );
    assert!(get("energy_residual") < 0.01);
}

/// The same answer whatever the step of the world is.
#[test]
fn the_step_does_not_matter() {
    let mut options = scenario::find("cantilever").unwrap().options;
    for path in ["lattice", "linear", "quadratic"] {
        let tips = [1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0].map(|dt| {
            options.dt = dt;
            cantilever::alone(path, &options).unwrap().0
        });
        close(path, tips[0], tips[2], 2e-3);
        close(path, tips[1], tips[2], 2e-3);
    }
}
