//! The roofline (Williams, Waterman & Patterson, *CACM* 52, 2009): how fast the machine could be at best, by its arithmetic
//! and by its memory, both measured here.

use super::clock::{median, per_call};
use super::subject::Subject;
use super::{SceneError, Sizes};
use crate::body::{Blueprint, Material};
use crate::math::Vector;
use crate::shape::lattice;
use crate::solve::{Kernel, roof};

/// The best kernel on a lattice, against what the machine allows.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Roofline {
    /// Springs of the lattice.
    pub springs: usize,
    /// Spring updates per second.
    pub updates_per_s: f64,
    /// Multiplications and additions per second, fused where the processor can.
    pub operations_per_s: f64,
    /// Bytes per second of the triad a = b + s·c over arrays of as many bytes as a substep moves.
    pub bytes_per_s: f64,
    /// Operations that a spring needs, its share of its nodes included.
    pub operations_per_update: f64,
    /// Bytes that a spring needs to move at the least, its share of its nodes included.
    pub bytes_per_update: f64,
    /// Updates per second over the lower of the two roofs, median over pairs \[1\].
    pub share: f64,
}

/// Operations of a spring without damping, each end's sum included: 3 differences, 5 for the square, a root, a quotient, 3 for
/// the direction, the elongation, the tension, 3 for the force and 6 for the sums.
const PER_SPRING: f64 = 24.0;
/// Operations of a free node without damping, by axis: acceleration and velocity 4, the speed 3, the compensated position 8.
const PER_NODE: f64 = 3.0 * 15.0;
/// Bytes of a node: 32 of position and velocity and 16 of the low parts, read and written, and 16 of its force, written and read.
const NODE_BYTES: f64 = 2.0 * (32.0 + 16.0 + 16.0);

pub(super) fn roofline(sizes: &Sizes) -> Result<Roofline, SceneError> {
    let net = lattice(Vector::ONE, 1.0 / sizes.roof_cells as f32)?;
    let material = Material::elastic(1e6, 100.0);
    let blueprint = Blueprint::resolve(net, |_| Some(material), None)?;
    let (springs, nodes) = (blueprint.springs.len() as f64, blueprint.nodes.len() as f64);
    let mut subject = Subject::new(&blueprint, Kernel::Auto, 0.0);
    subject.substep();
    let bytes = subject.solver.table_bytes()[0] as f64 + nodes * NODE_BYTES;
    let operations = springs * PER_SPRING + nodes * PER_NODE;
    let mut triad = roof::Triad::new(Kernel::Auto, bytes as usize);
    let rounds: Vec<[f64; 3]> = (0..sizes.rounds)
        .map(|_| {
            let rate = springs / per_call(sizes.long, 1, || subject.substep());
            let stream = triad.bytes() as f64 / per_call(sizes.long, 1, || triad.run());
            let mut sum = 0.0;
            let peak = per_call(sizes.long, 1, || {
                sum += roof::multiply_and_add(Kernel::Auto, PEAK_ROUNDS)
            });
            std::hint::black_box(sum);
            let peak = roof::operations(Kernel::Auto, PEAK_ROUNDS) as f64 / peak;
            [rate, stream, peak]
        })
        .collect();
    let middle = |k: usize| median(rounds.iter().map(|r| r[k]));
    let roof = |[_, stream, peak]: &[f64; 3]| (peak / operations).min(stream / bytes) * springs;
    Ok(Roofline {
        springs: springs as usize,
        updates_per_s: middle(0),
        bytes_per_s: middle(1),
        operations_per_s: middle(2),
        operations_per_update: operations / springs,
        bytes_per_update: bytes / springs,
        share: median(rounds.iter().map(|r| r[0] / roof(r))),
    })
}

const PEAK_ROUNDS: usize = 100_000;
