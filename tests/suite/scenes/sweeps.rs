//! Sweeps: killed and begun again, run in pieces, on a cluster.

use super::files::{STONE, crumple, folder, text};
use crumple::scenario::file::sweep::{Log, Sweep, SweepError};
use crumple::scenario::file::{LoadOptions, Scenario};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

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
    // Digit for digit what the runs have written.
    let lines = std::fs::read_to_string(whole.join("merged.jsonl")).unwrap();
    for (row, line) in csv.lines().skip(1).zip(lines.lines()) {
        let mut measured = row.split(',').filter(|number| number.contains('.'));
        assert!(
            measured.all(|number| line.contains(number)),
            "{row} of {line}"
        );
    }

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

/// Variants that are run one by one, as a cluster does, come to what a sweep comes to.
#[test]
fn single_variants_of_a_sweep_are_merged() {
    let dir = folder("only");
    let file = dir.join("stone.ron");
    std::fs::write(&file, STONE).unwrap();
    let [whole, parts] = ["whole", "parts"].map(|f| dir.join(f));
    sweep(&file, &whole).status().unwrap();
    let part = |only: &str| {
        let out = parts.join(only);
        let output = sweep(&file, &out).args(["--only", only]).status();
        assert_eq!(output.unwrap().code(), Some(0), "{only}");
        out.to_str().unwrap().to_owned()
    };
    let folders = [part("3"), part("4..24"), part("0..5")];
    let folders = folders.iter().map(String::as_str);
    let out = dir.join("out");
    let first = ["merge", "--no-pictures", "--out", out.to_str().unwrap()];
    let all: Vec<&str> = first.into_iter().chain(folders).collect();
    crumple(&all);
    let [a, b] = [&whole, &out].map(|f| std::fs::read(f.join("merged.jsonl")).unwrap());
    assert!(!a.is_empty() && a == b);
    let name = file.to_str().unwrap();
    let count = crumple(&["sweep", name, "--set", "speed=1..8:8", "--count"]);
    assert_eq!(text(&count.stdout), "8\n");
    for (only, says) in [
        ("24", "24 variants"),
        ("3..3", "FROM..TO"),
        ("x", "FROM..TO"),
    ] {
        let out = parts.join("wrong");
        let mut command = sweep(&file, &out);
        let output = command
            .args(["--only", only])
            .stderr(Stdio::piped())
            .output();
        let output = output.unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(
            text(&output.stderr).contains(says),
            "{}",
            text(&output.stderr)
        );
    }
    std::fs::remove_dir_all(dir).unwrap();
}

/// The script for GNU parallel, with a job that is killed at work: every variant arrives.
#[cfg(unix)]
#[test]
fn a_job_that_is_killed_on_a_cluster_is_run_again() {
    use std::os::unix::fs::PermissionsExt;
    let tool = Command::new("parallel").arg("--version").output();
    if !tool.is_ok_and(|o| text(&o.stdout).contains("GNU parallel")) {
        println!("skipped: GNU parallel is not there");
        return;
    }
    let dir = folder("cluster");
    let file = dir.join("stone.ron");
    std::fs::write(
        &file,
        STONE.replace("duration: 1)", "duration: 1, dt: 2e-5)"),
    )
    .unwrap();
    let whole = dir.join("whole");
    sweep(&file, &whole).status().unwrap();
    // Kills the work of variant 2 once, and itself with it.
    let program = dir.join("program.sh");
    let script = format!(
        "#!/bin/sh\ncase \"$*\" in *'--only 2 '*) if mkdir '{dir}/killed' 2>/dev/null; then\n\
         '{real}' \"$@\" & sleep 0.03; kill -9 $!; kill -9 $$; fi;; esac\nexec '{real}' \"$@\"\n",
        dir = dir.display(),
        real = env!("CARGO_BIN_EXE_crumple"),
    );
    std::fs::write(&program, script).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let out = dir.join("out");
    let script = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/assets/cluster/sweep_parallel.sh"
    );
    let output = Command::new("sh")
        .arg(script)
        .args([&out, &file])
        .args(["--set", "speed=1..8:8", "--set", "floor=-100,-50,1"])
        .env("CRUMPLE", &program)
        .output()
        .unwrap();
    // As in the sweep, one floor is too high for all but the fastest stones.
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(dir.join("killed").is_dir(), "no job was killed");
    let jobs = std::fs::read_to_string(out.join("jobs.log")).unwrap();
    assert_eq!(jobs.lines().count(), 25, "{jobs}");
    let [a, b] = [&whole, &out].map(|f| std::fs::read(f.join("merged.jsonl")).unwrap());
    assert!(!a.is_empty() && a == b);
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
    let mut lines: Vec<&str> = lines.split_inclusive('\n').collect();
    // The workers may have finished in another order.
    lines.sort_by_key(|l| {
        let number = l.rsplit("\"variant\":").next().unwrap();
        number.trim_end_matches(['}', '\n']).parse::<u32>().unwrap()
    });
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

/// Two sweeps at once in one folder would write every line twice.
#[test]
fn a_folder_is_written_by_one_sweep_at_a_time() {
    let dir = folder("busy");
    let file = dir.join("stone.ron");
    std::fs::write(&file, STONE).unwrap();
    let out = dir.join("out");
    let identity = serde_json::json!({});
    let log = Log::open(&out, &identity).unwrap();
    assert!(matches!(
        Log::open(&out, &identity),
        Err(SweepError::Busy { .. })
    ));
    let run = || {
        let mut command = sweep(&file, &out);
        command.stderr(Stdio::piped()).output().unwrap()
    };
    let output = run();
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("by another sweep"));
    drop(log);
    std::fs::remove_file(out.join("sweep.json")).unwrap();
    assert_eq!(run().status.code(), Some(1));
    std::fs::remove_dir_all(dir).unwrap();
}

/// What a sweep is of: what is in the files it names, wherever they lie.
#[test]
fn a_sweep_knows_its_meshes_by_what_is_in_them() {
    let dir = folder("contents");
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n";
    let skin = "v 0 0 0\nv .4 0 0\nv 0 0 .4\nv 0 .4 0\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";
    let scene = r#"(
        variables: (height: 1), world: (duration: 0.1),
        rigid: [
            (name: "ground", kind: Fixed, colliders: [(shape: TriMesh("ground.obj"))]),
            (name: "ball", translation: (0, "height", 0), colliders: [(shape: Ball(0.1))]),
        ],
        deformables: [(
            name: "cube", translation: (0, 9, 0), solid: (young: 1e6, poisson: 0.3, density: 1e3),
            body: TetBox(size: (1, 1, 1), cell: 1), embed: "skin.obj",
        )],
        expect: [(name: "rests", that: RestTime(1e-9), at_most: 9)],
    )"#;
    let [one, two] = ["one", "two"].map(|name| dir.join(name));
    for place in [&one, &two] {
        std::fs::create_dir_all(place).unwrap();
        std::fs::write(place.join("scene.ron"), scene).unwrap();
        std::fs::write(place.join("ground.obj"), mesh).unwrap();
        std::fs::write(place.join("skin.obj"), skin).unwrap();
    }
    let run = |place: &Path, values: &str, out: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_crumple"));
        command.arg("sweep").arg(place.join("scene.ron"));
        command.args(["--set", values, "--quiet", "--no-pictures", "--out"]);
        command.arg(out).output().unwrap()
    };
    let out = dir.join("out");
    assert_eq!(run(&one, "height=1,2", &out).status.code(), Some(1));
    // The same files elsewhere are the same sweep.
    assert_eq!(run(&two, "height=1,2", &out).status.code(), Some(1));
    for (file, other) in [
        ("ground.obj", mesh.replace("v 1", "v 2")),
        ("skin.obj", skin.replace("v .4", "v .3")),
    ] {
        let kept = std::fs::read(two.join(file)).unwrap();
        std::fs::write(two.join(file), other).unwrap();
        let output = run(&two, "height=1,2", &out);
        assert_eq!(output.status.code(), Some(2), "{file}");
        assert!(text(&output.stderr).contains("another sweep"), "{file}");
        std::fs::write(two.join(file), kept).unwrap();
    }
    // A ball that falls never rests: inf is no number of JSON, and must not be lost.
    let csv = std::fs::read_to_string(out.join("merged.csv")).unwrap();
    assert!(csv.contains(",inf,0\n"), "{csv}");
    std::fs::remove_dir_all(dir).unwrap();
}

/// One variant that panics does not take the others with it.
#[test]
fn a_variant_that_panics_is_one_that_cant_be_run() {
    let dir = folder("panic");
    let load = |options: &LoadOptions| {
        let speed = options.set.last().unwrap().1;
        assert!(speed != 2.0, "of all speeds, 2");
        Scenario::parse(STONE, Path::new("stone.ron"), options)
    };
    let sweep = Sweep {
        load: &load,
        options: LoadOptions::default(),
        axes: vec!["speed=1,2,3".parse().unwrap()],
        jobs: 2,
        only: None,
    };
    let pace = sweep.run(&dir, |_, _| {}).unwrap();
    assert!(pace.workers == 2 && pace.busy_share() <= 1.0);
    let lines = std::fs::read_to_string(dir.join("results.jsonl")).unwrap();
    assert_eq!(lines.lines().count(), 3);
    assert!(
        lines.contains("panicked") && lines.contains("of all speeds, 2"),
        "{lines}"
    );
    std::fs::remove_dir_all(dir).unwrap();
}

/// How well a sweep of variants of a second and more keeps its workers at work.
#[test]
#[ignore = "long: two sweeps of eight variants"]
fn a_sweep_keeps_its_workers_busy() {
    let dir = folder("pace");
    let slow = STONE.replace("duration: 1)", "duration: 1, dt: 2e-6)");
    let slow = slow.replace("duration: 1,", "duration: 1, history: 1e-2, energy: 1e-2,");
    let load = |options: &LoadOptions| Scenario::parse(&slow, Path::new("stone.ron"), options);
    for jobs in [1, 2] {
        let sweep = Sweep {
            load: &load,
            options: LoadOptions::default(),
            axes: vec!["speed=1..8:8".parse().unwrap()],
            jobs,
            only: None,
        };
        let out = dir.join(jobs.to_string());
        let pace = sweep.run(&out, |_, _| {}).unwrap();
        let each = pace.busy_s / 8.0;
        println!(
            "{jobs} at once: {each:.2} s each, busy for {:.2} %",
            100.0 * pace.busy_share()
        );
        assert!(each >= 1.0, "{each} s is too short");
        assert!(pace.busy_share() >= 0.9, "{pace:?}");
    }
    std::fs::remove_dir_all(dir).unwrap();
}
