//! V44: boxes on a pinned sheet a tenth and a hundredth of their mass.

use crumple::scenario;

#[test]
#[cfg_attr(debug_assertions, ignore = "long: 70000 substeps; run with --release")]
fn v44_both_sheets_hold_ten_boxes() {
    let scene = scenario::find("trampoline").unwrap();
    let mut run = scene.build(&scene.options).unwrap();
    for (_, body) in run.deformables.iter() {
        assert_eq!(body.node_count(), 900);
        let pinned = body.blueprint().nodes.iter().filter(|n| n.pinned);
        assert_eq!(pinned.count(), 116);
    }
    run.finish(|_| {});
    let f = scene.figures(&run).unwrap();
    let get = |key| f.get(key).unwrap();
    assert_eq!(get("boxes_held_10kg"), 10.0);
    assert_eq!(get("boxes_held_1kg"), 10.0);
    assert_eq!(get("nodes_through"), 0.0);
    for key in ["max_sag_10kg_m", "max_sag_1kg_m"] {
        let sag = get(key);
        assert!((0.1..=0.5).contains(&sag), "{key}: {sag}");
    }
    assert!(get("simulated_s") > 4.999);
    assert!(get("max_penetration_m") < 2e-3);
    assert!(get("energy_residual") < 1e-3);
}
