//! What is remembered of points that touch, from one substep to the next: on which side they are, and where friction holds
//! them.

use crate::math::DVec3;
use crate::solve::rows::{Row, Rows};

/// What tells one point of a pair from another; points are found in this order.
pub type Key = [u32; 3];

/// A point that touches, in the collider's frame.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Touch {
    key: Key,
    /// Its row in the substep under way.
    row: u32,
    /// The normal it had.
    pub normal: DVec3,
    /// How deep it was \[m\].
    pub depth: f64,
    /// Where friction holds it.
    pub hold: Option<Hold>,
    /// What the row ended with \[N·s\], in the world: along its normal, and the friction.
    pub impulse: (f64, DVec3),
}

/// Where friction took hold of a point: of what material point of the deformable, by the weights of its nodes, and where on
/// the collider \[m\].
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Hold {
    /// Weights of the nodes.
    pub weights: [f64; 4],
    /// Where that point was, in the collider's frame.
    pub anchor: DVec3,
    /// How far it had slipped by then \[m\]. Where a body rolls over a face the points that touch are others at every time,
    /// and only what each slips counts.
    pub drift: DVec3,
}

/// The points of one kind of a pair of body and collider.
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
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

    /// What is known of a point that touched last; keys ascend within a substep.
    pub fn last(&mut self, key: Key) -> Option<&Touch> {
        while self.kept.get(self.cursor).is_some_and(|t| t.key < key) {
            self.cursor += 1;
        }
        self.kept.get(self.cursor).filter(|t| t.key == key)
    }

    /// The normal that this point had when it last touched.
    pub fn normal(&self, key: Key) -> Option<DVec3> {
        let i = self.kept.binary_search_by_key(&key, |t| t.key);
        i.ok().map(|i| self.kept[i].normal)
    }

    /// The normals that points had when they last touched.
    pub fn normals(&self) -> impl Iterator<Item = (Key, DVec3)> {
        self.kept.iter().map(|t| (t.key, t.normal))
    }

    /// How deep the deepest of certain points was that last touched with a normal that has at least a cosine of `alike` with a
    /// direction \[m\].
    pub fn deepest_along(
        &self,
        direction: DVec3,
        alike: f64,
        is: impl Fn(Key) -> bool,
    ) -> Option<f64> {
        let along = |t: &&Touch| is(t.key) && t.normal.dot(direction) >= alike;
        let depths = self.kept.iter().filter(along).map(|t| t.depth);
        depths.max_by(f64::total_cmp)
    }

    /// Whether this point touched last.
    pub fn touched(&self, key: Key) -> bool {
        self.kept.binary_search_by_key(&key, |t| t.key).is_ok()
    }

    /// The keys that begin like this of points that touched last.
    pub fn known(&self, first: u32) -> impl Iterator<Item = Key> {
        let i = self.kept.partition_point(|t| t.key[0] < first);
        let kept = self.kept[i..].iter().map(|t| t.key);
        kept.take_while(move |key| key[0] == first)
    }

    /// The keys of all points that touched last, without those that were only near.
    pub fn keys(&self) -> impl Iterator<Item = Key> {
        let touched = self.kept.iter().filter(|t| t.has_touched());
        touched.map(|t| t.key)
    }

    /// Whether any point whose key begins and ends like this touched last.
    pub fn knows_last(&self, first: u32, last: u32) -> bool {
        self.known(first).any(|key| key[2] == last)
    }

    /// Whether any point whose key begins like this touched last.
    pub fn knows(&self, start: [u32; 2]) -> bool {
        self.beginning(start).next().is_some()
    }

    /// How deep the deepest of the points was whose keys begin like this and that touched last \[m\].
    pub fn deepest(&self, start: [u32; 2]) -> Option<f64> {
        let depths = self.beginning(start).map(|t| t.depth);
        depths.max_by(f64::total_cmp)
    }

    /// The normals that points had whose keys begin like this and that touched last.
    pub fn normals_of(&self, start: [u32; 2]) -> impl Iterator<Item = DVec3> {
        self.beginning(start).map(|t| t.normal)
    }

    /// The points whose keys begin like this that touched last.
    fn beginning(&self, [first, second]: [u32; 2]) -> impl Iterator<Item = &Touch> {
        let i = self.kept.partition_point(|t| t.key < [first, second, 0]);
        let begins = move |t: &&Touch| t.key[0] == first && t.key[1] == second;
        self.kept[i..].iter().take_while(begins)
    }

    /// A point has got a row; `hold` is where friction may take hold of it, or does.
    pub fn found(&mut self, key: Key, row: usize, normal: DVec3, hold: Hold) {
        self.next.push(Touch {
            key,
            row: row as u32,
            normal,
            depth: 0.0,
            hold: Some(hold),
            impulse: Default::default(),
        });
    }

    /// Ends a substep, after the rows have been solved. Friction keeps its hold on a point that sticks, or that leaves the
    /// surface by less than `touching` m; one that slides takes its anchor along.
    pub fn end(&mut self, rows: &Rows, touching: f64) {
        self.end_with(rows, touching, false);
    }

    /// As [`Self::end`], and what was so near that it had a row keeps its side: it may be on the other one the next time.
    pub fn end_near(&mut self, rows: &Rows, touching: f64) {
        self.end_with(rows, touching, true);
    }

    fn end_with(&mut self, rows: &Rows, touching: f64, near: bool) {
        self.kept.clear();
        for touch in &self.next {
            let row: &Row = &rows.contacts[touch.row as usize];
            let pressed = row.normal_impulse > 0.0;
            let touches = pressed || row.depth >= -touching;
            if touches || near {
                let holds = touches && (!pressed || row.sticks());
                self.kept.push(Touch {
                    hold: touch.hold.filter(|_| holds),
                    impulse: (row.normal_impulse, row.friction_impulse),
                    depth: row.depth,
                    ..*touch
                });
            }
        }
    }
}

impl Touch {
    /// Whether it was pressed or may be held, and not only near.
    fn has_touched(&self) -> bool {
        self.impulse.0 > 0.0 || self.hold.is_some()
    }
}

/// The part of a drift along a surface.
pub fn along(drift: DVec3, normal: DVec3) -> DVec3 {
    drift - normal * drift.dot(normal)
}
