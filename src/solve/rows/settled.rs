//! When a row has done what it can: what it would change any more is felt by nobody.
//!
//! Rows that share light nodes hand what is left of their velocities to and fro, a tenth less in each pass, long after the
//! bodies that they press on have found their own. What is left over is small, and a substep later all rows are visited
//! again, in the other order. The impulses that are booked are those given. Joints of shadows go on to the end, and so do
//! the nodes of a group that has ties: of a thousand random scenes one gained energy without, in which a pinned node is
//! pressed on.

use crate::math::{DMat3, sum_of_squares};

/// What a visit may leave nodes off by, as an acceleration over the substep and as a speed, which is half of that at which
/// bodies fall asleep \[length units/s², length units/s\].
const NODES: (f64, f64) = (10.0, 1e-3);
/// And in parts of that in rows between two deformables: what is left brings these nearer in every substep, and where they rest on each
/// other they would have to be moved out of each other again and again.
const BETWEEN: f64 = 0.1;
/// What a visit may leave rigid bodies off by: a hundredth of gravity \[length units/s²\].
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
            nodes: (NODES.0 * h).min(NODES.1) * length_unit,
            shadows: SHADOWS * h * length_unit,
        }
    }

    /// Nothing of nodes.
    pub fn of_shadows(self) -> Self {
        Self { nodes: 0.0, ..self }
    }
}

/// How much faster the nodes of a row get by an impulse, at most, and its point on the shadows \[1/kg\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Give {
    /// Nodes.
    pub nodes: f64,
    /// Shadows.
    pub shadows: f64,
}

impl Give {
    /// Of nodes that get `nodes`, and of shadows by their matrix at the point.
    pub fn of(nodes: f64, shadows: &DMat3) -> Self {
        Self {
            nodes,
            shadows: sum_of_squares(shadows).sqrt(),
        }
    }
}

/// What counts as settled in a pass.
#[derive(Clone, Copy, Debug, Default)]
pub struct Settled {
    /// Relative change of an impulse that nobody feels.
    pub tolerance: f64,
    /// Changes of velocity that nobody feels.
    pub negligible: Negligible,
}

impl Settled {
    /// What counts as settled in rows between two deformables.
    #[inline(always)]
    pub fn between(mut self) -> Self {
        self.negligible.nodes *= BETWEEN;
        self
    }

    /// Which sides feel a change of an impulse, by the squares of the change and of the impulse \[N²·s²\].
    #[inline(always)]
    pub fn felt(&self, change: f64, impulse: f64, give: Give) -> Felt {
        if change <= self.tolerance * self.tolerance * impulse {
            return Felt::default();
        }
        let above = |give: f64, least: f64| change * (give * give) > least * least;
        Felt {
            nodes: above(give.nodes, self.negligible.nodes),
            shadows: above(give.shadows, self.negligible.shadows),
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
