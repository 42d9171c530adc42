//! Rubber falls and bounces.

use crumple::scenario;

#[test]
fn rubber_bounces_and_every_joule_is_accounted_for() {
    let scene = scenario::find("rubber_drop").unwrap();
    for rate in [60.0, 240.0] {
        let mut options = scene.options;
        options.dt = 1.0 / rate;
        let mut run = scene.build(&options).unwrap();
        run.finish(|_| {});
        let f = scene.figures(&run).unwrap();
        let get = |key: &str| f.get(key).unwrap();
        let rebound = get("rebound_m");
        assert!(
            (0.7..0.85).contains(&rebound),
            "rebound {rebound} m from 1 m at {rate} Hz"
        );
        assert!(
            (0.9..0.95).contains(&get("flattest")),
            "{}",
            get("flattest")
        );
        assert!(get("energy_residual") < 3e-4, "{}", get("energy_residual"));
        assert!(
            get("momentum_closure") < 2e-6,
            "{}",
            get("momentum_closure")
        );
        assert!(
            get("max_penetration_m") < 3e-4,
            "{}",
            get("max_penetration_m")
        );
    }
}
