//! Solids of finite elements: constants in SI units and the law that uses them.

use super::error::{not_negative, positive};
use super::{BuildError, TetMesh};
use crate::law::elastic::Lame;

/// The law of elasticity; see [`crate::law::elastic`] for what each is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub enum SolidLaw {
    /// Linear in the turned frame: the choice for stiff solids.
    #[default]
    Corotational,
    /// W = μ/2(I₁ − 3) − μ ln J + λ/2 ln²J: the choice for rubber.
    NeoHookean,
    /// The law of Smith, de Goes & Kim (2018).
    StableNeoHookean,
    /// St. Venant–Kirchhoff; weak in compression.
    StVenantKirchhoff,
}

impl SolidLaw {
    /// Every law.
    pub const ALL: [Self; 4] = [
        Self::Corotational,
        Self::NeoHookean,
        Self::StableNeoHookean,
        Self::StVenantKirchhoff,
    ];
}

/// An isotropic elastic solid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Solid {
    /// Young's modulus E \[Pa\].
    pub young: f64,
    /// Poisson's ratio ν, between −1 and ½.
    pub poisson: f64,
    /// Density ρ \[kg/m³\].
    pub density: f64,
    /// How stress follows from large strains.
    pub law: SolidLaw,
    /// α of Rayleigh's damping \[1/s\]: a force −α·m·v on every node. It also brakes free flight.
    pub mass_damping: f64,
    /// β of Rayleigh's damping \[s\]: viscous stress is β times stiffness times the rate of strain. A mode of angular frequency
    /// ω gets the damping ratio α/(2ω) + βω/2.
    pub stiffness_damping: f64,
}

impl Solid {
    /// An undamped solid with E \[Pa\], ν and ρ \[kg/m³\].
    pub const fn new(young: f64, poisson: f64, density: f64) -> Self {
        Self {
            young,
            poisson,
            density,
            law: SolidLaw::Corotational,
            mass_damping: 0.0,
            stiffness_damping: 0.0,
        }
    }

    /// The same solid with another law.
    pub const fn law(self, law: SolidLaw) -> Self {
        Self { law, ..self }
    }

    /// The same solid with Rayleigh's α \[1/s\] and β \[s\].
    pub const fn damping(self, alpha: f64, beta: f64) -> Self {
        Self {
            mass_damping: alpha,
            stiffness_damping: beta,
            ..self
        }
    }

    /// Checks every constant.
    ///
    /// # Errors
    /// [`BuildError::Value`] with the name and the value of the first that is out of range.
    pub fn check(&self) -> Result<(), BuildError> {
        positive("the solid's young modulus", self.young)?;
        positive("the solid's density", self.density)?;
        not_negative("the solid's mass damping", self.mass_damping)?;
        not_negative("the solid's stiffness damping", self.stiffness_damping)?;
        if self.poisson > -1.0 && self.poisson < 0.5 {
            return Ok(());
        }
        Err(BuildError::Value {
            what: "the solid's Poisson ratio",
            value: self.poisson,
            must: "greater than -1 and less than 0.5 (0.5 itself would need an infinite bulk modulus; 0.49 or 0.499 is rubber)",
        })
    }

    /// λ and μ \[Pa\].
    ///
    /// # Errors
    /// Those of [`Solid::check`].
    pub fn lame(&self) -> Result<Lame<f64>, BuildError> {
        self.check()?;
        Ok(Lame::new(self.young, self.poisson))
    }

    /// The speed of waves of compression at rest, √((λ + 2μ)/ρ) \[m/s\].
    pub fn sound_speed(&self) -> f64 {
        let Lame { lambda, mu } = Lame::<f64>::new(self.young, self.poisson);
        ((lambda + 2.0 * mu) / self.density).sqrt()
    }
}

/// Tetrahedra made of a solid.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct SolidMesh {
    /// The elements at rest, in the body's own frame.
    pub mesh: TetMesh,
    /// What they are made of.
    pub solid: Solid,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_out_of_range_are_named() {
        let good = Solid::new(1.0e6, 0.3, 1000.0).damping(1.0, 1e-4);
        good.check().unwrap();
        assert!((good.lame().unwrap().mu - 1.0e6 / 2.6).abs() < 1e-6);
        for poisson in [-1.0, 0.5, 0.7, f64::NAN, f64::INFINITY] {
            let error = Solid { poisson, ..good }.check().unwrap_err();
            assert!(error.to_string().contains("Poisson"), "{error}");
        }
        for (what, bad) in [
            ("young", Solid { young: 0.0, ..good }),
            (
                "density",
                Solid {
                    density: -1.0,
                    ..good
                },
            ),
            ("mass damping", good.damping(f64::NAN, 0.0)),
            ("stiffness damping", good.damping(0.0, -1e-9)),
        ] {
            let error = bad.check().unwrap_err();
            assert!(error.to_string().contains(what), "{error}");
        }
    }
}
