//! The passes over elements: forces, damping, energy.
//!
//! The force passes are one text for vectors of any width. Nodes are reached through a [`Field`]: rows of particles that
//! the kernels fetch, or functions of a node for a state of another scalar, a vector of unknowns or a test's array. Each
//! element's forces are added in the order of elements, so all widths give the same bits.

use super::blocks::{Batch, Blocks};
use super::elements::{Basis, Element, Elements, Point};
use crate::law::elastic::tensor::{Mat, contract, mul, mul_transpose, scale, zero};
use crate::law::elastic::{Elastic, Viscous};
use crate::math::{Number, Packed, Scalar};
use std::ops::Range;

/// Where a pass finds positions and velocities, and where its forces go.
pub(crate) trait Field<S: Scalar, V: Packed<S>> {
    /// Positions \[m\] of the nodes of some elements, less that of their first node.
    fn positions<B: Basis<N, G>, const N: usize, const G: usize>(
        &self,
        blocks: &Blocks<S, B, N, G>,
        at: Batch,
    ) -> [[V; 3]; N];
    /// Velocities \[m/s\] likewise.
    fn velocities<B: Basis<N, G>, const N: usize, const G: usize>(
        &self,
        blocks: &Blocks<S, B, N, G>,
        at: Batch,
    ) -> [[V; 3]; N];
    /// Takes forces \[N\] from the nodes, elastic ones and those of damping.
    fn take<B: Basis<N, G>, const N: usize, const G: usize, const DAMPED: bool>(
        &mut self,
        blocks: &Blocks<S, B, N, G>,
        at: Batch,
        elastic: &[[V; 3]; N],
        damping: &[[V; 3]; N],
    );
}

/// Gives every node the elastic force of its elements in a list of blocks \[N\], and with `DAMPED` the damping force; the two are kept apart because
/// an energy ledger wants the work of damping by itself.
#[inline(always)]
pub(crate) fn add_forces<S, V, B, L, const N: usize, const G: usize, const DAMPED: bool>(
    blocks: &Blocks<S, B, N, G>,
    list: Range<usize>,
    (law, viscous): (&L, &Viscous<V>),
    field: &mut impl Field<S, V>,
) where
    S: Scalar,
    V: Packed<S>,
    B: Basis<N, G>,
    L: Elastic<V>,
{
    for at in blocks.parts_of::<V>(list) {
        let x = B::gradients(&field.positions(blocks, at));
        let mut v = [zero(); G];
        if DAMPED {
            v = B::gradients(&field.velocities(blocks, at));
        }
        let (mut elastic, mut damping) = ([zero(); G], [zero(); G]);
        for g in 0..G {
            let point = blocks.point::<V>(at, g);
            let f = mul(&x[g], &point.inverse);
            elastic[g] = at_corners(&point, &law.stress(&f));
            if DAMPED {
                damping[g] = at_corners(&point, &viscous.stress(&f, &mul(&v[g], &point.inverse)));
            }
        }
        let elastic = B::collect(&elastic);
        let mut resistance = [[V::ZERO; 3]; N];
        if DAMPED {
            resistance = B::collect(&damping);
        }
        field.take::<B, N, G, DAMPED>(blocks, at, &elastic, &resistance);
    }
}

/// What a stress \[Pa\] at a point gives to a basis's [`collect`](Basis::collect) \[N\]. Not a closure: those of a kernel that are not
/// inlined lose the processor's wider instructions, and with them all that they call.
#[inline(always)]
fn at_corners<V: Number>(point: &Point<V>, stress: &Mat<V>) -> Mat<V> {
    scale(&mul_transpose(stress, &point.inverse), point.volume)
}

/// A field of functions of a node, called through pointers: the passes are long, and would be compiled for each caller.
pub(crate) struct Functions<'a, S> {
    /// Position \[m\].
    pub position: &'a dyn Fn(usize) -> [S; 3],
    /// Velocity \[m/s\].
    pub velocity: &'a dyn Fn(usize) -> [S; 3],
    /// Called with a node and its forces \[N\], elastic and damping.
    pub add: &'a mut dyn FnMut(usize, [S; 3], [S; 3]),
}

impl<S: Scalar, P: Packed<S>> Field<S, P> for Functions<'_, S> {
    #[inline(always)]
    fn positions<B: Basis<N, G>, const N: usize, const G: usize>(
        &self,
        blocks: &Blocks<S, B, N, G>,
        at: Batch,
    ) -> [[P; 3]; N] {
        blocks.gather(at, self.position)
    }

    #[inline(always)]
    fn velocities<B: Basis<N, G>, const N: usize, const G: usize>(
        &self,
        blocks: &Blocks<S, B, N, G>,
        at: Batch,
    ) -> [[P; 3]; N] {
        blocks.gather(at, self.velocity)
    }

    #[inline(always)]
    fn take<B: Basis<N, G>, const N: usize, const G: usize, const DAMPED: bool>(
        &mut self,
        blocks: &Blocks<S, B, N, G>,
        at: Batch,
        elastic: &[[P; 3]; N],
        damping: &[[P; 3]; N],
    ) {
        for l in 0..blocks.filled::<P>(at) {
            for (n, (elastic, damping)) in elastic.iter().zip(damping).enumerate() {
                let of = |f: &[P; 3]| f.map(|f| S::of(-f.lane(l)));
                (self.add)(blocks.node::<P>(at, n, l), of(elastic), of(damping));
            }
        }
    }
}

/// The elastic energy of some elements \[J\].
pub fn energy<B, L, const N: usize, const G: usize>(
    elements: &Elements<B, N, G>,
    list: impl Iterator<Item = usize>,
    law: &L,
    position: impl Fn(usize) -> [f64; 3],
) -> f64
where
    B: Basis<N, G>,
    L: Elastic<f64>,
{
    let of = |element: &Element<N, G>| -> f64 {
        let x = B::gradients(&element.gather(&position));
        let each = element.points.iter().zip(&x);
        each.map(|(p, x)| law.energy(&mul(x, &p.inverse)) * p.volume)
            .sum()
    };
    list.map(|i| of(&elements.list[i])).sum()
}

/// What the elastic forces of some elements do to the nodes, −∫P:Ḟ dV \[W\].
pub fn power<B, L, const N: usize, const G: usize>(
    elements: &Elements<B, N, G>,
    list: impl Iterator<Item = usize>,
    law: &L,
    position: impl Fn(usize) -> [f64; 3],
    velocity: impl Fn(usize) -> [f64; 3],
) -> f64
where
    B: Basis<N, G>,
    L: Elastic<f64>,
{
    let of = |element: &Element<N, G>| -> f64 {
        let x = B::gradients(&element.gather(&position));
        let v = B::gradients(&element.gather(&velocity));
        let each = element.points.iter().zip(x.iter().zip(&v));
        each.map(|(p, (x, v))| {
            let stress = law.stress(&mul(x, &p.inverse));
            contract(&stress, &mul(v, &p.inverse)) * p.volume
        })
        .sum()
    };
    -list.map(|i| of(&elements.list[i])).sum::<f64>()
}
