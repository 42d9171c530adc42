//! The pass of symplectic Euler over nodes, sixteen at a time; see [`crate::solve::integrate`] for what it does.

use super::SLICES;
use super::vector::{LANES, Pass, Vector, Wide, columns, columns_of_four, put, put_four, run};
use crate::body::state::{Particle, State};
use crate::math::two_sum;
use crate::solve::forces::Force;
use crate::solve::solver::Solver;
use crate::solve::springs::Rows;
use crate::solve::threads::{NODE, Work, parts, share};

/// Speeds below this are none \[m/s\]: numbers that are not normal would cost a hundred cycles each.
const STILL: f64 = 1e-20;

/// Sums over nodes: work \[J\] and squared speeds \[m²/s²\].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Totals {
    pub damping: f64,
    pub external: f64,
    pub fastest: f32,
    /// Sum of all, so that what is not finite shows.
    pub all_speeds: f32,
}

/// Moves all nodes but the last few that make no sixteen, none without a table for the kernels; how many it has moved.
pub(crate) fn symplectic_euler(
    solver: &mut Solver<f32>,
    state: &mut State<f32>,
    h: f32,
) -> (usize, Totals) {
    if matches!(solver.table.rows, Rows::Never) {
        return Default::default();
    }
    let (particles, _) = state.particles.as_chunks_mut::<LANES>();
    let (low, _) = state.low.as_chunks_mut::<LANES>();
    let (forces, _) = solver.forces.as_chunks::<LANES>();
    let moved = LANES * particles.len();
    let mut totals = std::mem::take(&mut solver.totals);
    totals.resize(particles.len().div_ceil(SLICES), Totals::default());
    let nodes = Nodes {
        particles,
        low,
        forces,
        applied: solver.applied.as_chunks().0,
        damped: solver.is_damped(),
        gravity: solver.external.gravity,
        h,
        totals: &mut totals,
    };
    let kernel = solver.kernel;
    share(nodes, parts(NODE * moved), &|nodes| run(kernel, nodes));
    let mut sum = Totals::default();
    totals.iter().for_each(|block| sum.add(block));
    solver.totals = totals;
    (moved, sum)
}

impl Totals {
    fn add(&mut self, other: &Self) {
        self.damping += other.damping;
        self.external += other.external;
        self.fastest = self.fastest.max(other.fastest);
        self.all_speeds += other.all_speeds;
    }
}

struct Nodes<'a> {
    particles: &'a mut [[Particle<f32>; LANES]],
    low: &'a mut [[[f32; 4]; LANES]],
    forces: &'a [[Force<f32>; LANES]],
    applied: &'a [[[f32; 3]; LANES]],
    /// Whether there is any damping force.
    damped: bool,
    gravity: [f32; 3],
    h: f32,
    /// Sums of each block: few enough nodes that no sum in `f32` outgrows what is added to it, and that they stay in the nearest
    /// cache for the next part.
    totals: &'a mut [Totals],
}

impl Work for Nodes<'_> {
    fn blocks(&self) -> usize {
        self.totals.len()
    }

    fn cut(self, at: usize) -> [Self; 2] {
        let groups = SLICES * at;
        let (particles, more_particles) = self.particles.split_at_mut(groups);
        let (low, more_low) = self.low.split_at_mut(groups);
        let (forces, more_forces) = self.forces.split_at(groups);
        let (applied, more_applied) = self.applied.split_at(groups.min(self.applied.len()));
        let (totals, more_totals) = self.totals.split_at_mut(at);
        [
            Self {
                particles,
                low,
                forces,
                applied,
                totals,
                ..self
            },
            Self {
                particles: more_particles,
                low: more_low,
                forces: more_forces,
                applied: more_applied,
                totals: more_totals,
                ..self
            },
        ]
    }
}

impl Pass for Nodes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector>(self) {
        match (self.damped, self.applied.is_empty()) {
            (false, true) => self.runs::<V, false, false>(),
            (true, true) => self.runs::<V, true, false>(),
            (_, false) => self.runs::<V, true, true>(),
        }
    }
}

impl Nodes<'_> {
    #[inline(always)]
    fn runs<V: Vector, const DAMPED: bool, const APPLIED: bool>(self) {
        let constants = Constants {
            gravity: self.gravity.map(|g| V::of(g.into())),
            h: V::of(self.h.into()),
            half: V::of((0.5 * self.h).into()),
            still: V::of(STILL),
        };
        for (block, totals) in self.totals.iter_mut().enumerate() {
            let first = SLICES * block;
            let groups = first..self.particles.len().min(first + SLICES);
            let mut sums = [[0.0; LANES]; 4].map(Wide);
            for part in 0..LANES / V::LANES {
                let mut lanes = Lanes::<V>::default();
                for group in groups.clone() {
                    let nodes = (&mut self.particles[group], &mut self.low[group]);
                    let applied = if APPLIED {
                        &self.applied[group]
                    } else {
                        &[[0.0; 3]; LANES]
                    };
                    let forces = (&self.forces[group], applied);
                    lanes.step::<DAMPED, APPLIED>(nodes, forces, part, &constants);
                }
                lanes.damping.store(&mut sums[0], part);
                lanes.external.store(&mut sums[1], part);
                lanes.fastest.store(&mut sums[2], part);
                lanes.all_speeds.store(&mut sums[3], part);
            }
            let sum = |w: &Wide| w.0.iter().map(|&x| f64::from(x)).sum::<f64>();
            *totals = Totals {
                damping: sum(&sums[0]),
                external: sum(&sums[1]),
                fastest: sums[2].0.iter().fold(0.0, |a, &b| a.max(b)),
                all_speeds: sum(&sums[3]) as f32,
            };
        }
    }
}

struct Constants<V> {
    gravity: [V; 3],
    h: V,
    half: V,
    still: V,
}

/// Sums of each lane.
#[derive(Default)]
struct Lanes<V> {
    damping: V,
    external: V,
    fastest: V,
    all_speeds: V,
}

impl<V: Vector> Lanes<V> {
    /// Moves a part of a group.
    #[inline(always)]
    fn step<const DAMPED: bool, const APPLIED: bool>(
        &mut self,
        (particles, low): (&mut [Particle<f32>; LANES], &mut [[f32; 4]; LANES]),
        (forces, applied): (&[Force<f32>; LANES], &[[f32; 3]; LANES]),
        part: usize,
        c: &Constants<V>,
    ) {
        let [elastic, mut damping] = columns::<V, _>(forces, part);
        if !DAMPED {
            damping = [V::ZERO; 4];
        }
        let [mut at, mut velocity] = columns::<V, _>(particles, part);
        let mut below = columns_of_four::<V>(low, part);
        let inv_mass = at[3];
        let free = V::above(inv_mass, V::ZERO, V::ONE, V::ZERO);
        let (mut by_damping, mut by_elastic, mut outside) = (V::ZERO, V::ZERO, V::ZERO);
        let mut squared = V::ZERO;
        for k in 0..3 {
            let mut force = elastic[k] + damping[k];
            let mut push = V::ZERO;
            if APPLIED {
                push = V::of_lanes(|l| applied[part * V::LANES + l][k].into());
                force += push;
            }
            let old = velocity[k];
            let new = old + c.h * (c.gravity[k] * free + force * inv_mass);
            // What is not a number stays so: its product with 0 is none either.
            let new = V::above(new.abs(), c.still, new, new * V::ZERO);
            let mean = c.half * (old + new);
            velocity[k] = new;
            squared += new * new;
            by_elastic += elastic[k] * mean;
            if DAMPED {
                by_damping += damping[k] * mean;
            }
            if APPLIED {
                outside += push * mean;
            }
            (at[k], below[k]) = two_sum(at[k], c.h * new + below[k]);
        }
        // Whatever holds a pinned node takes up the work on it.
        let work = by_elastic + by_damping + outside;
        let held = V::above(inv_mass, V::ZERO, V::ZERO, work);
        self.damping -= by_damping;
        self.external += outside - held;
        self.fastest = squared.max(self.fastest);
        self.all_speeds += squared;
        put(particles, part, [at, velocity]);
        put_four(low, part, below);
    }
}
