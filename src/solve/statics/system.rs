//! The linear system of a Newton step.

use super::error::StaticError;
use super::structure::Structure;
use crate::math::DVec3;
use faer::linalg::solvers::Solve;
use faer::prelude::Reborrow;
use faer::sparse::linalg::LltError;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat};
use faer::{Mat, Side};

/// A coordinate that is no unknown.
const FIXED: u32 = u32::MAX;

/// The pattern of the tangent, its order of elimination and its values.
pub(super) struct System {
    /// Unknown of each coordinate, or [`FIXED`].
    unknown: Vec<[u32; 3]>,
    count: usize,
    pattern: SymbolicSparseColMat<usize>,
    order: Argsort<usize>,
    symbolic: SymbolicLlt<usize>,
    values: Vec<f64>,
    /// Diagonal of the tangent.
    diagonal: Vec<f64>,
}

impl System {
    /// The system of the coordinates that are not fixed.
    pub fn new(
        structure: &impl Structure,
        positions: &[DVec3],
        fixed: &[[bool; 3]],
    ) -> Result<Self, StaticError> {
        let mut count = 0;
        let unknown: Vec<[u32; 3]> = fixed
            .iter()
            .map(|axes| {
                axes.map(|fixed| {
                    if fixed {
                        FIXED
                    } else {
                        count += 1;
                        count - 1
                    }
                })
            })
            .collect();
        let count = count as usize;
        let mut pairs = Vec::new();
        each_entry(structure, positions, &unknown, |row, col, _| {
            pairs.push(Pair { row, col });
        });
        pairs.extend((0..count).map(|i| Pair { row: i, col: i }));
        let failed = |reason: String| StaticError::Solver {
            unknowns: count,
            reason,
        };
        let (pattern, order) = SymbolicSparseColMat::try_new_from_indices(count, count, &pairs)
            .map_err(|e| failed(format!("{e:?}")))?;
        let symbolic = SymbolicLlt::try_new(pattern.rb(), Side::Lower)
            .map_err(|e| failed(format!("{e:?}")))?;
        Ok(Self {
            unknown,
            count,
            pattern,
            order,
            symbolic,
            values: Vec::with_capacity(pairs.len()),
            diagonal: vec![0.0; count],
        })
    }

    /// Takes the tangent at positions. Returns the largest entry of its diagonal \[N/m\].
    pub fn assemble(&mut self, structure: &impl Structure, positions: &[DVec3]) -> f64 {
        let (values, diagonal) = (&mut self.values, &mut self.diagonal);
        values.clear();
        diagonal.fill(0.0);
        each_entry(structure, positions, &self.unknown, |row, col, value| {
            values.push(value);
            if row == col {
                diagonal[row] += value;
            }
        });
        diagonal.iter().fold(0.0, |m, d| d.abs().max(m))
    }

    /// Solves (K + shift·I)·d = r for the unknowns, d in the place of r; the fixed coordinates of d are zero. Whether the
    /// matrix is positive definite.
    pub fn solve(&mut self, shift: f64, r: &mut [DVec3]) -> Result<bool, StaticError> {
        let failed = |reason: String| StaticError::Solver {
            unknowns: self.count,
            reason,
        };
        let entries = self.values.len();
        self.values.resize(entries + self.count, shift);
        let matrix =
            SparseColMat::new_from_argsort(self.pattern.clone(), &self.order, &self.values)
                .map_err(|e| failed(format!("{e:?}")))?;
        self.values.truncate(entries);
        let factors =
            match Llt::try_new_with_symbolic(self.symbolic.clone(), matrix.rb(), Side::Lower) {
                Ok(factors) => factors,
                Err(LltError::Numeric(_)) => return Ok(false),
                Err(LltError::Generic(e)) => return Err(failed(format!("{e:?}"))),
            };
        let mut right = Mat::zeros(self.count, 1);
        for (v, unknown) in r.iter().zip(&self.unknown) {
            for (axis, &u) in unknown.iter().enumerate().filter(|(_, u)| **u != FIXED) {
                right[(u as usize, 0)] = v[axis];
            }
        }
        let found = factors.solve(&right);
        let mut finite = true;
        for (v, unknown) in r.iter_mut().zip(&self.unknown) {
            *v = DVec3::ZERO;
            for (axis, &u) in unknown.iter().enumerate().filter(|(_, u)| **u != FIXED) {
                v[axis] = found[(u as usize, 0)];
            }
            finite &= v.is_finite();
        }
        Ok(finite)
    }
}

/// The lower triangle of the tangent over the unknowns, in parts.
fn each_entry(
    structure: &impl Structure,
    positions: &[DVec3],
    unknown: &[[u32; 3]],
    mut add: impl FnMut(usize, usize, f64),
) {
    structure.stiffness(positions, &mut |a, b, block| {
        for (i, values) in block.iter().enumerate() {
            let row = unknown[a as usize][i];
            for (j, &value) in values.iter().enumerate() {
                let col = unknown[b as usize][j];
                if row != FIXED && col != FIXED && row >= col {
                    add(row as usize, col as usize, value);
                }
            }
        }
    });
}
