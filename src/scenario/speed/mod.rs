//! What this machine reaches: every kernel against a scalar loop, whole steps, the same scenes in Rapier's own soft bodies,
//! and the share of the roofline.
//!
//! Machines differ and are busy, so what counts are ratios, each the median over pairs that were measured one after the
//! other in one run, by the time of the thread.

pub mod clock;
pub mod kernels;
pub mod native;
pub mod peers;
pub mod roof;
pub mod subject;
pub mod threads;
pub mod whole;

pub use super::SceneError;
use kernels::KernelRow;
use peers::PeerRow;
use roof::Roofline;
use threads::Threads;
use whole::WholeRow;

use crate::solve::Kernel;

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Pairs.
    pub rounds: usize,
    /// The least time that a kernel is measured at a time \[s\].
    pub long: f64,
    /// Cells along a side of the bodies that kernels are measured with.
    pub kernel_cells: u32,
    /// Cells along a side of the body that threads share.
    pub thread_cells: u32,
    /// Cells along a side of the body that is held against the roofline, which outgrows the nearest caches.
    pub roof_cells: u32,
    /// Nodes along a side of the cloth, the block and what meets the wall.
    pub cloth: usize,
    /// See `cloth`.
    pub block: usize,
    /// See `cloth`.
    pub wall: usize,
    /// Duration of the crash scene \[s\].
    pub crash: f64,
    /// At most so many steps of a scene.
    pub frames: usize,
}

impl Sizes {
    /// What `crumple speed` measures, in less than a minute.
    pub const USUAL: Self = Self {
        rounds: 5,
        long: 0.05,
        kernel_cells: 19,
        thread_cells: 29,
        roof_cells: 49,
        cloth: 100,
        block: 10,
        wall: 20,
        crash: 0.03,
        frames: usize::MAX,
    };
    /// As little as shows that everything works.
    pub const TINY: Self = Self {
        rounds: 1,
        long: 0.001,
        kernel_cells: 3,
        thread_cells: 3,
        roof_cells: 3,
        cloth: 5,
        block: 3,
        wall: 3,
        crash: 0.005,
        frames: 3,
    };
}

/// The ratios.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Ratios {
    /// The fastest kernel over the scalar loop, on a mesh without order.
    pub kernel_general_vs_scalar: f64,
    /// The same on a lattice.
    pub kernel_lattice_vs_scalar: f64,
    /// Springs that can yield and break over those that can't, on a mesh without order.
    pub kernel_plastic_vs_plain: f64,
    /// Rapier's time over ours: a cloth of 100² nodes.
    pub cloth100_vs_rapier: f64,
    /// A solid of 10³ nodes that falls on a floor.
    pub block10_vs_rapier: f64,
    /// One of 20³ nodes that crumples at a wall.
    pub wall20_vs_rapier: f64,
    /// All threads over one, on a large mesh in order.
    pub threads_speedup: f64,
    /// Of the lower roof, by arithmetic or by memory.
    pub roofline_share: f64,
}

/// Everything that was measured.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Speed {
    /// The processor, as the system calls it.
    pub cpu: String,
    /// The fastest kernel.
    pub kernel: &'static str,
    /// The ratios.
    #[serde(flatten)]
    pub ratios: Ratios,
    /// Kernels on bodies.
    pub kernels: Vec<KernelRow>,
    /// Whole steps.
    pub whole_steps: Vec<WholeRow>,
    /// Scenes here and in Rapier's own soft bodies.
    pub peers: Vec<PeerRow>,
    /// Threads on meshes with and without order, and a lattice.
    pub threads: Vec<Threads>,
    /// The roofline.
    pub roofline: Roofline,
}

/// Measures everything; `tell` hears what comes next.
///
/// # Errors
/// [`SceneError`] where a scene can't be built.
pub fn measure(sizes: &Sizes, tell: impl FnMut(&str) + Send) -> Result<Speed, SceneError> {
    clock::alone(|| measure_alone(sizes, tell))
}

fn measure_alone(sizes: &Sizes, mut tell: impl FnMut(&str)) -> Result<Speed, SceneError> {
    tell("kernels");
    let kernels = kernels::rows(sizes)?;
    tell("roofline");
    let roofline = roof::roofline(sizes)?;
    tell("threads");
    let threads = threads::threads(sizes)?;
    tell("whole steps");
    let whole_steps = whole::rows(sizes)?;
    tell("scenes in Rapier's own soft bodies");
    let peers = vec![
        peers::cloth(sizes)?,
        peers::block(sizes)?,
        peers::wall(sizes)?,
    ];
    let best = |body: &str, material: &str| {
        let row = kernels
            .iter()
            .rfind(|r| (r.body, r.material, r.kernel) == (body, material, Kernel::Auto.name()));
        row.map_or([f64::NAN; 2], |r| [r.vs_scalar, r.vs_plain])
    };
    Ok(Speed {
        cpu: cpu(),
        kernel: Kernel::Auto.name(),
        ratios: Ratios {
            kernel_general_vs_scalar: best(kernels::GENERAL, kernels::PLAIN)[0],
            kernel_lattice_vs_scalar: best(kernels::LATTICE, kernels::PLAIN)[0],
            kernel_plastic_vs_plain: best(kernels::GENERAL, kernels::PLASTIC)[1],
            cloth100_vs_rapier: peers[0].ratio,
            block10_vs_rapier: peers[1].ratio,
            wall20_vs_rapier: peers[2].ratio,
            threads_speedup: threads.first().map_or(f64::NAN, |t| t.speedup),
            roofline_share: roofline.share,
        },
        kernels,
        whole_steps,
        peers,
        threads,
        roofline,
    })
}

/// The processor, as the system calls it, else its architecture.
fn cpu() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = info.lines().find(|l| l.starts_with("model name"));
    let name = line.and_then(|l| l.split(':').nth(1)).map(str::trim);
    name.unwrap_or(std::env::consts::ARCH).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_measured() {
        let speed = measure(&Sizes::TINY, |_| ()).unwrap();
        let json = serde_json::to_value(&speed).unwrap();
        for key in [
            "kernel_general_vs_scalar",
            "kernel_lattice_vs_scalar",
            "kernel_plastic_vs_plain",
            "cloth100_vs_rapier",
            "block10_vs_rapier",
            "wall20_vs_rapier",
            "threads_speedup",
            "roofline_share",
        ] {
            // What is not finite is null in JSON.
            let ratio = json[key].as_f64();
            assert!(ratio.is_some_and(|r| r > 0.0), "{key}: {:?}", json[key]);
        }
        assert!(!speed.cpu.is_empty());
        for row in &speed.kernels {
            assert_eq!(row.difference, 0.0, "{row:?}");
        }
        for row in &speed.peers {
            assert!(row.strain.iter().all(|s| s.is_finite()), "{row:?}");
        }
    }
}
