//! When a row has done what it can: what it would change any more is felt by nobody.
//!
//! Rows that share light nodes hand what is left of their velocities to and fro, a tenth less in each pass, long after the
//! bodies that they press on have found their own. A substep later all rows begin anew, so an error stays as long as that:
//! what a node is off by then is less than what gravity does in it, and the impulses that are booked are those given.

use crate::math::DMat3;

/// What nodes may be off by \[length units/s²\]: about gravity, at 5 kHz half a micrometre.
const NODES: f64 = 10.0;
/// What rigid bodies may be off by, likewise: a hundred rows on one may add up.
const SHADOWS: f64 = 0.1;

/// Changes of velocity that no other row has to answer \[m/s\]. None by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct Negligible {
    /// Of nodes.
    pub nodes: f64,
    /// Of shadows.
    pub shadows: f64,
}

impl Negligible {
    /// In a substep of h s, for a world of this length unit.
    pub fn of(h: f64, length_unit: f64) -> Self {
        Self {
            nodes: NODES * h * length_unit,
            shadows: SHADOWS * h * length_unit,
        }
    }
}

/// How much faster the two sides of a row get by an impulse, at most \[1/kg\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Give {
    /// Nodes.
    pub nodes: f64,
    /// Shadows.
    pub shadows: f64,
}

impl Give {
    /// Of a point that answers by `nodes`, and of shadows by a matrix.
    pub fn of(nodes: f64, shadows: &DMat3) -> Self {
        let square = |column: crate::math::DVec3| column.length_squared();
        let square = square(shadows.x_axis) + square(shadows.y_axis) + square(shadows.z_axis);
        Self {
            nodes,
            shadows: square.sqrt(),
        }
    }

    /// Which sides feel an impulse of this square \[N²·s²\].
    #[inline(always)]
    pub fn felt(&self, square: f64, negligible: Negligible) -> Felt {
        let above = |give: f64, least: f64| square * (give * give) > least * least;
        Felt {
            nodes: above(self.nodes, negligible.nodes),
            shadows: above(self.shadows, negligible.shadows),
        }
    }
}

/// Which sides of a row feel what it did.
#[derive(Clone, Copy, Debug, Default)]
pub struct Felt {
    pub nodes: bool,
    pub shadows: bool,
}

impl Felt {
    #[inline(always)]
    pub fn any(self) -> bool {
        self.nodes || self.shadows
    }
}
