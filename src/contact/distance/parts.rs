//! The parts of a compound, found by a tree where there are many.

use super::compound::Part;
use crate::contact::tree::{around, nearest};
use crate::math::DVec3;
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};

/// Up to so many parts are gone through one by one.
const FEW: usize = 8;

/// Parts, each with its box.
pub struct Parts {
    all: Vec<Part>,
    /// Of those that are bounded; empty where there are few.
    tree: Bvh,
    /// The others, or all.
    always: Vec<u32>,
}

impl PartialEq for Parts {
    fn eq(&self, other: &Self) -> bool {
        self.all == other.all
    }
}

impl std::fmt::Debug for Parts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.all.fmt(f)
    }
}

impl Parts {
    pub fn new(all: Vec<Part>) -> Self {
        let in_tree = |part: &Part| all.len() > FEW && part.lo.is_finite() && part.hi.is_finite();
        let numbered = || all.iter().enumerate();
        let bounded = numbered().filter(|(_, part)| in_tree(part));
        let boxes = bounded.map(|(i, part)| (i, around(part.lo, part.hi)));
        let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
        let others = numbered().filter(|(_, part)| !in_tree(part));
        let always = others.map(|(i, _)| i as u32).collect();
        Self { all, tree, always }
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Part> {
        self.all.iter()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Those whose boxes meet a box, and some more.
    pub fn meeting(&self, lo: DVec3, hi: DVec3) -> impl Iterator<Item = &Part> {
        let wanted = around(lo, hi);
        let found = self.tree.leaves(move |node| {
            node.mins().cmple(wanted.maxs).all() && node.maxs().cmpge(wanted.mins).all()
        });
        let always = self.always.iter().copied();
        always.chain(found).map(|i| &self.all[i as usize])
    }

    /// Those whose boxes are within `reach` m of a point, and some more.
    pub fn near(&self, p: DVec3, reach: f64) -> impl Iterator<Item = &Part> {
        self.meeting(p - reach, p + reach)
    }

    /// A distance within which the nearest part of those in the tree is, if there are any \[m\].
    pub fn within(&self, p: DVec3) -> f64 {
        let away = |leaf: usize| self.all[leaf].signed_distance(p).0.max(0.0);
        let found = nearest(&self.tree, p, away);
        // Rounding of `f32` may have it a little less.
        found.map_or(0.0, |(_, away)| away * (1.0 + 1e-6))
    }
}
