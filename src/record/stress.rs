//! The stress of a set of tets over time.

use crate::body::TetId;
use crate::solve::fem::Stress;
use crate::world::{Deformable, DeformableHandle};

/// Some tets of a deformable whose mean stress is followed.
#[derive(Clone, Debug, PartialEq)]
pub struct TetSet {
    /// A name for tables, without commas.
    pub name: String,
    /// The deformable.
    pub deformable: DeformableHandle,
    /// Its tets, and their volumes at rest \[m³\].
    pub tets: Vec<(TetId, f64)>,
    /// Time of each sample \[s\].
    pub times: Vec<f64>,
    /// Cauchy stress and Green strain, means by volume; the von Mises stress is the mean of the tets' own.
    pub stresses: Vec<Stress>,
}

impl TetSet {
    /// The tets of a body that exist.
    pub(super) fn new(
        name: String,
        deformable: DeformableHandle,
        body: &Deformable,
        tets: &[TetId],
    ) -> Self {
        let mesh = body.tet_mesh();
        let volumes: Vec<f64> = mesh.map_or_else(Vec::new, |m| m.corner_volumes().collect());
        let with_volume = |tet: &TetId| Some((*tet, *volumes.get(tet.index())?));
        Self {
            name,
            deformable,
            tets: tets.iter().filter_map(with_volume).collect(),
            times: Vec::new(),
            stresses: Vec::new(),
        }
    }

    pub(super) fn sample(&mut self, body: &Deformable, time: f64) {
        let whole: f64 = self.tets.iter().map(|(_, volume)| volume).sum();
        let mut mean = Stress {
            cauchy: [[0.0; 3]; 3],
            strain: [[0.0; 3]; 3],
            von_mises: 0.0,
        };
        for (tet, volume) in &self.tets {
            let Some(stress) = body.stress(*tet) else {
                continue;
            };
            let share = volume / whole;
            mean.von_mises += share * stress.von_mises;
            for i in 0..3 {
                for j in 0..3 {
                    mean.cauchy[i][j] += share * stress.cauchy[i][j];
                    mean.strain[i][j] += share * stress.strain[i][j];
                }
            }
        }
        self.times.push(time);
        self.stresses.push(mean);
    }
}
