//! A ride past crates, pendulums and a curtain.

use crumple::scenario;

#[test]
fn a_block_rides_through() {
    let scene = scenario::find("slalom").unwrap();
    let mut run = scene.build(&scene.options).unwrap();
    run.finish(|_| {});
    let f = scene.figures(&run).unwrap();
    let get = |key| f.get(key).unwrap();
    println!("{f:#?}");
    assert_eq!(get("finite"), 1.0);
    assert_eq!(get("nodes_through"), 0.0);
    assert!(get("lowest_node_m") > -1e-3);
    assert!(get("max_penetration_m") < 1e-3);
    assert!(get("energy_residual") < 6e-4);
    // The curtain and a pendulum push against it; friction holds.
    assert!(get("slip_m") < 0.01);
    assert!((get("block_x_m") - 2.0).abs() < 0.01);
    assert!(get("block_height_m") > 0.3);
}
