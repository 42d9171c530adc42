//! The textbook's two pictures: a damped oscillator at h = 0.01 s by every scheme against the exact curve, and explicit
//! Euler exploding at h = 0.035 s, beyond its limit c/k = 0.03 s.
//!
//! `cargo run --release --features cli --example integrators [FOLDER]` writes `oscillator.png` and `explosion.png`.

use crumple::body::State;
use crumple::prelude::*;
use crumple::report::{Plot, Series, Stroke};
use crumple::solve::Solver;
use std::path::Path;

const MASS: f64 = 1.0;
const STIFFNESS: f64 = 100.0;
const DAMPING: f64 = 3.0;

/// Elongation over time of a mass on a damped spring, let go 1 m out of rest.
fn oscillate(integrator: Integrator, h: f64, duration: f64) -> (Vec<f64>, Vec<f64>) {
    // A long rest length keeps the spring from turning inside out.
    let rest = 50.0;
    let spring = Spring::new(0, 1, STIFFNESS as f32)
        .damping(DAMPING as f32)
        .rest_length(rest as f32);
    let mut state = State::<f64>::new(
        [
            ([0.0; 3], [0.0; 3], 0.0),
            ([rest + 1.0, 0.0, 0.0], [0.0; 3], 1.0 / MASS),
        ],
        [rest],
    );
    let mut solver = Solver::new(&[spring], &state);
    let (mut times, mut elongations) = (vec![0.0], vec![1.0]);
    while solver.time < duration {
        solver.substep(&mut state, integrator, h);
        times.push(solver.time);
        elongations.push(state.position(1).x - rest);
    }
    (times, elongations)
}

/// e^(−ct/2m)·(cos ω_d t + c/(2mω_d)·sin ω_d t).
fn exact(t: f64) -> f64 {
    let decay = DAMPING / (2.0 * MASS);
    let omega = (STIFFNESS / MASS - decay * decay).sqrt();
    (-decay * t).exp() * ((omega * t).cos() + decay / omega * (omega * t).sin())
}

fn curve(name: &str, (x, y): (Vec<f64>, Vec<f64>), style: Stroke) -> Series {
    Series {
        name: name.to_owned(),
        x,
        y,
        style,
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "out/integrators".into());
    draw(Path::new(&folder))?;
    println!("written to {folder}");
    Ok(())
}

/// Draws both pictures into a folder and checks what they show.
pub fn draw(folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    std::fs::create_dir_all(folder)?;

    let fine: Vec<f64> = (0..=2000).map(|i| f64::from(i) * 1e-3).collect();
    let truth = fine.iter().map(|&t| exact(t)).collect();
    let mut series = vec![curve("exact", (fine, truth), Stroke::Bold)];
    for integrator in Integrator::ALL {
        let (times, elongations) = oscillate(integrator, 0.01, 2.0);
        let worst = times
            .iter()
            .zip(&elongations)
            .map(|(t, x)| (x - exact(*t)).abs())
            .fold(0.0, f64::max);
        println!(
            "{:>17}: largest error {worst:.2e} m at h = 0.01 s",
            integrator.name()
        );
        // What each scheme promises here: order 1, 2 or 4.
        let promised = match integrator {
            Integrator::ExplicitEuler => 0.6,
            Integrator::SymplecticEuler => 0.1,
            Integrator::VelocityVerlet | Integrator::Midpoint => 0.02,
            _ => 1e-4,
        };
        assert!(
            worst < promised,
            "{} is off by {worst} m",
            integrator.name()
        );
        series.push(curve(integrator.name(), (times, elongations), Stroke::Bold));
    }
    Plot {
        title: "Damped oscillator, h = 0.01 s".into(),
        x_label: "time [s]".into(),
        y_label: "elongation [m]".into(),
        series,
        ..Plot::default()
    }
    .save_png(&folder.join("oscillator.png"))?;

    let grows = oscillate(Integrator::ExplicitEuler, 0.035, 10.0);
    let holds = oscillate(Integrator::SymplecticEuler, 0.035, 10.0);
    let last = grows.1.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    println!("explicit Euler at h = 0.035 s: up to {last:.1} m within 10 s");
    assert!(last > 8.0 && holds.1[holds.1.len() - 1].abs() < 0.01);
    Plot {
        title: "The same at h = 0.035 s, beyond explicit Euler's limit c/k = 0.03 s".into(),
        x_label: "time [s]".into(),
        y_label: "elongation [m]".into(),
        series: vec![
            curve("explicit Euler", grows, Stroke::Bold),
            curve("symplectic Euler", holds, Stroke::Bold),
        ],
        ..Plot::default()
    }
    .save_png(&folder.join("explosion.png"))?;
    Ok(())
}
