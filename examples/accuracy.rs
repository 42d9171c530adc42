//! Accuracy over cost: the cantilever of the scene `cantilever` by a lattice of springs, linear tets, quadratic tets and
//! Rapier's soft body, each over finer and finer nodes. Error of the tip's deflection against beam theory, over milliseconds
//! per frame of 1/60 s.
//!
//! `cargo run --release --features cli --example accuracy [FOLDER]` writes `accuracy.png` and `accuracy.csv`.

use crumple::report::{Plot, Series, Stroke};
use crumple::scenario::{self, cantilever};
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

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1);
    let folder = folder.unwrap_or_else(|| "out/accuracy".into());
    draw(Path::new(&folder), &CELLS)?;
    println!("written to {folder}");
    Ok(())
}

/// Runs all beams and draws the picture. Quadratic tets must be within 2 % of beam theory over any nodes.
pub fn draw(folder: &Path, cells: &[f64]) -> Result<(), Box<dyn std::error::Error>> {
    std::fs::create_dir_all(folder)?;
    let mut table = String::from("path,cell_m,ms_per_frame,error_percent\n");
    let mut series = Vec::new();
    for (path, name) in cantilever::PATHS.iter().zip(NAMES) {
        let (mut costs, mut errors) = (Vec::new(), Vec::new());
        for &cell in cells {
            let mut options = scenario::find("cantilever")?.options;
            options.cell = cell;
            let (tip, ms) = cantilever::alone(path.name, &options)?;
            let error = 100.0 * (tip / path.reference - 1.0).abs();
            writeln!(table, "{},{cell},{ms:.4},{error:.4}", path.name)?;
            println!(
                "{:>9}, nodes {cell} m apart: {ms:8.3} ms, error {error:.2} %",
                path.name
            );
            if path.name == "quadratic" && error > 2.0 {
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
