//! Boxes on soft blocks and the other way round, at rest.

use crumple::scenario;

#[test]
fn everything_comes_to_rest_where_it_belongs() {
    let scene = scenario::find("drop").unwrap();
    let mut run = scene.build(&scene.options).unwrap();
    run.finish(|_| {});
    let f = scene.figures(&run).unwrap();
    let get = |key| f.get(key).unwrap();
    // Foam of 0.1 MPa under boxes of about 2 to 4 kPa gives by some centimetres at the most.
    for (key, above, half) in [
        ("box_20kg_height_m", 0.40, 0.17),
        ("box_40kg_height_m", 0.40, 0.17),
        ("box_5kg_height_m", 0.40, 0.12),
        ("block_above_height_m", 0.40, 0.20),
        ("block_below_height_m", 0.0, 0.20),
    ] {
        let sunk = above + half - get(key);
        assert!((0.0..0.025).contains(&sunk), "{key}: {sunk} m too low");
    }
    assert!(get("soft_jitter_mps") < 1e-3);
    assert_eq!(get("rigid_jitter_mps"), 0.0);
    assert_eq!(get("asleep"), get("boxes"));
    assert!(get("max_penetration_m") < 1e-3);
    assert!(get("energy_residual") < 4e-4);
    assert!(get("momentum_closure") < 2e-5);
}
