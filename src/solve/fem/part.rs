//! The elements of a body as its solver holds them.

use super::bound::{Moments, Rates};
use super::model::Model;
use crate::body::state::Particle;
use crate::math::Scalar;
use crate::solve::forces::{Force, add_to};
use std::sync::Arc;

/// Elements, and what the bound on their fastest mode needs to know of the masses. Copies of a body share both.
#[derive(Clone, Debug)]
pub struct Part<S> {
    /// The elements.
    pub model: Arc<Model<S>>,
    moments: Arc<Moments<S>>,
}

impl<S: Scalar> Part<S> {
    /// Elements whose nodes have these masses \[kg\].
    pub fn new(model: Arc<Model<S>>, masses: &[f64]) -> Self {
        Self {
            moments: Arc::new(model.moments(|n| 1.0 / masses[n])),
            model,
        }
    }

    /// The same elements with other masses \[kg\].
    pub fn weighed(&self, masses: &[f64]) -> Self {
        Self::new(self.model.clone(), masses)
    }

    /// Adds the elastic and damping force of every element to its nodes.
    pub(crate) fn add_forces(&self, particles: &[Particle<S>], forces: &mut [Force<S>]) {
        if self.model.solid().stiffness_damping > 0.0 {
            let add = |n: usize, elastic, damping| {
                add_to(&mut forces[n].elastic, elastic);
                add_to(&mut forces[n].damping, damping);
            };
            let model = &self.model;
            model.add_damped_lanes(|n| particles[n].x, |n| particles[n].v, add);
        } else {
            let add = |n: usize, elastic| add_to(&mut forces[n].elastic, elastic);
            self.model.add_elastic_lanes(|n| particles[n].x, add);
        }
        let alpha = S::of(self.model.solid().mass_damping);
        if alpha > S::ZERO {
            let free = |p: &&Particle<S>| p.inv_mass > S::ZERO;
            for (f, p) in forces.iter_mut().zip(particles).filter(|(_, p)| free(p)) {
                let c = alpha / p.inv_mass;
                for k in 0..3 {
                    f.damping[k] -= c * p.v[k];
                }
            }
        }
    }

    /// Bounds of λ(M⁻¹K) and of λ(M⁻¹C) as the particles stand.
    pub(crate) fn rates(&self, particles: &[Particle<S>]) -> [Rates; 2] {
        self.model.rates(&self.moments, |n| particles[n].x)
    }
}
