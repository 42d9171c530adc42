//! The elements of a body with their law: one value for eight compiled loops.
//!
//! Which kind of element and which law a body has is asked once per pass, not once per element.

use super::blocks::Blocks;
use super::bound::{Moments, Rates};
use super::elements::{Elements, Linear, Quadratic};
use super::pass::{Field, Functions};
use super::stiffness::element_matrix;
use super::stress::Stress;
use super::{mass, pass, stress};
use crate::body::state::Particle;
use crate::body::{BuildError, Solid, SolidLaw, TetMesh, Tets};
use crate::law::elastic::tensor::unit;
use crate::law::elastic::{
    Corotational, Elastic, Lame, NeoHookean, StVenantKirchhoff, StableNeoHookean, Viscous,
};
use crate::math::{LANES, Number, Pack, Packed, Scalar};
use std::ops::Range;

#[derive(Clone, Debug)]
enum Kind<S> {
    Linear(Elements<Linear, 4, 1>, Blocks<S, Linear, 4, 1>),
    Quadratic(Elements<Quadratic, 10, 4>, Blocks<S, Quadratic, 10, 4>),
}

/// Elements and constants of a solid: for forces in blocks of the scalar `S`, for all else one by one in `f64`.
#[derive(Clone, Debug)]
pub struct Model<S> {
    kind: Kind<S>,
    solid: Solid,
    lame: Lame<f64>,
}

/// Runs an expression with `$elements` and `$blocks` of the model's kind.
macro_rules! by_kind {
    ($model:expr, ($elements:pat, $blocks:pat) => $body:expr) => {
        match &$model.kind {
            Kind::Linear($elements, $blocks) => $body,
            Kind::Quadratic($elements, $blocks) => $body,
        }
    };
}

/// Runs an expression with `$law` of the model's, over `$s`.
macro_rules! by_law {
    ($model:expr, $s:ty, $law:ident => $body:expr) => {{
        let lame = Lame {
            lambda: <$s as Number>::of($model.lame.lambda),
            mu: <$s as Number>::of($model.lame.mu),
        };
        match $model.solid.law {
            SolidLaw::Corotational => {
                let $law = Corotational(lame);
                $body
            }
            SolidLaw::NeoHookean => {
                let $law = NeoHookean(lame);
                $body
            }
            SolidLaw::StableNeoHookean => {
                let $law = StableNeoHookean::new(lame);
                $body
            }
            SolidLaw::StVenantKirchhoff => {
                let $law = StVenantKirchhoff(lame);
                $body
            }
        }
    }};
}

impl<S: Scalar> Model<S> {
    /// The elements of a mesh made of a solid.
    ///
    /// # Errors
    /// Those of [`TetMesh::check`] and [`Solid::check`].
    pub fn new(mesh: &TetMesh, solid: Solid) -> Result<Self, BuildError> {
        let lame = solid.lame()?;
        let kind = match &mesh.tets {
            Tets::Linear(_) => {
                let elements = Elements::new(mesh)?;
                let blocks = Blocks::new(&elements)?;
                Kind::Linear(elements, blocks)
            }
            Tets::Quadratic(_) => {
                let elements = Elements::new(mesh)?;
                let blocks = Blocks::new(&elements)?;
                Kind::Quadratic(elements, blocks)
            }
        };
        Ok(Self { kind, solid, lame })
    }

    /// The solid.
    pub fn solid(&self) -> &Solid {
        &self.solid
    }

    /// How many nodes the mesh has.
    pub fn node_count(&self) -> usize {
        by_kind!(self, (e, _) => e.node_count())
    }

    /// How many elements.
    pub fn element_count(&self) -> usize {
        by_kind!(self, (e, _) => e.list().len())
    }

    /// How many nodes each element has.
    pub(super) fn nodes_per_element(&self) -> usize {
        match &self.kind {
            Kind::Linear(..) => 4,
            Kind::Quadratic(..) => 10,
        }
    }

    /// The nodes of all elements, one element behind the other.
    pub(super) fn nodes(&self) -> Vec<u32> {
        by_kind!(self, (e, _) => e.list().iter().flat_map(|e| e.nodes).collect())
    }

    /// Lumped mass of each node \[kg\]; 0 for one no element has.
    pub fn masses(&self) -> Vec<f64> {
        let mut masses = by_kind!(self, (e, _) => mass::lumped_volumes(e));
        masses.iter_mut().for_each(|m| *m *= self.solid.density);
        masses
    }

    /// Whether it has damping of either kind.
    pub fn is_damped(&self) -> bool {
        self.solid.mass_damping > 0.0 || self.solid.stiffness_damping > 0.0
    }

    /// Gives every node the elastic force of its elements \[N\].
    pub fn add_elastic(
        &self,
        position: impl Fn(usize) -> [S; 3],
        mut add: impl FnMut(usize, [S; 3]),
    ) {
        self.add_of_functions::<false>(&mut Functions {
            position: &position,
            velocity: &|_| [S::ZERO; 3],
            add: &mut |n, elastic, _| add(n, elastic),
        });
    }

    /// Gives every node the elastic force of its elements and the stiffness-proportional damping force \[N\]. The mass-proportional
    /// one, −α·m·v, needs no elements.
    pub(crate) fn add_damped(
        &self,
        position: impl Fn(usize) -> [S; 3],
        velocity: impl Fn(usize) -> [S; 3],
        mut add: impl FnMut(usize, [S; 3], [S; 3]),
    ) {
        self.add_of_functions::<true>(&mut Functions {
            position: &position,
            velocity: &velocity,
            add: &mut add,
        });
    }

    #[inline(never)]
    fn add_of_functions<const DAMPED: bool>(&self, field: &mut Functions<S>) {
        self.add_forces::<Pack<S>, DAMPED>(self.blocks(), field);
    }

    /// All blocks of elements.
    pub(super) fn blocks(&self) -> Range<usize> {
        0..self.element_count().div_ceil(LANES)
    }

    /// The same by vectors `V` in any field, of some blocks of elements: with damping where there is some.
    #[inline(always)]
    pub(super) fn add_by<V: Packed<S>>(&self, blocks: Range<usize>, field: &mut impl Field<S, V>) {
        if self.solid.stiffness_damping > 0.0 {
            self.add_forces::<V, true>(blocks, field);
        } else {
            self.add_forces::<V, false>(blocks, field);
        }
    }

    #[inline(always)]
    fn add_forces<V: Packed<S>, const DAMPED: bool>(
        &self,
        blocks: Range<usize>,
        field: &mut impl Field<S, V>,
    ) {
        let viscous = Viscous::proportional(self.solid.stiffness_damping, self.lame);
        by_kind!(self, (_, b) => by_law!(self, V, law => {
            pass::add_forces::<S, V, _, _, _, _, DAMPED>(b, blocks, (&law, &viscous), field);
        }));
    }

    /// The elastic energy \[J\].
    pub fn energy(&self, position: impl Fn(usize) -> [f64; 3]) -> f64 {
        self.energy_of(0..self.element_count(), position)
    }

    /// That of some elements \[J\].
    pub(crate) fn energy_of(
        &self,
        list: impl Iterator<Item = usize>,
        position: impl Fn(usize) -> [f64; 3],
    ) -> f64 {
        by_kind!(self, (e, _) => by_law!(self, f64, law => pass::energy(e, list, &law, position)))
    }

    /// What the elastic forces of some elements do to the nodes \[W\].
    pub(crate) fn power_of(
        &self,
        list: impl Iterator<Item = usize>,
        position: impl Fn(usize) -> [f64; 3],
        velocity: impl Fn(usize) -> [f64; 3],
    ) -> f64 {
        by_kind!(self, (e, _) => by_law!(self, f64, law => {
            pass::power(e, list, &law, position, velocity)
        }))
    }

    /// Stress and strain of an element; `None` for an unknown one.
    pub fn stress(&self, element: usize, position: impl Fn(usize) -> [f64; 3]) -> Option<Stress> {
        match &self.kind {
            Kind::Linear(e, _) => {
                let element = e.list().get(element)?;
                Some(
                    by_law!(self, f64, law => stress::of::<Linear, _, 4, 1>(element, &law, position)),
                )
            }
            Kind::Quadratic(e, _) => {
                let element = e.list().get(element)?;
                Some(
                    by_law!(self, f64, law => stress::of::<Quadratic, _, 10, 4>(element, &law, position)),
                )
            }
        }
    }

    /// Stress and strain of every element, in order.
    pub fn stresses(&self, position: impl Fn(usize) -> [f64; 3]) -> Vec<Stress> {
        by_kind!(self, (e, _) => by_law!(self, f64, law => stress::stresses(e, &law, position).collect()))
    }

    /// What bounds of rates need to know of the masses: 1/m of each node \[1/kg\].
    pub fn moments(&self, inv_mass: impl Fn(usize) -> f64) -> Moments<S> {
        let rest = by_law!(self, f64, law => law.majorant(&unit()));
        by_kind!(self, (e, _) => Moments::new(e, &rest, inv_mass))
    }

    /// Bounds of λ(M⁻¹K) and of λ(M⁻¹C), damping by mass included, where the particles are.
    pub(crate) fn rates(&self, moments: &Moments<S>, particles: &[Particle<S>]) -> [Rates; 2] {
        let elastic = by_kind!(self, (_, b) => by_law!(self, Pack<S>, law => {
            moments.rates(b, |f| law.majorant(f), particles)
        }));
        let beta = self.solid.stiffness_damping;
        let mut damping = Rates::default();
        if beta > 0.0 {
            let law = Viscous::<Pack<S>>::proportional(beta, self.lame);
            damping = by_kind!(self, (_, b) => moments.rates(b, |f| law.majorant(f), particles));
        }
        damping.largest += self.solid.mass_damping;
        [elastic, damping]
    }

    /// Calls `add` with the nodes and the stiffness of every element at positions \[m\]: row by row, 3N×3N \[N/m\].
    pub fn stiffness(
        &self,
        position: impl Fn(usize) -> [f64; 3],
        mut add: impl FnMut(&[u32], &[f64]),
    ) {
        let mut matrix = Vec::new();
        match &self.kind {
            Kind::Linear(e, _) => by_law!(self, f64, law => {
                matrix.resize(144, 0.0);
                for element in e.list() {
                    element_matrix::<Linear, 4, 1>(element, |f, d| law.differential(f, d), &position, &mut matrix);
                    add(&element.nodes, &matrix);
                }
            }),
            Kind::Quadratic(e, _) => by_law!(self, f64, law => {
                matrix.resize(900, 0.0);
                for element in e.list() {
                    element_matrix::<Quadratic, 10, 4>(element, |f, d| law.differential(f, d), &position, &mut matrix);
                    add(&element.nodes, &matrix);
                }
            }),
        }
    }
}
