//! Stress and strain per element, as channels and pictures read them.

use super::elements::{Basis, Elements, jacobian};
use crate::law::elastic::tensor::{Mat, add_scaled, mul, zero};
use crate::law::elastic::{Elastic, green_strain, von_mises};
use crate::math::Scalar;

/// What an element feels, the mean over its volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stress<S> {
    /// Cauchy stress \[Pa\], symmetric.
    pub cauchy: Mat<S>,
    /// Green strain, symmetric.
    pub strain: Mat<S>,
    /// Von Mises stress of the mean Cauchy stress \[Pa\].
    pub von_mises: S,
}

/// The stress of every element, in order.
pub fn stresses<'a, S, B, L, const N: usize, const G: usize>(
    elements: &'a Elements<S, B, N, G>,
    law: &'a L,
    position: impl Fn(usize) -> [S; 3] + 'a,
) -> impl Iterator<Item = Stress<S>> + 'a
where
    S: Scalar,
    B: Basis<N, G>,
    L: Elastic<S>,
{
    elements.list.iter().map(move |element| {
        let x = element.gather(&position);
        let (mut stress, mut strain, mut volume) = (zero(), zero(), S::ZERO);
        for (g, point) in element.points.iter().enumerate() {
            let f = mul(&jacobian::<S, B, N, G>(&x, g), &point.inverse);
            stress = add_scaled(&stress, point.volume, &law.cauchy(&f));
            strain = add_scaled(&strain, point.volume, &green_strain(&f));
            volume += point.volume;
        }
        let mean = |m: Mat<S>| m.map(|row| row.map(|v| v / volume));
        let cauchy = mean(stress);
        Stress {
            cauchy,
            strain: mean(strain),
            von_mises: von_mises(&cauchy),
        }
    })
}
