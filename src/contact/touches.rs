//! What is remembered of points that touch, from one substep to the next: on which side they are, and where friction holds
//! them.

use crate::math::DVec3;
use crate::solve::rows::{Row, Rows};

/// What tells one point of a pair from another; points are found in this order.
pub type Key = [u32; 3];

/// A point that touches, in the collider's frame.
#[derive(Clone, Copy, Debug)]
struct Touch {
    key: Key,
    /// Its row in the substep under way.
    row: u32,
    normal: DVec3,
    hold: Option<Hold>,
}

/// Where friction took hold of a point: of what material point of the deformable, by the weights of its nodes, and where on
/// the collider \[m\].
#[derive(Clone, Copy, Debug)]
pub struct Hold {
    /// Weights of the nodes.
    pub weights: [f64; 3],
    /// Where that point was, in the collider's frame.
    pub anchor: DVec3,
}

/// The points of one kind of a pair of body and collider.
#[derive(Clone, Debug, Default)]
pub struct Touches {
    kept: Vec<Touch>,
    next: Vec<Touch>,
    cursor: usize,
}

impl Touches {
    /// Forgets all.
    pub fn forget(&mut self) {
        self.kept.clear();
    }

    /// Begins a substep.
    pub fn begin(&mut self) {
        self.next.clear();
        self.cursor = 0;
    }

    /// The normal a point had when it last touched, and where friction holds it; keys ascend within a substep.
    pub fn last(&mut self, key: Key) -> Option<(DVec3, Option<Hold>)> {
        while self.kept.get(self.cursor).is_some_and(|t| t.key < key) {
            self.cursor += 1;
        }
        let touch = self.kept.get(self.cursor).filter(|t| t.key == key)?;
        Some((touch.normal, touch.hold))
    }

    /// A point has got a row; `hold` is where friction may take hold of it, or does.
    pub fn found(&mut self, key: Key, row: usize, normal: DVec3, hold: Hold) {
        self.next.push(Touch {
            key,
            row: row as u32,
            normal,
            hold: Some(hold),
        });
    }

    /// Ends a substep, after the rows have been solved. Friction keeps its hold on a point that sticks, or that leaves the
    /// surface by less than `touching` m; one that slides takes its anchor along.
    pub fn end(&mut self, rows: &Rows, touching: f64) {
        self.kept.clear();
        for touch in &self.next {
            let row: &Row = &rows.contacts[touch.row as usize];
            let pressed = row.normal_impulse > 0.0;
            if pressed || row.depth >= -touching {
                self.kept.push(Touch {
                    hold: touch.hold.filter(|_| !pressed || row.sticks()),
                    ..*touch
                });
            }
        }
    }
}

/// The part of a drift along a surface.
pub fn along(drift: DVec3, normal: DVec3) -> DVec3 {
    drift - normal * drift.dot(normal)
}
