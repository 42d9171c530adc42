//! Jaws lift a soft cube by friction, or don't.

use crumple::scenario::{self, gripper};

#[test]
fn it_holds_with_much_friction_and_slips_with_little() {
    let scene = scenario::find("gripper").unwrap();
    for rate in [60.0, 240.0] {
        let mut options = scene.options;
        options.dt = 1.0 / rate;
        let mut run = scene.build(&options).unwrap();
        run.finish(|_| {});
        let f = scene.figures(&run).unwrap();
        let get = |key: &str| f.get(key).unwrap();
        let (weight, held) = (get("weight_n"), get("grip_06_n"));
        assert!(1.2 * held > weight, "{held} N can hold {weight} N");
        assert!(
            0.4 * held < weight,
            "{held} N can't hold {weight} N with 0.2"
        );
        // What hangs between the jaws sags by a part of its size, but does not slip.
        let lift = f64::from(gripper::LIFT);
        let (firm, loose) = (get("lifted_06_m"), get("lifted_02_m"));
        assert!(
            (firm - lift).abs() < 0.03,
            "lifted by {firm} of {lift} m at {rate} Hz"
        );
        assert!(
            loose < 0.02,
            "lifted by {loose} m with little friction at {rate} Hz"
        );
        assert!(get("max_penetration_m") < 1e-3);
        assert!(get("energy_residual") < 0.01, "{}", get("energy_residual"));
        assert!(get("momentum_closure") < 1e-4);
    }
}

/// Once it hangs, it hangs: no creep.
#[test]
fn a_held_cube_does_not_creep() {
    let scene = scenario::find("gripper").unwrap();
    let mut options = scene.options;
    options.duration = 6.0;
    let mut run = scene.build(&options).unwrap();
    let at = |run: &scenario::Run| {
        let handle = run.cast.deformable("holds").unwrap();
        run.deformables[handle].center_of_mass().y
    };
    while run.deformables.time() < 3.0 {
        run.step();
    }
    let early = at(&run);
    run.finish(|_| {});
    assert!(
        (at(&run) - early).abs() < 1e-4,
        "{} m in 3 s",
        at(&run) - early
    );
}
