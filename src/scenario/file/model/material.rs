//! What deformables are made of: bars of a lattice, or a solid of tets.

use super::super::check::{NOT_NEGATIVE, POISSON, POSITIVE, STRENGTH};
use super::super::decode::{Decode, Decoder};
use super::super::schema::{choice, record};
use super::super::tree::{Node, Value};
use crate::body::Material;

record! {
    /// What the springs of a deformable are made of. A name in quotes stands for one of `materials`, or for a preset, as a
    /// word without quotes does:
    /// MildSteel, Aluminium, Rubber, PolypropyleneFoam, AluminiumFoam, MildSteelFoam, CarBody.
    pub struct SpringMaterial {
        /// Young's modulus \[Pa\].
        young: f64, POSITIVE;
        /// Density \[kg/m³\].
        density: f64, POSITIVE;
        /// Viscosity \[Pa·s\].
        viscosity: f64 = 0.0, NOT_NEGATIVE;
        /// Yield stress in tension \[Pa\]; inf for none.
        yield_tension: f64 = f64::INFINITY, STRENGTH;
        /// Yield stress in compression, positive \[Pa\]; inf for none.
        yield_compression: f64 = f64::INFINITY, STRENGTH;
        /// Growth of the yield stress per plastic strain \[Pa\].
        hardening: f64 = 0.0, NOT_NEGATIVE;
        /// Tensile stress at which a spring breaks \[Pa\]; inf for never.
        strength: f64 = f64::INFINITY, STRENGTH;
        /// Tensile strain at which a spring breaks; inf for never.
        break_strain: f64 = f64::INFINITY, STRENGTH;
    }
}

record! {
    /// What a solid of tets is made of. A name in quotes stands for one of `materials`.
    pub struct SolidMaterial {
        /// Young's modulus \[Pa\].
        young: f64, POSITIVE;
        /// Poisson's ratio, above -1 and below 0.5.
        poisson: f64, POISSON;
        /// Density \[kg/m³\].
        density: f64, POSITIVE;
        /// How stress follows from large strains.
        law: Law = Law::Corotational;
        /// α of Rayleigh's damping \[1/s\].
        mass_damping: f64 = 0.0, NOT_NEGATIVE;
        /// β of Rayleigh's damping \[s\].
        stiffness_damping: f64 = 0.0, NOT_NEGATIVE;
    }
}

choice! {
    /// How stress follows from large strains.
    pub enum Law {
        /// Linear in the turned frame.
        Corotational;
        /// For rubber.
        NeoHookean;
        /// The stable form of Smith, de Goes and Kim.
        StableNeoHookean;
        /// Weak in compression.
        StVenantKirchhoff;
    }
}

/// A material that may be given by its name.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(transparent)]
pub struct Made<T>(pub T);

impl<T: Decode + Preset> Decode for Made<T> {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        let known = |word: &str| T::PRESETS.iter().find(|(name, _)| *name == word);
        match &node.value {
            Value::Text(name) => match known(name).filter(|_| !d.has_material(name)) {
                Some((_, make)) => Some(make()),
                None => d.material(node, name, T::PRESETS.iter().map(|(name, _)| *name)),
            },
            Value::Named(word, None) => match known(word) {
                Some((_, make)) => Some(make()),
                None => {
                    let names = T::PRESETS.iter().map(|(name, _)| *name);
                    d.wrong(node.at, |_| {
                        super::super::problem::unknown("preset", word, names)
                    });
                    None
                }
            },
            _ => T::decode(node, d),
        }
        .map(Self)
    }
}

/// A name, and the material it stands for.
pub(crate) type Named<T> = (&'static str, fn() -> T);

/// A kind of material with presets by name.
pub(crate) trait Preset: Sized + 'static {
    /// Their names.
    const PRESETS: &'static [Named<Self>];
}

impl Preset for SpringMaterial {
    const PRESETS: &'static [Named<Self>] = &[
        ("MildSteel", || Material::mild_steel().into()),
        ("Aluminium", || Material::aluminium().into()),
        ("Rubber", || Material::rubber().into()),
        ("PolypropyleneFoam", || {
            Material::polypropylene_foam().into()
        }),
        ("AluminiumFoam", || Material::aluminium_foam().into()),
        ("MildSteelFoam", || Material::mild_steel_foam().into()),
        ("CarBody", || Material::car_body().into()),
    ];
}

impl Preset for SolidMaterial {
    const PRESETS: &'static [Named<Self>] = &[];
}

impl From<Material> for SpringMaterial {
    fn from(m: Material) -> Self {
        Self {
            young: m.young.into(),
            density: m.density.into(),
            viscosity: m.viscosity.into(),
            yield_tension: m.yield_tension.into(),
            yield_compression: m.yield_compression.into(),
            hardening: m.hardening.into(),
            strength: m.strength.into(),
            break_strain: m.break_strain.into(),
        }
    }
}

/// A material of the list that deformables share: a solid if it has a Poisson ratio, of springs otherwise.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum AnyMaterial {
    /// For springs.
    Springs(SpringMaterial),
    /// For tets.
    Solid(SolidMaterial),
}

impl Decode for AnyMaterial {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        match node.get("poisson") {
            Some(_) => SolidMaterial::decode(node, d).map(Self::Solid),
            None => Made::decode(node, d).map(|m: Made<SpringMaterial>| Self::Springs(m.0)),
        }
    }
}
