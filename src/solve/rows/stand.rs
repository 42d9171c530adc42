//! What light bodies pass on between heavy nodes and what they stand on.
//!
//! Nodes that come down on a light body which lies on the ground stop that body rather than themselves; the ground stops it again, and
//! they press on: each pass takes them m/(m+M) of their way, one part in hundreds. So where passes did not end it, nodes are
//! stopped as if the bodies that they press on would not give way, and these hand all that on to what they press on
//! themselves. Of that change of all impulses the share is taken which leads farthest down, see [`super::climb`]: all of it where
//! bodies stand, and little where they don't, or where joints hold them.

use super::climb::Climb;
use super::pass::{Pass, inverse};
use super::settled::{Felt, Settled};
use crate::math::DVec3;

/// How often contacts of shadows are visited: a few bodies alone, whose masses are not far apart.
const SETTLES: usize = 64;

/// A row as it was before it was changed.
#[derive(Clone, Copy, Debug)]
struct Before<const N: usize> {
    heap: u32,
    row: usize,
    /// Impulses \[N·s\], and velocities that are not as asked for \[m/s\].
    impulses: [f64; N],
    errors: [f64; N],
}

impl<const N: usize> Before<N> {
    /// The change since, and what that adds to the slopes of the measure along it.
    fn climb(&self, impulses: [f64; N], errors: [f64; N], climb: &mut Climb) {
        for k in 0..N {
            let change = impulses[k] - self.impulses[k];
            climb.slope += change * self.errors[k];
            climb.end += change * errors[k];
        }
    }
}

/// Bodies that press on each other, and rows on them.
#[derive(Clone, Debug, Default)]
pub(super) struct Heaps {
    /// Per shadow, another one of its heap, or itself.
    parent: Vec<u32>,
    /// Rows of nodes: their normal impulses.
    contacts: Vec<Before<1>>,
    /// Contacts of shadows.
    rigid: Vec<Before<3>>,
    /// Velocities that rows of nodes have yet to give to the shadows \[m/s\], \[rad/s\].
    pending: Vec<(DVec3, DVec3)>,
}

impl Heaps {
    fn root(&mut self, mut shadow: u32) -> u32 {
        while self.parent[shadow as usize] != shadow {
            let above = self.parent[self.parent[shadow as usize] as usize];
            self.parent[shadow as usize] = above;
            shadow = above;
        }
        shadow
    }

    /// Finds them, and the rows in their order.
    fn find(&mut self, pass: &Pass) {
        let moves = |i: &u32| pass.worklist.moves(*i);
        self.parent.clear();
        self.parent.extend(0..pass.shadows.len() as u32);
        for row in pass.rigid.iter().filter(|r| r.shadows.iter().all(moves)) {
            let [a, b] = row.shadows.map(|i| self.root(i));
            self.parent[a.max(b) as usize] = a.min(b);
        }
        self.rigid.clear();
        for (i, row) in pass.rigid.iter().enumerate() {
            if let Some(one) = row.shadows.into_iter().find(moves) {
                let heap = self.root(one);
                self.rigid.push(Before {
                    heap,
                    row: i,
                    impulses: row.impulse(),
                    errors: [0.0; 3],
                });
            }
        }
        self.contacts.clear();
        for (i, row) in pass.contacts.iter().enumerate() {
            if moves(&row.shadow) && row.softness == 0.0 {
                let heap = self.root(row.shadow);
                self.contacts.push(Before {
                    heap,
                    row: i,
                    impulses: [row.normal_impulse],
                    errors: [0.0],
                });
            }
        }
        self.rigid.sort_unstable_by_key(|b| (b.heap, b.row));
        self.contacts.sort_unstable_by_key(|b| (b.heap, b.row));
        self.pending.clear();
        self.pending.resize(pass.shadows.len(), Default::default());
    }
}

impl Pass<'_> {
    /// Stops nodes as if the bodies that they press on stood fast, as far as that is right.
    pub(super) fn stand(&mut self, heaps: &mut Heaps) {
        heaps.find(self);
        let Heaps {
            contacts,
            rigid,
            pending,
            ..
        } = heaps;
        let mut contacts = &mut contacts[..];
        // Those that stand on something.
        for rigid in rigid.chunk_by_mut(|a, b| a.heap == b.heap) {
            let heap = rigid[0].heap;
            let first = contacts.partition_point(|b| b.heap < heap);
            let end = contacts.partition_point(|b| b.heap <= heap);
            if first < end {
                self.stand_heap(&mut contacts[first..end], rigid, pending);
            }
            contacts = &mut contacts[end..];
        }
    }

    fn stand_heap(
        &mut self,
        contacts: &mut [Before<1>],
        rigid: &mut [Before<3>],
        pending: &mut [(DVec3, DVec3)],
    ) {
        for before in &mut *contacts {
            before.errors = [self.missed(before.row)];
        }
        for before in &mut *rigid {
            before.errors = self.rigid[before.row].errors(self.shadows);
        }
        self.settle_shadows(rigid);
        for before in &*contacts {
            let row = &self.contacts[before.row];
            let (i, normal) = (row.shadow as usize, row.normal);
            let own = self.points.response(row.terms);
            let (v, w) = (self.shadows[i].v, self.shadows[i].w);
            self.press(before.row, inverse(normal.dot(own * normal)));
            let body = &mut self.shadows[i];
            pending[i].0 += body.v - v;
            pending[i].1 += body.w - w;
            (body.v, body.w) = (v, w);
        }
        for before in &*contacts {
            let i = self.contacts[before.row].shadow as usize;
            let (v, w) = std::mem::take(&mut pending[i]);
            self.shadows[i].v += v;
            self.shadows[i].w += w;
        }
        self.settle_shadows(rigid);
        self.follow_all();
        let mut climb = Climb::default();
        for before in &*contacts {
            let pressed = self.contacts[before.row].normal_impulse;
            before.climb([pressed], [self.missed(before.row)], &mut climb);
        }
        for before in &*rigid {
            let row = &self.rigid[before.row];
            before.climb(row.impulse(), row.errors(self.shadows), &mut climb);
        }
        self.take_back(contacts, rigid, 1.0 - climb.lowest());
    }

    /// Visits contacts of shadows alone until they are settled.
    fn settle_shadows(&mut self, rigid: &[Before<3>]) {
        // What is missing of a heavy load is much to a light body.
        let settled = Settled {
            tolerance: 1e-9,
            ..self.settled
        };
        for _ in 0..SETTLES {
            let mut changed = false;
            for before in rigid {
                changed |= self.rigid[before.row].solve(self.shadows, settled);
            }
            if !changed {
                break;
            }
        }
    }

    /// Takes back a share of what has changed, and tells all who feel it.
    fn take_back(&mut self, contacts: &[Before<1>], rigid: &[Before<3>], share: f64) {
        let felt = Felt {
            nodes: true,
            shadows: true,
        };
        for before in contacts {
            let row = &self.contacts[before.row];
            let more = before.impulses[0] - row.normal_impulse;
            let (normal, friction) = (row.normal_impulse, row.friction_impulse);
            self.set_row(before.row, normal + share * more, friction);
            if let Some(bounded) = self.contacts[before.row].bounded(friction) {
                self.set_row(before.row, normal + share * more, bounded);
            }
            let row = &self.contacts[before.row];
            let terms = self.points.terms_of(row.terms);
            self.worklist.change(terms, [row.shadow; 2], felt);
        }
        for before in rigid {
            let row = &mut self.rigid[before.row];
            let now = row.impulse();
            let more = [0, 1, 2].map(|k| share * (before.impulses[k] - now[k]));
            row.give(self.shadows, more);
            self.worklist.change(&[], row.shadows, felt);
        }
        self.follow_all();
    }
}
