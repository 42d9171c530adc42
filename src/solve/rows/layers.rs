//! Layers: what lies on other deformables that can't give way can't give way either.
//!
//! Sheets under a box on a floor are moved out of each other at position level, and so is each out of the box and out of the floor. The box
//! alone can make room for them, and it has to know that they have no other way to go.

use super::squeeze::Squeeze;
use super::{Row, RowNode, Term};
use crate::math::DVec3;
use crate::solve::shadow::Shadow;

/// How often all rows are gone through: most layers are found at once, as rows come in the order of their bodies.
const SWEEPS: usize = 8;

/// The cosine from which on what is under a node holds it against what presses it down.
pub(super) const UNDER: f64 = 0.7;

/// From which share of it on a point is held that has to give way otherwise. What presses on a face from either side seldom has the very
/// same nodes.
pub(super) const HELD_SHARE: f64 = 0.5;

/// Of every row between two deformables, whether that on the positive side of its weights is held on its other side, and that on the
/// negative one.
#[derive(Clone, Debug, Default)]
pub(super) struct Layers {
    held: Vec<[bool; 2]>,
}

/// The rows of a substep and their nodes.
#[derive(Clone, Copy)]
pub(super) struct Seen<'a> {
    pub contacts: &'a [Row],
    pub terms: &'a [Term],
    pub nodes: &'a [RowNode],
    pub squeeze: &'a Squeeze,
}

impl Layers {
    /// Looks for them where a rigid body that can make room is inside of something: nobody else asks.
    pub fn find(&mut self, all: Seen, shadows: &[Shadow]) {
        self.held.clear();
        self.held.resize(all.contacts.len(), [false; 2]);
        let moves = |row: &&Row| shadows[row.shadow as usize].gives_way();
        let rigid = all.contacts.iter().filter(moves);
        let deepest = rigid.map(|row| row.depth).fold(0.0, f64::max);
        if deepest <= 0.0 {
            return;
        }
        for _ in 0..SWEEPS {
            let mut found = false;
            for i in 0..all.contacts.len() {
                if !all.contacts[i].between {
                    continue;
                }
                for side in 0..2 {
                    if !self.held[i][side] && self.holds_side(all, i, side, deepest) {
                        self.held[i][side] = true;
                        found = true;
                    }
                }
            }
            if !found {
                return;
            }
        }
    }

    /// Whether most of a side of row `i` is held where there are at most `room` m behind it.
    fn holds_side(&self, all: Seen, i: usize, side: usize, room: f64) -> bool {
        let row = &all.contacts[i];
        let sign = [1.0, -1.0][side];
        let terms = all.terms[row.terms.range()].iter();
        let terms = terms.filter(|t| t.weight * sign > 0.0);
        let is_held = |t: &&Term| {
            all.nodes[t.node as usize].inv_mass == 0.0
                || self
                    .against(all, (i, t.node), row.normal * sign)
                    .any(|other| other.depth + room > 0.0)
        };
        let held = terms.filter(is_held).map(|t| t.weight.abs());
        held.sum::<f64>() > HELD_SHARE
    }

    /// The rows at a node that push it against a direction, but for row `i`: those on rigid bodies, and those on deformables that are held.
    pub fn against<'a>(
        &'a self,
        all: Seen<'a>,
        (i, node): (usize, u32),
        along: DVec3,
    ) -> impl Iterator<Item = &'a Row> {
        let at = all.squeeze.own(node).chain(all.squeeze.with_others(node));
        let least = UNDER * along.length();
        at.filter(move |j| *j != i).filter_map(move |j| {
            let row = &all.contacts[j];
            let push = row.normal.dot(along);
            if !row.between {
                return (push < -least).then_some(row);
            }
            let [positive, negative] = self.held[j];
            if push.abs() <= least || !(positive || negative) {
                return None;
            }
            let mut terms = all.terms[row.terms.range()].iter();
            let weight = terms.find(|t| t.node == node)?.weight;
            // It is pushed by what is on the other side of the row.
            let held = if weight > 0.0 { negative } else { positive };
            (held && push * weight < 0.0).then_some(row)
        })
    }
}
