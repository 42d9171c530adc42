//! Energies of a body: what it has now, and the work done on it so far.

use super::Deformable;
use crate::law::plastic::{self, Mapped, Yield, return_map};
use crate::law::spring as law;
use crate::math::DVec3;
use crate::solve::Integrator;
use crate::solve::work::Work;

/// Energies of a body and the work done on it so far \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// ½Σ m·v⁻·v⁺ with the velocities half a substep before and after, as they would be without damping, for symplectic Euler
    /// and velocity Verlet, which are leapfrog; ½Σ m·v² for the other schemes.
    pub kinetic: f64,
    /// Held by springs and tets, and by the links of the body's attachments.
    pub elastic: f64,
    /// Σ −m·g·x of the nodes that are not pinned, relative to where each was inserted, or let go since.
    pub gravity: f64,
    /// Sums of dissipation and external work.
    pub work: Work,
}

impl Energies {
    /// Everything that stays constant: kinetic + elastic + gravity + dissipation − external work − work received from
    /// rigid bodies − what moving nodes out of colliders added.
    pub fn balance(&self) -> f64 {
        let w = &self.work;
        self.kinetic + self.elastic + self.gravity + self.dissipated()
            - w.external
            - w.rigid
            - w.push_out
    }

    /// Plastic, damping, fracture and contact losses together.
    pub fn dissipated(&self) -> f64 {
        let w = &self.work;
        w.damping + w.plastic + w.fracture + w.contact_normal + w.contact_friction
    }

    /// What a residual is measured against: kinetic + elastic + dissipation + |work of gravity| + |external work|.
    pub fn scale(&self) -> f64 {
        self.kinetic
            + self.elastic
            + self.dissipated().abs()
            + self.gravity.abs()
            + self.work.external.abs()
            + self.work.rigid.abs()
    }
}

impl Deformable {
    /// Energies now and work so far.
    pub fn energies(&self) -> Energies {
        let part = self.solver.part.as_ref();
        self.energies_of(
            0..self.node_count(),
            0..self.spring_count(),
            0..part.map_or(0, |part| part.model.element_count()),
        )
    }

    /// Those of such nodes, springs and tets. Links of attachments and work so far are counted whole.
    pub(super) fn energies_of(
        &self,
        nodes: impl Iterator<Item = usize> + Clone,
        springs: impl Iterator<Item = usize>,
        tets: impl Iterator<Item = usize> + Clone,
    ) -> Energies {
        let mut energies = self.node_energies_of(nodes);
        let lead = self.lead();
        if let Some(part) = &self.solver.part {
            let position = |n| self.state.local(n).to_array();
            energies.elastic += part.model.energy_of(tets.clone(), position);
            if lead > 0.0 {
                let velocity = |n| self.state.velocity(n).to_array();
                energies.kinetic += lead * part.model.power_of(tets, position, velocity);
            }
        }
        springs.for_each(|spring| self.add_spring(&mut energies, spring, lead));
        energies
    }

    fn add_spring(&self, energies: &mut Energies, spring: usize, lead: f64) {
        let link = &self.solver.table.links[spring];
        let stiffness = f64::from(link.stiffness);
        if stiffness == 0.0 {
            return;
        }
        let (a, b) = (link.a as usize, link.b as usize);
        let d = self.state.local(b) - self.state.local(a);
        let length = d.length();
        let mapped = self.mapped(spring, length, stiffness);
        let elongation = length - f64::from(self.state.rest[spring]);
        energies.elastic += law::energy(stiffness, elongation - mapped.flow);
        let rate = (self.state.velocity(b) - self.state.velocity(a)).dot(d)
            / length.max(f64::MIN_POSITIVE);
        let last = stiffness * (elongation - self.h * rate);
        energies.work.plastic += plastic::work(last, &mapped);
        energies.kinetic -= lead * mapped.tension * rate;
    }

    /// Those of its nodes by themselves, and work so far.
    pub(super) fn node_energies(&self) -> Energies {
        self.node_energies_of(0..self.node_count())
    }

    /// Velocities of symplectic Euler stand half a substep back: ½·h·F·v brings the kinetic energy to the positions' \[s\].
    fn lead(&self) -> f64 {
        if self.integrator() == Integrator::SymplecticEuler {
            0.5 * self.h
        } else {
            0.0
        }
    }

    fn node_energies_of(&self, nodes: impl Iterator<Item = usize> + Clone) -> Energies {
        let gravity = self.gravity();
        let mut energies = Energies {
            work: self.solver.work,
            elastic: self.links,
            ..Energies::default()
        };
        let lead = self.lead();
        let verlet = self.integrator() == Integrator::VelocityVerlet;
        for i in nodes.clone().filter(|i| self.is_free(*i)) {
            let mass = f64::from(self.blueprint.nodes[i].mass);
            let v = self.state.velocity(i);
            energies.kinetic += mass * (0.5 * v.length_squared() + lead * gravity.dot(v));
            if verlet {
                // Leapfrog by another name: ½m·v⁻·v⁺ with v± = v ± ½h·a, a by all that damping is not.
                let solver = &self.solver;
                let force = solver.elastic_force(i) + solver.applied_force(i) + gravity * mass;
                energies.kinetic -= 0.125 * (self.h * force).length_squared() / mass;
            }
        }
        energies.gravity = gravity.dot(self.moment - self.moment_of(nodes));
        energies
    }

    fn is_free(&self, node: usize) -> bool {
        self.state.particles[node].inv_mass != 0.0
    }

    /// Σ m·(x − datum) of such of these nodes as are free \[kg·m\].
    pub(super) fn moment_of(&self, nodes: impl Iterator<Item = usize>) -> DVec3 {
        nodes
            .filter(|i| self.is_free(*i))
            .map(|i| {
                let mass = f64::from(self.blueprint.nodes[i].mass);
                mass * (self.state.position(i) - self.datum)
            })
            .sum()
    }

    /// Makes a node free or pinned, or gives it another mass, by `change`, and leaves the energy of gravity as it is: the node counts
    /// from where it is.
    pub(super) fn reweigh(&mut self, node: usize, change: impl FnOnce(&mut Self)) {
        let before = self.moment_of(std::iter::once(node));
        change(self);
        self.moment += self.moment_of(std::iter::once(node)) - before;
    }

    /// Tension of a spring at a length, and the flow that the next force evaluation will commit, but for a digit of the length.
    #[inline]
    pub(super) fn mapped(&self, spring: usize, length: f64, stiffness: f64) -> Mapped<f64> {
        let rest = f64::from(self.state.rest[spring]);
        let elongation = length - rest;
        match self.solver.table.limits.get(spring) {
            None => Mapped {
                tension: law::tension(stiffness, elongation),
                flow: 0.0,
                beyond: 0.0,
            },
            Some(limit) => {
                let y = limit.yields;
                let yields = Yield {
                    tension: f64::from(y.tension),
                    compression: f64::from(y.compression),
                    hardening: f64::from(y.hardening),
                    inverse: f64::from(y.inverse),
                };
                return_map(
                    stiffness,
                    rest,
                    elongation,
                    self.state.flow[spring].into(),
                    &yields,
                )
            }
        }
    }
}
