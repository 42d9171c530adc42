//! The force pass by vectors as wide as the processor has.

use super::blocks::{Batch, Blocks};
use super::elements::Basis;
use super::model::Model;
use super::pass::Field;
use crate::body::state::Particle;
use crate::math::LANES;
use crate::solve::forces::{Force, add_to};
use crate::solve::kernel::{Half, Kernel, Pass, Vector, put_four, run};

/// Adds the elastic and damping force of every element to its nodes.
pub(crate) fn add_forces(
    kernel: Kernel,
    model: &Model<f32>,
    particles: &[Particle<f32>],
    forces: &mut [Force<f32>],
) {
    run(
        kernel,
        ElementForces {
            model,
            particles,
            forces,
        },
    );
}

struct ElementForces<'a> {
    model: &'a Model<f32>,
    particles: &'a [Particle<f32>],
    forces: &'a mut [Force<f32>],
}

impl Pass for ElementForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector>(self) {
        let mut rows = Rows {
            particles: self.particles,
            forces: self.forces,
        };
        self.model.add_by::<V>(&mut rows);
    }
}

/// A field of particles and forces as the state and the solver have them.
struct Rows<'a> {
    particles: &'a [Particle<f32>],
    forces: &'a mut [Force<f32>],
}

impl Rows<'_> {
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

impl<V: Vector> Field<f32, V> for Rows<'_> {
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
        for l in 0..blocks.filled::<V>(at) {
            for (n, [elastic, damping]) in rows.iter().enumerate() {
                let force = &mut self.forces[blocks.node::<V>(at, n, l)];
                add_to(&mut force.elastic, elastic[l]);
                if DAMPED {
                    add_to(&mut force.damping, damping[l]);
                }
            }
        }
    }
}
