//! The command line: arguments → scenario → report. No physics here.
//!
//! Exit codes: 0 for a run that is written, 2 for anything the user can mend (an unknown scene, a bad option, a folder
//! that can't be written), with one clear line on stderr.

use clap::{Parser, Subcommand};
use crumple::record::{CsvError, FilterError, Interface};
use crumple::report::{ReportError, Stage, Table, charts, contact_sheet};
use crumple::scenario::{self, Figures, Options, Run, Scene, SceneError, UnknownScene};
use crumple::world::Deformable;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Crash scenes of deformable bodies in a Rapier world.
#[derive(Parser)]
#[command(version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Lists the scenes.
    List,
    /// Runs a scene and writes its channels, plots, pictures and figures.
    Run(RunArguments),
}

#[derive(clap::Args)]
#[command(allow_negative_numbers = true)]
struct RunArguments {
    /// Name of the scene; see `crumple list`.
    name: String,
    /// Where to write; out/NAME by default.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Step of the world.
    #[arg(long, value_name = "SECONDS")]
    dt: Option<f64>,
    /// Simulated time.
    #[arg(long, value_name = "SECONDS")]
    duration: Option<f64>,
    /// Fraction of the longest stable substep that is used, at most 1.
    #[arg(long, value_name = "FRACTION")]
    safety: Option<f64>,
    /// Cell of the lattices.
    #[arg(long, value_name = "METRES")]
    cell: Option<f64>,
    /// No pictures and no plots.
    #[arg(long)]
    no_pictures: bool,
    /// No progress bar.
    #[arg(long)]
    quiet: bool,
}

#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error(transparent)]
    Unknown(#[from] UnknownScene),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Csv(#[from] CsvError),
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error(transparent)]
    Filter(#[from] FilterError),
    #[error("can't write {}", path.display())]
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::List => {
            for scene in scenario::all() {
                println!("{:12} {}", scene.name, scene.about);
            }
            Ok(())
        }
        Command::Run(arguments) => run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {}", chain(&failure));
            ExitCode::from(2)
        }
    }
}

/// An error with its causes, in one line.
fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        let cause_text = cause.to_string();
        if !text.contains(&cause_text) {
            text = format!("{text}: {cause_text}");
        }
        source = cause.source();
    }
    text
}

fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let scene = scenario::find(&arguments.name)?;
    let usual = scene.options;
    let options = Options {
        dt: arguments.dt.unwrap_or(usual.dt),
        duration: arguments.duration.unwrap_or(usual.duration),
        safety: arguments.safety.unwrap_or(usual.safety),
        cell: arguments.cell.unwrap_or(usual.cell),
    };
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| Path::new("out").join(scene.name));
    let mut run = scene.build(&options)?;
    // Before the run: nobody wants to hear after it that there is nowhere to write to.
    make_writable(&out)?;
    let bar = progress(run.total_steps(), arguments.quiet);
    run.finish(|steps| bar.set_position(steps));
    bar.finish_and_clear();
    let figures = scene.figures(&run)?;
    write_channels(&run, &out)?;
    if !arguments.no_pictures {
        draw_plots(scene, &run, &out)?;
        draw_pictures(&run, &out)?;
    }
    write_summary(scene, &run, &figures, &out)?;
    let rows = figures.0.iter().map(|f| (f.label, f.value, f.unit));
    print!("{}", rows.collect::<Table>());
    println!("written to {}", out.display());
    Ok(())
}

fn progress(steps: u64, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(steps);
    let template = "{bar:40} {pos}/{len} steps, {eta} left";
    bar.set_style(
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    bar
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> Failure {
    let path = path.to_owned();
    move |source| Failure::Write { path, source }
}

fn make_writable(out: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(out).map_err(failed(out))?;
    let probe = out.join("summary.json");
    std::fs::write(&probe, "{}\n").map_err(failed(&probe))
}

fn write_channels(run: &Run, out: &Path) -> Result<(), Failure> {
    let name = |interface| match interface {
        Interface::Collider(c) => {
            let mut rigid = run.cast.rigid.iter();
            rigid.find(|r| r.2 == c).map(|r| r.0.clone())
        }
        Interface::Deformable(d) => {
            let mut all = run.cast.deformables.iter();
            all.find(|(_, h)| *h == d).map(|(n, _)| n.clone())
        }
        Interface::Attachment(a) => {
            let mut all = run.cast.attachments.iter();
            all.find(|(_, h)| *h == a).map(|(n, _)| n.clone())
        }
    };
    for (body, handle) in &run.cast.deformables {
        if let Some(record) = run.recorder.body(*handle) {
            record.write_forces(&out.join(format!("{body}_forces.csv")), name)?;
            record.write_energies(&out.join(format!("{body}_energies.csv")))?;
            let history = out.join(format!("{body}_history.csv"));
            run.recorder.write_history(record, &history)?;
        }
    }
    run.recorder.write_events(&out.join("events.csv"))?;
    Ok(())
}

fn draw_plots(scene: &Scene, run: &Run, out: &Path) -> Result<(), Failure> {
    if scene.name == scenario::wall::SCENE.name {
        let force = scenario::wall::wall_force(run)?;
        let plot = charts::filtered("Force of the wall on the car", "force [kN]", &force, 1.0e-3);
        plot?.save_png(&out.join("force.png"))?;
        let pulse = scenario::wall::cabin_deceleration(run)?;
        let plot = charts::filtered(
            "Deceleration of the cabin",
            "deceleration [g]",
            &pulse,
            1.0 / 9.80665,
        );
        plot?.save_png(&out.join("deceleration.png"))?;
    }
    if scene.name == scenario::pole::SCENE.name {
        let force = scenario::pole::pole_force(run)?;
        let plot = charts::filtered("Force of the pole on the car", "force [kN]", &force, 1.0e-3);
        plot?.save_png(&out.join("force.png"))?;
    }
    for (i, (name, handle)) in run.cast.deformables.iter().enumerate() {
        if let Some(record) = run.recorder.body(*handle) {
            let file = match i {
                0 => "energies.png".to_owned(),
                _ => format!("{name}_energies.png"),
            };
            charts::energies(&format!("Energies: {}", name.replace('_', " ")), record)
                .save_png(&out.join(file))?;
        }
    }
    Ok(())
}

fn draw_pictures(run: &Run, out: &Path) -> Result<(), Failure> {
    let mut stage = Stage::framing(&run.frames, run.view, [1000, 560]);
    stage.ground = run.cast.collider("ground");
    stage.parts = run.cast.parts.clone();
    let plastic = run.frames.iter().flat_map(|f| &f.bodies);
    let largest = plastic
        .flat_map(|b| &b.strain)
        .fold(0.0, |m: f32, s| m.max(*s));
    if largest == 0.0 {
        stage.max_strain = 0.0;
    }
    let solid = |(_, body): (_, &Deformable)| body.tet_count() > 0;
    if run.deformables.iter().any(solid) {
        stage.label = "von Mises stress over E";
        stage.max_strain = f64::from(largest);
    }
    let name = run.cast.deformables.first();
    let name = name.map_or("scene", |(n, _)| n.as_str());
    let name = if run.cast.deformables.len() > 1 {
        "scene"
    } else {
        name
    };
    let mut pictures = Vec::new();
    for frame in &run.frames {
        let picture = stage.draw(frame);
        let file = format!("{name}_{:03.0}ms.png", frame.time * 1.0e3);
        picture.save_png(&out.join(file))?;
        pictures.push(picture);
    }
    contact_sheet(&pictures, 2).save_png(&out.join(format!("{name}.png")))?;
    Ok(())
}

fn write_summary(scene: &Scene, run: &Run, f: &Figures, out: &Path) -> Result<(), Failure> {
    let mut summary = serde_json::Map::new();
    summary.insert("scene".into(), scene.name.into());
    for figure in &f.0 {
        let count = figure.unit.is_empty() && figure.value.fract() == 0.0;
        let value = match count && figure.value.abs() < 1.0e15 {
            true => (figure.value as i64).into(),
            false => figure.value.into(),
        };
        summary.insert(figure.key.into(), value);
    }
    let hash = format!("{:016x}", run.deformables.state_hash());
    summary.insert("state_hash".into(), hash.into());
    summary.insert("kernel".into(), "scalar".into());
    let path = out.join("summary.json");
    let text = serde_json::Value::Object(summary);
    std::fs::write(&path, format!("{text:#}\n")).map_err(failed(&path))
}
