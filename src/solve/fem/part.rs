//! The elements of a body as its solver holds them.

use super::bound::{Moments, Rates};
use super::gather::Gather;
use super::kernel;
use super::model::Model;
use crate::body::state::Particle;
use crate::math::Scalar;
use crate::solve::forces::{Forces, Lanes, add_to};
use crate::solve::kernel::{Kernel, of_f32, of_f32_mut};
use crate::solve::threads;
use std::sync::Arc;

/// Elements, and what the bound on their fastest mode needs to know of the masses. Copies of a body share both.
#[derive(Clone, Debug)]
pub struct Part<S> {
    /// The elements.
    pub model: Arc<Model<S>>,
    moments: Arc<Moments<S>>,
    /// Made when threads first share the body.
    gather: Option<Box<Gather>>,
}

/// An element takes about as long as so many springs, per node that it has.
const ELEMENT: usize = 3;

/// The least parts that elements are shared out in: to keep and gather forces takes, in all, 1.6 times as long for linear tets
/// and 2.3 times for quadratic ones (measured).
const WORTH: usize = 4;

impl<S: Scalar> Part<S> {
    /// Elements whose nodes have these masses \[kg\].
    pub fn new(model: Arc<Model<S>>, masses: &[f64]) -> Self {
        Self {
            moments: Arc::new(model.moments(|n| 1.0 / masses[n])),
            model,
            gather: None,
        }
    }

    /// The same elements with other masses \[kg\].
    pub fn weighed(&self, masses: &[f64]) -> Self {
        Self::new(self.model.clone(), masses)
    }

    /// How many springs take as long.
    pub(crate) fn size(&self) -> usize {
        ELEMENT * self.model.nodes_per_element() * self.model.element_count()
    }

    /// Adds the elastic and damping force of every element to its nodes.
    pub(crate) fn add_forces(
        &mut self,
        kernel: Kernel,
        particles: &Vec<Particle<S>>,
        forces: &mut Forces<S>,
    ) {
        if let (Some(model), Some(particles), Some(forces)) = (
            of_f32::<_, Model<f32>>(&*self.model),
            of_f32::<_, Vec<_>>(particles),
            of_f32_mut(forces),
        ) {
            let parts = threads::parts();
            if parts >= WORTH {
                let new = || Box::new(Gather::new(model.node_count(), &model.nodes()));
                let gather = self.gather.get_or_insert_with(new);
                gather.add_forces((kernel, parts), model, particles, forces);
            } else {
                kernel::add_forces(kernel, model, particles, forces);
            }
        } else {
            let add = |n: usize, elastic: [S; 3], damping: [S; 3]| {
                let add = |sum: &mut Lanes<S>, [x, y, z]: [S; 3]| add_to(sum, [x, y, z, S::ZERO]);
                add(&mut forces.elastic[n], elastic);
                if let Some(sum) = forces.damping.get_mut(n) {
                    add(sum, damping);
                }
            };
            let (x, v) = (|n: usize| particles[n].x, |n: usize| particles[n].v);
            self.model.add_damped(x, v, add);
        }
        let alpha = S::of(self.model.solid().mass_damping);
        if alpha > S::ZERO {
            let nodes = threads::Nodes {
                first: 0,
                values: &mut forces.damping[..],
            };
            threads::share(nodes, threads::parts(), &|nodes| {
                let particles = &particles[nodes.first..];
                let free = |p: &Particle<S>| p.inv_mass > S::ZERO;
                let each = nodes.values.iter_mut().zip(particles);
                for (f, p) in each.filter(|(_, p)| free(p)) {
                    let c = alpha / p.inv_mass;
                    let [x, y, z] = p.v.map(|v| -(c * v));
                    add_to(f, [x, y, z, S::ZERO]);
                }
            });
        }
    }

    /// Bounds of λ(M⁻¹K) and of λ(M⁻¹C) as the particles stand.
    pub(crate) fn rates(&self, particles: &[Particle<S>]) -> [Rates; 2] {
        self.model.rates(&self.moments, particles)
    }
}
