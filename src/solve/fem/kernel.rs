//! The force pass by vectors as wide as the processor has.

use super::blocks::{Batch, Blocks};
use super::elements::Basis;
use super::model::Model;
use super::pass::Field;
use crate::body::state::Particle;
use crate::math::LANES;
use crate::solve::forces::{Force, Forces, add_to};
use crate::solve::kernel::{Half, Kernel, Pass, Vector, put_four, run};
use crate::solve::threads::Work;
use std::ops::Range;

/// Adds the elastic and damping force of every element to its nodes.
pub(crate) fn add_forces(
    kernel: Kernel,
    model: &Model<f32>,
    particles: &[Particle<f32>],
    forces: &mut Forces<f32>,
) {
    let elements = ElementForces {
        model,
        particles,
        blocks: model.blocks(),
        out: Out::Nodes(forces),
    };
    run(kernel, elements);
}

/// The elements of some blocks.
pub(super) struct ElementForces<'a> {
    pub model: &'a Model<f32>,
    pub particles: &'a [Particle<f32>],
    pub blocks: Range<usize>,
    pub out: Out<'a>,
}

/// Where the forces of elements go.
pub(super) enum Out<'a> {
    /// They are added to those of nodes, which only all elements together may do.
    Nodes(&'a mut Forces<f32>),
    /// They are kept, from those of the first block on: one for each node of each element.
    Elements(&'a mut [Force<f32>]),
}

impl Work for ElementForces<'_> {
    fn blocks(&self) -> usize {
        match self.out {
            Out::Nodes(_) => 1,
            Out::Elements(_) => self.blocks.len(),
        }
    }

    fn cut(self, at: usize) -> [Self; 2] {
        let middle = self.blocks.start + at;
        let each = LANES * self.model.nodes_per_element();
        let [out, rest] = match self.out {
            Out::Elements(forces) => {
                let (forces, rest) = forces.split_at_mut(at * each);
                [Out::Elements(forces), Out::Elements(rest)]
            }
            whole => [whole, Out::Elements(&mut [])],
        };
        let of = |blocks, out| Self {
            model: self.model,
            particles: self.particles,
            blocks,
            out,
        };
        [
            of(self.blocks.start..middle, out),
            of(middle..self.blocks.end, rest),
        ]
    }
}

impl Pass for ElementForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector>(mut self) {
        let model = self.model;
        model.add_by::<V>(self.blocks.clone(), &mut self);
    }
}

impl ElementForces<'_> {
    /// Half of the rows of the nodes of some elements, less that of their first node.
    #[inline(always)]
    fn fetch<V: Vector, B: Basis<N, G>, const N: usize, const G: usize>(
        &self,
        blocks: &Blocks<f32, B, N, G>,
        at: Batch,
        half: Half,
    ) -> [[V; 3]; N] {
        let mut values = [[V::ZERO; 3]; N];
        if let Some(reader) = blocks.places.of(self.particles) {
            for (node, value) in values.iter_mut().enumerate() {
                let slot = reader.slot(N * at.block + node);
                let [x, y, z, _] = slot.columns(at.part, half);
                *value = [x, y, z];
            }
        }
        super::blocks::relative(values)
    }
}

impl<V: Vector> Field<f32, V> for ElementForces<'_> {
    #[inline(always)]
    fn positions<B: Basis<N, G>, const N: usize, const G: usize>(
        &self,
        blocks: &Blocks<f32, B, N, G>,
        at: Batch,
    ) -> [[V; 3]; N] {
        self.fetch(blocks, at, Half::First)
    }

    #[inline(always)]
    fn velocities<B: Basis<N, G>, const N: usize, const G: usize>(
        &self,
        blocks: &Blocks<f32, B, N, G>,
        at: Batch,
    ) -> [[V; 3]; N] {
        self.fetch(blocks, at, Half::Second)
    }

    /// Element by element: neighbours share nodes, and sums keep the order of elements.
    #[inline(always)]
    fn take<B: Basis<N, G>, const N: usize, const G: usize, const DAMPED: bool>(
        &mut self,
        blocks: &Blocks<f32, B, N, G>,
        at: Batch,
        elastic: &[[V; 3]; N],
        damping: &[[V; 3]; N],
    ) {
        let lanes = |f: &[V; 3]| [-f[0], -f[1], -f[2], V::ZERO];
        let mut rows = [[[[0.0; 4]; LANES]; 2]; N];
        for (n, [first, second]) in rows.iter_mut().enumerate() {
            put_four(first, 0, lanes(&elastic[n]));
            if DAMPED {
                put_four(second, 0, lanes(&damping[n]));
            }
        }
        let lanes = 0..blocks.filled::<V>(at);
        match &mut self.out {
            Out::Nodes(forces) => {
                for l in lanes {
                    for (n, [elastic, damping]) in rows.iter().enumerate() {
                        let node = blocks.node::<V>(at, n, l);
                        add_to(&mut forces.elastic[node], elastic[l]);
                        if DAMPED {
                            add_to(&mut forces.damping[node], damping[l]);
                        }
                    }
                }
            }
            Out::Elements(forces) => {
                let first = LANES * (at.block - self.blocks.start) + V::LANES * at.part;
                let kept = forces[N * first..].chunks_exact_mut(N);
                for (l, kept) in lanes.zip(kept) {
                    for (force, [elastic, damping]) in kept.iter_mut().zip(&rows) {
                        (force.elastic, force.damping) = (elastic[l], damping[l]);
                    }
                }
            }
        }
    }
}
