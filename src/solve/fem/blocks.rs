//! Elements as the force pass reads them: sixteen side by side, front to back, computed in parts as wide as the vectors are.

use super::elements::{Basis, Element, Elements, Point};
use crate::body::BuildError;
use crate::math::{LANES, Number, Packed, Scalar, Wide};
use crate::solve::kernel::Places;
use std::ops::Range;

/// Integration points of [`LANES`] elements. What is left over in the last block has no volume, and the nodes of its first
/// element.
pub type Block<S, const G: usize> = [Point<Wide<S>>; G];

/// All elements of a body.
#[derive(Clone, Debug)]
pub struct Blocks<S, B, const N: usize, const G: usize> {
    pub(super) list: Vec<Block<S, G>>,
    /// Nodes, N slots for each block.
    pub(super) places: Places,
    count: usize,
    kind: std::marker::PhantomData<B>,
}

/// As many elements as a vector has lanes: the block and the part of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Batch {
    /// Which block.
    pub block: usize,
    /// Which part of it.
    pub part: usize,
}

impl<S: Scalar, B: Basis<N, G>, const N: usize, const G: usize> Blocks<S, B, N, G> {
    /// The elements in their order.
    ///
    /// # Errors
    /// [`BuildError::Value`] for more nodes than there are indices.
    pub fn new(elements: &Elements<B, N, G>) -> Result<Self, BuildError> {
        let mut places = Places::new(elements.node_count).ok_or(BuildError::Value {
            what: "the number of nodes",
            value: elements.node_count as f64,
            must: "less than 2^27",
        })?;
        let block = |group: &[Element<N, G>]| {
            let lane = |l: usize| group.get(l).unwrap_or(&group[0]);
            for a in 0..N {
                places.push(std::array::from_fn(|l| lane(l).nodes[a]));
            }
            let wide =
                |value: &dyn Fn(usize) -> f64| Wide(std::array::from_fn(|l| S::of(value(l))));
            std::array::from_fn(|g| Point {
                inverse: std::array::from_fn(|i| {
                    std::array::from_fn(|j| wide(&|l| lane(l).points[g].inverse[i][j]))
                }),
                volume: wide(&|l| group.get(l).map_or(0.0, |e| e.points[g].volume)),
            })
        };
        Ok(Self {
            list: elements.list.chunks(LANES).map(block).collect(),
            places,
            count: elements.list.len(),
            kind: std::marker::PhantomData,
        })
    }

    /// All elements, as many at a time as there are lanes in `V`.
    #[inline(always)]
    pub(super) fn parts<V: Number>(&self) -> impl Iterator<Item = Batch> + use<S, B, V, N, G> {
        self.parts_of::<V>(0..self.list.len())
    }

    /// Those of some blocks.
    #[inline(always)]
    pub(super) fn parts_of<V: Number>(
        &self,
        blocks: Range<usize>,
    ) -> impl Iterator<Item = Batch> + use<S, B, V, N, G> {
        let each = LANES / V::LANES;
        let parts = self.count.div_ceil(V::LANES);
        (each * blocks.start..parts.min(each * blocks.end)).map(move |p| Batch {
            block: p / each,
            part: p % each,
        })
    }

    /// How many lanes of a part are elements.
    #[inline(always)]
    pub(super) fn filled<V: Number>(&self, at: Batch) -> usize {
        (self.count - LANES * at.block - V::LANES * at.part).min(V::LANES)
    }

    /// An integration point of a part.
    #[inline(always)]
    pub(super) fn point<V: Packed<S>>(&self, at: Batch, point: usize) -> Point<V> {
        let point = &self.list[at.block][point];
        let mut inverse = [[V::ZERO; 3]; 3];
        for (row, table) in inverse.iter_mut().zip(&point.inverse) {
            for (entry, table) in row.iter_mut().zip(table) {
                *entry = V::load(table, at.part);
            }
        }
        Point {
            inverse,
            volume: V::load(&point.volume, at.part),
        }
    }

    /// A node of the element in a lane.
    #[inline(always)]
    pub(super) fn node<V: Number>(&self, at: Batch, node: usize, lane: usize) -> usize {
        self.places
            .row(N * at.block + node, V::LANES * at.part + lane)
    }

    /// Values at the nodes less the value at the first, which keeps the digits of `f32` positions.
    #[inline(always)]
    pub(super) fn gather<V: Packed<S>>(
        &self,
        at: Batch,
        value: impl Fn(usize) -> [S; 3],
    ) -> [[V; 3]; N] {
        let mut packs = [[V::ZERO; 3]; N];
        for (node, pack) in packs.iter_mut().enumerate() {
            let mut lanes = [Wide([S::ZERO; LANES]); 3];
            for l in 0..V::LANES {
                let v = value(self.node::<V>(at, node, l));
                for d in 0..3 {
                    lanes[d].0[l] = v[d];
                }
            }
            *pack = [0, 1, 2].map(|d| V::load(&lanes[d], 0));
        }
        relative(packs)
    }
}

/// Values less the first.
#[inline(always)]
pub(super) fn relative<V: Number, const N: usize>(mut values: [[V; 3]; N]) -> [[V; 3]; N] {
    let first = values[0];
    for value in &mut values {
        for d in 0..3 {
            value[d] -= first[d];
        }
    }
    values
}
