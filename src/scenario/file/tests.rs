//! Loading: what is read, and what is said of what can't be.

use super::*;
use std::path::Path;

fn load(text: &str) -> Result<Scenario, LoadError> {
    Scenario::parse(text, Path::new("a.ron"), &LoadOptions::default())
}

/// Every problem, as it is shown.
fn problems(text: &str) -> Vec<String> {
    let error = load(text).unwrap_err();
    error.problems.iter().map(Problem::to_string).collect()
}

const BLOCK: &str = r#"(
    variables: (speed: 10, half: "speed / 2"),
    materials: (foam: (young: 1e5, density: 100)),
    rigid: [(name: "floor", kind: Fixed, colliders: [(shape: Cuboid(half: (1, 0.1, 1)))])],
    deformables: [(
        name: "block", body: Lattice(size: (1, 1, 1), cell: 0.5), material: "foam",
        linvel: (0, "-half", 0), pin: "x < min_x + 0.1",
    )],
    probes: [(name: "force", of: Force(by: "floor", axis: Y), cfc: Cfc60)],
    expect: [(that: Peak("force"), at_most: 1e6), (that: EnergyResidual, at_most: 0.01)],
)"#;

#[test]
fn a_scene_is_read_with_its_variables() {
    let scene = load(BLOCK).unwrap();
    assert_eq!(scene.deformables[0].linvel, [0.0, -5.0, 0.0]);
    assert_eq!(scene.world, model::World::default());
    let set = LoadOptions {
        set: vec![("speed".into(), 4.0)],
        ..Default::default()
    };
    let scene = Scenario::parse(BLOCK, Path::new("a.ron"), &set).unwrap();
    assert_eq!(scene.deformables[0].linvel, [0.0, -2.0, 0.0]);
    let wrong = LoadOptions {
        set: vec![("sped".into(), 4.0)],
        ..Default::default()
    };
    let error = Scenario::parse(BLOCK, Path::new("a.ron"), &wrong).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("--set sped") && text.contains("`speed`"),
        "{text}"
    );
}

#[test]
fn every_mistake_is_told_at_once_with_its_place() {
    let found = problems(
        r#"(
    world: (gravty: (0, 0, 0), dt: -1),
    rigid: [
        (name: "floor", kind: Fixd),
        (name: "floor"),
    ],
    deformables: [(
        name: "block",
        body: Lattice(size: (1, 0, 1), cel: 0.5),
        material: (young: NaN, density: "rho"),
    )],
    joints: [(kind: Spherical, a: "flor", b: "floor")],
    expect: [(that: Peak(Force(by: "blok", axis: W)), at_most: 1), (that: EnergyResidual)],
)"#,
    );
    for (place, key, what) in [
        (
            "a.ron:2:13",
            "world",
            "there is no key `gravty`; did you mean `gravity`?",
        ),
        (
            "a.ron:2:36",
            "world.dt",
            "is -1, it must be from 1e-7 to 0.1 s",
        ),
        ("a.ron:4:31", "rigid[0].kind", "did you mean `Fixed`?"),
        ("a.ron:5:16", "rigid[1].name", "already"),
        (
            "a.ron:9:29",
            "deformables[0].body.Lattice.size",
            "is 0, it must be positive",
        ),
        (
            "a.ron:9:40",
            "deformables[0].body.Lattice",
            "did you mean `cell`?",
        ),
        (
            "a.ron:9:22",
            "deformables[0].body.Lattice",
            "the key `cell` is missing",
        ),
        ("a.ron:10:27", "deformables[0].material.young", "is NaN"),
        (
            "a.ron:10:41",
            "deformables[0].material.density",
            "no variable `rho`",
        ),
        ("a.ron:12:35", "joints[0].a", "did you mean `floor`?"),
        ("a.ron:13:36", "by", "did you mean `block`?"),
        ("a.ron:13:50", "axis", "there are: X, Y, Z"),
        ("a.ron:13:68", "expect[1]", "nothing is expected"),
    ] {
        let hit = |p: &&String| p.starts_with(place) && p.contains(key) && p.contains(what);
        assert_eq!(
            found.iter().filter(hit).count(),
            1,
            "{place} {key} {what} in\n{}",
            found.join("\n")
        );
    }
    assert_eq!(found.len(), 13, "{}", found.join("\n"));
}

#[test]
fn json_is_read_alike() {
    let json = r#"{
        "variables": {"speed": 10, "half": "speed / 2"},
        "materials": {"foam": {"young": 1e5, "density": 100}},
        "rigid": [{"name": "floor", "kind": "Fixed", "colliders": [{"shape": {"Cuboid": {"half": [1, 0.1, 1]}}}]}],
        "deformables": [{
            "name": "block", "body": {"Lattice": {"size": [1, 1, 1], "cell": 0.5}}, "material": "foam",
            "linvel": [0, "-half", 0], "pin": "x < min_x + 0.1"
        }],
        "probes": [{"name": "force", "of": {"Force": {"by": "floor", "axis": "Y"}}, "cfc": "Cfc60"}],
        "expect": [{"that": {"Peak": "force"}, "at_most": 1e6}, {"that": "EnergyResidual", "at_most": 0.01}]
    }"#;
    assert_eq!(load(json).unwrap(), load(BLOCK).unwrap());
}

/// What the reference crates write of a scene is read back as the same scene: the syntax is theirs.
#[test]
fn what_is_written_is_read_back() {
    let scene = load(BLOCK).unwrap();
    let written = ron::to_string(&scene).unwrap();
    assert_eq!(load(&written).unwrap(), scene, "{written}");
    let written = serde_json::to_string(&scene).unwrap();
    assert_eq!(load(&written).unwrap(), scene, "{written}");
    ron::from_str::<ron::Value>(BLOCK).unwrap();
}

/// Lists of one and meshes are what RON and JSON write differently.
#[test]
fn every_form_of_a_shape_is_read_back() {
    let scene = load(
        r#"(rigid: [(name: "a", kind: Fixed, colliders: [
            (shape: Compound([(shape: Ball(1), translation: (0, 1, 0))])),
            (shape: TriMesh((vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], triangles: [(0, 1, 2)]))),
            (shape: TriMesh(Hatchback)),
            (shape: Polyline(points: [(0, 0, 0), (1, 0, 0)]), groups: (member: [3])),
        ])])"#,
    )
    .unwrap();
    for written in [
        ron::to_string(&scene).unwrap(),
        serde_json::to_string(&scene).unwrap(),
    ] {
        assert_eq!(load(&written).unwrap(), scene, "{written}");
    }
}

#[test]
fn what_is_written_of_the_catalog_is_read_back() {
    for name in embedded_names() {
        let scene = Scenario::embedded(name, &LoadOptions::default()).unwrap();
        for written in [
            ron::to_string(&scene).unwrap(),
            serde_json::to_string(&scene).unwrap(),
        ] {
            let again = load(&written).unwrap_or_else(|e| panic!("{name}: {e}\n{written}"));
            assert_eq!(again, scene, "{name}");
        }
    }
}

#[test]
fn sizes_are_checked_before_memory_is_taken() {
    for (body, what) in [
        ("Lattice(size: (1e6, 1e6, 1e6), cell: 0.001)", "too many"),
        (
            "Sheet(size: (1, 1), nodes: (100000, 100000), thickness: 0.1)",
            "too many",
        ),
        (
            "Rope(from: (0, 0, 0), to: (1, 0, 0), segments: 1e12, section: 1)",
            "it must be",
        ),
        (
            "Net(nodes: [(at: (0, 0, 0), mass: 1)], springs: [(nodes: (0, 1), stiffness: 1)])",
            "node 1",
        ),
    ] {
        let text = format!(r#"(deformables: [(name: "b", body: {body}, material: Rubber)])"#);
        let found = problems(&text);
        assert!(found.len() == 1 && found[0].contains(what), "{found:?}");
    }
    assert!(problems("(world: (dt: 1e-7, duration: 3000))")[0].contains("at most"));
}

#[test]
fn nothing_is_held_by_itself_or_kept_from_itself() {
    let block = r#"(name: "b", body: Lattice(size: (1, 1, 1), cell: 1), material: Rubber)"#;
    for (more, what) in [
        (
            r#"attachments: [(name: "a", of: "b", nodes: "x > 0", to: "b")]"#,
            "can't be attached to itself",
        ),
        (r#"no_contact: [("b", "b")]"#, "`b` does not touch itself"),
    ] {
        let found = problems(&format!("(deformables: [{block}], {more})"));
        assert!(found.len() == 1 && found[0].contains(what), "{found:?}");
    }
}

#[test]
fn the_reference_names_every_key() {
    let entries = reference();
    assert!(
        entries.iter().all(|e| !e.doc.trim().is_empty()),
        "every key has its text"
    );
    let dt = entries
        .iter()
        .find(|e| e.owner == "World" && e.key == "dt")
        .unwrap();
    assert_eq!(dt.default, "1.0 / 60.0");
    assert!(dt.doc.contains("\\[s\\]"));
}

#[test]
fn what_can_not_be_is_told_of_a_whole_scene() {
    let scene = |b: &str, more: &str| {
        let text = format!(
            r#"(
            rigid: [(name: "ball", colliders: [(shape: Ball(1))])],
            deformables: [
                (name: "a", body: Net(nodes: [(at: (0, 0, 0), mass: 1)])),
                (name: "b", {b}),
            ], {more})"#
        );
        load(&text).map(|_| ()).map_err(|e| e.to_string())
    };
    let free = "body: Net(nodes: [(at: (1, 0, 0), mass: 1)])";
    let closure = "expect: [(that: MomentumClosure, at_most: 1e-3)]";
    let force =
        |on: &str| format!(r#"actuators: [Force(on: "{on}", force: (1, 0, 0))], {closure}"#);
    assert_eq!(scene(free, closure), Ok(()));
    assert_eq!(scene(free, &force("ball")), Ok(()));
    let pinned = "body: Net(nodes: [(at: (1, 0, 0), mass: 1, pinned: true)])";
    let damped = "body: TetBox(size: (1, 1, 1), cell: 1), solid: (young: 1e6, poisson: 0.3, density: 9, mass_damping: 1)";
    for (b, more, key, what) in [
        (free, "view: (0, 1e-50, 0)", "view", "no direction"),
        (pinned, closure, "expect[0]", "`b` has pinned nodes"),
        (
            &format!("{free}, drag: 1"),
            closure,
            "expect[0]",
            "`b` has drag",
        ),
        (damped, closure, "expect[0]", "`b` has drag or mass damping"),
        (free, &force("b"), "expect[0]", "`b` has a force"),
    ] {
        let found = scene(b, more).unwrap_err();
        assert!(found.contains(key) && found.contains(what), "{found}");
    }
}

#[test]
fn nothing_is_looked_at_after_the_end() {
    let scene = |more: &str| {
        let text = format!(
            r#"(world: (duration: 1, dt: 0.03), deformables: [
                (name: "a", body: Net(nodes: [(at: (0, 0, 0), mass: 1)])),
            ], {more})"#
        );
        let started = load(&text).unwrap().start();
        started.map(|_| ()).map_err(|e| e.to_string())
    };
    let at =
        |time: f64| format!("expect: [(that: At(channel: Fastest, time: {time}), at_least: 0)]");
    let over = |to: f64| format!("expect: [(that: Peak(Fastest), over: (0.1, {to}), at_least: 0)]");
    // 34 steps end at 1.02 s.
    for whole in [at(1.02), over(1.0), "frames: [1.0]".into()] {
        assert_eq!(scene(&whole), Ok(()));
    }
    for (late, what) in [
        (
            at(1.1),
            "expect[0]: 1.1 s is after the end of the run at 1.02 s",
        ),
        (over(2.0), "expect[0]: 2 s"),
        ("frames: [0, 3]".into(), "frames: 3 s"),
    ] {
        let error = scene(&late).unwrap_err();
        assert!(error.starts_with(what), "{error}");
    }
}
