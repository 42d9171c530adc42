//! The commands for scene files.

use crumple::scenario::file::{LoadOptions, Scenario, embedded_names, reference, scenes_in};
use crumple::scenario::survey;
use std::path::PathBuf;
use std::process::{Command, Output};

pub fn crumple(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_crumple"))
        .args(arguments)
        .output()
        .unwrap()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A new folder for one test.
pub fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("crumple-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

const CATALOG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenes");

/// A stone that is thrown up; `floor` says how low it may get.
pub const STONE: &str = r#"(
    about: "a stone is thrown up",
    variables: (speed: 5, floor: -100),
    world: (duration: 1),
    deformables: [(name: "stone", body: Net(nodes: [(at: (0, 0, 0), mass: 2)]), linvel: (0, "speed", 0))],
    probes: [(name: "height", of: Position(of: "stone", axis: Y))],
    expect: [
        (name: "top", that: Peak("height"), equals: "speed^2 / (2 * 9.81)", within: "speed / 60"),
        (name: "end", that: Final("height"), at_least: "floor"),
    ],
)"#;

/// A force with a pole: nothing is expected of what is finite, and yet nothing can be made of such a run.
#[test]
fn a_run_that_blows_up_fails() {
    let scene = |expect: &str| {
        let text = format!(
            r#"(
            world: (duration: 0.2, gravity: (0, 0, 0)),
            deformables: [
                (name: "calm", body: Net(nodes: [(at: (0, 0, 0), mass: 2)])),
                (name: "stone", body: Net(nodes: [(at: (5, 0, 0), mass: 2)])),
            ],
            actuators: [Force(on: "stone", force: ("1 / (t - 0.1)^12", 0, 0))],
            expect: [{expect}],
        )"#
        );
        let path = std::path::Path::new("pole.ron");
        let scenario = Scenario::parse(&text, path, &LoadOptions::default()).unwrap();
        scenario.run().unwrap()
    };
    let residual = "(that: EnergyResidual, at_most: 1)";
    let outcome = scene(residual);
    assert!(!outcome.passed());
    let [_, finite] = &outcome.checks[..] else {
        panic!("{:?}", outcome.checks);
    };
    assert_eq!(finite.name, "Finite: `stone` froze");
    assert!(outcome.verdict().unwrap_err().to_string().contains("stone"));
    // A scene may be about that.
    assert!(scene("(that: Finite, at_most: 0)").passed());
}

/// What acts and is not finite is left out, and the run is no good. A force of NaN left every trace of a run that is well.
#[test]
fn a_run_whose_actuator_is_not_finite_fails() {
    let run = |act: &str, expect: &str| {
        let text = format!(
            r#"(
            world: (duration: 0.1, dt: 0.01, gravity: (0, 0, 0)),
            rigid: [
                (name: "box", colliders: [(shape: Ball(0.1), mass: 2)]),
                (name: "lift", kind: KinematicPosition, translation: (0, 5, 0)),
            ],
            joints: [(name: "hinge", a: "box", b: "lift", kind: Revolute((0, 0, 1)), motor: (damping: 1))],
            deformables: [
                (name: "stone", body: Net(nodes: [(at: (5, 0, 0), mass: 2)])),
                (name: "held", body: Net(nodes: [(at: (9, 0, 0), mass: 2, pinned: true)])),
            ],
            actuators: [Force(on: "box", force: (0, "sqrt(0.1 - t)", 0)), {act}],
            expect: [{expect}],
        )"#
        );
        let path = std::path::Path::new("acts.ron");
        let scenario = Scenario::parse(&text, path, &LoadOptions::default());
        scenario.unwrap_or_else(|e| panic!("{e}")).run().unwrap()
    };
    for (act, from) in [
        (r#"Force(on: "box", force: ("1 / (t - t)", 0, 0))"#, 0.0),
        (
            r#"Force(on: "box", torque: ("sqrt(0.052 - t)", 0, 0))"#,
            0.05,
        ),
        (r#"Force(on: "stone", force: (0, "1e42 * t", 0))"#, 0.0),
        (r#"Move(of: "lift", by: (0, "ln(0.055 - t)", 0))"#, 0.05),
        (r#"Move(of: "held", by: (0, "ln(0.055 - t)", 0))"#, 0.05),
        (r#"Drive(joint: "hinge", velocity: "0 / (t - t)")"#, 0.0),
    ] {
        for expect in ["", "(that: Finite, equals: 1, within: 0)"] {
            let outcome = run(act, expect);
            let [finite] = &outcome.checks[..] else {
                panic!("{act}: {:?}", outcome.checks);
            };
            assert!(!finite.passed);
            let said = format!("Finite: actuators[1] is not finite in the step from {from} s");
            assert_eq!(finite.name, said, "{act}");
            let run = &outcome.run.run;
            assert!(survey::all_finite(&run.world, &run.deformables));
        }
    }
    // What is finite for as long as the run is to last is well, to its very end.
    let outcome = run(r#"Move(of: "lift", by: (0, "sqrt(0.1 - t)", 0))"#, "");
    assert!(outcome.passed(), "{outcome}");
}

/// What a node may not touch it can't be through.
#[test]
fn nodes_are_through_what_they_may_touch() {
    let stays = "kind: Fixed, colliders: [(shape: Ball(0.5)";
    for (rigid, more, through) in [
        (format!("{stays})]"), "", 1),
        (format!("{stays}, sensor: true)]"), "", 0),
        (format!("{stays}, groups: (member: [2]))]"), "", 0),
        (format!("{stays}, solver_groups: (member: [2]))]"), "", 0),
        (
            format!("{stays})]"),
            r#"no_contact: [("rock", "stone")],"#,
            0,
        ),
    ] {
        let text = format!(
            r#"(
            world: (duration: 0.01, dt: 0.01, gravity: (0, 0, 0)),
            rigid: [(name: "rock", {rigid})],
            deformables: [(
                name: "stone", body: Net(nodes: [(at: (0, 0.1, 0), mass: 2)]),
                groups: (with: [1]), solver_groups: (with: [1]),
            )],
            {more}
            expect: [(that: NodesThrough(0.01), equals: {through}, within: 0)],
        )"#
        );
        let path = std::path::Path::new("through.ron");
        let scenario = Scenario::parse(&text, path, &LoadOptions::default());
        let outcome = scenario.unwrap_or_else(|e| panic!("{e}")).run().unwrap();
        assert!(outcome.passed(), "{rigid} {more}: {outcome}");
    }
}

/// A ball bound to a box of tets that is larger than it rests on the ball, with the box in the floor.
#[test]
fn an_embedded_surface_touches_in_place_of_its_tets() {
    let scene = r#"(
        variables: (radius: 0.2, side: 0.5, density: 100),
        world: (duration: 1),
        rigid: [(name: "floor", kind: Fixed, colliders: [(shape: HalfSpace(normal: (0, 1, 0)))])],
        deformables: [(
            name: "ball",
            body: TetBox(size: ("side", "side", "side"), cell: 0.25),
            embed: Ball(radius: "radius", around: 16, rings: 8),
            solid: (young: 1e6, poisson: 0.3, density: "density", mass_damping: 20),
            translation: (0, "radius", 0),
        )],
        probes: [(name: "low", of: Low(of: "ball", axis: Y)), (name: "floor", of: Force(by: "floor", axis: Y))],
        expect: [
            (name: "lowest node", that: Final("low"), equals: "radius - side / 2", within: 2e-3),
            (name: "weight", that: Mean("floor"), over: (0.5, 1), equals: "density * side^3 * 9.81", within_share: 0.01),
        ],
    )"#;
    let options = LoadOptions::default();
    let scene = Scenario::parse(scene, std::path::Path::new("a.ron"), &options).unwrap();
    let outcome = scene.run().unwrap();
    assert!(outcome.passed(), "{outcome}");
}

/// Forces on one rigid body add up.
#[test]
fn two_forces_on_one_body_both_act() {
    let scene = r#"(
        world: (gravity: (0, 0, 0), duration: 1),
        rigid: [(name: "box", colliders: [(shape: Ball(0.1), mass: 2)])],
        actuators: [Force(on: "box", force: (4, 0, 0)), Force(on: "box", force: (0, 2, 0))],
        probes: [(name: "x", of: Position(of: "box", axis: X)), (name: "y", of: Position(of: "box", axis: Y))],
        expect: [
            (name: "x", that: Final("x"), equals: 1, within: 0.02),
            (name: "y", that: Final("y"), equals: 0.5, within: 0.01),
        ],
    )"#;
    let options = LoadOptions::default();
    let scene = Scenario::parse(scene, std::path::Path::new("a.ron"), &options).unwrap();
    let outcome = scene.run().unwrap();
    assert!(outcome.passed(), "{outcome}");
}

#[test]
fn the_crate_has_every_file_of_the_catalog() {
    let files = scenes_in(CATALOG).unwrap();
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    let mut embedded: Vec<&str> = embedded_names().collect();
    embedded.sort_unstable();
    assert_eq!(embedded, names);
    for (name, path) in &files {
        let options = LoadOptions::default();
        let embedded = Scenario::embedded(name, &options).unwrap();
        assert_eq!(embedded, Scenario::load(path, &options).unwrap(), "{name}");
        assert!(
            !embedded.about.is_empty() && embedded.expect.len() > 1,
            "{name}"
        );
    }
}

#[test]
fn a_scene_file_is_run_and_held_to_what_it_expects() {
    let dir = folder("stone");
    let file = dir.join("stone.ron");
    std::fs::write(&file, STONE).unwrap();
    let (file, out) = (file.to_str().unwrap(), dir.join("out"));
    let run = |more: &[&str]| {
        let mut arguments = vec!["run", file, "--quiet", "--out", out.to_str().unwrap()];
        arguments.extend(more);
        crumple(&arguments)
    };
    let good = run(&["--set", "speed=8"]);
    assert_eq!(good.status.code(), Some(0), "{}", text(&good.stderr));
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["variables"]["speed"], 8.0);
    assert_eq!(summary["passed"], true);
    let csv = std::fs::read_to_string(out.join("probe_height.csv")).unwrap();
    assert!(csv.starts_with("time_s,height\n0,0\n"), "{csv}");
    assert_eq!(
        &std::fs::read(out.join("probe_height.png")).unwrap()[1..4],
        b"PNG"
    );

    let bad = run(&["--set", "floor=1"]);
    assert_eq!(bad.status.code(), Some(1));
    let table = text(&bad.stdout);
    for part in [
        "check",
        "measured",
        "bound",
        "end",
        "≥ 1",
        "FAILED",
        "written to",
    ] {
        assert!(table.contains(part), "{table}");
    }
    let unknown = run(&["--set", "sped=1"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(text(&unknown.stderr).contains("did you mean `speed`?"));
    let twice = run(&["--set", "speed=1", "--set", "speed=2"]);
    assert_eq!(twice.status.code(), Some(2));
    assert!(text(&twice.stderr).contains("`speed` is set twice"));
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn folders_are_tested_and_files_checked() {
    let dir = folder("folder");
    std::fs::write(dir.join("good.ron"), STONE).unwrap();
    let path = dir.to_str().unwrap();
    let output = crumple(&["test", path]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
    std::fs::write(dir.join("low.ron"), STONE.replace("-100", "3")).unwrap();
    std::fs::write(
        dir.join("wrong.ron"),
        STONE.replace("duration", "durations"),
    )
    .unwrap();
    let output = crumple(&["test", path]);
    assert_eq!(output.status.code(), Some(1));
    let shown = text(&output.stdout);
    for part in [
        "good: ok",
        "low: FAILED",
        "wrong: FAILED",
        "did you mean `duration`?",
        "1 passed, 1 failed, 1 can't",
    ] {
        assert!(shown.contains(part), "{shown}");
    }
    let [low, wrong] = ["low.ron", "wrong.ron"].map(|f| dir.join(f));
    let output = crumple(&["check", low.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0));
    let output = crumple(&["check", low.to_str().unwrap(), wrong.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("wrong.ron:4:13"),
        "{}",
        text(&output.stderr)
    );
    let output = crumple(&["check", "trampolin"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("did you mean `trampoline`?"), "{said}");
    let output = crumple(&["check", path, "wall"]);
    assert_eq!(output.status.code(), Some(2));
    let shown = text(&output.stdout);
    assert!(shown.contains("low.ron: ok") && shown.contains("wall: ok"));
    let output = crumple(&["run", path]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("crumple test"));
    std::fs::remove_dir_all(dir).unwrap();
}

/// What a file may say and a body can't be is found without a run.
#[test]
fn a_checked_scene_can_be_built() {
    let dir = folder("checked");
    let file = dir.join("stiff.ron");
    let scene = r#"(
    world: (duration: 0.1),
    materials: ( steel: (young: 1e30, density: 1000) ),
    deformables: [ (name: "block", body: Lattice(size: (1, 1, 1), cell: 0.5), material: "steel") ],
)"#;
    std::fs::write(&file, scene).unwrap();
    let output = crumple(&["check", file.to_str().unwrap()]);
    let shown = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{shown}");
    assert!(
        shown.contains("stiff.ron") && shown.contains("block"),
        "{shown}"
    );
    std::fs::remove_dir_all(dir).unwrap();
}

/// What files of meshes, and factors on heights, put too far out is named.
#[test]
fn nothing_lies_farther_out_than_digits_reach() {
    let dir = folder("far");
    let file = dir.join("far.ron");
    std::fs::write(
        dir.join("far.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 2e30\nf 1 2 3\n",
    )
    .unwrap();
    let ground = |shape: &str| {
        format!("rigid: [ (name: \"ground\", kind: Fixed, colliders: [ (shape: {shape}) ]) ]")
    };
    let block = "(name: \"block\", body: Lattice(size: (3e6, 1, 1), cell: 1e5), material: Rubber)";
    for (what, words) in [
        (
            ground("TriMesh(File(\"far.obj\"))"),
            "`ground`: point 3 of its mesh is (0, 1, 2000",
        ),
        (
            ground("HeightField(heights: [[0, 1e3], [0, 1]], size: (1, 2e3, 1))"),
            "more than 1e6 m",
        ),
        (format!("deformables: [ {block} ]"), "at most 1e6 m"),
    ] {
        std::fs::write(&file, format!("( world: (duration: 0.1), {what} )")).unwrap();
        let output = crumple(&["check", file.to_str().unwrap()]);
        let shown = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{shown}");
        assert!(shown.contains(words), "{shown}");
    }
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn the_reference_is_printed() {
    let all = text(&crumple(&["keys"]).stdout);
    for entry in reference() {
        let owner = entry.owner.split("::").next().unwrap();
        assert!(all.contains(entry.key) && all.contains(owner), "{entry:?}");
    }
    let world = text(&crumple(&["keys", "World"]).stdout);
    assert!(
        world.contains("dt: f64 = 1.0 / 60.0") && !world.contains("colliders"),
        "{world}"
    );
    assert_eq!(crumple(&["keys", "Wrld"]).status.code(), Some(2));
}

/// Every channel takes a rate, and a filter where it is recorded often enough for it.
#[test]
fn every_probe_has_a_rate_and_a_filter() {
    let stone = |probe: &str| {
        let text = format!(
            "(world: (duration: 1, dt: 0.01, history: 1e-3, substeps: Fixed(10)),
              deformables: [(name: \"stone\", body: Net(nodes: [(at: (0, 0, 0), mass: 2)]), linvel: (3, 0, 0))],
              rigid: [(name: \"ball\", colliders: [(shape: Ball(0.1))], translation: (5, 0, 0))],
              probes: [(name: \"p\", {probe})])"
        );
        let scene = Scenario::parse(&text, "probe.ron".as_ref(), &Default::default());
        let outcome = scene.map_err(|e| e.to_string())?.run();
        let outcome = outcome.map_err(|e| e.to_string())?;
        Ok::<_, String>(outcome.probes[0].1.clone())
    };
    let height = |t: f64| -0.5 * 9.81 * t * t;
    let all = stone("of: Position(of: \"stone\", axis: Y)").unwrap();
    assert!(all.times.len() > 900, "{}", all.times.len());
    let some = stone("of: Position(of: \"stone\", axis: Y), rate: 50").unwrap();
    let spaced = |times: &[f64], by: f64| times.windows(2).all(|t| (t[1] - t[0] - by).abs() < 1e-9);
    assert!(some.times.len() >= 50 && spaced(&some.times, 0.02));
    let filtered = stone("of: Position(of: \"stone\", axis: Y), rate: 1000, cfc: Cfc60").unwrap();
    assert!(filtered.times.len() > 990 && spaced(&filtered.times, 1e-3));
    for (t, y) in some.times.iter().zip(&some.values) {
        assert!((y - height(*t)).abs() < 0.02, "{y} at {t} s");
    }
    // In the middle a filter without delay leaves a parabola as it is, but for its constant curvature.
    for i in 200..800 {
        let (t, y) = (filtered.times[i], filtered.values[i]);
        assert!((y - height(t)).abs() < 0.02, "{y} at {t} s");
    }
    // A rigid body is recorded once per step, a hundred times a second: too seldom for 100 Hz.
    let ball = "of: Velocity(of: \"ball\", axis: Y)";
    let seldom = stone(&format!("{ball}, rate: 20")).unwrap();
    assert!(seldom.times.len() == 21 && spaced(&seldom.times, 0.05));
    let error = stone(&format!("{ball}, cfc: Cfc60")).unwrap_err();
    assert!(error.contains("CFC 60 needs"), "{error}");
    let error = stone(&format!("{ball}, rate: 10000, cfc: Cfc60")).unwrap_err();
    assert!(error.contains("CFC 60 needs"), "{error}");
}
