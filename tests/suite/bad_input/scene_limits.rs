//! Scene files that ask for too much, or for what makes no sense: a located error before memory or time is spent on it.

use super::scene_files::Folder;
use crumple::body::Material;
use crumple::scenario::file::{LoadOptions, Scenario};
use std::path::Path;
use std::time::{Duration, Instant};

fn load(text: &str) -> Result<Scenario, String> {
    let loaded = Scenario::parse(text, Path::new("a.ron"), &LoadOptions::default());
    loaded.map_err(|e| {
        for p in &e.problems {
            assert!(p.line > 0 && p.column > 0, "{p} has no place");
        }
        e.to_string()
    })
}

/// Every text is refused at once, with a place, the key and these words.
fn refused(cases: &[(&str, &[&str])]) {
    for (text, words) in cases {
        let start = Instant::now();
        let shown = match load(text) {
            Ok(_) => panic!("{} is a scene", &text[..text.len().min(300)]),
            Err(shown) => shown,
        };
        let took = start.elapsed();
        assert!(took < Duration::from_secs(2), "{took:?} for {words:?}");
        for word in *words {
            assert!(shown.contains(word), "{word:?} is not in: {shown}");
        }
    }
}

#[test]
fn what_a_scene_may_ask_for_in_all_is_limited() {
    let block = "body: Lattice(size: (0.9, 0.9, 0.9), cell: 0.01), material: Rubber";
    let nodes = format!("(deformables: [(name: \"a\", {block}), (name: \"b\", {block})])");
    let ropes = "(name: \"r\", body: Net(nodes: [(at: (0, 0, 0), mass: 1)]))";
    let ropes: Vec<String> = (0..900)
        .map(|i| ropes.replace("\"r\"", &format!("\"r{i}\"")))
        .collect();
    let histories = format!(
        "(world: (duration: 3600, dt: 0.1, history: 0.001), deformables: [{}])",
        ropes.join(",")
    );
    let bodies: String = (0..2000)
        .map(|i| format!("(name: \"r{i}\", colliders: [(shape: Ball(1))]),"))
        .collect();
    let paths = format!("(world: (duration: 3600, dt: 0.01), rigid: [{bodies}])");
    let collider = "(shape: Ball(1)),".repeat(900);
    let colliders: String = (0..120)
        .map(|i| format!("(name: \"r{i}\", colliders: [{collider}]),"))
        .collect();
    let colliders = format!("(rigid: [{colliders}])");
    let ground = "(shape: Terrain(height: \"x\", size: (800, 800), cell: 1)),".repeat(4);
    let ground = format!("(rigid: [(name: \"a\", kind: Fixed, colliders: [{ground}])])");
    let balls = "(shape: TriMesh(Ball(radius: 1, around: 512, rings: 512))),".repeat(9);
    let balls = format!("(rigid: [(name: \"a\", kind: Fixed, colliders: [{balls}])])");
    let tets = "body: TetBox(size: (1, 1, 1), cell: 1), solid: (young: 1, poisson: 0, density: 1)";
    let skins: String = (0..9)
        .map(|i| {
            format!("(name: \"b{i}\", {tets}, embed: Ball(radius: 1, around: 512, rings: 512)),")
        })
        .collect();
    let skins = format!("(deformables: [{skins}])");
    let frames = format!("(frames: [{}])", "0,".repeat(1001));
    let pictures = format!(
        "(deformables: [(name: \"a\", {block})], frames: [{}])",
        "0,".repeat(100)
    );
    let pairs = format!(
        "(rigid: [(name: \"a\"), (name: \"b\")], no_contact: [{}])",
        "(\"a\", \"b\"),".repeat(1001)
    );
    let parts = "(at: \"x > 0\", material: Rubber),".repeat(50);
    let choices = format!("(deformables: [(name: \"a\", {block}, parts: [{parts}])])");
    let probe = "world: (duration: 3600, dt: 0.1, history: 1, energy: 1), rigid: [(name: \"a\")]";
    let probes: String = (0..10)
        .map(|i| format!("(name: \"p{i}\", of: Force(by: \"a\", axis: X), rate: 1000),"))
        .collect();
    let probes = format!("({probe}, probes: [{probes}])");
    refused(&[
        (
            &nodes,
            &["a.ron:1:", "deformables[1]", "1507142 nodes", "1000000"],
        ),
        (&histories, &["deformables[", "samples", "20000000"]),
        (&paths, &["rigid[", "samples", "20000000"]),
        (&colliders, &["rigid[", "100800 colliders", "100000"]),
        (&ground, &["rigid[0]", "2566404 points", "2000000"]),
        (&balls, &["rigid[0]", "points", "2000000"]),
        (&skins, &["deformables[7]", "points", "2000000"]),
        (&frames, &["frames", "1001", "1000"]),
        (&pictures, &["frames", "75357100 nodes", "50000000"]),
        (&pairs, &["no_contact", "1001", "1000"]),
        (&choices, &["deformables[0]", "37678550", "20000000"]),
        (&probes, &["probes[5]", "samples", "20000000"]),
        (
            "(rigid: [(name: \"a\")], world: (duration: 100), probes: [(name: \"p\", of: Force(by: \"a\", axis: X), rate: 1e7)])",
            &["probes[0]", "1000000000 samples", "20000000"],
        ),
        (
            "(world: (duration: 1000, dt: 1e-3, history: 1, energy: 1, substeps: Fixed(10000)))",
            &["world", "10000000000 substeps", "100000000"],
        ),
        (
            "(world: (duration: 1000, dt: 1e-3, history: 1, energy: 1), deformables: [(name: \"a\", substeps: Unchecked(10000), body: Net(nodes: [(at: (0, 0, 0), mass: 1)]))])",
            &["deformables[0]", "10000000000 substeps", "100000000"],
        ),
        (
            "(world: (substeps: Auto(min_h: 0)))",
            &["min_h", "is 0", "1e-9"],
        ),
        (
            "(world: (substeps: Auto(min_h: 1e-12)))",
            &["min_h", "is 0.000000000001", "1e-9"],
        ),
        (
            "(world: (passes: 1001))",
            &["world.passes", "is 1001", "1000"],
        ),
        (
            "(deformables: [(name: \"a\", body: Filled(mesh: Hatchback, cell: 1e-3), material: Rubber)])",
            &["deformables[0]", "nodes", "1000000"],
        ),
        (
            "(deformables: [(name: \"a\", body: TetFilled(mesh: Ball(radius: 1), cell: 0.03, quadratic: true), solid: (young: 1, poisson: 0, density: 1))])",
            &["deformables[0]", "nodes", "1000000"],
        ),
    ]);
}

/// The time that mistakes take grows with the file, not with the square of it.
#[test]
fn many_mistakes_are_found_in_time() {
    let names: String = (0..20_000)
        .map(|i| format!("(name: \"body{i}\"),"))
        .collect();
    let joint = "(kind: Fixed, a: \"bodz\", b: \"bodz\"),".repeat(20_000);
    let joints = format!("(rigid: [{names}], joints: [{joint}])");
    let variables: String = (0..900).map(|i| format!("variable_{i}: {i},")).collect();
    let formula = "(\"varjable_1\", 0, 0),".repeat(50_000);
    let formulas = format!(
        "(variables: ({variables}), rigid: [(name: \"a\", colliders: [(shape: Hull(points: [{formula}]))])])"
    );
    for text in [joints, formulas] {
        let start = Instant::now();
        let shown = load(&text).unwrap_err();
        let took = start.elapsed();
        assert!(took < Duration::from_secs(2), "{took:?}");
        assert!(
            shown.lines().count() <= 101 && shown.contains("more"),
            "{shown}"
        );
    }
}

#[test]
fn includes_are_limited_in_number_and_bytes() {
    let folder = Folder::new("many-includes");
    let names = "\"none.ron\",".repeat(200);
    let scene = folder.put("a.ron", &format!("(include: [{names}])"));
    let error = Scenario::load(&scene, &LoadOptions::default()).unwrap_err();
    assert!(error.problems.len() <= 100, "{}", error.problems.len());
    let text = error.to_string();
    assert!(
        text.contains("a.ron:1:") && text.contains("200") && text.contains("64"),
        "{text}"
    );

    folder.put(
        "large.ron",
        &format!("(about: \"{}\")", "x".repeat(3 << 20)),
    );
    let scene = folder.put(
        "b.ron",
        "(include: [\"large.ron\", \"large.ron\", \"large.ron\"])",
    );
    let text = Scenario::load(&scene, &LoadOptions::default())
        .unwrap_err()
        .to_string();
    for part in ["b.ron:1:", "bytes", "8388608"] {
        assert!(text.contains(part), "{text}");
    }
    // An included file's own list is looked at as well.
    for (name, list) in [("c.ron", "3"), ("d.ron", "[3]")] {
        folder.put(name, &format!("(\n include: {list})"));
        let scene = folder.put("e.ron", &format!("(include: [\"{name}\"])"));
        let text = Scenario::load(&scene, &LoadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(
            text.contains(&format!("{name}:2:")) && text.contains("include"),
            "{text}"
        );
    }
}

#[test]
fn meshes_are_plain_files_of_a_limited_size() {
    let folder = Folder::new("meshes");
    std::fs::create_dir_all(folder.0.join("dir.obj")).unwrap();
    let large = std::fs::File::create(folder.0.join("large.obj")).unwrap();
    large.set_len(100 << 20).unwrap();
    for (name, what) in [
        ("dir.obj", "not a file"),
        ("large.obj", "104857600 bytes, at most 67108864"),
    ] {
        let scene = format!(
            "(rigid: [(name: \"a\", kind: Fixed, colliders: [(shape: TriMesh(\"{name}\"))])])"
        );
        let scene = folder.put("a.ron", &scene);
        let text = Scenario::load(&scene, &LoadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(text.contains("a.ron:1:") && text.contains(what), "{text}");
    }
}

/// What lies beside an allowed file may not lead elsewhere.
#[cfg(unix)]
#[test]
fn no_link_leads_out_of_the_folder() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new("links");
    let outside = folder.put("outside/secret.ele", "1 4 0\n1 1 2 3 4\n");
    folder.put("outside/secret.node", "4 3 0 0\n");
    let scenes = folder.0.join("scenes");
    folder.put(
        "scenes/good.node",
        "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n",
    );
    symlink(&outside, scenes.join("good.ele")).unwrap();
    // The link stays inside, but what is read beside its end does not.
    folder.put("scenes/inner.txt", "");
    symlink(scenes.join("inner.txt"), scenes.join("bad.node")).unwrap();
    folder.put("scenes/bad.ele", "1 4 0\n1 1 2 3 4\n");
    symlink(
        folder.0.join("outside/secret.node"),
        scenes.join("inner.node"),
    )
    .unwrap();
    for name in ["good.node", "bad.node"] {
        let scene = format!(
            "(deformables: [(name: \"a\", body: TetMesh(\"{name}\"), solid: (young: 1e6, poisson: 0, density: 1000))])"
        );
        let scene = folder.put("scenes/a.ron", &scene);
        let text = match Scenario::load(&scene, &LoadOptions::default()) {
            Ok(_) => panic!("{name} is read"),
            Err(error) => error.to_string(),
        };
        assert!(text.contains("a.ron:1:"), "{text}");
    }
}

/// Keys that would be passed over, and actions that nothing can take.
#[test]
fn what_would_be_passed_over_is_refused() {
    let net = "deformables: [(name: \"a\", body: Net(nodes: [(at: (0, 0, 0), mass: 1)]))]";
    let rigid = "rigid: [(name: \"r\", kind: KinematicPosition), (name: \"f\", kind: Fixed), (name: \"d\")]";
    let with = |more: &str| format!("({net}, {rigid}, {more})");
    let block = |more: &str| {
        format!(
            "(deformables: [(name: \"a\", body: Lattice(size: (1, 1, 1), cell: 0.5), material: Rubber, {more})])"
        )
    };
    let collider = |shape: &str| format!("(rigid: [(name: \"r\", colliders: [(shape: {shape})])])");
    refused(&[
        (
            &block("low: (None, 0, None), high: (0, 1, 0)"),
            &["deformables[0]", "`low`", "`high`"],
        ),
        (
            "(frames: [0, 2, 1], world: (duration: 3))",
            &["frames", "1"],
        ),
        ("(frames: [-1])", &["frames", "-1"]),
        (
            &with("actuators: [Force(on: \"f\")]"),
            &["actuators[0]", "dynamic"],
        ),
        (
            &with("actuators: [Force(on: \"d\", nodes: \"x > 0\")]"),
            &["actuators[0]", "whole"],
        ),
        (
            &with("actuators: [Force(on: \"a\", torque: (1, 0, 0))]"),
            &["actuators[0]", "torques"],
        ),
        (
            &with("actuators: [Move(of: \"d\")]"),
            &["actuators[0]", "KinematicPosition"],
        ),
        (
            &with("actuators: [Move(of: \"a\")]"),
            &["actuators[0]", "pinned"],
        ),
        (
            &with("actuators: [Move(of: \"r\"), Move(of: \"r\")]"),
            &["actuators[1]", "`r`"],
        ),
        (
            &with(
                "joints: [(name: \"j\", kind: Fixed, a: \"r\", b: \"d\")], actuators: [Drive(joint: \"j\", velocity: 1)]",
            ),
            &["actuators[0]", "motor"],
        ),
        (
            &with(
                "joints: [(name: \"j\", kind: Revolute((1, 0, 0)), a: \"r\", b: \"d\", motor: (damping: 1))], actuators: [Drive(joint: \"j\", velocity: 1), Drive(joint: \"j\", velocity: 2)]",
            ),
            &["actuators[1]", "`j`"],
        ),
        (
            &with("probes: [(name: \"p\", of: Position(of: \"d\", nodes: \"x > 0\", axis: X))]"),
            &["probes[0]", "deformable"],
        ),
        (
            &with(
                "expect: [(that: Final(Velocity(of: \"d\", nodes: \"x > 0\", axis: X)), at_most: 1)]",
            ),
            &["expect[0]", "deformable"],
        ),
        (
            &with("probes: [(name: \"p\", of: Stress(of: \"a\"))]"),
            &["probes[0]", "tets"],
        ),
        (
            &with("probes: [(name: \"p\", of: Position(of: \"a\", axis: X), cfc: Cfc180)]"),
            &["probes[0]", "CFC 180 needs"],
        ),
        (
            &with("probes: [(name: \"p\", of: Force(by: \"d\", axis: X), rate: 100, cfc: Cfc60)]"),
            &["probes[0]", "CFC 60 needs"],
        ),
        (
            &with("sets: [(name: \"a,b\", of: \"a\", nodes: \"x > 0\")]"),
            &["sets[0].name", "letters"],
        ),
        (
            "(soft_bodies: [(name: \"a b\", size: (1, 1, 1), cell: 1, young: 1, mass: 1)])",
            &["soft_bodies[0].name", "letters"],
        ),
        (
            &with("expect: [(that: StateHash, hash: \"12\")]"),
            &["expect[0]", "16"],
        ),
        (
            &with("expect: [(that: StateHash, hash: \"0123456789abcdeg\")]"),
            &["expect[0]", "16"],
        ),
        (
            "(rigid: [(name: \"r\", kind: Fixed, colliders: [(shape: HalfSpace(normal: (0, 0, 0)))])])",
            &["rigid[0].colliders[0]", "normal"],
        ),
        (
            &collider("Polyline(points: [(0, 0, 0)])"),
            &["rigid[0].colliders[0]", "two points"],
        ),
        (
            &collider("HeightField(heights: [[0, 1], [0]], size: (1, 1, 1))"),
            &["rigid[0].colliders[0]", "rows"],
        ),
        (
            &collider("Compound([(shape: Polyline(points: [(0, 0, 0), (1, 0, 0)]))])"),
            &["rigid[0].colliders[0]", "part of a compound"],
        ),
        (
            &collider("Voxels(size: (1, 1, 1), points: [(1e30, 0, 0)])"),
            &["rigid[0].colliders[0]", "1e6 m"],
        ),
        (
            &collider("Voxels(size: (1e-9, 1, 1), points: [(1e5, 0, 0)])"),
            &["rigid[0].colliders[0]", "voxel"],
        ),
        (
            &collider("HeightField(heights: [[0, 1], [0, 1e30]], size: (1, 1, 1))"),
            &["rigid[0].colliders[0]", "1e6 m"],
        ),
        (
            &collider("HalfSpace(normal: (0, 1, 0))"),
            &["rigid[0]", "half-space", "Fixed"],
        ),
        (
            &collider("Compound([(shape: HalfSpace(normal: (0, 1, 0)))])"),
            &["rigid[0]", "half-space", "Fixed"],
        ),
        (
            &with(
                "expect: [(that: Final(Position(of: \"a\", axis: X)), equals: 0, within_share: 0.1)]",
            ),
            &["expect[0]", "share of 0"],
        ),
        (
            &collider("Terrain(height: \"x\", size: (1e6, 1e6), cell: 0.1)"),
            &["rigid[0]", "points"],
        ),
    ]);
}

#[test]
fn regions_that_select_nothing_are_told() {
    for (more, what) in [
        ("pin: \"x > 9\"", "a pin"),
        ("parts: [(at: \"x > 9\", material: Rubber)]", "a part"),
    ] {
        let text = format!(
            "(deformables: [(name: \"a\", body: Lattice(size: (1, 1, 1), cell: 0.5), material: Rubber, {more})])"
        );
        let error = load(&text)
            .unwrap()
            .build()
            .err()
            .expect("it is built")
            .to_string();
        for part in [what, "x > 9", "`a`"] {
            assert!(error.contains(part), "{error}");
        }
    }
}

/// Points without a volume, surfaces without an inside: an error, not a panic.
#[test]
fn flat_hulls_and_flat_decompositions_are_errors() {
    let sheet = "(vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], triangles: [(0, 1, 2), (0, 2, 1)])";
    let thin = "(vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.3, 0.3, 1e-30)], triangles: [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])";
    let tiny = "(vertices: [(0, 0, 0), (1e-20, 0, 0), (0, 1e-20, 0), (0, 0, 1e-20)], triangles: [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])";
    let far = "(vertices: [(0, 0, 0), (1e30, 0, 0), (0, 1e30, 0), (0, 0, 1e30)], triangles: [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])";
    let mut shapes: Vec<String> = [sheet, thin, tiny, far]
        .iter()
        .map(|mesh| format!("Decomposition({mesh})"))
        .collect();
    for points in [
        "(0, 0, 0)",
        "(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0.3, 0.6, 0)",
        "(0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0)",
        "(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)",
        "(0, 0, 0), (1e-30, 0, 0), (0, 1e-30, 0), (0, 0, 1e-30)",
        "(0, 0, 0), (3e38, 0, 0), (0, 3e38, 0), (0, 0, 3e38)",
    ] {
        shapes.push(format!("Hull(points: [{points}])"));
        shapes.push(format!("Hull(points: [{points}], border: 0.1)"));
    }
    let mut refused = 0;
    for shape in &shapes {
        let text = format!("(rigid: [(name: \"r\", colliders: [(shape: {shape})])])");
        let built =
            load(&text).and_then(|scene| scene.build().map(|_| ()).map_err(|e| e.to_string()));
        match built {
            Err(what) => {
                refused += 1;
                let named = ["`r`", "rigid[0]"].iter().any(|r| what.contains(r));
                assert!(named, "{what}");
            }
            Ok(()) => println!("built: {shape}"),
        }
    }
    // Those that are far or tiny may do.
    assert!(refused >= 10, "{refused} of {}", shapes.len());
    let cube = "(vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], triangles: [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])";
    let text = format!("(rigid: [(name: \"r\", colliders: [(shape: Decomposition({cube}))])])");
    load(&text).unwrap().build().unwrap();
    let apart = "(rigid: [(name: \"r\", kind: Fixed, colliders: [(shape: Voxels(size: (1, 1, 1), points: [(0, 0, 0), (9e5, 9e5, 9e5)]))])])";
    load(apart).unwrap().build().unwrap();
    let steep = "(rigid: [(name: \"r\", colliders: [(shape: Terrain(height: \"1e30 * x\", size: (1, 1), cell: 0.5))])])";
    let steep = load(steep).unwrap().build().err().unwrap().to_string();
    assert!(steep.contains("1e6 m"), "{steep}");
}

/// What is written in one file holds wherever the other puts it.
#[test]
fn presets_variables_and_records_are_merged_by_what_they_mean() {
    let scene = load(
        "(materials: (soft: Rubber), deformables: [(name: \"a\", body: Lattice(size: (1, 1, 1), cell: 0.5), material: \"soft\")])",
    );
    scene.unwrap();
    // JSON has words in quotes only.
    let json = |materials: &str, name: &str| {
        let text = format!(
            "{{\"materials\": {{{materials}}}, \"deformables\": [{{\"name\": \"a\", \"material\": \"{name}\", \"body\": {{\"Lattice\": {{\"size\": [1, 1, 1], \"cell\": 0.5}}}}}}]}}"
        );
        let scene = Scenario::parse(&text, Path::new("a.json"), &LoadOptions::default());
        scene.map(|s| s.deformables[0].material.as_ref().unwrap().0.density)
    };
    assert_eq!(
        json("", "Rubber").unwrap(),
        f64::from(Material::rubber().density)
    );
    let own = "\"Rubber\": {\"young\": 1e6, \"density\": 7}";
    assert_eq!(json(own, "Rubber").unwrap(), 7.0);
    let unknown = json("", "Gum").unwrap_err().to_string();
    assert!(unknown.contains("PolypropyleneFoam"), "{unknown}");
    let folder = Folder::new("merged");
    folder.put(
        "part.ron",
        "(variables: (a: 1, b: \"2 * a\"), world: (duration: \"b\", passes: 7))",
    );
    let scene = folder.put(
        "whole.ron",
        "(include: [\"part.ron\"], variables: (c: 3, a: \"c\"), world: World(dt: 0.01))",
    );
    let scene = Scenario::load(&scene, &LoadOptions::default()).unwrap();
    assert_eq!((scene.variables["a"], scene.variables["b"]), (3.0, 6.0));
    assert_eq!(
        (scene.world.dt, scene.world.duration, scene.world.passes),
        (0.01, 6.0, 7)
    );
    // Nothing else is wrong with a circle.
    let circle = "(variables: (a: \"b\", b: \"a\"), world: (duration: \"a\"))";
    let circle = Scenario::parse(circle, Path::new("a.ron"), &LoadOptions::default());
    assert_eq!(circle.unwrap_err().problems.len(), 2);
    refused(&[
        (
            "(variables: (a: \"b + 1\", b: \"a\"), world: (duration: \"a\"))",
            &["variables.", "itself"],
        ),
        (
            "(variables: (a: \"a\"), world: (duration: \"a\"))",
            &["variables.a", "itself"],
        ),
    ]);
}

/// Who sweeps over a variable that changes nothing is told.
#[test]
fn a_variable_that_is_set_is_named_somewhere() {
    let text = "(about: \"of sped\", variables: (speed: 3, sped: 4), world: (duration: \"speed\"))";
    let with = |name: &str| {
        let set = LoadOptions {
            set: vec![(name.into(), 5.0)],
            ..LoadOptions::default()
        };
        Scenario::parse(text, Path::new("a.ron"), &set)
    };
    assert_eq!(with("speed").unwrap().world.duration, 5.0);
    let shown = with("sped").unwrap_err().to_string();
    assert!(
        shown.contains("a.ron:1:") && shown.contains("variables.sped"),
        "{shown}"
    );
}

/// Built-in scenes take any option or say why not.
#[test]
fn built_in_scenes_refuse_options_that_would_never_end() {
    for scene in crumple::scenario::all() {
        for (cell, dt, duration) in [
            (1e-12, scene.options.dt, scene.options.duration),
            (1e-300, scene.options.dt, scene.options.duration),
            (scene.options.cell, 1e-30, scene.options.duration),
            (scene.options.cell, 1e-7, 60.0),
        ] {
            let options = crumple::scenario::Options {
                dt,
                duration,
                cell,
                ..scene.options
            };
            let start = Instant::now();
            let built = scene.build(&options).map(|_| ());
            let took = start.elapsed();
            assert!(built.is_err(), "{}: cell {cell}, dt {dt}", scene.name);
            assert!(took < Duration::from_secs(5), "{}: {took:?}", scene.name);
        }
    }
}

/// A span of time that the run did not reach, for it was over before, is not measured.
#[test]
fn a_window_beyond_the_end_is_not_met() {
    let scene = load(
        "(world: (duration: 2, stop: AtRest(speed: 100, during: 1)), deformables: [(name: \"a\", body: Net(nodes: [(at: (0, 0, 0), mass: 1)]))],
          expect: [
              (that: Mean(Velocity(of: \"a\", axis: Y)), over: (0.5, 1), at_most: 0),
              (that: Mean(Velocity(of: \"a\", axis: Y)), over: (0.5, 2), at_most: 0),
          ])",
    );
    let outcome = scene.unwrap().run().unwrap();
    assert!(
        outcome.checks[0].passed && !outcome.checks[1].passed,
        "{outcome}"
    );
}
