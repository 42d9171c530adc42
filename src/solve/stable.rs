//! A bound on the fastest modes of a body in its current configuration, and from it the longest stable substep.
//!
//! The matrix of one spring, k·dd⊤ ⊗ [1 −1; −1 1], is at most k·dd⊤ ⊗ diag(1 + t, 1 + 1/t) for every t > 0; with t = u_b/u_a
//! for some swing u > 0 of each node, λ(M⁻¹K) ≤ max over nodes a of λ(Σ k·dd⊤·(1 + u_b/u_a)/m_a). The usual row sum is u = 1,
//! blind to masses and to directions. With u = 1/m each end gets k·dd⊤·(1/m_a + 1/m_b), which is exact for a single
//! spring, a chain and a regular lattice, but not at the surface of one, whose nodes are light and have few springs. The
//! least bound has u as the nodes swing in the fastest mode (Perron and Frobenius; Collatz 1942), and the power method finds
//! it: every look at the body multiplies each node's swing by its own rate. Whatever the swings are, the bound holds.
//!
//! Springs turn between two looks, and rates with them. Those of a mesh turn together; the two of a node in a chain may come
//! into line within a step, as a rope does that is whipped: they are taken to be in line.
//!
//! A stretched spring also resists sideways, with k(1 − L/l); that is added. Elements have a bound of their own,
//! see [`super::fem`]; of a body with both the sum is taken.

use super::integrate::Integrator;
use super::kernel::{self, of_f32, of_f32_mut};
use super::solver::Solver;
use crate::body::state::{Particle, State};
use crate::law::stable::{self, Resistance, sideways};
use crate::math::Scalar;
use crate::solve::forces::axis;

/// The longest stable substep and the spring that sets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableStep {
    /// Longest stable substep \[s\]; infinite for a body without springs and drag, 0 where k/m is beyond all numbers.
    pub h: f64,
    /// The worst spring, if there is one.
    pub spring: Option<u32>,
    /// The worst element where no spring is at the worst node.
    pub element: Option<u32>,
    /// Whether the scheme is unstable at every substep because that spring or element is undamped.
    pub never: bool,
}

/// The largest eigenvalue of Σ k·dd⊤·(1 + u_b/u_a)/m_a over the springs of a node \[1/s²\], and the same of their viscosities
/// \[1/s\]; the others mean nothing.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Rates<S>(pub [S; 8]);

impl<S: Scalar> Rates<S> {
    fn of(sums: &[Resistance<S>; 2]) -> Self {
        let mut rates = Self::default();
        rates.0[..2].copy_from_slice(&sums.each_ref().map(Resistance::largest));
        rates
    }

    fn stiff(&self) -> S {
        self.0[0]
    }

    fn damp(&self) -> S {
        self.0[1]
    }
}

/// How often a new body is looked at for its fastest mode: most of what there is to gain is gained then.
const FIRST_LOOKS: usize = 4;

/// The least swing that a node is credited with, of the largest that its mass allows: where the fastest mode is not, the next one may
/// come to be.
const LEAST_SWING: f64 = 1.0 / 32.0;

/// The least of all, in the largest that the lightest node can have: far more than what the integration takes for nothing.
const FAINTEST_SWING: f64 = 1e-12;

impl<S: Scalar> Solver<S> {
    /// The longest stable substep of a scheme for the body as it is now, and which spring or element sets it.
    ///
    /// The rates of nodes are sums in the scalar of the solver.
    pub fn stable_step(&self, state: &State<S>, integrator: Integrator) -> StableStep {
        let (mut step, worst, _) = self.longest_step(state, integrator, &self.rates(state));
        if step.never {
            let (least, spring) = self.table.relaxation();
            step.spring = spring.filter(|_| least <= 0.0);
            step.element = step.element.filter(|_| step.spring.is_none());
        } else if step.element.is_none() {
            step.spring = self.most_strained(state, worst);
        }
        step
    }

    /// As [`Self::stable_step`], without looking for the spring that sets it.
    pub(crate) fn longest_stable_step(
        &self,
        state: &State<S>,
        integrator: Integrator,
    ) -> StableStep {
        self.longest_step(state, integrator, &self.rates(state)).0
    }

    /// As [`Self::longest_stable_step`], and learns how the body swings in its fastest mode, for a closer bound next time. Every
    /// free node must have a swing.
    pub(crate) fn review(&mut self, state: &mut State<S>, integrator: Integrator) -> StableStep {
        let rates = self.rates_by_rows(state);
        let (step, worst, stiffest) = self.longest_step(state, integrator, &rates);
        self.learn_swings(state, &rates, worst);
        self.last_rates = rates;
        self.stiffest = stiffest;
        self.stable_h = step.h;
        step
    }

    /// Looks at a new body so often that most of what there is to learn of its fastest mode is known: [`Self::stable_step`]
    /// is longer then. A body in a world is looked at on its way in and in every step.
    pub fn learn(&mut self, state: &mut State<S>, integrator: Integrator) {
        for particle in &mut state.particles {
            particle.swing = particle.sound_swing();
        }
        for _ in 0..FIRST_LOOKS {
            self.review(state, integrator);
        }
    }

    /// A step of the power method: every node's swing times its own rate. `worst` is the largest rate of stiffness \[1/s²\] and
    /// of viscosity \[1/s\]. At the longest substep h of both, h²K + 2hC has 4 for its largest eigenvalue; that is the matrix
    /// whose mode is looked for.
    fn learn_swings(&self, state: &mut State<S>, rates: &[Rates<S>], (k, c): (f64, f64)) {
        let h = stable::leapfrog(k, c);
        if !(h > 0.0 && h.is_finite()) {
            return;
        }
        let (h, two, drag) = (S::of(h), S::of(2.0), self.external.drag);
        let (mut most, mut lightest) = (S::ZERO, S::ZERO);
        for (p, rates) in state.particles.iter_mut().zip(rates) {
            if p.inv_mass > S::ZERO {
                let rate = h * rates.stiff() + two * (rates.damp() + drag * p.inv_mass);
                p.swing = rate * p.swing / p.inv_mass;
                most = p.swing.max(most);
                lightest = p.inv_mass.max(lightest);
            }
        }
        let (least, per_most) = (S::of(LEAST_SWING), S::ONE / most);
        let (faintest, per_lightest) = (S::of(FAINTEST_SWING), S::ONE / lightest);
        for p in state.particles.iter_mut().filter(|p| p.inv_mass > S::ZERO) {
            let share = (p.swing * per_most).max(least).min(S::ONE);
            p.swing = (share * (p.inv_mass * per_lightest)).max(faintest);
        }
    }

    /// The least share of its energy that a mode of frequency `omega` [1/s] loses by damping \[1/s\].
    pub(crate) fn least_decay(&self, state: &State<S>, omega: f64) -> f64 {
        let square = omega * omega;
        let (of_springs, _) = self.table.relaxation();
        let mut decay = of_springs * square;
        if let Some(solid) = self.part.as_ref().map(|p| p.model.solid()) {
            decay = decay.min(solid.mass_damping + solid.stiffness_damping * square);
        }
        let drag = self.external.drag.f64();
        if drag > 0.0 {
            let masses = state.particles.iter().map(|p| p.inv_mass.f64());
            let of_heaviest = masses.filter(|w| *w > 0.0).fold(f64::INFINITY, f64::min);
            decay += drag * of_heaviest;
        }
        decay
    }

    /// The rates of nodes, one spring after the other.
    fn rates(&self, state: &State<S>) -> Vec<Rates<S>> {
        let mut sums = vec![[Resistance::default(); 2]; state.particles.len()];
        for (link, rest) in self.table.links.iter().zip(&state.rest) {
            let (ia, ib) = (link.a as usize, link.b as usize);
            let (a, b) = (&state.particles[ia], &state.particles[ib]);
            let (n, inverse) = axis(a, b);
            let n = [n[0], n[1], n[2]];
            let sideways = sideways(n, *rest * inverse);
            for (node, own, far) in [(ia, a, b), (ib, b, a)] {
                let w = per_force(own, far);
                let along = link.stiffness * w;
                let [stiff, damp] = &mut sums[node];
                stiff.add(n, along, along * sideways);
                if self.table.damped {
                    damp.add_along(n, link.damping * w);
                }
            }
        }
        let mut rates: Vec<_> = sums.iter().map(Rates::of).collect();
        self.straighten(state, &mut rates);
        rates
    }

    /// The rates of the nodes of chains as if their two springs were in line.
    fn straighten(&self, state: &State<S>, rates: &mut [Rates<S>]) {
        for end in &self.table.chain_nodes {
            rates[end.node as usize] = Rates::default();
        }
        for end in &self.table.chain_nodes {
            let link = &self.table.links[end.spring as usize];
            let ends = [link.a, link.b].map(|n| &state.particles[n as usize]);
            let [own, far] = if end.node == link.a {
                ends
            } else {
                [ends[1], ends[0]]
            };
            let w = per_force(own, far);
            let sum = &mut rates[end.node as usize].0;
            sum[0] += link.stiffness * w;
            sum[1] += link.damping * w;
        }
    }

    /// The same by rows, where there are any; the bits are the same.
    fn rates_by_rows(&mut self, state: &State<S>) -> Vec<Rates<S>> {
        let mut found = std::mem::take(&mut self.last_rates);
        // One more, as for forces.
        found.resize(state.particles.len() + 1, Rates::default());
        let by_rows = match (
            of_f32_mut(self),
            of_f32(state),
            of_f32_mut::<_, Vec<Rates<f32>>>(&mut found),
        ) {
            (Some(solver), Some(state), Some(rates)) => kernel::rates(solver, state, rates),
            _ => false,
        };
        if !by_rows {
            return self.rates(state);
        }
        self.straighten(state, &mut found);
        found
    }

    /// The longest stable substep, its spring not named yet, the rates of the node that sets it, and the largest one of stiffness of any
    /// free node. Of a body of springs and elements the element is named if most is its doing.
    fn longest_step(
        &self,
        state: &State<S>,
        integrator: Integrator,
        rates: &[Rates<S>],
    ) -> (StableStep, (f64, f64), f64) {
        let part = self.part.as_ref();
        let [elastic, viscous] = part.map_or_else(Default::default, |p| p.rates(&state.particles));
        let drag = self.external.drag.f64();
        let mut relaxation = f64::INFINITY;
        if integrator.needs_relaxation() {
            relaxation = self.table.relaxation().0;
            if let Some(solid) = part.map(|p| p.model.solid()) {
                // The least c/k of any mode, α/λ + β.
                let least = solid.mass_damping / elastic.largest + solid.stiffness_damping;
                relaxation = relaxation.min(least);
            }
            if drag > 0.0 {
                // Drag damps every mode: C ≥ D·min(1/m), K ≤ max λ(K), both per mass.
                let masses = state.particles.iter().map(|p| p.inv_mass.f64());
                let free = masses.filter(|w| *w > 0.0);
                let stiff = rates.iter().map(|r| r.stiff().f64());
                let stiffest = stiff.fold(0.0, f64::max) + elastic.largest;
                relaxation += drag * free.fold(f64::INFINITY, f64::min) / stiffest;
            }
        }
        let mut worst = (f64::INFINITY, (-1.0, -1.0));
        let mut largest = 0.0_f64;
        // Of a node with no more of anything than another has nothing is to be learned. Most are so, and numbers need not be widened
        // to see it.
        let mut seen = [-S::ONE; 3];
        let nodes = state.particles.iter().zip(rates);
        for (p, rates) in nodes.filter(|(p, _)| p.inv_mass > S::ZERO) {
            let own = [rates.stiff(), rates.damp(), p.inv_mass];
            if own.iter().zip(&seen).all(|(own, seen)| own <= seen) {
                continue;
            }
            let k = rates.stiff().f64() + elastic.largest;
            let c = rates.damp().f64() + drag * p.inv_mass.f64() + viscous.largest;
            largest = largest.max(k);
            // The step only falls with either.
            if !(k <= worst.1.0 && c <= worst.1.1) {
                let finite = k.is_finite() && c.is_finite();
                let h = if finite {
                    integrator.stable_step(k, c, relaxation)
                } else {
                    0.0
                };
                if h < worst.0 {
                    worst = (h, (k, c));
                    seen = own;
                }
            }
        }
        let (h, (k, c)) = worst;
        // Rates beyond all numbers are those of a body, not of a scheme.
        let never = h <= 0.0 && k.is_finite() && c.is_finite();
        let share = |k: f64, c: f64| h * k + 2.0 * c;
        let endless = !(elastic.largest.is_finite() && viscous.largest.is_finite());
        let most = never || endless || share(elastic.largest, viscous.largest) > 0.5 * share(k, c);
        let step = StableStep {
            h,
            spring: None,
            element: elastic.element.filter(|_| most),
            never,
        };
        (step, worst.1, largest)
    }

    /// The spring that has most of the energy of the fastest mode: a change of its constants changes the step most. In that mode
    /// neighbours swing against each other.
    fn most_strained(&self, state: &State<S>, (k, c): (f64, f64)) -> Option<u32> {
        let h = stable::leapfrog(k, c);
        // Of rates beyond all numbers the stiffness counts.
        let h = if h > 0.0 { h } else { 1.0 };
        let mut most = (0.0, None);
        for (i, link) in (0..).zip(&self.table.links) {
            let swing = |node: u32| state.particles[node as usize].sound_swing().f64();
            let apart = swing(link.a) + swing(link.b);
            let rate = h * link.stiffness.f64() + 2.0 * link.damping.f64();
            if rate * apart * apart > most.0 {
                most = (rate * apart * apart, Some(i));
            }
        }
        most.1
    }
}

/// 1/m_a·(1 + u_b/u_a) for the two ends of a spring \[1/kg\]; 0 for a pinned one.
fn per_force<S: Scalar>(own: &Particle<S>, far: &Particle<S>) -> S {
    if own.inv_mass == S::ZERO {
        return S::ZERO;
    }
    own.inv_mass + far.sound_swing() * (own.inv_mass / own.sound_swing())
}

#[cfg(test)]
mod tests;
