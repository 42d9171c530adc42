//! A bound on the fastest modes of a body in its current configuration, and from it the longest stable substep.
//!
//! The matrix of one spring, k·dd⊤ ⊗ [1 −1; −1 1], is at most k·dd⊤ ⊗ diag(1 + t, 1 + 1/t) for every t > 0; with
//! t = m_a/m_b each end gets k·dd⊤·(1/m_a + 1/m_b). So λ(M⁻¹K) ≤ max over nodes of λ(Σ k·dd⊤·(1/m_a + 1/m_b)): exact for
//! a single spring, a chain and a regular lattice, where the usual row sum, blind to directions, costs 1.7 times the
//! substeps. A stretched spring also resists sideways, with k(1 − L/l); that is added. Elements have a bound of their own,
//! see [`super::fem`]; of a body with both the sum is taken.

use super::integrate::Integrator;
use super::solver::Solver;
use crate::body::state::State;
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

/// Symmetric 3×3 in six numbers: xx, yy, zz, xy, xz, yz.
type Sym = [f64; 6];

fn add(m: &mut Sym, n: [f64; 3], along: f64, across: f64) {
    let d = along - across;
    m[0] += across + d * n[0] * n[0];
    m[1] += across + d * n[1] * n[1];
    m[2] += across + d * n[2] * n[2];
    m[3] += d * n[0] * n[1];
    m[4] += d * n[0] * n[2];
    m[5] += d * n[1] * n[2];
}

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
    /// The longest stable substep of a scheme for the body as it is now.
    pub fn stable_step(&self, state: &State<S>, integrator: Integrator) -> StableStep {
        let nodes = state.particles.len();
        let mut stiff = vec![[0.0; 6]; nodes];
        let damped = self.table.damped;
        let mut damp = vec![[0.0; 6]; if damped { nodes } else { 0 }];
        let mut relaxation = (f64::INFINITY, None);
        for (i, link) in self.table.links.iter().enumerate() {
            let (k, c) = (link.stiffness.f64(), link.damping.f64());
            if k == 0.0 && c == 0.0 {
                continue;
            }
            let (ia, ib) = (link.a as usize, link.b as usize);
            let (a, b) = (&state.particles[ia], &state.particles[ib]);
            let (n, length) = axis(a, b);
            let n = [n[0].f64(), n[1].f64(), n[2].f64()];
            let w = (a.inv_mass + b.inv_mass).f64();
            let sideways = (1.0 - state.rest[i].f64() / length.f64()).max(0.0);
            // Nodes in one place have no direction yet and may part in any.
            let lost = n == [0.0; 3];
            let across = if lost {
                [k * w, c * w]
            } else {
                [k * w * sideways, 0.0]
            };
            for node in [ia, ib] {
                add(&mut stiff[node], n, k * w, across[0]);
                if damped {
                    add(&mut damp[node], n, c * w, across[1]);
                }
            }
            if k > 0.0 && c / k < relaxation.0 {
                relaxation = (c / k, Some(i as u32));
            }
        }
        let part = self.part.as_ref();
        let [elastic, viscous] = part.map_or_else(Default::default, |p| p.rates(&state.particles));
        if let Some(solid) = part.map(|p| p.model.solid()) {
            // The least c/k of any mode, α/λ + β.
            let least = solid.mass_damping / elastic.largest + solid.stiffness_damping;
            if least < relaxation.0 {
                relaxation = (least, None);
            }
        }
        let drag = self.external.drag.f64();
        if drag > 0.0 {
            // Drag damps every mode: C ≥ D·min(1/m), K ≤ max λ(K), both per mass.
            let free = state
                .particles
                .iter()
                .map(|p| p.inv_mass.f64())
                .filter(|w| *w > 0.0);
            let stiffest = stiff.iter().map(cheap_bound).fold(0.0, f64::max) + elastic.largest;
            relaxation.0 += drag * free.fold(f64::INFINITY, f64::min) / stiffest;
        }
        let limit = |i: usize, eigenvalue: fn(&Sym) -> f64| {
            let c = damp.get(i).map_or(0.0, eigenvalue) + drag * state.particles[i].inv_mass.f64();
            let (k, c) = (eigenvalue(&stiff[i]) + elastic.largest, c + viscous.largest);
            integrator.stable_step(k, c, relaxation.0)
        };
        let mut worst = (f64::INFINITY, None);
        for i in (0..nodes).filter(|&i| state.particles[i].inv_mass > S::ZERO) {
            if limit(i, cheap_bound) < worst.0 {
                let h = limit(i, largest_eigenvalue);
                if h < worst.0 {
                    worst = (h, Some(i));
                }
            }
        }
        let never = worst.0 <= 0.0;
        let spring = if never {
            relaxation.1
        } else {
            worst.1.and_then(|i| self.stiffest_at(i, state))
        };
        StableStep {
            h: worst.0,
            spring,
            element: elastic.element.filter(|_| spring.is_none()),
            never,
        }
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
