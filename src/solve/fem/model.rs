//! The elements of a body with their law: one value for eight compiled loops.
//!
//! Which kind of element and which law a body has is asked once per pass, not once per element.

use super::elements::{Elements, Linear, Quadratic};
use super::stable::{Rates, element_matrix};
use super::stress::Stress;
use super::{mass, pass, stable, stress};
use crate::body::{BuildError, Solid, SolidLaw, TetMesh, Tets};
use crate::law::elastic::{
    Corotational, Elastic, Lame, NeoHookean, StVenantKirchhoff, StableNeoHookean, Viscous,
};
use crate::math::Scalar;
use crate::solve::Integrator;
use crate::solve::stable::StableStep;

#[derive(Clone, Debug)]
enum Kind<S> {
    Linear(Elements<S, Linear, 4, 1>),
    Quadratic(Elements<S, Quadratic, 10, 4>),
}

/// Elements and constants of a solid.
#[derive(Clone, Debug)]
pub struct Model<S> {
    kind: Kind<S>,
    solid: Solid,
    lame: Lame<f64>,
}

/// Runs an expression with `$elements` of the model's kind.
macro_rules! by_kind {
    ($model:expr, $elements:ident => $body:expr) => {
        match &$model.kind {
            Kind::Linear($elements) => $body,
            Kind::Quadratic($elements) => $body,
        }
    };
}

/// Runs an expression with `$law` of the model's, over `$s`.
macro_rules! by_law {
    ($model:expr, $s:ty, $law:ident => $body:expr) => {{
        let lame = Lame {
            lambda: <$s as Scalar>::of($model.lame.lambda),
            mu: <$s as Scalar>::of($model.lame.mu),
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
            Tets::Linear(_) => Kind::Linear(Elements::new(mesh)?),
            Tets::Quadratic(_) => Kind::Quadratic(Elements::new(mesh)?),
        };
        Ok(Self { kind, solid, lame })
    }

    /// The solid.
    pub fn solid(&self) -> &Solid {
        &self.solid
    }

    /// How many nodes the mesh has.
    pub fn node_count(&self) -> usize {
        by_kind!(self, e => e.node_count())
    }

    /// How many elements.
    pub fn element_count(&self) -> usize {
        by_kind!(self, e => e.list().len())
    }

    /// Lumped mass of each node \[kg\]; 0 for one no element has.
    pub fn masses(&self) -> Vec<f64> {
        let mut masses = by_kind!(self, e => mass::lumped_volumes(e));
        masses.iter_mut().for_each(|m| *m *= self.solid.density);
        masses
    }

    /// Gives every node the elastic force of its elements \[N\].
    pub fn add_elastic(&self, position: impl Fn(usize) -> [S; 3], add: impl FnMut(usize, [S; 3])) {
        by_kind!(self, e => by_law!(self, S, law => pass::add_elastic(e, &law, position, add)));
    }

    /// Gives every node the stiffness-proportional damping force of its elements \[N\]. The mass-proportional one, −α·m·v, needs
    /// no elements.
    pub fn add_damping(
        &self,
        position: impl Fn(usize) -> [S; 3],
        velocity: impl Fn(usize) -> [S; 3],
        add: impl FnMut(usize, [S; 3]),
    ) {
        if self.solid.stiffness_damping > 0.0 {
            let law = Viscous::proportional(self.solid.stiffness_damping, self.lame);
            by_kind!(self, e => pass::add_damping(e, &law, position, velocity, add));
        }
    }

    /// The elastic energy \[J\].
    pub fn energy(&self, position: impl Fn(usize) -> [S; 3]) -> f64 {
        by_kind!(self, e => by_law!(self, S, law => pass::energy(e, &law, position)))
    }

    /// Stress and strain of every element, in order.
    pub fn stresses(&self, position: impl Fn(usize) -> [S; 3]) -> Vec<Stress<S>> {
        by_kind!(self, e => by_law!(self, S, law => stress::stresses(e, &law, position).collect()))
    }

    /// Bounds of λ(M⁻¹K) and of λ(M⁻¹C), damping by mass included, at positions \[m\] with 1/m of each node \[1/kg\], 0 when
    /// pinned.
    pub fn rates(
        &self,
        position: impl Fn(usize) -> [f64; 3],
        inv_mass: impl Fn(usize) -> f64,
    ) -> [Rates; 2] {
        let elastic = by_kind!(self, e => by_law!(self, f64, law => {
            stable::elastic_rates(e, &law, &position, &inv_mass)
        }));
        let beta = self.solid.stiffness_damping;
        let mut damping = Rates::default();
        if beta > 0.0 {
            let law = Viscous::proportional(beta, self.lame);
            damping = by_kind!(self, e => stable::damping_rates(e, &law, &position, &inv_mass));
        }
        damping.largest += self.solid.mass_damping;
        [elastic, damping]
    }

    /// The longest stable substep of a scheme at positions \[m\] with 1/m of each node \[1/kg\], 0 when pinned. Its `spring` is
    /// the worst element.
    pub fn stable_step(
        &self,
        integrator: Integrator,
        position: impl Fn(usize) -> [f64; 3],
        inv_mass: impl Fn(usize) -> f64,
    ) -> StableStep {
        let [elastic, damping] = self.rates(position, inv_mass);
        let Solid {
            mass_damping: alpha,
            stiffness_damping: beta,
            ..
        } = self.solid;
        // The least c/k of any mode, α/λ + β.
        let relaxation = if elastic.largest > 0.0 {
            alpha / elastic.largest + beta
        } else {
            f64::INFINITY
        };
        let h = integrator.stable_step(elastic.largest, damping.largest, relaxation);
        StableStep {
            h: if h.is_nan() { 0.0 } else { h },
            spring: elastic.element,
            never: h.is_nan() || h <= 0.0,
        }
    }

    /// Calls `add` with the nodes and the stiffness of every element at positions \[m\]: row by row, 3N×3N \[N/m\].
    pub fn stiffness(
        &self,
        position: impl Fn(usize) -> [f64; 3],
        mut add: impl FnMut(&[u32], &[f64]),
    ) {
        let mut matrix = Vec::new();
        match &self.kind {
            Kind::Linear(e) => by_law!(self, f64, law => {
                matrix.resize(144, 0.0);
                for element in e.list() {
                    element_matrix::<S, Linear, 4, 1>(element, |f, d| law.differential(f, d), &position, &mut matrix);
                    add(&element.nodes, &matrix);
                }
            }),
            Kind::Quadratic(e) => by_law!(self, f64, law => {
                matrix.resize(900, 0.0);
                for element in e.list() {
                    element_matrix::<S, Quadratic, 10, 4>(element, |f, d| law.differential(f, d), &position, &mut matrix);
                    add(&element.nodes, &matrix);
                }
            }),
        }
    }
}
