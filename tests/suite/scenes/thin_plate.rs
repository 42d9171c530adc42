//! Blocks at 50 m/s on a plate of 2 mm, at every usual step of the world.

use crumple::scenario;

#[test]
fn nothing_gets_through_a_plate_of_2_mm() {
    let scene = scenario::find("thin_plate").unwrap();
    for rate in [30.0, 60.0, 240.0, 1000.0] {
        let mut options = scene.options;
        options.dt = 1.0 / rate;
        let mut run = scene.build(&options).unwrap();
        run.finish(|_| {});
        let f = scene.figures(&run).unwrap();
        let get = |key| f.get(key).unwrap();
        assert_eq!(get("nodes_through"), 0.0, "at {rate} Hz");
        for key in ["rebound_flat_mps", "rebound_edge_mps"] {
            // It comes back, and with less than it came with.
            let v = get(key);
            assert!((25.0..50.0).contains(&v), "{key} at {rate} Hz: {v}");
        }
        assert!(get("lowest_node_m") > -1e-6, "at {rate} Hz");
        assert!(get("max_penetration_m") < 1e-6, "at {rate} Hz");
        assert!(get("energy_residual") < 0.01, "at {rate} Hz");
        assert!(get("momentum_closure") < 1e-5, "at {rate} Hz");
    }
}
