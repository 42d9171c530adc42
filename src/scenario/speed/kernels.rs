//! Every kernel that the processor has against the scalar loop, on a mesh without order and on a lattice.

use super::clock::{median, per_call};
use super::subject::{ScalarLoop, Subject, shuffled};
use super::{SceneError, Sizes};
use crate::body::{Blueprint, Material, Net};
use crate::math::Vector;
use crate::shape::{TetSplit, lattice, tet_box_of_cells};
use crate::solve::Kernel;

/// A kernel on a body.
#[derive(Clone, Debug, serde::Serialize)]
pub struct KernelRow {
    /// Which body.
    pub body: &'static str,
    /// Its springs.
    pub springs: usize,
    /// What they are made of.
    pub material: &'static str,
    /// Which kernel.
    pub kernel: &'static str,
    /// Spring updates per second, integration included.
    pub updates_per_s: f64,
    /// Against the scalar loop over the same springs without limits, median over pairs.
    pub vs_scalar: f64,
    /// Against the same kernel without limits and damping, median over pairs.
    pub vs_plain: f64,
    /// Largest distance of a node from where the portable kernel leaves it, over the body's size, after a squeeze \[1\].
    pub difference: f64,
}

/// Names of bodies and materials.
pub const GENERAL: &str = "mesh without order";
/// See [`GENERAL`].
pub const LATTICE: &str = "lattice";
/// See [`GENERAL`].
pub const PLAIN: &str = "plain";
/// See [`GENERAL`].
pub const PLASTIC: &str = "yield and break";

/// The kernels that differ on this processor, the fastest last.
pub fn available() -> Vec<Kernel> {
    let mut kernels = vec![Kernel::Portable, Kernel::Avx2, Kernel::Avx512];
    kernels.dedup_by_key(|k| k.name());
    kernels
}

/// What springs are made of, and by how much the body is squeezed along x.
fn materials() -> [(&'static str, Material, f32); 4] {
    let elastic = Material::elastic(1e6, 100.0);
    let mut plastic = elastic.yielding(1e4, 0.0);
    plastic.break_strain = 0.5;
    [
        (PLAIN, elastic, 0.0),
        ("damped", elastic.viscosity(100.0), 0.0),
        (PLASTIC, plastic, 0.0),
        ("all flowing", plastic, 0.03),
    ]
}

/// The bodies: one that is a general mesh for every kernel, and one whose nodes and springs are regular.
///
/// # Errors
/// [`SceneError`] where they can't be built.
pub fn bodies(sizes: &Sizes) -> Result<[(&'static str, Net); 2], SceneError> {
    bodies_of(sizes.kernel_cells)
}

/// The same with so many cells along a side.
///
/// # Errors
/// [`SceneError`] where they can't be built.
pub fn bodies_of(cells: u32) -> Result<[(&'static str, Net); 2], SceneError> {
    let tets = tet_box_of_cells(Vector::ONE, [cells; 3], TetSplit::Six)?;
    let regular = lattice(Vector::ONE, 1.0 / cells as f32)?;
    Ok([(GENERAL, shuffled(&tets.springs())), (LATTICE, regular)])
}

/// The rows of all bodies. Everything in turn, so that what else the machine does hits all alike.
pub(super) fn rows(sizes: &Sizes) -> Result<Vec<KernelRow>, SceneError> {
    let mut rows = Vec::new();
    for (body, net) in bodies(sizes)? {
        let mut blueprints = Vec::new();
        for (name, material, squeeze) in materials() {
            let blueprint = Blueprint::resolve(net.clone(), |_| Some(material), None)?;
            blueprints.push((name, blueprint, squeeze));
        }
        rows.extend(rows_of(body, &blueprints, sizes));
    }
    Ok(rows)
}

fn rows_of(
    body: &'static str,
    blueprints: &[(&'static str, Blueprint, f32)],
    sizes: &Sizes,
) -> Vec<KernelRow> {
    let kernels = available();
    let plain = &blueprints[0].1;
    let springs = plain.springs.len();
    let count = 200_000 / springs + 1;
    let mut scalar = ScalarLoop::new(plain);
    // Per round the scalar loop, and every kernel of every material.
    let mut times: Vec<(f64, Vec<Vec<f64>>)> = Vec::new();
    for _ in 0..sizes.rounds {
        let alone = per_call(sizes.long, count, || scalar.substep());
        let all = blueprints.iter().map(|(_, blueprint, squeeze)| {
            let each = kernels.iter().map(|kernel| {
                let mut subject = Subject::new(blueprint, *kernel, *squeeze);
                subject.substep();
                per_call(sizes.long, count, || subject.substep())
            });
            each.collect()
        });
        times.push((alone, all.collect()));
    }
    let mut rows = vec![KernelRow {
        body,
        springs,
        material: PLAIN,
        kernel: "scalar loop",
        updates_per_s: springs as f64 / median(times.iter().map(|t| t.0)),
        vs_scalar: 1.0,
        vs_plain: 1.0,
        difference: 0.0,
    }];
    for (m, (material, blueprint, _)) in blueprints.iter().enumerate() {
        for (k, kernel) in kernels.iter().enumerate() {
            rows.push(KernelRow {
                body,
                springs,
                material,
                kernel: kernel.name(),
                updates_per_s: springs as f64 / median(times.iter().map(|t| t.1[m][k])),
                vs_scalar: median(times.iter().map(|t| t.0 / t.1[m][k])),
                vs_plain: median(times.iter().map(|t| t.1[0][k] / t.1[m][k])),
                difference: difference(blueprint, *kernel),
            });
        }
    }
    rows
}

/// How far a kernel leaves the nodes of a body of 1 m from where the portable one does \[m\].
fn difference(blueprint: &Blueprint, kernel: Kernel) -> f64 {
    let [a, b] = [Kernel::Portable, kernel].map(|kernel| {
        let mut subject = Subject::new(blueprint, kernel, 0.03);
        for _ in 0..50 {
            subject.substep();
        }
        subject.state
    });
    let nodes = 0..a.particles.len();
    nodes
        .map(|i| a.local(i).distance(b.local(i)))
        .fold(0.0, f64::max)
}
