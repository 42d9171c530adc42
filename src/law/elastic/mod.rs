//! Elastic solids: from a deformation gradient F to the energy per volume at rest, the first Piola–Kirchhoff stress
//! P = ∂W/∂F, and the change of P with F.
//!
//! Four laws, all of the two Lamé constants and all with the same linear part, so that they agree where strains are small:
//!
//! | law | for | beyond its range |
//! |---|---|---|
//! | [`Corotational`] | stiff solids: large turns, small strains | survives inversion; stress stays linear in stretch |
//! | [`NeoHookean`] | rubber and everything that strains much | its energy grows without bound as J → 0; below J = 0.1 a parabola in J goes on |
//! | [`StableNeoHookean`] | flesh-like bodies that are crushed flat and must recover | survives inversion by itself |
//! | [`StVenantKirchhoff`] | comparison with other codes | softens and collapses in compression: not for crashes |
//!
//! The law called neo-Hookean is the textbook one, W = μ/2(I₁ − 3) − μ ln J + λ/2 ln²J (Bonet & Wood, *Nonlinear Continuum
//! Mechanics*, 2nd ed., eq. 6.28), because measured constants of rubber and published results mean that one. The law of
//! Smith, de Goes & Kim (2018) has the same slope at rest but another curve: at a stretch of ½ its stress is another one, so
//! it has its own name. What it is loved for, a finite energy for flat and inverted elements, the textbook law
//! has here too, by its continuation below J = 0.1.
//!
//! Each is a value of a few numbers and [`Elastic`] is what a loop over elements is compiled for, once per law.

mod corotational;
mod majorant;
mod measure;
mod neo_hookean;
pub mod polar;
mod st_venant;
mod stable_neo_hookean;
pub mod tensor;
mod viscous;

pub use corotational::Corotational;
pub use majorant::Majorant;
pub use measure::{cauchy, green_strain, mean_pressure, von_mises};
pub use neo_hookean::NeoHookean;
pub use st_venant::StVenantKirchhoff;
pub use stable_neo_hookean::StableNeoHookean;
pub use viscous::Viscous;

use crate::math::Number;
use tensor::Mat;

/// An elastic law: functions of F. All are finite for every finite F, flat and inverted ones included.
pub trait Elastic<S: Number>: Copy + Send + Sync {
    /// W, stored energy per volume at rest \[J/m³\]; 0 at rest.
    fn energy(&self, f: &Mat<S>) -> S;
    /// P = ∂W/∂F \[Pa\]: force per area at rest.
    fn stress(&self, f: &Mat<S>) -> Mat<S>;
    /// The change of P along `d` \[Pa\], ∂P/∂F : d.
    fn differential(&self, f: &Mat<S>, d: &Mat<S>) -> Mat<S>;
    /// A bound of [`Self::differential`] at F.
    fn majorant(&self, f: &Mat<S>) -> Majorant<S>;
    /// The Cauchy stress \[Pa\].
    #[inline(always)]
    fn cauchy(&self, f: &Mat<S>) -> Mat<S> {
        cauchy(&self.stress(f), f)
    }
}

/// λ and μ \[Pa\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lame<S> {
    /// λ \[Pa\], negative for auxetic solids.
    pub lambda: S,
    /// μ, the shear modulus \[Pa\].
    pub mu: S,
}

impl<S: Number> Lame<S> {
    /// From Young's modulus \[Pa\] and Poisson's ratio, which must be in (−1, ½).
    pub fn new(young: f64, poisson: f64) -> Self {
        let mu = 0.5 * young / (1.0 + poisson);
        Self {
            lambda: S::of(2.0 * mu * poisson / (1.0 - 2.0 * poisson)),
            mu: S::of(mu),
        }
    }
}

#[cfg(test)]
mod tests;
