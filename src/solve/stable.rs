//! A bound on the fastest modes of a body in its current configuration, and from it the longest stable substep.
//!
//! The matrix of one spring, k·dd⊤ ⊗ [1 −1; −1 1], is at most k·dd⊤ ⊗ diag(1 + t, 1 + 1/t) for every t > 0; with
//! t = m_a/m_b each end gets k·dd⊤·(1/m_a + 1/m_b). So λ(M⁻¹K) ≤ max over nodes of λ(Σ k·dd⊤·(1/m_a + 1/m_b)): exact for
//! a single spring, a chain and a regular lattice, where the usual row sum, blind to directions, costs 1.7 times the
//! substeps. A stretched spring also resists sideways, with k(1 − L/l); that is added. Elements have a bound of their own,
//! see [`super::fem`]; of a body with both the sum is taken.

use super::integrate::Integrator;
use super::kernel::{self, of_f32, of_f32_mut};
use super::solver::Solver;
use crate::body::state::State;
use crate::law::stable::{Symmetric, add_spring, sideways};
use crate::math::{DMat3, DVec3, Scalar};
use crate::solve::forces::axis;

/// The longest stable substep and the spring that sets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableStep {
    /// Longest stable substep \[s\]; infinite for a body without springs and drag.
    pub h: f64,
    /// The worst spring, if there is one.
    pub spring: Option<u32>,
    /// The worst element where no spring is at the worst node.
    pub element: Option<u32>,
    /// Whether the scheme is unstable at every substep because that spring or element is undamped.
    pub never: bool,
}

/// Σ k·dd⊤·(1/m_a + 1/m_b) over the springs of a node \[1/s²\], or the same of their viscosities \[1/s\]: xx, yy, zz, xy, xz,
/// yz, and two that fill it to a power of two.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Rates<S>(pub [S; 8]);

impl<S: Scalar> Rates<S> {
    fn add(&mut self, n: [S; 3], along: S, across: S) {
        let [a, b, c, d, e, f, ..] = &mut self.0;
        let mut m = [*a, *b, *c, *d, *e, *f];
        add_spring(&mut m, n, along, across);
        (*a, *b, *c, *d, *e, *f) = (m[0], m[1], m[2], m[3], m[4], m[5]);
    }

    fn f64(&self) -> Sym {
        std::array::from_fn(|k| self.0[k].f64())
    }
}

type Sym = Symmetric<f64>;

/// A cheap upper bound of the largest eigenvalue of a positive matrix: the lesser of trace and row-sum norm.
fn cheap_bound(m: &Sym) -> f64 {
    let row = |a: f64, b: f64, c: f64| a + b.abs() + c.abs();
    let norm = row(m[0], m[3], m[4])
        .max(row(m[1], m[3], m[5]))
        .max(row(m[2], m[4], m[5]));
    norm.min(m[0] + m[1] + m[2])
}

/// The largest eigenvalue, in closed form (Smith 1961).
fn largest_eigenvalue(m: &Sym) -> f64 {
    let q = (m[0] + m[1] + m[2]) / 3.0;
    let off = m[3] * m[3] + m[4] * m[4] + m[5] * m[5];
    let spread = (m[0] - q).powi(2) + (m[1] - q).powi(2) + (m[2] - q).powi(2) + 2.0 * off;
    let p = (spread / 6.0).sqrt();
    if p <= 1e-12 * q.abs() {
        return q;
    }
    let b = DMat3::from_cols(
        DVec3::new(m[0] - q, m[3], m[4]) / p,
        DVec3::new(m[3], m[1] - q, m[5]) / p,
        DVec3::new(m[4], m[5], m[2] - q) / p,
    );
    q + 2.0 * p * ((0.5 * b.determinant()).clamp(-1.0, 1.0).acos() / 3.0).cos()
}

impl<S: Scalar> Solver<S> {
    /// The longest stable substep of a scheme for the body as it is now, and which spring or element sets it.
    ///
    /// The rates of nodes are sums in the scalar of the solver.
    pub fn stable_step(&self, state: &State<S>, integrator: Integrator) -> StableStep {
        let (mut step, node) = self.longest_step(state, integrator);
        step.spring = if step.never {
            self.relaxation().1
        } else {
            node.and_then(|i| self.stiffest_at(i, state))
        };
        step.element = step.element.filter(|_| step.spring.is_none());
        step
    }

    /// As [`Self::stable_step`], without looking for the spring that sets it.
    pub(crate) fn longest_stable_step(
        &self,
        state: &State<S>,
        integrator: Integrator,
    ) -> StableStep {
        self.longest_step(state, integrator).0
    }

    /// The least c/k of any spring \[s\], and of which.
    fn relaxation(&self) -> (f64, Option<u32>) {
        let mut least = (f64::INFINITY, None);
        for (i, link) in self.table.links.iter().enumerate() {
            let (k, c) = (link.stiffness.f64(), link.damping.f64());
            if k > 0.0 && c / k < least.0 {
                least = (c / k, Some(i as u32));
            }
        }
        least
    }

    /// Per node the rates of its springs' stiffnesses, and of their viscosities where there are any.
    fn rates(&self, state: &State<S>) -> [Vec<Rates<S>>; 2] {
        // One more, as for forces.
        let nodes = state.particles.len() + 1;
        let damped = self.table.damped;
        let mut found = [nodes, if damped { nodes } else { 0 }].map(|n| vec![Rates::default(); n]);
        if let (Some(solver), Some(state), Some(rates)) =
            (of_f32(self), of_f32(state), of_f32_mut(&mut found))
            && kernel::rates(solver, state, rates)
        {
            return found;
        }
        self.add_rates(state, &mut found);
        found
    }

    /// The same one spring after the other, which gives the same bits.
    fn add_rates(&self, state: &State<S>, [stiff, damp]: &mut [Vec<Rates<S>>; 2]) {
        for (link, rest) in self.table.links.iter().zip(&state.rest) {
            let (ia, ib) = (link.a as usize, link.b as usize);
            let (a, b) = (&state.particles[ia], &state.particles[ib]);
            let (n, length) = axis(a, b);
            let n = [n[0], n[1], n[2]];
            let w = a.inv_mass + b.inv_mass;
            let along = link.stiffness * w;
            let across = along * sideways(n, *rest, length);
            for node in [ia, ib] {
                stiff[node].add(n, along, across);
                if let Some(damp) = damp.get_mut(node) {
                    damp.add(n, link.damping * w, S::ZERO);
                }
            }
        }
    }

    /// The longest stable substep, its spring not named yet, and the worst node.
    fn longest_step(
        &self,
        state: &State<S>,
        integrator: Integrator,
    ) -> (StableStep, Option<usize>) {
        let [stiff, damp] = self.rates(state);
        let part = self.part.as_ref();
        let [elastic, viscous] = part.map_or_else(Default::default, |p| p.rates(&state.particles));
        let drag = self.external.drag.f64();
        let mut relaxation = f64::INFINITY;
        if integrator.needs_relaxation() {
            relaxation = self.relaxation().0;
            if let Some(solid) = part.map(|p| p.model.solid()) {
                // The least c/k of any mode, α/λ + β.
                let least = solid.mass_damping / elastic.largest + solid.stiffness_damping;
                relaxation = relaxation.min(least);
            }
            if drag > 0.0 {
                // Drag damps every mode: C ≥ D·min(1/m), K ≤ max λ(K), both per mass.
                let masses = state.particles.iter().map(|p| p.inv_mass.f64());
                let free = masses.filter(|w| *w > 0.0);
                let bounds = stiff.iter().map(|m| cheap_bound(&m.f64()));
                let stiffest = bounds.fold(0.0, f64::max) + elastic.largest;
                relaxation += drag * free.fold(f64::INFINITY, f64::min) / stiffest;
            }
        }
        let rates = |i: usize, eigenvalue: fn(&Sym) -> f64| {
            let c = damp.get(i).map_or(0.0, |m| eigenvalue(&m.f64()));
            let c = c + drag * state.particles[i].inv_mass.f64();
            (
                eigenvalue(&stiff[i].f64()) + elastic.largest,
                c + viscous.largest,
            )
        };
        let mut worst = (f64::INFINITY, None, (-1.0, -1.0));
        for i in (0..state.particles.len()).filter(|&i| state.particles[i].inv_mass > S::ZERO) {
            let (k, c) = rates(i, cheap_bound);
            // The step only falls with either.
            if k > worst.2.0 || c > worst.2.1 {
                let (k, c) = rates(i, largest_eigenvalue);
                let h = integrator.stable_step(k, c, relaxation);
                if h < worst.0 {
                    worst = (h, Some(i), (k, c));
                }
            }
        }
        let step = StableStep {
            h: worst.0,
            spring: None,
            element: elastic.element,
            never: worst.0 <= 0.0,
        };
        (step, worst.1)
    }

    fn stiffest_at(&self, node: usize, state: &State<S>) -> Option<u32> {
        let rate = |i: usize| {
            let link = &self.table.links[i];
            let w = state.particles[link.a as usize].inv_mass
                + state.particles[link.b as usize].inv_mass;
            let (k, c) = ((link.stiffness * w).f64(), (link.damping * w).f64());
            c + (c * c + 4.0 * k).sqrt()
        };
        (0..self.table.links.len())
            .filter(|&i| {
                let link = &self.table.links[i];
                link.a as usize == node || link.b as usize == node
            })
            .max_by(|&a, &b| rate(a).total_cmp(&rate(b)))
            .map(|i| i as u32)
    }
}
