//! Soft bodies of Rapier's own.

use super::super::check::{NOT_NEGATIVE, POINT, POISSON, POSITIVE};
use super::super::decode::Decoder;
use super::super::schema::record;
use super::super::tree::Node;
use super::deformable::Region;

/// Most particles of one.
const MOST: f64 = 1.0e5;

record! {
    /// A soft body of Rapier's own to compare with: a box of corotational cells. Deformables pass through it.
    pub struct SoftBody {
        /// Its name.
        name: String;
        /// Its sides \[m\].
        size: [f64; 3], POSITIVE;
        /// Side of a cell \[m\].
        cell: f64, POSITIVE;
        /// Young's modulus \[Pa\].
        young: f64, POSITIVE;
        /// Poisson's ratio.
        poisson: f64 = 0.0, POISSON;
        /// Rapier's damping of the cells, as a share of the critical.
        damping_ratio: f64 = 1.0, NOT_NEGATIVE;
        /// Mass \[kg\].
        mass: f64, POSITIVE;
        /// Which particles are pinned: a formula of x, y, z.
        pin: Option<Region> = None;
        /// Where its middle is \[m\].
        translation: [f64; 3] = [0.0; 3], POINT;
    }
    then few
}

impl SoftBody {
    /// How many particles it has.
    pub(crate) fn particles(&self) -> f64 {
        let along = |side: f64| (side / self.cell).round().max(1.0) + 1.0;
        self.size.map(along).iter().product()
    }
}

fn few(body: &SoftBody, node: &Node, d: &mut Decoder) -> Option<()> {
    let n = body.particles();
    if n <= MOST {
        return Some(());
    }
    d.wrong(node.at, |_| {
        format!("{n:.0} particles are too many, at most {MOST} are possible")
    });
    None
}
