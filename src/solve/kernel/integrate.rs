//! The pass of symplectic Euler over nodes; see [`crate::solve::integrate`] for what it does.
//!
//! Rows stay rows: a vector holds x, y, z of one, two or four nodes and a fourth number of each that goes along. To make
//! columns of rows, and rows of columns again, would take longer than to compute a fourth number for nothing.

use super::SLICES;
use super::vector::{LANES, Pass, Vector, Wide, numbers_mut, run};
use crate::body::state::{Particle, State};
use crate::math::two_sum;
use crate::solve::forces::Lanes as Four;
use crate::solve::solver::Solver;
use crate::solve::springs::Rows;
use crate::solve::threads::{Work, parts, share};

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
    let moved = LANES * particles.len();
    let mut totals = std::mem::take(&mut solver.totals);
    totals.resize(particles.len().div_ceil(SLICES), Totals::default());
    let nodes = Nodes {
        particles,
        low,
        elastic: solver.forces.elastic.as_chunks().0,
        damping: solver.forces.damping.as_chunks().0,
        applied: solver.applied.as_chunks().0,
        gravity: solver.external.gravity,
        h,
        totals: &mut totals,
    };
    let kernel = solver.kernel;
    share(nodes, parts(), &|nodes| run(kernel, nodes));
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
    elastic: &'a [[Four<f32>; LANES]],
    /// Empty where there are no damping forces.
    damping: &'a [[Four<f32>; LANES]],
    applied: &'a [[[f32; 3]; LANES]],
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
        let (elastic, more_elastic) = self.elastic.split_at(groups);
        let (damping, more_damping) = self.damping.split_at(groups.min(self.damping.len()));
        let (applied, more_applied) = self.applied.split_at(groups.min(self.applied.len()));
        let (totals, more_totals) = self.totals.split_at_mut(at);
        [
            Self {
                particles,
                low,
                elastic,
                damping,
                applied,
                totals,
                ..self
            },
            Self {
                particles: more_particles,
                low: more_low,
                elastic: more_elastic,
                damping: more_damping,
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
        match (self.damping.is_empty(), self.applied.is_empty()) {
            (true, true) => self.runs::<V, false, false>(),
            (false, true) => self.runs::<V, true, false>(),
            (_, false) => self.runs::<V, true, true>(),
        }
    }
}

impl Nodes<'_> {
    #[inline(always)]
    fn runs<V: Vector, const DAMPED: bool, const APPLIED: bool>(self) {
        let constants = Constants {
            // What stands in the fourth place, 1/m and the swing, does not change; swings are not as small as speeds may be.
            gravity: threes(self.gravity),
            h: threes([self.h; 3]),
            half: threes([0.5 * self.h; 3]),
            one: threes([1.0; 3]),
            still: V::of(STILL),
        };
        for (block, totals) in self.totals.iter_mut().enumerate() {
            let first = SLICES * block;
            let groups = first..self.particles.len().min(first + SLICES);
            let mut sums = [[0.0; LANES]; 4].map(Wide);
            let mut held = false;
            for part in 0..LANES / V::LANES {
                let mut lanes = Lanes::<V>::default();
                for group in groups.clone() {
                    let particles = numbers_mut(&mut self.particles[group]);
                    let low = self.low[group].as_flattened_mut();
                    let elastic = self.elastic[group].as_flattened();
                    let none = &[][..];
                    let damping = self.damping.get(group).map_or(none, |d| d.as_flattened());
                    let applied = if APPLIED {
                        self.applied[group].as_flattened()
                    } else {
                        &[]
                    };
                    let nodes = (particles, low);
                    let forces = (elastic, damping, applied);
                    lanes.step::<DAMPED, APPLIED>(nodes, forces, part, &constants);
                }
                held |= lanes.held;
                lanes.damping.store(&mut sums[0], part);
                lanes.external.store(&mut sums[1], part);
                lanes.fastest.store(&mut sums[2], part);
                lanes.all_speeds.store(&mut sums[3], part);
            }
            *totals = Totals {
                damping: if DAMPED { sum(&sums[0]) } else { 0.0 },
                external: if APPLIED || held { sum(&sums[1]) } else { 0.0 },
                fastest: greatest(&sums[2]),
                all_speeds: folded(sums[3].0, |a, b| a + b),
            };
        }
    }
}

/// Sixteen numbers folded four times, the second half on the first: as many as possible at once.
#[inline(always)]
fn folded<T: Copy>(all: [T; LANES], by: impl Fn(T, T) -> T) -> T {
    let eight: [T; 8] = std::array::from_fn(|i| by(all[i], all[i + 8]));
    let four: [T; 4] = std::array::from_fn(|i| by(eight[i], eight[i + 4]));
    by(by(four[0], four[2]), by(four[1], four[3]))
}

#[inline(always)]
fn sum(wide: &Wide) -> f64 {
    folded(wide.0.map(f64::from), |a, b| a + b)
}

#[inline(always)]
fn greatest(wide: &Wide) -> f32 {
    folded(wide.0, |a, b| if a > b { a } else { b })
}

/// Three numbers for each node, and 0.
#[inline(always)]
fn threes<V: Vector>([x, y, z]: [f32; 3]) -> V {
    let four = [x, y, z, 0.0];
    V::load_from([four; LANES / 4].as_flattened())
}

/// Both halves of the rows of eight numbers whose halves begin with the so many-th number.
#[inline(always)]
fn halves<V: Vector>(rows: &[f32; 8 * LANES], first: usize) -> [V; 2] {
    let rows = &rows[2 * first..][..2 * V::LANES];
    V::halves([V::load_from(rows), V::load_from(&rows[V::LANES..])])
}

/// In fourth place 0.
struct Constants<V> {
    gravity: V,
    h: V,
    half: V,
    one: V,
    still: V,
}

/// Sums of each lane.
#[derive(Default)]
struct Lanes<V> {
    damping: V,
    external: V,
    fastest: V,
    all_speeds: V,
    /// Whether any node is pinned.
    held: bool,
}

impl<V: Vector> Lanes<V> {
    /// Moves the nodes of a part of sixteen: sixteen numbers of each kind in turn, so that sums do not depend on the width. Four
    /// vectors at once, so that what is rare is asked once of all, and squares become speeds in one vector.
    #[inline(always)]
    fn step<const DAMPED: bool, const APPLIED: bool>(
        &mut self,
        (particles, low): (&mut [f32; 8 * LANES], &mut [f32]),
        (elastic, damping, applied): (&[f32], &[f32], &[f32]),
        part: usize,
        c: &Constants<V>,
    ) {
        let mut firsts = [0; 4];
        let [mut at, mut old, mut inv_mass] = [[V::ZERO; 4]; 3];
        let mut least = V::ONE;
        for k in 0..4 {
            firsts[k] = LANES * k + part * V::LANES;
            [at[k], old[k]] = halves::<V>(particles, firsts[k]);
            inv_mass[k] = at[k].last_of_four();
            least = inv_mass[k].min(least);
        }
        let pinned = !least.all_above(V::ZERO);
        let mut gravity = [c.gravity; 4];
        if pinned {
            self.held = true;
            for k in 0..4 {
                gravity[k] = V::above(inv_mass[k], V::ZERO, c.gravity, V::ZERO);
            }
        }
        let [mut new, mut push, mut resisting] = [[V::ZERO; 4]; 3];
        for k in 0..4 {
            let mut force = V::load_from(&elastic[firsts[k]..]);
            if DAMPED && !damping.is_empty() {
                resisting[k] = V::load_from(&damping[firsts[k]..]);
                force += resisting[k];
            }
            if APPLIED {
                push[k] = pushes(applied, firsts[k]);
                force += push[k];
            }
            let free = old[k] + c.h * (gravity[k] + force * inv_mass[k]);
            new[k] = free.zero_below(c.still);
        }
        if DAMPED || APPLIED || pinned {
            for k in 0..4 {
                let mean = c.half * (old[k] + new[k]);
                let by_damping = resisting[k] * mean;
                let outside = push[k] * mean;
                if DAMPED {
                    self.damping -= by_damping;
                }
                if APPLIED {
                    self.external += outside;
                }
                if pinned {
                    // Whatever holds a pinned node takes up the work on it.
                    let elastic = V::load_from(&elastic[firsts[k]..]);
                    let work = elastic * mean + by_damping + outside;
                    self.external -= V::above(inv_mass[k], V::ZERO, V::ZERO, work);
                }
            }
        }
        let mut squared = new;
        for k in 0..4 {
            squared[k] = new[k] * new[k] * c.one;
            let low = &mut low[firsts[k]..][..V::LANES];
            let (at, below) = two_sum(at[k], c.h * new[k] + V::load_from(low));
            below.store_to(low);
            let to = &mut particles[2 * firsts[k]..][..2 * V::LANES];
            let [a, b] = V::rows([at, new[k]]);
            a.store_to(to);
            b.store_to(&mut to[V::LANES..]);
        }
        let speeds = V::sums_of_fours(squared);
        self.fastest = speeds.max(self.fastest);
        self.all_speeds += speeds;
    }
}

/// The forces applied to the nodes whose positions begin with the so many-th number, a fourth number of each 0.
#[inline(always)]
fn pushes<V: Vector>(applied: &[f32], first: usize) -> V {
    V::of_lanes(|l| {
        let (node, axis) = ((first + l) / 4, l % 4);
        if axis < 3 {
            applied[3 * node + axis].into()
        } else {
            0.0
        }
    })
}
