//! Stress and strain per element, as channels and pictures read them.

use super::elements::{Basis, Element, Elements};
use crate::law::elastic::tensor::{Mat, add_scaled, mul, zero};
use crate::law::elastic::{Elastic, green_strain, von_mises};

/// What an element feels, the mean over its volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stress {
    /// Cauchy stress \[Pa\], symmetric.
    pub cauchy: Mat<f64>,
    /// Green strain, symmetric.
    pub strain: Mat<f64>,
    /// Von Mises stress of the mean Cauchy stress \[Pa\].
    pub von_mises: f64,
}

/// The stress of an element.
pub(super) fn of<B, L, const N: usize, const G: usize>(
    element: &Element<N, G>,
    law: &L,
    position: impl Fn(usize) -> [f64; 3],
) -> Stress
where
    B: Basis<N, G>,
    L: Elastic<f64>,
{
    let x = B::gradients(&element.gather(position));
    let (mut stress, mut strain, mut volume) = (zero(), zero(), 0.0);
    for (point, x) in element.points.iter().zip(&x) {
        let f = mul(x, &point.inverse);
        stress = add_scaled(&stress, point.volume, &law.cauchy(&f));
        strain = add_scaled(&strain, point.volume, &green_strain(&f));
        volume += point.volume;
    }
    let mean = |m: Mat<f64>| m.map(|row| row.map(|v| v / volume));
    let cauchy = mean(stress);
    Stress {
        cauchy,
        strain: mean(strain),
        von_mises: von_mises(&cauchy),
    }
}

/// The stress of every element, in order.
pub fn stresses<'a, B, L, const N: usize, const G: usize>(
    elements: &'a Elements<B, N, G>,
    law: &'a L,
    position: impl Fn(usize) -> [f64; 3] + 'a,
) -> impl Iterator<Item = Stress> + 'a
where
    B: Basis<N, G>,
    L: Elastic<f64>,
{
    let each = move |element| of::<B, L, N, G>(element, law, &position);
    elements.list.iter().map(each)
}
