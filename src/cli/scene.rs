//! `run` of a scene file: probes and expectations beside what is written of any run.

use super::run::RunArguments;
use super::write::{draw_energies, draw_pictures, write_channels};
use super::{Failure, failed, make_writable, progress};
use crumple::record::write_csv;
use crumple::report::{Plot, Series as Curve, Stroke};
use crumple::scenario::file::sweep::number;
use crumple::scenario::file::{Outcome, Scenario};
use serde_json::{Value, json};
use std::path::Path;

pub fn run(scene: &Scenario, arguments: &RunArguments) -> Result<(), Failure> {
    let name = arguments.scene.stem();
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| Path::new("out").join(name));
    let mut run = scene.start()?;
    make_writable(&out)?;
    let bar = progress(run.run.total_steps(), arguments.quiet, "steps");
    run.finish(|steps| bar.set_position(steps));
    bar.finish_and_clear();
    let outcome = run.outcome()?;
    write_channels(&outcome.run.run, &out)?;
    write_probes(&outcome, &out)?;
    if !arguments.no_pictures {
        draw_probes(&outcome, &out)?;
        draw_energies(&outcome.run.run, &out)?;
        draw_pictures(&outcome.run.run, &out)?;
    }
    write_summary(name, &outcome, &out)?;
    say!("{outcome}");
    if outcome.checks.is_empty() {
        say_line!("the scene expects nothing: nothing was checked");
    }
    say_line!("state {}, kernel {}", outcome.state_hash, outcome.kernel);
    say_line!("written to {}", out.display());
    match outcome.passed() {
        true => Ok(()),
        false => Err(Failure::Expectation),
    }
}

fn write_probes(outcome: &Outcome, out: &Path) -> Result<(), Failure> {
    for (name, series) in &outcome.probes {
        let path = out.join(format!("probe_{name}.csv"));
        write_csv(&path, &[("time_s", &series.times), (name, &series.values)])?;
    }
    Ok(())
}

fn draw_probes(outcome: &Outcome, out: &Path) -> Result<(), Failure> {
    let probes = &outcome.run.scenario.probes;
    for (name, series) in &outcome.probes {
        let title = name.replace('_', " ");
        // A factor may be there for another unit.
        let unscaled = probes.iter().find(|p| p.name == *name && p.scale == 1.0);
        let y_label = match unscaled.and_then(|p| p.of.unit()) {
            Some(unit) => format!("{title} [{unit}]"),
            None => title.clone(),
        };
        let plot = Plot {
            title,
            x_label: "time [s]".into(),
            y_label,
            series: vec![Curve {
                name: String::new(),
                x: series.times.clone(),
                y: series.values.clone(),
                style: Stroke::Bold,
            }],
            ..Plot::default()
        };
        plot.save_png(&out.join(format!("probe_{name}.png")))?;
    }
    Ok(())
}

fn write_summary(name: &str, outcome: &Outcome, out: &Path) -> Result<(), Failure> {
    let checks = outcome.checks.iter().map(|c| {
        json!({
            "name": c.name, "measured": number(c.measured), "bound": c.bound, "time_s": c.time,
            "passed": c.passed,
        })
    });
    let checks: Vec<Value> = checks.collect();
    let run = &outcome.run.run;
    let summary = json!({
        "scene": name,
        "variables": outcome.run.scenario.variables,
        "seed": outcome.run.scenario.world.seed,
        "passed": outcome.passed(),
        "checks": checks,
        "steps": run.steps,
        "substeps": run.substeps,
        "simulated_s": run.deformables.time(),
        "wall_s": run.wall_s,
        "state_hash": outcome.state_hash,
        "kernel": outcome.kernel,
    });
    let path = out.join("summary.json");
    std::fs::write(&path, format!("{summary:#}\n")).map_err(failed(&path))
}
