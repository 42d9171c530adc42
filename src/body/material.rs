//! Materials: the constants of a solid in SI units, with presets and their sources.

use super::BuildError;
use super::error::{not_negative, positive, positive_or_infinite};
use crate::math::Real;

/// Constants of an isotropic solid. A spring of section A and length L gets k = E·A/L, c = η·A/L, F_y = σ_y·A,
/// hardening H·A/L, break force σ_b·A.
///
/// In a lattice squeezed along its edges the first springs flow at σ_y, those along the edges; the face diagonals follow,
/// and once all flow the lattice carries about 2·σ_y. Without hardening it gives way from a strain of some 3 % on, the finer its cells
/// the more.
///
/// Springs transmit central forces only, so a lattice has Poisson's ratio ¼ (a sheet ⅓) whatever the real material's is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus E \[Pa\].
    pub young: Real,
    /// Density ρ \[kg/m³\].
    pub density: Real,
    /// Viscosity η of the Kelvin–Voigt solid \[Pa·s\]; the loss factor at angular frequency ω is η·ω/E.
    pub viscosity: Real,
    /// Yield stress in tension \[Pa\]; infinite: elastic.
    pub yield_tension: Real,
    /// Yield stress in compression, positive \[Pa\]; infinite: elastic.
    pub yield_compression: Real,
    /// Plastic modulus H: growth of the yield stress per plastic strain \[Pa\].
    pub hardening: Real,
    /// Tensile stress at which a spring breaks \[Pa\]; infinite: never.
    pub strength: Real,
    /// Tensile strain at which a spring breaks; infinite: never.
    pub break_strain: Real,
}

impl Material {
    /// An elastic, undamped material with Young's modulus \[Pa\] and density \[kg/m³\].
    pub const fn elastic(young: Real, density: Real) -> Self {
        Self {
            young,
            density,
            viscosity: 0.0,
            yield_tension: Real::INFINITY,
            yield_compression: Real::INFINITY,
            hardening: 0.0,
            strength: Real::INFINITY,
            break_strain: Real::INFINITY,
        }
    }

    /// The same material, flowing at ±`stress` Pa with plastic modulus `hardening` Pa.
    pub const fn yielding(self, stress: Real, hardening: Real) -> Self {
        Self {
            yield_tension: stress,
            yield_compression: stress,
            hardening,
            ..self
        }
    }

    /// The same material with viscosity η \[Pa·s\].
    pub const fn viscosity(self, viscosity: Real) -> Self {
        Self { viscosity, ..self }
    }

    /// Low-carbon structural steel S235: E = 210 GPa, ρ = 7850 kg/m³, f_y = 235 MPa (EN 1993-1-1, table 3.1 and 3.2.6),
    /// plastic modulus E/100 (the bilinear model of EN 1993-1-5, annex C), elongation at fracture 26 % (EN 10025-2).
    pub const fn mild_steel() -> Self {
        Self {
            break_strain: 0.26,
            ..Self::elastic(210.0e9, 7850.0).yielding(235.0e6, 2.1e9)
        }
    }

    /// Aluminium alloy EN AW-6082-T6: E = 70 GPa, ρ = 2700 kg/m³, f_o = 250 MPa, f_u = 290 MPa at 8 % elongation
    /// (EN 1999-1-1, table 3.2a and 3.2.5), plastic modulus (f_u − f_o)/0.08.
    pub const fn aluminium() -> Self {
        Self {
            break_strain: 0.08,
            ..Self::elastic(70.0e9, 2700.0).yielding(250.0e6, 0.5e9)
        }
    }

    /// Natural rubber of about 50 IRHD: E = 2.2 MPa, ρ = 930 kg/m³, elongation at break 500 % (Gent, *Engineering with
    /// Rubber*, 3rd ed., ch. 3 and appendix); viscosity for a loss factor of about 0.1 at 10 Hz.
    pub const fn rubber() -> Self {
        Self {
            break_strain: 5.0,
            ..Self::elastic(2.2e6, 930.0).viscosity(3.5e3)
        }
    }

    /// Expanded polypropylene foam of 60 kg/m³: E = 13 MPa, crush stress 0.4 MPa, by the closed-cell scaling laws of
    /// Gibson & Ashby, *Cellular Solids*, 2nd ed., ch. 5 (E* ≈ E_s(ρ*/ρ_s)², σ* ≈ 0.3 σ_s(ρ*/ρ_s)^1.5 with cell-face and
    /// gas terms) fitted to bumper-foam data sheets. Tension is weaker than crushing is strong: it tears at 15 %.
    pub const fn polypropylene_foam() -> Self {
        Self {
            break_strain: 0.15,
            ..Self::elastic(13.0e6, 60.0).yielding(0.4e6, 0.5e6)
        }
    }

    /// Aluminium foam of 10 % relative density: E = 1 GPa·(0.1)²·70 ≈ 0.7 GPa, ρ = 270 kg/m³, plateau 1.9 MPa
    /// (Ashby et al., *Metal Foams: A Design Guide*, table 4.2: E ≈ E_s(ρ*/ρ_s)², σ_pl ≈ 0.25 σ_y,s(ρ*/ρ_s)^1.5).
    pub const fn aluminium_foam() -> Self {
        Self::elastic(0.7e9, 270.0).yielding(1.98e6, 2.0e6)
    }

    /// Steel foam of 5 % relative density, by the same scaling from mild steel: E = 0.525 GPa, ρ = 392 kg/m³, plateau
    /// 0.66 MPa. A light body that crushes like folded sheet metal.
    pub const fn mild_steel_foam() -> Self {
        Self::elastic(0.525e9, 392.0).yielding(0.66e6, 0.7e6)
    }

    /// The front of a passenger car smeared into a solid: about 1300 kg over 7 m³ and a crush force of 250 kN (the
    /// 18 to 25 g plateau of a 56 km/h full-width barrier test, FMVSS 208) over about 1.2 m² give 190 kg/m³ and 0.2 MPa;
    /// the modulus gives an elastic strain of 1 %.
    pub const fn car_body() -> Self {
        Self::elastic(20.0e6, 190.0)
            .yielding(0.2e6, 0.1e6)
            .viscosity(2.0e3)
    }

    /// Checks the range of every constant.
    ///
    /// # Errors
    /// [`BuildError::Value`] with the name of the constant and its value.
    pub fn check(&self) -> Result<(), BuildError> {
        positive("the material's young modulus", self.young.into())?;
        positive("the material's density", self.density.into())?;
        not_negative("the material's viscosity", self.viscosity.into())?;
        not_negative("the material's hardening", self.hardening.into())?;
        positive_or_infinite(
            "the material's yield stress in tension",
            self.yield_tension.into(),
        )?;
        positive_or_infinite(
            "the material's yield stress in compression",
            self.yield_compression.into(),
        )?;
        positive_or_infinite("the material's strength", self.strength.into())?;
        positive_or_infinite("the material's break strain", self.break_strain.into())?;
        Ok(())
    }
}
