//! A recording as CSV files, units in the headers.

use super::body::BodyRecord;
use super::channel::Interface;
use super::csv::{CsvError, write_csv};
use super::history::Moments;
use super::recorder::Recorder;
use super::stress::TetSet;
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

fn vectors(columns: &mut Columns, name: &str, unit: &str, values: &[crate::math::DVec3]) {
    for (k, axis) in AXES.iter().enumerate() {
        let along = values.iter().map(|v| v.to_array()[k]).collect();
        columns.push((format!("{name}_{axis}_{unit}"), along));
    }
}

fn moments(columns: &mut Columns, name: &str, m: &Moments) {
    vectors(columns, name, "m", &m.positions);
    vectors(columns, &format!("{name}_v"), "mps", &m.velocities);
}

fn stresses(columns: &mut Columns, set: &TetSet) {
    let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let all = || set.stresses.iter();
    let von_mises = all().map(|s| s.von_mises).collect();
    columns.push((format!("{}_von_mises_pa", set.name), von_mises));
    for (i, j) in entries {
        let axes = format!("{}{}", AXES[i], AXES[j]);
        let stress = all().map(|s| s.cauchy[i][j]).collect();
        columns.push((format!("{}_stress_{axes}_pa", set.name), stress));
        let strain = all().map(|s| s.strain[i][j]).collect();
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
    /// Writes the history of a deformable: centre of mass, bounds, and the node sets that belong to it.
    ///
    /// # Errors
    /// [`CsvError`].
    pub fn write_history(&self, body: &BodyRecord, path: &Path) -> Result<(), CsvError> {
        let mut columns: Columns = vec![("time_s".into(), body.center.times.clone())];
        moments(&mut columns, "com", &body.center);
        let momentum: Vec<_> = body
            .center
            .velocities
            .iter()
            .map(|v| *v * body.mass)
            .collect();
        vectors(&mut columns, "momentum", "ns", &momentum);
        for (k, name) in ["low", "high"].into_iter().enumerate() {
            let corner: Vec<_> = body.bounds.iter().map(|b| b[k]).collect();
            vectors(&mut columns, name, "m", &corner);
        }
        for set in &self.sets {
            // A set that was followed later has samples of its own times only.
            if set.deformable == body.deformable && set.history.times == body.center.times {
                moments(&mut columns, &set.name, &set.history);
            }
        }
        for set in &self.tet_sets {
            if set.deformable == body.deformable && set.times == body.center.times {
                stresses(&mut columns, set);
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
