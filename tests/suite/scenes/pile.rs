//! Thirty bodies in a heap.

use crumple::rapier3d::prelude::*;
use crumple::scenario::{self, Figures, Run};

fn heap() -> (Run, Figures) {
    let scene = scenario::find("pile").unwrap();
    let mut run = scene.build(&scene.options).unwrap();
    run.finish(|_| {});
    let figures = scene.figures(&run).unwrap();
    (run, figures)
}

/// The speed of a rigid body, of a ball that of its lowest point \[m/s\]: Rapier lets what rolls on a floor roll on.
fn unrest(body: &RigidBody, colliders: &ColliderSet) -> f32 {
    let balls = body.colliders().iter();
    let radius = balls.filter_map(|c| Some(colliders[*c].shape().as_ball()?.radius));
    let down = -Vector::Y * radius.fold(0.0, f32::max);
    body.velocity_at_point(body.center_of_mass() + down)
        .length()
}

#[test]
fn nothing_sinks_or_gains_in_a_heap() {
    let (run, f) = heap();
    let get = |key| f.get(key).unwrap();
    println!("{f:#?}");
    assert_eq!(get("bodies"), 30.0);
    assert_eq!(get("finite"), 1.0);
    assert_eq!(get("nodes_through"), 0.0);
    assert!(get("lowest_node_m") > -1e-3);
    assert!(get("max_penetration_m") < 3e-3);
    assert!(get("energy_rise") < 1e-4);
    assert!(get("energy_residual") < 3e-3);
    for (_, body) in run.world.bodies.iter() {
        let unrest = unrest(body, &run.world.colliders);
        assert!(unrest < 0.02, "{unrest} m/s at {}", body.translation());
    }
}
