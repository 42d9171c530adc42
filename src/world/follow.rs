//! What follows rigid bodies to where Rapier's own step has left these: attached nodes at once, shadows of what rests in their own
//! time. Where nodes would have to jump, bodies are led back before, see [`super::lead_back`].

use super::attach::held_frame;
use super::group::{Ends, Waiting};
use super::laden::{Held, softest_contact};
use super::{Deformable, DeformableWorld, RapierParts};
use crate::contact::target::wide_rotation;
use crate::coupling::attach::{Hold, Part, Point};
use crate::coupling::flight::rotation_vector;
use crate::coupling::observe::Answer;
use crate::math::{DVec3, wide};
use std::collections::BTreeMap;

impl DeformableWorld {
    /// Leaves the shadow of what rests on rigid bodies where it is after Rapier's step of `dt` s, see [`BodyMemory::keep_apart`].
    /// The shadow of what hangs on joints or holds nodes goes to where the body is and stays there, for joints and nodes would stretch;
    /// but where the springs behind nodes are stiff, these are held where the shadow is, or they would be driven, and so is all that
    /// hangs together with it. That of a sleeper stays, or what lies on it would be moved.
    pub(super) fn leave_shadow(
        &mut self,
        parts: &RapierParts,
        waiting: &Waiting,
        held: &Held,
        dt: f64,
    ) {
        let (touched, end) = (&waiting.touched, &waiting.end);
        let Some(memory) = self.memory.get_mut(&touched.body.into_raw_parts()) else {
            return;
        };
        let body = parts.bodies.get(touched.body);
        let Some(body) = body.filter(|b| !b.is_sleeping()) else {
            return;
        };
        let on_joints = parts.joints_of(touched.body).next().is_some();
        let (holds, is_stiff) = (held.holds(touched.body), held.is_stiff(touched.body));
        let rot = wide_rotation(*body.rotation());
        let miss_of = |com: DVec3| (end.com - com, rotation_vector(end.rot * rot.inverse()));
        let (miss, turn) = match touched.answer {
            // Its mass may have changed since the shadow was made.
            Answer::Linked => miss_of(wide(body.translation()) + rot * touched.local_com),
            Answer::Constrained if is_stiff || waiting.put => {
                miss_of(wide(body.translation()) + rot * touched.local_com)
            }
            Answer::Constrained if !on_joints && !holds => miss_of(wide(body.center_of_mass())),
            // What its shadow took for free, Rapier may have stopped.
            Answer::Free if is_stiff && softest_contact(body, parts).is_some() => {
                miss_of(wide(body.translation()) + rot * touched.local_com)
            }
            // It is turned as its shadow, and has moved as far.
            Answer::Free if holds => (memory.offset.0, DVec3::ZERO),
            // Nodes and joints of what was held off the body are not to be moved at once.
            Answer::Constrained if holds || on_joints => memory.offset,
            _ => Default::default(),
        };
        memory.keep_apart(miss, turn, parts.length_unit(), dt);
    }

    /// Brings held points to where the shadows of their rigid bodies begin the next step, which is for all that have been left
    /// where they were a little nearer to their bodies. Positions alone: it completes the way over which the attachment has
    /// worked, so it is booked as work received from the body. The rate is unlimited; what was moved from outside is not
    /// touched here. A link brings its nodes by what the body has missed its shadow's place, the more of it the stiffer it is:
    /// what it is stretched by in between it would keep, and a stiff one throw the node.
    pub(super) fn follow_rigid_bodies(&mut self, parts: &RapierParts, shadows: &Ends) {
        // How many attachments hold each node, where links ask for it.
        let mut holders = BTreeMap::new();
        let holding = || self.attachments.iter().filter(|(_, b)| !b.is_broken());
        if holding().any(|(_, bond)| bond.is_link()) {
            for (_, bond) in holding() {
                for node in bond.nodes.iter() {
                    *holders.entry((bond.deformable.key(), *node)).or_insert(0) += 1;
                }
            }
        }
        for (_, bond) in self.attachments.iter() {
            let rigid = bond.body().and_then(|b| Some((b, parts.bodies.get(b)?)));
            let soft = self.bodies.get_mut(bond.deformable.0);
            let (Some((handle, rigid)), Some(soft)) = (rigid, soft) else {
                continue;
            };
            if bond.loose || bond.is_broken() || !rigid.is_enabled() || !soft.is_active() {
                continue;
            }
            let (origin, rot) = held_frame(&self.memory, (handle, rigid));
            let mut errors: Vec<_> = bond.errors(origin, rot, &soft.state, None).collect();
            if let Hold::Link { stiffness, .. } = bond.hold {
                let shadow = bond.body().and_then(|b| shadows.get(&b.into_raw_parts()));
                let Some((com, turned)) = shadow else {
                    continue;
                };
                let shadows = bond.errors(*com - *turned * bond.com, *turned, &soft.state, None);
                for ((error, shadows), node) in errors.iter_mut().zip(shadows).zip(&*bond.nodes) {
                    let mass = f64::from(soft.blueprint.nodes[*node as usize].mass);
                    // What something else holds as well, is led by neither.
                    let alone = holders.get(&(bond.deformable.key(), *node)) == Some(&1);
                    let share = if alone {
                        lead_of_link(stiffness, soft.h, mass)
                    } else {
                        0.0
                    };
                    *error = (*error - shadows) * share;
                }
            }
            let most = errors.iter().map(|e| e.length()).fold(0.0, f64::max);
            if most > 0.0 && most.is_finite() {
                soft.shift_points(&bond.points, &errors);
            }
        }
    }
}

impl Deformable {
    /// Moves each point by minus its error as an impulse would, and books what that does to the energies as work of the rigid
    /// body.
    fn shift_points(&mut self, points: &[Point], errors: &[DVec3]) {
        self.cache.forget();
        let shifts = self.shifts(points, errors);
        let subset = self.subset(shifts.iter().map(|(node, _)| *node));
        let before = self.energies_in(&subset).balance();
        let mut farthest = 0.0_f64;
        for (node, by) in shifts {
            farthest = farthest.max(by.length());
            self.state.displace(node as usize, by.as_vec3().to_array());
        }
        self.shifted += farthest;
        self.solver.work.rigid += self.energies_in(&subset).balance() - before;
    }

    /// What it takes to move points so within `dt` s \[J\]: what the energies rise by, and that of the way.
    pub(super) fn cost_of_shift(&mut self, points: &[Point], errors: &[DVec3], dt: f64) -> f64 {
        let shifts = self.shifts(points, errors);
        let subset = self.subset(shifts.iter().map(|(node, _)| *node));
        let before = self.energies_in(&subset).balance();
        let at = |n: &u32| {
            (
                self.state.particles[*n as usize],
                self.state.low[*n as usize],
            )
        };
        let places: Vec<_> = subset.nodes.iter().map(at).collect();
        let mut cost = 0.0;
        for (node, by) in shifts {
            let mass = f64::from(self.blueprint.nodes[node as usize].mass);
            cost += 0.5 * mass * by.length_squared() / (dt * dt);
            self.state.displace(node as usize, by.as_vec3().to_array());
        }
        cost += self.energies_in(&subset).balance() - before;
        for (node, (particle, low)) in subset.nodes.iter().zip(places) {
            let node = *node as usize;
            (self.state.particles[node], self.state.low[node]) = (particle, low);
        }
        cost
    }

    /// The nodes that are moved so, and how far \[m\]. A node of several points comes several times.
    fn shifts(&self, points: &[Point], errors: &[DVec3]) -> Vec<(u32, DVec3)> {
        let inv_mass = |p: &Part| f64::from(self.state.particles[p.node as usize].inv_mass);
        let mut shifts = Vec::new();
        for (point, error) in points.iter().zip(errors) {
            let parts = point.parts.iter();
            let response: f64 = parts.map(|p| p.weight * (p.weight * inv_mass(p))).sum();
            if response <= 0.0 {
                continue;
            }
            for part in &point.parts {
                let by = *error * (-part.weight * inv_mass(part) / response);
                if by != DVec3::ZERO {
                    shifts.push((part.node, by));
                }
            }
        }
        shifts
    }
}

/// What of the way of a node of `mass` kg, if it is not held, a link of this stiffness leads, in substeps of `h` s \[1\].
fn lead_of_link(stiffness: f64, h: f64, mass: f64) -> f64 {
    let stiff = 0.25 * h * h * stiffness;
    stiff / (stiff + mass)
}
