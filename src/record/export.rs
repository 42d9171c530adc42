//! A recording as CSV files, units in the headers.

use super::body::BodyRecord;
use super::channel::Interface;
use super::csv::{CsvError, write_csv};
use super::history::Moments;
use super::recorder::Recorder;
use super::stress::TetSet;
use crate::math::DVec3;
use crate::solve::fem::Stress;
use crate::world::SpringEventKind;
use std::path::Path;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Columns that own their headers and values.
type Columns = Vec<(String, Vec<f64>)>;

fn write(path: &Path, columns: &Columns) -> Result<(), CsvError> {
    let borrowed: Vec<(&str, &[f64])> = columns
        .iter()
        .map(|(h, v)| (h.as_str(), v.as_slice()))
        .collect();
    write_csv(path, &borrowed)
}

fn vectors(columns: &mut Columns, name: &str, unit: &str, values: &[DVec3]) {
    for (k, axis) in AXES.iter().enumerate() {
        let along = values.iter().map(|v| v.to_array()[k]).collect();
        columns.push((format!("{name}_{axis}_{unit}"), along));
    }
}

/// Which sample belongs to each row of a table, if any does; the times of both ascend.
fn samples(rows: &[f64], times: &[f64]) -> Vec<Option<usize>> {
    let mut next = 0;
    let of = |row: &f64| {
        next += times[next..].iter().take_while(|t| *t < row).count();
        (times.get(next) == Some(row)).then_some(next)
    };
    rows.iter().map(of).collect()
}

fn moments(columns: &mut Columns, name: &str, m: &Moments, rows: &[f64]) {
    let samples = samples(rows, &m.times);
    for (name, unit, values) in [
        (name.to_owned(), "m", &m.positions),
        (format!("{name}_v"), "mps", &m.velocities),
    ] {
        let at = |i: &Option<usize>| i.map_or(DVec3::NAN, |i| values[i]);
        let column: Vec<DVec3> = samples.iter().map(at).collect();
        vectors(columns, &name, unit, &column);
    }
}

fn stresses(columns: &mut Columns, set: &TetSet, rows: &[f64]) {
    let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let samples = samples(rows, &set.times);
    let all = |of: &dyn Fn(&Stress) -> f64| {
        let at = |i: &Option<usize>| i.map_or(f64::NAN, |i| of(&set.stresses[i]));
        samples.iter().map(at).collect()
    };
    columns.push((format!("{}_von_mises_pa", set.name), all(&|s| s.von_mises)));
    for (i, j) in entries {
        let axes = format!("{}{}", AXES[i], AXES[j]);
        let stress = all(&|s| s.cauchy[i][j]);
        columns.push((format!("{}_stress_{axes}_pa", set.name), stress));
        let strain = all(&|s| s.strain[i][j]);
        columns.push((format!("{}_strain_{axes}", set.name), strain));
    }
}

impl BodyRecord {
    /// Writes the contact and attachment forces of every substep: its end, its length and the mean force within it.
    /// `name` gives an interface its column; those without a name are left out.
    ///
    /// # Errors
    /// [`CsvError`].
    pub fn write_forces(
        &self,
        path: &Path,
        name: impl Fn(Interface) -> Option<String>,
    ) -> Result<(), CsvError> {
        let lengths: Vec<f64> = self.edges.windows(2).map(|t| t[1] - t[0]).collect();
        let mut columns: Columns = vec![
            (
                "time_s".into(),
                self.edges.iter().skip(1).copied().collect(),
            ),
            ("substep_s".into(), lengths.clone()),
        ];
        for channel in &self.channels {
            let Some(name) = name(channel.interface) else {
                continue;
            };
            let forces: Vec<_> = lengths
                .iter()
                .enumerate()
                .map(|(i, h)| channel.impulses.get(i).copied().unwrap_or_default() / *h)
                .collect();
            vectors(&mut columns, &name, "n", &forces);
        }
        write(path, &columns)
    }

    /// Writes the energies and the ledger's residual.
    ///
    /// # Errors
    /// [`CsvError`].
    pub fn write_energies(&self, path: &Path) -> Result<(), CsvError> {
        let mut columns: Columns = vec![(
            "time_s".into(),
            self.ledger.iter().map(|s| s.time).collect(),
        )];
        for (name, values) in self.energy_lines() {
            columns.push((format!("{}_j", name.replace(' ', "_")), values));
        }
        let residuals = self.ledger.iter().map(|s| s.residual).collect();
        columns.push(("residual_fraction".into(), residuals));
        write(path, &columns)
    }

    /// Every energy and work term by its name, one value per sample of the ledger \[J\].
    pub fn energy_lines(&self) -> Vec<(&'static str, Vec<f64>)> {
        type Term = fn(&crate::world::Energies) -> f64;
        let terms: [(&'static str, Term); 12] = [
            ("kinetic", |e| e.kinetic),
            ("elastic", |e| e.elastic),
            ("plastic", |e| e.work.plastic),
            ("damping", |e| e.work.damping),
            ("fracture", |e| e.work.fracture),
            ("contact normal", |e| e.work.contact_normal),
            ("contact friction", |e| e.work.contact_friction),
            ("gravity", |e| e.gravity),
            ("external work", |e| e.work.external),
            ("rigid work", |e| e.work.rigid),
            ("push out", |e| e.work.push_out),
            ("balance", |e| e.balance()),
        ];
        terms
            .into_iter()
            .map(|(name, of)| (name, self.ledger.iter().map(|s| of(&s.energies)).collect()))
            .collect()
    }
}

impl Recorder {
    /// Writes the history of a deformable: centre of mass, momentum, bounds, and the sets of nodes and tets that belong to it. A set that was
    /// followed later has no values (`NaN`) before.
    ///
    /// # Errors
    /// [`CsvError`].
    pub fn write_history(&self, body: &BodyRecord, path: &Path) -> Result<(), CsvError> {
        let times = &body.center.times;
        let mut columns: Columns = vec![("time_s".into(), times.clone())];
        moments(&mut columns, "com", &body.center, times);
        vectors(&mut columns, "momentum", "ns", &body.momenta);
        for (k, name) in ["low", "high"].into_iter().enumerate() {
            let corner: Vec<_> = body.bounds.iter().map(|b| b[k]).collect();
            vectors(&mut columns, name, "m", &corner);
        }
        for set in &self.sets {
            if set.deformable == body.deformable {
                moments(&mut columns, &set.name, &set.history, times);
            }
        }
        for set in &self.tet_sets {
            if set.deformable == body.deformable {
                stresses(&mut columns, set, times);
            }
        }
        write(path, &columns)
    }

    /// Writes the kept events; `broke` is 1 for a spring that broke and 0 for one that began to yield.
    ///
    /// # Errors
    /// [`CsvError`].
    pub fn write_events(&self, path: &Path) -> Result<(), CsvError> {
        let column = |name: &str, of: &dyn Fn(&crate::world::SpringEvent) -> f64| {
            (name.to_owned(), self.events.iter().map(of).collect())
        };
        let body = |e: &crate::world::SpringEvent| {
            self.bodies
                .iter()
                .position(|b| b.deformable == e.deformable)
                .map_or(-1.0, |i| i as f64)
        };
        let columns: Columns = vec![
            column("time_s", &|e| e.time),
            column("deformable", &body),
            column("spring", &|e| f64::from(e.spring.0)),
            column("broke", &|e| {
                f64::from(u8::from(e.kind == SpringEventKind::Broke))
            }),
            column("x_m", &|e| e.position.x),
            column("y_m", &|e| e.position.y),
            column("z_m", &|e| e.position.z),
            column("force_n", &|e| e.force),
            column("energy_j", &|e| e.energy),
        ];
        write(path, &columns)
    }
}
