//! Forces of elements for a body that threads share: kept by elements until all are there, then gathered by nodes.
//!
//! Elements share nodes, so no part of them owns what it would add to. Each node adds what its elements have for it in the
//! order of elements, as the pass over the whole body does, so both give the same bits.

use super::kernel::{ElementForces, Out};
use super::model::Model;
use crate::body::state::Particle;
use crate::solve::forces::{Force, Forces, Lanes, add_to};
use crate::solve::kernel::{Kernel, run};
use crate::solve::threads::{Nodes, share};

/// What is kept.
#[derive(Clone, Debug, Default)]
pub struct Gather {
    /// Of each node of each element.
    forces: Vec<Force<f32>>,
    /// Per node where its places begin, and the end.
    firsts: Vec<u32>,
    /// Where in `forces` those of a node are, in the order of elements.
    places: Vec<u32>,
}

impl Gather {
    /// Of elements with so many nodes each, which are the numbers.
    pub fn new(node_count: usize, nodes: &[u32]) -> Self {
        let mut firsts = vec![0; node_count + 1];
        for &node in nodes {
            firsts[node as usize + 1] += 1;
        }
        for node in 0..node_count {
            firsts[node + 1] += firsts[node];
        }
        let mut next = firsts.clone();
        let mut places = vec![0; nodes.len()];
        for (place, &node) in (0..).zip(nodes) {
            let at = &mut next[node as usize];
            places[*at as usize] = place;
            *at += 1;
        }
        Self {
            forces: vec![Force::default(); nodes.len()],
            firsts,
            places,
        }
    }

    /// Adds the elastic and damping force of every element to its nodes, in so many parts at once.
    pub fn add_forces(
        &mut self,
        (kernel, parts): (Kernel, usize),
        model: &Model<f32>,
        particles: &[Particle<f32>],
        forces: &mut Forces<f32>,
    ) {
        let elements = ElementForces {
            model,
            particles,
            blocks: model.blocks(),
            out: Out::Elements(&mut self.forces),
        };
        share(elements, parts, &|elements| run(kernel, elements));
        self.add_to_nodes(parts, &mut forces.elastic, |f| f.elastic);
        if model.solid().stiffness_damping > 0.0 {
            self.add_to_nodes(parts, &mut forces.damping, |f| f.damping);
        }
    }

    /// A body may have more nodes than its elements have.
    fn add_to_nodes(
        &self,
        parts: usize,
        sums: &mut [Lanes<f32>],
        which: impl Fn(&Force<f32>) -> Lanes<f32> + Sync,
    ) {
        let nodes = Nodes {
            first: 0,
            values: &mut sums[..self.firsts.len() - 1],
        };
        share(nodes, parts, &|nodes| self.gather(nodes, &which));
    }

    #[inline(always)]
    fn gather(&self, nodes: Nodes<Lanes<f32>>, which: &impl Fn(&Force<f32>) -> Lanes<f32>) {
        let starts = self.firsts[nodes.first..].windows(2);
        for (force, start) in nodes.values.iter_mut().zip(starts) {
            for &place in &self.places[start[0] as usize..start[1] as usize] {
                add_to(force, which(&self.forces[place as usize]));
            }
        }
    }
}
