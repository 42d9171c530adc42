//! Accuracy over cost: the cantilever of the scene `cantilever` by a lattice of springs, linear tets, quadratic tets and
//! Rapier's soft body, each over finer and finer nodes. Error of the tip's deflection against beam theory, over milliseconds
//! per frame of 1/60 s. With the feature `native-fem` by Rapier's finite elements as well.
//!
//! `cargo run --release --features cli,native-fem --example accuracy [FOLDER]` writes `accuracy.png` and `accuracy.csv`.

#[cfg(feature = "native-fem")]
#[path = "../benches/solids/beam.rs"]
mod beam;

#[cfg(feature = "native-fem")]
use crumple::rapier3d::dynamics::SoftBodySolver;
use crumple::report::{Plot, Series, Stroke};
use crumple::scenario::{self, cantilever};
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

/// Distances of nodes \[m\]; quadratic tets are twice as long and have a node in the middle of each edge.
const CELLS: [f64; 4] = [0.1, 0.05, 0.04, 0.025];

/// What the legend calls them.
const NAMES: [&str; 4] = [
    "Rapier's soft body",
    "lattice of springs",
    "linear tets",
    "quadratic tets",
];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1);
    let folder = folder.unwrap_or_else(|| "out/accuracy".into());
    draw(Path::new(&folder), &CELLS)?;
    println!("written to {folder}");
    Ok(())
}

/// Error \[%\] and milliseconds per frame of a beam over nodes `cell` m apart.
type Run = Box<dyn Fn(f64) -> Result<(f64, f64), Box<dyn Error>>>;

/// All of them, with what the table and the legend call them.
fn runs() -> Vec<(&'static str, &'static str, Run)> {
    let scene = |path: &'static cantilever::Path| -> Run {
        Box::new(|cell| {
            let mut options = scenario::find("cantilever")?.options;
            options.cell = cell;
            let (tip, ms) = cantilever::alone(path.name, &options)?;
            Ok((100.0 * (tip / path.reference - 1.0).abs(), ms))
        })
    };
    let paths = cantilever::PATHS.iter().zip(NAMES);
    let runs = paths.map(|(p, name)| (p.name, name, scene(p)));
    #[cfg(feature = "native-fem")]
    let runs = runs.chain([finite_elements()]);
    runs.collect()
}

/// With so many iterations at the most that its linear systems are solved: the usual 20 leave errors of 88 % and more.
#[cfg(feature = "native-fem")]
fn finite_elements() -> (&'static str, &'static str, Run) {
    let run = |cell| {
        let (tip, ms) = beam::rapier(cell as f32, SoftBodySolver::Fem, 1000, 120);
        Ok((100.0 * (tip / beam::THEORY - 1.0).abs(), ms))
    };
    ("native_fem", "Rapier's finite elements", Box::new(run))
}

/// Runs all beams and draws the picture. Quadratic tets must be within 2 % of beam theory over any nodes.
pub fn draw(folder: &Path, cells: &[f64]) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    let mut table = String::from("path,cell_m,ms_per_frame,error_percent\n");
    let mut series = Vec::new();
    for (path, name, run) in runs() {
        let (mut costs, mut errors) = (Vec::new(), Vec::new());
        for &cell in cells {
            let (error, ms) = run(cell)?;
            writeln!(table, "{path},{cell},{ms:.4},{error:.4}")?;
            println!("{path:>10}, nodes {cell} m apart: {ms:8.3} ms, error {error:.2} %");
            if path == "quadratic" && error > 2.0 {
                return Err(format!("quadratic tets of {cell} m are {error:.2} % off").into());
            }
            costs.push(ms);
            errors.push(error);
        }
        series.push(Series {
            name: name.to_owned(),
            x: costs,
            y: errors,
            style: Stroke::Bold,
        });
    }
    std::fs::write(folder.join("accuracy.csv"), table)?;
    Plot {
        title: "a cantilever under its own weight".to_owned(),
        x_label: "ms per frame of 1/60 s".to_owned(),
        y_label: "error of the tip's deflection [%]".to_owned(),
        series,
        logarithmic: true,
    }
    .save_png(&folder.join("accuracy.png"))?;
    Ok(())
}
