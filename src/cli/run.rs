//! `run`: one scene, with everything that is written of it.

use super::write::{draw_energies, draw_pictures, write_channels};
use super::{Failure, SceneArguments, failed, make_writable, progress, scene};
use crumple::report::{Table, charts};
use crumple::scenario::file::LoadError;
use crumple::scenario::{self, Figures, Options, Run, Scene, UnknownScene};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct RunArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Where to write; out/NAME by default.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Step of the world, 1/60 s in most scenes.
    ///
    /// This option and the next three change a built-in scene; of a scene file they set the variable of that name, where it has one.
    #[arg(long, value_name = "SECONDS")]
    dt: Option<f64>,
    /// Simulated time, by default what the scene takes.
    #[arg(long, value_name = "SECONDS")]
    duration: Option<f64>,
    /// Fraction of the longest stable substep that is used, at most 1; 0.9 by default.
    #[arg(long, value_name = "FRACTION")]
    safety: Option<f64>,
    /// Cell of the lattices, by default that of the scene.
    #[arg(long, value_name = "METRES")]
    cell: Option<f64>,
    /// No pictures and no plots.
    #[arg(long)]
    pub no_pictures: bool,
    /// No progress bar.
    #[arg(long)]
    pub quiet: bool,
}

impl RunArguments {
    /// The options that scene files have as variables.
    fn as_variables(&self) -> Vec<(String, f64)> {
        let options = [
            ("dt", self.dt),
            ("duration", self.duration),
            ("safety", self.safety),
            ("cell", self.cell),
        ];
        let given = options
            .into_iter()
            .filter_map(|(n, x)| Some((n.into(), x?)));
        given.collect()
    }

    /// An error about a variable that was typed as an option, in the words of that.
    fn as_typed(&self, error: LoadError) -> Failure {
        let text = error.to_string();
        let named = |(name, _): &(String, f64)| text.contains(&format!("--set {name}:"));
        match self.as_variables().into_iter().find(named) {
            None => error.into(),
            Some((name, _)) => {
                let text = text.replace(&format!("--set {name}:"), &format!("--{name}:"));
                let what = "in a scene file the option sets the variable of its name";
                Failure::Wrong(format!("{}; {what}", text.trim_end()))
            }
        }
    }
}

/// Built-in scenes go by their names; a name with `--set` or `--seed`, and every path, is a scene file.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let name = &arguments.scene.name;
    let varied = !arguments.scene.set.is_empty() || arguments.scene.seed.is_some();
    if let (Ok(scene), false, false) = (scenario::find(name), arguments.scene.is_file(), varied) {
        return built_in(scene, arguments);
    }
    let mut options = arguments.scene.options();
    options.set.extend(arguments.as_variables());
    for (i, (name, _)) in options.set.iter().enumerate() {
        if options.set[..i].iter().any(|(other, _)| other == name) {
            let text = format!("the variable `{name}` is set twice");
            return Err(Failure::Wrong(text));
        }
    }
    match arguments.scene.load(&options) {
        Some(Ok(loaded)) => scene::run(&loaded, arguments),
        Some(Err(error)) => Err(arguments.as_typed(error)),
        None if Path::new(name).is_dir() => Err(Failure::Wrong(format!(
            "{name} is a folder: `crumple test {name}` runs all scene files in it, `run` one of them"
        ))),
        None => Err(unknown(name)),
    }
}

/// What to say of a name that no scene has: the nearest one, those of files included.
fn unknown(name: &str) -> Failure {
    let suggestion = scenario::find(name).err().and_then(|e| e.suggestion);
    match suggestion.or_else(|| scenario::file::nearest_embedded(name)) {
        None => {
            let built_in = scenario::all().iter().map(|s| s.name);
            let files = scenario::file::embedded_names();
            let files = files.filter(|f| scenario::find(f).is_err());
            let names: Vec<&str> = built_in.chain(files).collect();
            let names = names.join(", ");
            Failure::Wrong(format!("there is no scene `{name}`; there are: {names}"))
        }
        suggestion => Failure::Unknown(UnknownScene {
            name: name.into(),
            suggestion,
        }),
    }
}

fn built_in(scene: &Scene, arguments: &RunArguments) -> Result<(), Failure> {
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
    let bar = progress(run.total_steps(), arguments.quiet, "steps");
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
    say!("{}", rows.collect::<Table>());
    let (hash, kernel) = (run.deformables.state_hash(), run.deformables.params.kernel);
    say_line!("state {hash:016x}, kernel {}", kernel.name());
    say_line!("written to {}", out.display());
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
    draw_energies(run, out)
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
    let kernel = run.deformables.params.kernel.name();
    summary.insert("kernel".into(), kernel.into());
    let path = out.join("summary.json");
    let text = serde_json::Value::Object(summary);
    std::fs::write(&path, format!("{text:#}\n")).map_err(failed(&path))
}
