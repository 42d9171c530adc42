//! The passes over elements: forces, damping, energy.
//!
//! Positions, velocities and forces are reached through functions of a node, so that the same loop reads a state of
//! particles, a vector of unknowns or a test's array, and is inlined into each.

use super::blocks::Blocks;
use super::elements::{Basis, Elements};
use crate::law::elastic::tensor::{Mat, mul, mul_transpose, scale};
use crate::law::elastic::{Elastic, Viscous};
use crate::math::{Pack, Scalar};

/// Gives every node the elastic force of its elements \[N\]; `position` \[m\] and `add` are called with node indices.
#[inline]
pub fn add_elastic<S, B, L, const N: usize, const G: usize>(
    blocks: &Blocks<S, B, N, G>,
    law: &L,
    position: impl Fn(usize) -> [S; 3],
    mut add: impl FnMut(usize, [S; 3]),
) where
    S: Scalar,
    B: Basis<N, G>,
    L: Elastic<Pack<S>>,
{
    for block in &blocks.list {
        let x = B::gradients(&block.gather(&position));
        let forces: [Mat<_>; G] = std::array::from_fn(|g| {
            let point = &block.points[g];
            let stress = law.stress(&mul(&x[g], &point.inverse));
            scale(&mul_transpose(&stress, &point.inverse), point.volume)
        });
        block.scatter(&B::collect(&forces), &mut add);
    }
}

/// Gives every node the damping force of its elements \[N\]. Apart from [`add_elastic`] because an energy ledger wants its
/// work by itself, and because most bodies have none.
#[inline]
pub fn add_damping<S, B, const N: usize, const G: usize>(
    blocks: &Blocks<S, B, N, G>,
    law: &Viscous<Pack<S>>,
    position: impl Fn(usize) -> [S; 3],
    velocity: impl Fn(usize) -> [S; 3],
    mut add: impl FnMut(usize, [S; 3]),
) where
    S: Scalar,
    B: Basis<N, G>,
{
    for block in &blocks.list {
        let x = B::gradients(&block.gather(&position));
        let v = B::gradients(&block.gather(&velocity));
        let forces: [Mat<_>; G] = std::array::from_fn(|g| {
            let point = &block.points[g];
            let f = mul(&x[g], &point.inverse);
            let stress = law.stress(&f, &mul(&v[g], &point.inverse));
            scale(&mul_transpose(&stress, &point.inverse), point.volume)
        });
        block.scatter(&B::collect(&forces), &mut add);
    }
}

/// The elastic energy \[J\].
pub fn energy<B, L, const N: usize, const G: usize>(
    elements: &Elements<B, N, G>,
    law: &L,
    position: impl Fn(usize) -> [f64; 3],
) -> f64
where
    B: Basis<N, G>,
    L: Elastic<f64>,
{
    let of = |element: &super::elements::Element<N, G>| -> f64 {
        let x = B::gradients(&element.gather(&position));
        let each = element.points.iter().zip(&x);
        each.map(|(p, x)| law.energy(&mul(x, &p.inverse)) * p.volume)
            .sum()
    };
    elements.list.iter().map(of).sum()
}
