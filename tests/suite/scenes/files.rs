//! The commands for scene files.

use crumple::scenario::file::{LoadOptions, Scenario, embedded_names, reference, scenes_in};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn crumple(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_crumple"))
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A new folder for one test.
fn folder(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("crumple-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

const CATALOG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenes");

/// A stone that is thrown up; `floor` says how low it may get.
const STONE: &str = r#"(
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
        let start = Instant::now();
        assert_eq!(embedded, Scenario::load(path, &options).unwrap(), "{name}");
        assert!(
            start.elapsed() < Duration::from_millis(50),
            "{name}: {:?}",
            start.elapsed()
        );
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

fn sweep(file: &Path, out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_crumple"));
    command.arg("sweep").arg(file).arg("--out").arg(out);
    command.args([
        "--set",
        "speed=1..8:8",
        "--set",
        "floor=-100,-50,1",
        "--quiet",
        "--no-pictures",
    ]);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// Killed at any moment and begun again, a sweep comes to the same results, byte for byte.
#[test]
fn a_killed_sweep_goes_on_where_it_was() {
    let dir = folder("sweep");
    let file = dir.join("stone.ron");
    // Slow enough that a kill meets it at work.
    std::fs::write(
        &file,
        STONE.replace("duration: 1)", "duration: 1, dt: 1e-4)"),
    )
    .unwrap();
    let [whole, killed] = ["whole", "killed"].map(|f| dir.join(f));
    let status = sweep(&file, &whole).status().unwrap();
    // One of the floors is too high for all but the fastest stones.
    assert_eq!(status.code(), Some(1));
    let log = killed.join("results.jsonl");
    let mut interrupted = 0;
    for wait in [5, 60, 120, 200, 350] {
        let mut child = sweep(&file, &killed).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(wait));
        child.kill().unwrap();
        child.wait().unwrap();
        // As if it was killed in the middle of a line.
        if let Ok(text) = std::fs::read_to_string(&log) {
            interrupted += usize::from(text.lines().count() < 24);
            std::fs::write(&log, text + "{\"variant\": 3, \"se").unwrap();
        }
    }
    assert!(interrupted > 0, "no kill met the sweep at work");
    sweep(&file, &killed).status().unwrap();
    for name in ["merged.jsonl", "merged.csv"] {
        let [a, b] = [&whole, &killed].map(|f| std::fs::read(f.join(name)).unwrap());
        assert!(!a.is_empty() && a == b, "{name}");
    }
    let csv = std::fs::read_to_string(whole.join("merged.csv")).unwrap();
    assert!(
        csv.starts_with("variant,speed,floor,top,end,passed\n0,1,-100,0.0"),
        "{csv}"
    );
    assert_eq!(csv.lines().count(), 25);

    // Another sweep does not go into the same folder.
    let output = Command::new(env!("CARGO_BIN_EXE_crumple"))
        .arg("sweep")
        .arg(&file)
        .arg("--out")
        .arg(&whole)
        .args(["--set", "speed=1,2", "--quiet"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("another sweep"));
    std::fs::remove_dir_all(dir).unwrap();
}

/// Halves of a sweep from two folders make the whole.
#[test]
fn folders_of_one_sweep_are_merged() {
    let dir = folder("merge");
    let file = dir.join("stone.ron");
    std::fs::write(&file, STONE).unwrap();
    let [whole, one, two] = ["whole", "one", "two"].map(|f| dir.join(f));
    sweep(&file, &whole).status().unwrap();
    let lines = std::fs::read_to_string(whole.join("results.jsonl")).unwrap();
    let lines: Vec<&str> = lines.split_inclusive('\n').collect();
    for (part, range) in [(&one, 0..15), (&two, 10..24)] {
        std::fs::create_dir_all(part).unwrap();
        std::fs::copy(whole.join("sweep.json"), part.join("sweep.json")).unwrap();
        std::fs::write(part.join("results.jsonl"), lines[range].concat()).unwrap();
    }
    let merge = |folders: &[&PathBuf]| {
        let folders: Vec<&str> = folders.iter().map(|f| f.to_str().unwrap()).collect();
        let out = dir.join("out");
        let mut arguments = vec!["merge", "--no-pictures", "--out", out.to_str().unwrap()];
        arguments.extend(folders);
        crumple(&arguments)
    };
    let output = merge(&[&two]);
    assert!(
        text(&output.stdout).contains("14 of 24 variants"),
        "{}",
        text(&output.stdout)
    );
    merge(&[&two, &one]);
    let [a, b] = [&whole, &dir.join("out")].map(|f| std::fs::read(f.join("merged.jsonl")).unwrap());
    assert_eq!(a, b);
    let wrong = lines[3].replace("\"speed\":", "\"sped\":");
    std::fs::write(two.join("results.jsonl"), wrong).unwrap();
    let output = merge(&[&one, &two]);
    assert!(
        text(&output.stderr).contains("variant 3"),
        "{}",
        text(&output.stderr)
    );
    assert_eq!(merge(&[&dir]).status.code(), Some(2));
    std::fs::remove_dir_all(dir).unwrap();
}
