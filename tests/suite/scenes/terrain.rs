//! Balls down a height field and down a mesh of the same surface.

use crumple::scenario::{self, Run};

fn finished(change: impl FnOnce(&mut Run)) -> (Run, scenario::Figures) {
    let scene = scenario::find("terrain").unwrap();
    let mut run = scene.build(&scene.options).unwrap();
    change(&mut run);
    run.finish(|_| {});
    let figures = scene.figures(&run).unwrap();
    (run, figures)
}

#[test]
fn twins_roll_the_same_way_over_a_field_and_a_mesh() {
    let (_, f) = finished(|_| {});
    let get = |key| f.get(key).unwrap();
    for key in ["field_rolled_m", "mesh_rolled_m"] {
        // Without losses a = 5/7·g·sin: 5.6 m in 3 s on this slope, and a few waves to climb.
        assert!((3.0..6.5).contains(&get(key)), "{key}: {}", get(key));
    }
    assert!(get("apart_early_m") < 1.0e-3, "{}", get("apart_early_m"));
    assert!(get("apart_m") < 0.05, "{}", get("apart_m"));
    assert_eq!(get("nodes_through"), 0.0);
    assert!(get("max_penetration_m") <= 1.0e-3);
    assert!(get("energy_residual") <= 0.01);
    assert!(get("momentum_closure") <= 0.005);
    // Less than a thousandth of what a ball has after a fall of half a metre.
    assert!(get("gained_j") < 0.1, "{}", get("gained_j"));
}

/// The figures see what they are there for: a ball whose mesh is gone falls, and takes another way.
#[test]
fn a_ball_without_ground_is_seen() {
    let (run, f) = finished(|run| {
        let mesh = run.cast.collider("mesh").unwrap();
        run.world.colliders[mesh].set_enabled(false);
        run.options.duration = 0.5;
    });
    let ball = run.cast.deformable("on_mesh").unwrap();
    let nodes = run.deformables[ball].node_count() as f64;
    assert_eq!(f.get("nodes_through").unwrap(), nodes);
    assert!(f.get("apart_early_m").unwrap() > 0.5);
}
