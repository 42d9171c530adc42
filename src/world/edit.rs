//! Changing a body between steps. Values are editable, lengths are not; whatever changes stored energy is booked as external
//! work, so that the balance stays closed. Lengths and speeds that have no square in `f32`, as from 1.8e19 on, have no energy
//! there either and are refused as those that are not finite.

use super::Deformable;
use super::energies::Energies;
use crate::body::{BuildError, NodeId, Spring, SpringId};
use crate::contact::target::{SurfaceProperties, wide_rotation};
use crate::math::{Pose, Real, Vector, narrow, wide};
use crate::solve::external::ForceField;
use crate::solve::springs::SpringTable;
use std::sync::Arc;

impl Deformable {
    /// Books a change made from outside, so that the energy balance stays closed: it is external work.
    pub(super) fn edit<T>(&mut self, change: impl FnOnce(&mut Self) -> T) -> T {
        self.edit_by(Self::energies, change)
    }

    /// The same where only such `energies` change.
    pub(super) fn edit_by<T>(
        &mut self,
        energies: impl Fn(&Self) -> Energies,
        change: impl FnOnce(&mut Self) -> T,
    ) -> T {
        self.wake_up();
        self.solver.write_back(&mut self.state);
        let before = energies(self).balance();
        self.moved_out.clear();
        self.solver.last_substep = None;
        let result = change(self);
        self.cache.forget();
        let after = energies(self).balance();
        self.solver.work.external += after - before;
        result
    }

    /// Enables or disables the body. A disabled body stays where it is and touches nothing.
    pub fn set_enabled(&mut self, enabled: bool) {
        self.wake_up();
        self.enabled = enabled;
    }

    /// Changes friction, collision groups, thickness and the rest of how it touches.
    ///
    /// # Errors
    /// [`BuildError::Value`] for a value out of range, [`BuildError::TooThick`]; the body is then as before.
    pub fn set_surface(&mut self, surface: SurfaceProperties) -> Result<(), BuildError> {
        surface.check()?;
        surface.check_thickness(self.contact_blueprint())?;
        *self.surface_mut() = surface;
        Ok(())
    }

    /// The same, of which nothing is checked: a thickness above what `build` takes is used as it is, and what is not positive counts as 0.
    pub fn surface_mut(&mut self) -> &mut SurfaceProperties {
        self.wake_up();
        &mut self.surface
    }

    /// Puts a node somewhere in the world \[m\]. Unknown ids and values that are not finite, or whose square is not, change
    /// nothing: `false`.
    pub fn set_position(&mut self, node: NodeId, position: Vector) -> bool {
        let ok = node.index() < self.node_count() && has_square(position);
        if ok {
            self.edits += 1;
            self.edit_at([node.0], |body| {
                body.state.set_position(node.index(), wide(position));
            });
        }
        ok
    }

    /// Sets the velocity of a node at its present place \[m/s\]; a pinned one goes on at it until told otherwise. Unknown ids and values
    /// that are not finite, or whose square is not, change nothing: `false`.
    pub fn set_linvel_of(&mut self, node: NodeId, linvel: Vector) -> bool {
        let ok = node.index() < self.node_count() && has_square(linvel);
        if ok {
            self.edit_at([node.0], |body| {
                body.state.set_velocity(node.index(), wide(linvel));
            });
            self.tell(node.0);
        }
        ok
    }

    /// Notes that the velocity of a node is meant for its present place.
    fn tell(&mut self, node: u32) {
        if let Err(place) = self.told.binary_search(&node) {
            self.told.insert(place, node);
        }
    }

    /// Gives all nodes that are not pinned one velocity at their present places \[m/s\]. Values that are not finite, or whose square is not, change
    /// nothing: `false`.
    pub fn set_linvel(&mut self, linvel: Vector) -> bool {
        self.set_velocities(linvel, Vector::ZERO)
    }

    /// Gives the body the velocity field of a rigid one: `linvel` \[m/s\] of its centre of mass and `angvel` \[rad/s\];
    /// pinned nodes stay. Values that are not finite, or whose square is not, change nothing: `false`.
    pub fn set_velocities(&mut self, linvel: Vector, angvel: Vector) -> bool {
        let ok = has_square(linvel) && has_square(angvel);
        if ok {
            let com = self.center_of_mass();
            self.edit(|body| {
                body.told.clear();
                for i in 0..body.node_count() {
                    if body.state.particles[i].inv_mass == 0.0 {
                        continue;
                    }
                    body.told.push(i as u32);
                    let arm = body.state.position(i) - com;
                    body.state
                        .set_velocity(i, wide(linvel) + wide(angvel).cross(arm));
                }
            });
        }
        ok
    }

    /// Moves the body rigidly: every node goes through `motion`, velocities are turned with it. Values that are not
    /// finite, and places whose square is not, change nothing: `false`.
    pub fn transform(&mut self, motion: Pose) -> bool {
        let turn = wide_rotation(motion.rotation);
        let shift = wide(motion.translation);
        let moved = |i| narrow(turn * self.state.position(i) + shift);
        // A rotation of length 0 is none.
        let ok = motion.is_finite()
            && turn.is_finite()
            && (0..self.node_count()).all(|i| has_square(moved(i)));
        if ok {
            self.edits += 1;
            self.edit(|body| {
                for i in 0..body.node_count() {
                    let (x, v) = (body.state.position(i), body.state.velocity(i));
                    body.state.set_position(i, turn * x + shift);
                    body.state.set_velocity(i, turn * v);
                }
                body.state.recentre(1.0);
            });
        }
        ok
    }

    /// Pins a node where it is, or lets it go. Unknown ids change nothing: `false`.
    pub fn set_pinned(&mut self, node: NodeId, pinned: bool) -> bool {
        let ok = node.index() < self.node_count();
        if ok {
            self.edit_at([node.0], |body| {
                let mass = body.blueprint.nodes[node.index()].mass;
                let inv_mass = if pinned { 0.0 } else { 1.0 / mass };
                body.reweigh(node.index(), |body| {
                    body.state.set_inv_mass(node.index(), inv_mass);
                });
                if pinned {
                    body.state.particles[node.index()].v = [0.0; 3];
                }
                body.blueprint.nodes[node.index()].pinned = pinned;
                body.led.retain(|(n, _)| pinned || *n != node.0);
            });
            self.tell(node.0);
        }
        ok
    }

    /// Leads a pinned node to a point of the world \[m\], to be reached at the end of the coming step. Nodes that are not
    /// pinned, unknown ids and points that are not finite, or whose square is not, change nothing: `false`. One that is too far
    /// off for a speed that has a square freezes the body in that step.
    pub fn set_kinematic_target(&mut self, node: NodeId, target: Vector) -> bool {
        let ok = has_square(target)
            && self
                .state
                .particles
                .get(node.index())
                .is_some_and(|p| p.inv_mass == 0.0);
        if ok {
            self.wake_up();
            // By node.
            let led = (node.0, wide(target));
            match self.led.binary_search_by_key(&node.0, |(n, _)| *n) {
                Ok(i) => self.led[i] = led,
                Err(i) => self.led.insert(i, led),
            }
        }
        ok
    }

    /// Sets the force that acts on a node until changed \[N\]. Unknown ids and forces that are not finite change
    /// nothing: `false`.
    pub fn set_node_force(&mut self, node: NodeId, force: Vector) -> bool {
        self.force_slot(node, force)
            .map(|(kept, _)| *kept = force)
            .is_some()
    }

    /// Adds to the force that acts on a node during the coming step only \[N\]. Unknown ids and forces that are not
    /// finite change nothing: `false`.
    pub fn add_step_force(&mut self, node: NodeId, force: Vector) -> bool {
        self.force_slot(node, force)
            .map(|(_, once)| *once += force)
            .is_some()
    }

    fn force_slot(&mut self, node: NodeId, force: Vector) -> Option<&mut (Vector, Vector)> {
        if !force.is_finite() || node.index() >= self.node_count() {
            return None;
        }
        self.wake_up();
        self.node_forces
            .resize(self.node_count(), Default::default());
        self.node_forces.get_mut(node.index())
    }

    /// Sets the force field on all nodes; `None` for none.
    pub fn set_force_field(&mut self, field: Option<Arc<dyn ForceField>>) {
        self.wake_up();
        self.field = field;
    }

    /// Changes a spring. Its nodes and rest length at build stay what they are.
    ///
    /// # Errors
    /// A constant out of range, an unknown spring, or a body that would need substeps shorter than its budget; the body
    /// is then as before.
    pub fn set_spring(
        &mut self,
        spring: SpringId,
        change: impl FnOnce(&mut Spring),
    ) -> Result<(), BuildError> {
        let Some(old) = self.blueprint.springs.get(spring.index()).copied() else {
            return Err(BuildError::Value {
                what: "the spring's index",
                value: spring.0.into(),
                must: "less than the number of springs",
            });
        };
        let mut new = old;
        change(&mut new);
        new.nodes = old.nodes;
        new.rest_length = old.rest_length;
        crate::body::error::check_constants(spring.0, &new)?;
        let (work, sleep) = (self.solver.work, self.sleep);
        self.put_spring(spring, new);
        self.check_changed().inspect_err(|_| {
            self.put_spring(spring, old);
            (self.solver.work, self.sleep) = (work, sleep);
        })
    }

    fn put_spring(&mut self, id: SpringId, spring: Spring) {
        self.edit(|body| {
            body.blueprint.springs[id.index()] = spring;
            body.rebuild_table();
        });
    }

    pub(super) fn rebuild_table(&mut self) {
        self.solver.table = SpringTable::new(&self.blueprint.springs, &self.state);
        // Springs without limits are not backed up: the backup must be right from the moment the last limit goes.
        self.backup.take_over_springs(&self.state);
    }

    /// Changes the mass of a node \[kg\].
    ///
    /// # Errors
    /// As [`Self::set_spring`].
    pub fn set_node_mass(&mut self, node: NodeId, mass: Real) -> Result<(), BuildError> {
        let bad = |what, value, must| BuildError::Value { what, value, must };
        let Some(old) = self.node_mass(node) else {
            return Err(bad(
                "the node's index",
                node.0.into(),
                "less than the number of nodes",
            ));
        };
        crate::body::error::positive("the node's mass", mass.into())?;
        if !mass.is_normal() {
            return Err(bad(
                "the node's mass",
                mass.into(),
                "large enough to have an inverse",
            ));
        }
        let (work, sleep, moment) = (self.solver.work, self.sleep, self.moment);
        let swing = self.state.particles[node.index()].swing;
        self.put_mass(node, mass);
        self.check_changed().inspect_err(|_| {
            self.put_mass(node, old);
            self.state.particles[node.index()].swing = swing;
            (self.solver.work, self.sleep, self.moment) = (work, sleep, moment);
        })
    }

    fn put_mass(&mut self, node: NodeId, mass: Real) {
        self.edit(|body| {
            body.reweigh(node.index(), |body| {
                body.blueprint.nodes[node.index()].mass = mass;
                if body.state.particles[node.index()].inv_mass > 0.0 {
                    body.state.set_inv_mass(node.index(), 1.0 / mass);
                }
            });
            if let Some(part) = &mut body.solver.part {
                let nodes = body.blueprint.nodes.iter();
                let masses: Vec<f64> = nodes.map(|n| n.mass.into()).collect();
                *part = part.weighed(&masses);
            }
        });
    }

    /// Lets a frozen body take part again, from where it stands and at rest.
    pub fn thaw(&mut self) {
        self.wake_up();
        self.frozen = false;
        self.told.clear();
        self.told.extend(0..self.node_count() as u32);
    }
}

/// Whether a vector is finite, and its square as well.
fn has_square(v: Vector) -> bool {
    v.length_squared().is_finite()
}
