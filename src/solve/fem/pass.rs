//! The passes over elements: forces, damping, energy.
//!
//! Positions, velocities and forces are reached through functions of a node, so that the same loop reads a state of
//! particles, a vector of unknowns or a test's array, and is inlined into each.

use super::elements::{Basis, Elements, jacobian};
use crate::law::elastic::tensor::{Mat, mul, mul_transpose, scale};
use crate::law::elastic::{Elastic, Viscous};
use crate::math::Scalar;

/// Gives every node the elastic force of its elements \[N\]; `position` \[m\] and `add` are called with node indices.
#[inline]
pub fn add_elastic<S, B, L, const N: usize, const G: usize>(
    elements: &Elements<S, B, N, G>,
    law: &L,
    position: impl Fn(usize) -> [S; 3],
    mut add: impl FnMut(usize, [S; 3]),
) where
    S: Scalar,
    B: Basis<N, G>,
    L: Elastic<S>,
{
    for element in &elements.list {
        let x = element.gather(&position);
        let mut forces = [[S::ZERO; 3]; N];
        for (g, point) in element.points.iter().enumerate() {
            let f = mul(&jacobian::<S, B, N, G>(&x, g), &point.inverse);
            collect::<S, B, N, G>(
                &mut forces,
                &law.stress(&f),
                &point.inverse,
                point.volume,
                g,
            );
        }
        for (node, force) in element.nodes.iter().zip(forces) {
            add(*node as usize, force);
        }
    }
}

/// Gives every node the damping force of its elements \[N\]. Apart from [`add_elastic`] because an energy ledger wants its
/// work by itself, and because most bodies have none.
#[inline]
pub fn add_damping<S, B, const N: usize, const G: usize>(
    elements: &Elements<S, B, N, G>,
    law: &Viscous<S>,
    position: impl Fn(usize) -> [S; 3],
    velocity: impl Fn(usize) -> [S; 3],
    mut add: impl FnMut(usize, [S; 3]),
) where
    S: Scalar,
    B: Basis<N, G>,
{
    for element in &elements.list {
        let (x, v) = (element.gather(&position), element.gather(&velocity));
        let mut forces = [[S::ZERO; 3]; N];
        for (g, point) in element.points.iter().enumerate() {
            let f = mul(&jacobian::<S, B, N, G>(&x, g), &point.inverse);
            let rate = mul(&jacobian::<S, B, N, G>(&v, g), &point.inverse);
            let stress = law.stress(&f, &rate);
            collect::<S, B, N, G>(&mut forces, &stress, &point.inverse, point.volume, g);
        }
        for (node, force) in element.nodes.iter().zip(forces) {
            add(*node as usize, force);
        }
    }
}

/// f −= V·P·∇N of every node of an element.
#[inline(always)]
fn collect<S: Scalar, B: Basis<N, G>, const N: usize, const G: usize>(
    forces: &mut [[S; 3]; N],
    stress: &Mat<S>,
    inverse: &Mat<S>,
    volume: S,
    g: usize,
) {
    let h = scale(&mul_transpose(stress, inverse), volume);
    for (force, gradient) in forces.iter_mut().zip(&B::GRADIENTS[g]) {
        let d = gradient.map(S::of);
        for (f, row) in force.iter_mut().zip(&h) {
            *f -= row[0] * d[0] + row[1] * d[1] + row[2] * d[2];
        }
    }
}

/// The elastic energy \[J\].
#[inline]
pub fn energy<S, B, L, const N: usize, const G: usize>(
    elements: &Elements<S, B, N, G>,
    law: &L,
    position: impl Fn(usize) -> [S; 3],
) -> f64
where
    S: Scalar,
    B: Basis<N, G>,
    L: Elastic<S>,
{
    let mut sum = 0.0;
    for element in &elements.list {
        let x = element.gather(&position);
        for (g, point) in element.points.iter().enumerate() {
            let f = mul(&jacobian::<S, B, N, G>(&x, g), &point.inverse);
            sum += (law.energy(&f) * point.volume).f64();
        }
    }
    sum
}
