//! Layers: what lies on other deformables that can't give way can't give way either.
//!
//! Sheets under a box on a floor are moved out of each other at position level, and so is each out of the box and out of the floor. The box
//! alone can make room for them, and it has to know that they have no other way to go.

use super::lift::UNDER;
use super::squeeze::Squeeze;
use super::{Row, RowNode, Term};
use crate::math::DVec3;

/// How many of them are looked through.
const MOST: usize = 8;

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
pub(super) struct All<'a> {
    pub contacts: &'a [Row],
    pub terms: &'a [Term],
    pub nodes: &'a [RowNode],
    pub squeeze: &'a Squeeze,
}

impl Layers {
    /// Looks for them, if anything is deep in what is rigid.
    pub fn find(&mut self, all: All) {
        self.held.clear();
        self.held.resize(all.contacts.len(), [false; 2]);
        let rigid = all.contacts.iter().filter(|row| !row.between);
        let deepest = rigid.map(|row| row.depth).fold(0.0, f64::max);
        if deepest <= 0.0 {
            return;
        }
        for _ in 0..MOST {
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
    fn holds_side(&self, all: All, i: usize, side: usize, room: f64) -> bool {
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
        all: All<'a>,
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
            let [above, below] = self.held[j];
            if push.abs() <= least || !(above || below) {
                return None;
            }
            let mut terms = all.terms[row.terms.range()].iter();
            let weight = terms.find(|t| t.node == node)?.weight;
            let held = if weight > 0.0 { below } else { above };
            (held && push * weight < 0.0).then_some(row)
        })
    }
}
