//! What an encounter remembers of points that touch.

use crate::math::DVec3;
use crate::solve::rows::Rows;

/// Something of one body near something of the other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Touch {
    /// The node, or the edge of the first body.
    pub own: u32,
    /// The element, or the edge of the second body.
    pub other: u32,
    /// The normal of its row: on which side of a sheet it belongs, and through which face of a solid it came.
    pub normal: DVec3,
    /// How deep it was \[m\].
    pub depth: f64,
    /// Where friction holds it: the other's element and weights, or how far along both edges. `None` while it slides.
    pub anchor: Option<(u32, [f64; 3])>,
    /// Normal impulse of the arrival, which friction has not answered yet \[N·s\].
    pub carried: f64,
    /// What its row ended with last \[N·s\]: along its normal, and the friction.
    pub impulse: (f64, DVec3),
}

impl Touch {
    /// Whether its row pressed when it was last solved.
    pub fn is_pressed(&self) -> bool {
        self.impulse.0 > 0.0
    }
}

/// The touches of one kind, sorted by `own`.
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Touches {
    known: Vec<Touch>,
    next: Vec<Touch>,
    first_row: usize,
}

impl Touches {
    /// Forgets everything, keeping the memory.
    pub fn clear(&mut self) {
        self.known.clear();
        self.next.clear();
    }

    /// Begins a substep; the rows that follow are this kind's.
    pub fn begin(&mut self, rows: &Rows) {
        self.first_row = rows.contacts.len();
        self.next.clear();
    }

    /// What is known of a node or edge, from place `from` on, which moves along.
    pub fn of(&self, own: u32, from: &mut usize) -> &[Touch] {
        while self.known.get(*from).is_some_and(|t| t.own < own) {
            *from += 1;
        }
        let known = &self.known[*from..];
        let count = known.iter().take_while(|t| t.own == own).count();
        &known[..count]
    }

    /// Notes the touch of a row that has just been added.
    pub fn push(&mut self, touch: Touch) {
        self.next.push(touch);
    }

    /// After the rows have been solved. Friction keeps its hold on what sticks, or leaves the surface by less than
    /// `touching` m; what slides takes its anchor along. Points that are about to arrive have had no friction yet.
    pub fn remember(&mut self, rows: &Rows, touching: f64) {
        let Some(solved) = rows.contacts.get(self.first_row..) else {
            return;
        };
        self.known.clear();
        for (touch, row) in self.next.iter().zip(solved) {
            let pressed = row.normal_impulse > 0.0;
            let arriving = row.depth < -touching;
            let held = if arriving {
                pressed
            } else {
                !pressed || row.sticks()
            };
            self.known.push(Touch {
                anchor: touch.anchor.filter(|_| held),
                carried: if arriving && pressed {
                    touch.carried + row.normal_impulse
                } else {
                    0.0
                },
                impulse: (row.normal_impulse, row.friction_impulse),
                ..*touch
            });
        }
    }
}
