//! V31: bars that collide end on, against Saint-Venant and against the exact solution of the same chains.

use crumple::scenario;

#[test]
fn v31_bars_change_velocities() {
    let scene = scenario::find("cradle").unwrap();
    let mut run = scene.build(&scene.options).unwrap();
    run.finish(|_| {});
    let f = scene.figures(&run).unwrap();
    let get = |key| f.get(key).unwrap();
    for (key, continuum, chain) in [
        ("equal_striker_v", 0.0, 0.0063),
        ("equal_struck_v", 1.0, 0.9937),
        ("double_striker_v", 0.0, -0.0085),
        ("double_struck_v", 0.5, 0.5043),
    ] {
        let v = get(key);
        println!("{key}: {v}");
        assert!((v - continuum).abs() < 0.02, "{key}: {v}");
        assert!((v - chain).abs() < 0.01, "{key}: {v}, not {chain}");
    }
    assert!(get("momentum_error") < 1e-6);
    assert!(get("momentum_closure") < 1e-5);
    assert!(get("energy_residual") < 1e-4);
    assert!(get("max_penetration_m") < 1e-6);
    assert_eq!(get("nodes_through"), 0.0);
}
