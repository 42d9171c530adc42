//! Elements as the force pass reads them: [`WIDTH`] side by side, front to back.

use super::elements::{Basis, Elements, Point};
use crate::math::{Number, Pack, Scalar, WIDTH};
use crate::solve::forces::Lanes;

/// [`WIDTH`] elements. What is left over in the last block has no volume, and the nodes of its first element.
#[derive(Clone, Copy, Debug)]
pub struct Block<S, const N: usize, const G: usize> {
    /// Node indices, node by node.
    pub nodes: [[u32; WIDTH]; N],
    /// Integration points.
    pub points: [Point<Pack<S>>; G],
}

/// All elements of a body.
#[derive(Clone, Debug)]
pub struct Blocks<S, B, const N: usize, const G: usize> {
    pub(super) list: Vec<Block<S, N, G>>,
    kind: std::marker::PhantomData<B>,
}

impl<S: Scalar, B: Basis<N, G>, const N: usize, const G: usize> Blocks<S, B, N, G> {
    /// The elements in their order.
    pub fn new(elements: &Elements<B, N, G>) -> Self {
        let block = |group: &[super::elements::Element<N, G>]| {
            let lane = |l: usize| group.get(l).unwrap_or(&group[0]);
            Block {
                nodes: std::array::from_fn(|a| std::array::from_fn(|l| lane(l).nodes[a])),
                points: std::array::from_fn(|g| Point {
                    inverse: std::array::from_fn(|i| {
                        std::array::from_fn(|j| Pack::of_lanes(|l| lane(l).points[g].inverse[i][j]))
                    }),
                    volume: Pack::of_lanes(|l| group.get(l).map_or(0.0, |e| e.points[g].volume)),
                }),
            }
        };
        Self {
            list: elements.list.chunks(WIDTH).map(block).collect(),
            kind: std::marker::PhantomData,
        }
    }
}

impl<S: Scalar, const N: usize, const G: usize> Block<S, N, G> {
    /// Values at its nodes less the value at the first, which keeps the digits of `f32` positions.
    #[inline(always)]
    pub(super) fn gather(&self, value: impl Fn(usize) -> [S; 3]) -> [[Pack<S>; 3]; N] {
        let mut packs = [[Pack::ZERO; 3]; N];
        for (pack, nodes) in packs.iter_mut().zip(&self.nodes) {
            for (l, node) in nodes.iter().enumerate() {
                let v = value(*node as usize);
                for d in 0..3 {
                    pack[d].0[l] = v[d];
                }
            }
        }
        let first = packs[0];
        for pack in &mut packs {
            for d in 0..3 {
                pack[d] -= first[d];
            }
        }
        packs
    }

    /// Takes two kinds of forces from the nodes, lane by lane.
    #[inline(always)]
    pub(super) fn scatter(
        &self,
        first: &[[Pack<S>; 3]; N],
        second: &[[Pack<S>; 3]; N],
        add: &mut impl FnMut(usize, Lanes<S>, Lanes<S>),
    ) {
        for ((nodes, first), second) in self.nodes.iter().zip(first).zip(second) {
            for (l, node) in nodes.iter().enumerate() {
                let first = [-first[0].0[l], -first[1].0[l], -first[2].0[l], S::ZERO];
                let second = [-second[0].0[l], -second[1].0[l], -second[2].0[l], S::ZERO];
                add(*node as usize, first, second);
            }
        }
    }
}
