//! The car into the wall at 56 km/h: what a full-width rigid barrier test of a car of this size gives.

use crumple::scenario::{self, Figures, Options};

/// Runs `wall` with changed options.
fn run(change: impl FnOnce(&mut Options)) -> (Figures, u64) {
    let scene = scenario::find("wall").unwrap();
    let mut options = scene.options;
    change(&mut options);
    let mut run = scene.build(&options).unwrap();
    run.finish(|_| {});
    let hash = run.deformables.state_hash();
    (scene.figures(&run).unwrap(), hash)
}

#[track_caller]
fn within(figures: &Figures, key: &str, least: f64, most: f64) {
    let value = figures.get(key).unwrap();
    assert!(
        (least..=most).contains(&value),
        "{key} is {value}, it must be from {least} to {most}"
    );
}

/// Relative difference of a figure in two runs.
fn apart(a: &Figures, b: &Figures, key: &str) -> f64 {
    let [a, b] = [a, b].map(|f| f.get(key).unwrap());
    println!("{key}: {a} and {b}, {:.3} % apart", 100.0 * (b / a - 1.0));
    (b / a - 1.0).abs()
}

#[test]
fn the_crash_is_one_of_a_real_car() {
    let (f, _) = run(|_| {});
    within(&f, "mass_kg", 1299.9, 1300.1);
    within(&f, "crush_m", 0.45, 0.75);
    within(&f, "time_of_crush_s", 0.050, 0.095);
    within(&f, "contact_end_s", 0.070, 0.130);
    within(&f, "mean_decel_g", 16.0, 28.0);
    within(&f, "peak_decel_g", 20.0, 45.0);
    within(&f, "restitution", 0.05, 0.25);
    within(&f, "energy_residual", 0.0, 2e-4);
    within(&f, "momentum_closure", 0.0, 1e-6);
    within(&f, "max_penetration_m", 0.0, 1e-5);
    within(&f, "springs_broken", 0.0, 0.0);
    within(&f, "crates_pushed", 1.0, 8.0);
    // The cabin stays a cabin: nearly all of the crush is before it.
    within(&f, "cabin_strain", 0.0, 0.02);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long: several crashes; run with --release")]
fn half_the_substep_gives_the_same_crash() {
    let ((a, _), (b, _)) = (run(|_| {}), run(|o| o.safety *= 0.5));
    assert!(b.get("substeps").unwrap() > 1.9 * a.get("substeps").unwrap());
    for (key, most) in [
        ("crush_m", 0.01),
        ("delta_v_mps", 0.01),
        ("absorbed_j", 0.01),
        ("peak_decel_g", 0.05),
    ] {
        assert!(apart(&a, &b, key) <= most, "{key}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "long: several crashes; run with --release")]
fn the_step_of_the_world_does_not_matter() {
    let runs = [30.0, 60.0, 120.0, 240.0].map(|rate| run(|o| o.dt = 1.0 / rate).0);
    for other in &runs[..3] {
        for key in ["crush_m", "delta_v_mps"] {
            assert!(apart(&runs[3], other, key) <= 0.02, "{key}");
        }
    }
}

#[test]
fn the_same_run_gives_the_same_bits_and_recording_changes_none() {
    let short = |o: &mut Options| o.duration = 0.025;
    let (a, b) = (run(short).1, run(short).1);
    assert_eq!(a, b);
    let scene = scenario::find("wall").unwrap();
    let mut options = scene.options;
    short(&mut options);
    let mut unseen = scene.build(&options).unwrap();
    for _ in 0..unseen.total_steps() {
        unseen.deformables.step(&mut unseen.world);
    }
    assert_eq!(unseen.deformables.state_hash(), a);
}
