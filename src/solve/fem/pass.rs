//! The passes over elements: forces, damping, energy.
//!
//! Positions, velocities and forces are reached through functions of a node, so that the same loop reads a state of
//! particles, a vector of unknowns or a test's array, and is inlined into each. Forces come in four lanes, the last of them
//! zero: added as one vector they cost half as much as one by one.

use super::blocks::Blocks;
use super::elements::{Basis, Elements};
use crate::law::elastic::tensor::{mul, mul_transpose, scale, zero};
use crate::law::elastic::{Elastic, Viscous};
use crate::math::{Number, Pack, Scalar};
use crate::solve::forces::Lanes;

/// Gives every node the elastic force of its elements \[N\]; `position` \[m\] and `add` are called with node indices.
#[inline]
pub(crate) fn add_elastic<S, B, L, const N: usize, const G: usize>(
    blocks: &Blocks<S, B, N, G>,
    law: &L,
    position: impl Fn(usize) -> [S; 3],
    mut add: impl FnMut(usize, Lanes<S>),
) where
    S: Scalar,
    B: Basis<N, G>,
    L: Elastic<Pack<S>>,
{
    for block in &blocks.list {
        let x = B::gradients(&block.gather(&position));
        let mut forces = [zero(); G];
        for (g, point) in block.points.iter().enumerate() {
            let stress = law.stress(&mul(&x[g], &point.inverse));
            forces[g] = scale(&mul_transpose(&stress, &point.inverse), point.volume);
        }
        let none = [[Pack::ZERO; 3]; N];
        block.scatter(&B::collect(&forces), &none, &mut |n, f, _| add(n, f));
    }
}

/// Gives every node the elastic and the damping force of its elements \[N\]; `add` is called with both, which are kept apart
/// because an energy ledger wants the work of damping by itself.
#[inline]
pub(crate) fn add_damped<S, B, L, const N: usize, const G: usize>(
    blocks: &Blocks<S, B, N, G>,
    (law, viscous): (&L, &Viscous<Pack<S>>),
    position: impl Fn(usize) -> [S; 3],
    velocity: impl Fn(usize) -> [S; 3],
    mut add: impl FnMut(usize, Lanes<S>, Lanes<S>),
) where
    S: Scalar,
    B: Basis<N, G>,
    L: Elastic<Pack<S>>,
{
    for block in &blocks.list {
        let x = B::gradients(&block.gather(&position));
        let v = B::gradients(&block.gather(&velocity));
        let mut elastic = [zero(); G];
        let mut damping = [zero(); G];
        for (g, point) in block.points.iter().enumerate() {
            let f = mul(&x[g], &point.inverse);
            let rate = mul(&v[g], &point.inverse);
            let (stress, resistance) = (law.stress(&f), viscous.stress(&f, &rate));
            elastic[g] = scale(&mul_transpose(&stress, &point.inverse), point.volume);
            damping[g] = scale(&mul_transpose(&resistance, &point.inverse), point.volume);
        }
        block.scatter(&B::collect(&elastic), &B::collect(&damping), &mut add);
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
