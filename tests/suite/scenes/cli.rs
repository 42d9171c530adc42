//! The command line: what it writes, and how it fails.

use std::path::PathBuf;
use std::process::{Command, Output};

fn crumple(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_crumple"))
        .args(arguments)
        .output()
        .unwrap()
}

fn folder(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("crumple-{}-{name}", std::process::id()))
}

/// Runs and expects exit code 2, nothing on stdout and every part of a message on stderr.
#[track_caller]
fn fails(arguments: &[&str], parts: &[&str]) {
    let output = crumple(arguments);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert!(output.stdout.is_empty());
    for part in parts {
        assert!(stderr.contains(part), "{arguments:?}: {stderr}");
    }
}

#[test]
fn the_list_names_every_scene() {
    let output = crumple(&["list"]);
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    for scene in crumple::scenario::all() {
        assert!(text.contains(scene.name) && text.contains(scene.about));
    }
}

/// Symptom: `crumple list | head -1` ended in a panic.
#[test]
fn nobody_need_read_to_the_end() {
    use std::io::Read;
    let mut child = Command::new(env!("CARGO_BIN_EXE_crumple"))
        .arg("keys")
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut said = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    assert!(child.wait().unwrap().success() && said.is_empty(), "{said}");
}

#[test]
fn mistakes_are_named() {
    let options = ["run", "sliding_block", "--duration", "0.1"];
    fails(&options, &["--duration: there is no variable `duration`"]);
    fails(&["run", "wal"], &["`wal`", "did you mean `wall`?"]);
    fails(
        &["run", "aeroplane"],
        &["`aeroplane`", "wall", "drop", "damped_oscillator"],
    );
    fails(&["run"], &["<NAME>"]);
    fails(&["sweep", "sliding_block", "--jobs", "0"], &["0", "--jobs"]);
    fails(&["run", "wall", "--dt", "soon"], &["soon", "--dt"]);
    fails(&["run", "wall", "--dt=-1"], &["dt", "-1", "above 0"]);
    fails(&["run", "wall", "--dt", "NaN"], &["dt", "NaN"]);
    fails(&["run", "wall", "--safety", "2"], &["safety", "2"]);
    fails(&["run", "wall", "--cell", "0"], &["cell", "0"]);
    fails(&["run", "wall", "--fast"], &["--fast"]);
    let file = folder("file");
    std::fs::write(&file, "in the way").unwrap();
    let inside = file.join("out");
    let (file, inside) = (file.to_str().unwrap(), inside.to_str().unwrap());
    fails(&["run", "wall", "--out", inside], &["can't write", inside]);
    fails(&["run", "wall", "--out", file], &["can't write", file]);
    std::fs::remove_file(file).unwrap();
}

#[test]
fn the_speed_is_measured_and_written() {
    let file = folder("speed.json");
    let path = file.to_str().unwrap();
    let output = crumple(&["speed", "--tiny", "--json", path]);
    assert!(output.status.success());
    let table = String::from_utf8(output.stdout).unwrap();
    for part in [
        "scalar loop",
        "portable",
        "cloth",
        "block",
        "wall",
        "roofline",
    ] {
        assert!(table.contains(part), "{table}");
    }
    let text = std::fs::read_to_string(&file).unwrap();
    let speed: serde_json::Value = serde_json::from_str(&text).unwrap();
    for key in [
        "kernel_lattice_vs_scalar",
        "block10_vs_rapier",
        "roofline_share",
    ] {
        assert!(
            speed[key].as_f64().is_some_and(|r| r > 0.0),
            "{key}: {text}"
        );
    }
    assert!(speed["cpu"].is_string() && speed["kernel"].is_string());
    let inside = format!("{path}/none.json");
    std::fs::remove_file(&file).unwrap();
    fails(&["speed", "--json", &inside], &["can't write", &inside]);
}

#[test]
fn a_run_writes_everything() {
    let out = folder("wall");
    let output = crumple(&["run", "wall", "--out", out.to_str().unwrap()]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{stderr}");
    let table = String::from_utf8(output.stdout).unwrap();
    for line in ["crush", "restitution", "energy residual", "written to"] {
        assert!(table.contains(line), "{table}");
    }
    let text = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    for key in [
        "peak_force_n",
        "mean_force_n",
        "crush_m",
        "delta_v_mps",
        "restitution",
        "peak_decel_g",
        "mean_decel_g",
        "energy_residual",
        "momentum_closure",
        "max_penetration_m",
        "time_of_crush_s",
        "contact_end_s",
        "absorbed_j",
        "mass_kg",
        "nodes",
        "springs",
        "substeps",
        "spring_updates_per_second",
        "wall_s",
    ] {
        let value = summary[key].as_f64();
        assert!(value.is_some_and(f64::is_finite), "{key}: {text}");
    }
    let kernel = crumple::solve::Kernel::Auto.name();
    assert_eq!(summary["kernel"], kernel);
    assert_eq!(summary["scene"], "wall");
    assert_eq!(summary["state_hash"].as_str().unwrap().len(), 16);
    for name in [
        "force",
        "energies",
        "car",
        "car_000ms",
        "car_025ms",
        "car_150ms",
    ] {
        let png = std::fs::read(out.join(format!("{name}.png"))).unwrap();
        assert_eq!(&png[1..4], b"PNG", "{name}");
    }
    for (name, header) in [
        ("car_forces", "time_s,substep_s,"),
        ("car_energies", "time_s,kinetic_j,"),
        ("car_history", "time_s,com_x_m,"),
        ("events", "time_s,deformable,"),
    ] {
        let csv = std::fs::read_to_string(out.join(format!("{name}.csv"))).unwrap();
        assert!(csv.starts_with(header), "{name}");
        assert!(csv.lines().count() > 100, "{name}");
    }
    std::fs::remove_dir_all(out).unwrap();
}
