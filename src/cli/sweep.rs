//! `sweep` and `merge`: one scene with many values of its variables.

use super::{Failure, SceneArguments, progress};
use crumple::report::{Plot, Series as Curve, Stroke};
use crumple::scenario::file::sweep::{self, Merged, Pace, Sweep, SweepAxis};
use crumple::scenario::file::{LoadError, LoadOptions, Scenario, nearest_embedded};
use std::num::NonZero;
use std::ops::Range;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct SweepArguments {
    /// A scene file, or the name of a scene in one; see `crumple list`.
    name: String,
    /// Values of a variable: speed=5..30:26 are 26 from 5 to 30, angle=0,15,30 are these. May be given several times: then
    /// every combination is run.
    #[arg(long, required = true, value_name = "NAME=VALUES")]
    set: Vec<String>,
    /// Where to write; out/NAME_sweep by default.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Only these variants, counted from 0: 7, or 10..20 for 10 to 19. Nothing is merged then: `merge` does it once all
    /// are there.
    #[arg(long, value_name = "N", value_parser = numbers)]
    only: Option<Range<usize>>,
    /// Says how many variants there are, and runs none.
    #[arg(long)]
    count: bool,
    /// How many run at once; as many as there are cores by default.
    #[arg(long, value_name = "N")]
    jobs: Option<NonZero<usize>>,
    /// Another seed.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Files outside of the scene's folder may be read.
    #[arg(long)]
    allow_outside: bool,
    /// No plots.
    #[arg(long)]
    no_pictures: bool,
    /// No progress bar.
    #[arg(long)]
    quiet: bool,
}

/// One number, or a range without its end.
fn numbers(text: &str) -> Result<Range<usize>, String> {
    let number = |text: &str| text.parse::<usize>();
    let range = match text.split_once("..") {
        Some((from, to)) => number(from).and_then(|from| Ok(from..number(to)?)),
        None => number(text).map(|n| n..n.saturating_add(1)),
    };
    let range = range.ok().filter(|range| !range.is_empty());
    range.ok_or_else(|| "expected a number or FROM..TO".into())
}

#[derive(clap::Args)]
pub struct MergeArguments {
    /// Folders of one sweep.
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Where to write; the first folder by default.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// No plots.
    #[arg(long)]
    no_pictures: bool,
}

pub fn sweep(arguments: &SweepArguments) -> Result<(), Failure> {
    let scene = SceneArguments {
        name: arguments.name.clone(),
        set: Vec::new(),
        seed: arguments.seed,
        allow_outside: arguments.allow_outside,
    };
    if scene.load(&LoadOptions::default()).is_none() {
        let name = &scene.name;
        let near = nearest_embedded(name).map(|n| format!("; did you mean `{n}`?"));
        let near = near.unwrap_or_default();
        return Err(Failure::Wrong(format!(
            "there is no scene file `{name}`{near}"
        )));
    }
    let load = |options: &LoadOptions| -> Result<Scenario, LoadError> {
        match scene.load(options) {
            Some(loaded) => loaded,
            // Looked up above.
            None => Scenario::embedded(&scene.name, options),
        }
    };
    let axes = arguments.set.iter().map(|text| text.parse());
    let axes: Vec<SweepAxis> = axes.collect::<Result<_, _>>()?;
    let total = sweep::variants(&axes)?.len();
    if arguments.count {
        say_line!("{total}");
        return Ok(());
    }
    if let Some(only) = arguments.only.as_ref().filter(|only| only.end > total) {
        return Err(Failure::Wrong(format!(
            "there are {total} variants, from 0 on, and none of number {}",
            only.end - 1
        )));
    }
    let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
    let sweep = Sweep {
        load: &load,
        options: scene.options(),
        axes,
        jobs: arguments.jobs.map_or(cores, NonZero::get),
        only: arguments.only.clone(),
    };
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| Path::new("out").join(format!("{}_sweep", scene.stem())));
    let bar = progress(1, arguments.quiet, "variants");
    let pace = sweep.run(&out, |done, total| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    })?;
    bar.finish_and_clear();
    match arguments.only {
        None => finish(&[&out], &out, arguments.no_pictures, Some(pace)),
        // What others run is not missing.
        Some(_) => Ok(()),
    }
}

pub fn merge(arguments: &MergeArguments) -> Result<(), Failure> {
    let first = arguments.folders[0].clone();
    let out = arguments.out.clone().unwrap_or(first);
    finish(&arguments.folders, &out, arguments.no_pictures, None)
}

/// Merges, writes, draws, and says what there is. Exit code 1 if a variant failed or is missing.
fn finish(
    folders: &[impl AsRef<Path>],
    out: &Path,
    no_pictures: bool,
    pace: Option<Pace>,
) -> Result<(), Failure> {
    let merged = sweep::merge(folders)?;
    merged.write(out)?;
    if !no_pictures {
        draw(&merged, out)?;
    }
    say!("{}", table(&merged));
    let passed = merged.variants.iter().filter(|v| v["passed"] == true);
    let (passed, n) = (passed.count(), merged.variants.len());
    say!("{n} of {} variants, {passed} as expected", merged.total);
    if let Some(pace) = pace.filter(|p| p.busy_s > 0.0) {
        let (share, s) = (100.0 * pace.busy_share(), pace.wall_s);
        say!(
            "; {} at once, busy for {share:.1} % of {s:.1} s",
            pace.workers
        );
    }
    say_line!();
    say_line!("written to {}", out.display());
    match passed == merged.total {
        true => Ok(()),
        false => Err(Failure::Expectation),
    }
}

/// The merged table with its columns in line.
fn table(merged: &Merged) -> String {
    let cell = |text: &str| match text.parse::<f64>() {
        Ok(x) if text.len() > 8 => format!("{x:.4e}"),
        _ => text.to_owned(),
    };
    let csv = merged.csv();
    let rows: Vec<Vec<String>> = csv
        .lines()
        .map(|line| line.split(',').map(cell).collect())
        .collect();
    let columns = rows.first().map_or(0, Vec::len);
    let width = |i: usize| rows.iter().map(|r| r[i].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in &rows {
        let cells = row.iter().zip(&widths).map(|(c, w)| format!("{c:>w$}"));
        text += &cells.collect::<Vec<_>>().join("  ");
        text.push('\n');
    }
    text
}

/// Most curves of one plot.
const CURVES: usize = 9;

/// Every check over the variable with the most values, a curve for each combination of the others.
fn draw(merged: &Merged, out: &Path) -> Result<(), Failure> {
    let count = |name: &String| {
        let values = merged
            .variants
            .iter()
            .map(|v| Merged::value(v, name).to_bits());
        values.collect::<std::collections::BTreeSet<_>>().len()
    };
    let Some(along) = merged.variables.iter().max_by_key(|v| count(v)) else {
        return Ok(());
    };
    let rest = |variant| {
        let others = merged.variables.iter().filter(|v| *v != along);
        let words = others.map(|v| format!("{v} = {}", Merged::value(variant, v)));
        words.collect::<Vec<_>>().join(", ")
    };
    for (i, check) in merged.checks().iter().enumerate() {
        let mut series: Vec<Curve> = Vec::new();
        for variant in &merged.variants {
            let name = rest(variant);
            let known = series.iter().position(|s| s.name == name);
            let at = known.unwrap_or_else(|| {
                series.push(Curve {
                    name,
                    style: Stroke::Bold,
                    ..Curve::default()
                });
                series.len() - 1
            });
            series[at].x.push(Merged::value(variant, along));
            series[at].y.push(Merged::measured(variant, i));
        }
        series.truncate(CURVES);
        for s in &mut series {
            let mut points: Vec<(f64, f64)> =
                s.x.iter().copied().zip(s.y.iter().copied()).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            (s.x, s.y) = points.into_iter().unzip();
        }
        let plot = Plot {
            title: check.clone(),
            x_label: along.clone(),
            y_label: check.clone(),
            series,
            ..Plot::default()
        };
        plot.save_png(&out.join(format!("check_{}.png", i + 1)))?;
    }
    Ok(())
}
