//! What wakes a group asleep: anything awake that comes near, anything near that changes, and a change of one of its bodies.
//!
//! Rapier's flags of what has changed are its own, and gone after its step. So a sleeper remembers all of a collider that its
//! contacts depend on, and holds its shape: held, it can't change without being another one, whose address is all that has to
//! be looked at. A snapshot has a hash of the shape in place of the address.

use super::island::Island;
use crate::contact::form::address;
use crate::coupling::observe::velocity;
use crate::math::{DVec3, Pose, Real};
use crate::world::hooks::Gate;
use crate::world::reach::{self, Search, grown, travel, true_bounds, true_pose};
use crate::world::{DeformableHandle, DeformableWorld, RapierParts};
use rapier3d::dynamics::{CoefficientCombineRule, RigidBody};
use rapier3d::geometry::{Aabb, Collider, ColliderHandle, SharedShape};
use rapier3d::parry::bounding_volume::BoundingVolume;

/// How close something awake may be, in length units.
const NEAR: f64 = 0.01;

/// A sleeping deformable, and what it may lie on.
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
#[derive(Clone, Debug)]
pub(in crate::world) struct Sleeper {
    pub deformable: DeformableHandle,
    bounds: Aabb,
    pub neighbours: Vec<Neighbour>,
}

/// A collider at rest beside a sleeping deformable.
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
#[derive(Clone, Debug, PartialEq)]
pub(in crate::world) struct Neighbour {
    pub collider: ColliderHandle,
    /// Not saved, and `None` after that until it is found again: a neighbour without one counts as changed.
    #[cfg_attr(feature = "serde-serialize", serde(skip))]
    pub shape: Option<HeldShape>,
    pose: Pose,
    skin: Real,
    friction: (Real, CoefficientCombineRule),
    dominance: Option<i16>,
    pushes: bool,
}

/// A shape that is known by its address. While it is held, Rapier copies it before it changes it.
#[derive(Clone, Debug)]
pub(in crate::world) struct HeldShape(pub SharedShape);

impl PartialEq for HeldShape {
    fn eq(&self, other: &Self) -> bool {
        address(&self.0) == address(&other.0)
    }
}

impl DeformableWorld {
    /// A body as it would sleep; `None` if something awake is too close.
    pub(super) fn sleeper(
        &self,
        deformable: DeformableHandle,
        search: &Search,
        gate: &mut Gate,
    ) -> Option<Sleeper> {
        let body = self.get(deformable)?;
        let thickness = 2.0 * body.half_thickness();
        let bounds = body.box_within(NEAR * search.parts.length_unit() + thickness);
        let neighbours = self.neighbours(deformable, &bounds, search, gate)?;
        Some(Sleeper {
            deformable,
            bounds,
            neighbours,
        })
    }

    /// What rests within `bounds` that a body may touch; `None` if something awake is there or will be.
    fn neighbours(
        &self,
        deformable: DeformableHandle,
        bounds: &Aabb,
        search: &Search,
        gate: &mut Gate,
    ) -> Option<Vec<Neighbour>> {
        let body = self.get(deformable)?;
        let parts = search.parts;
        let rigid_speed = search.rigid_speed(|| *bounds, 0.0);
        let reach = grown(bounds, travel(rigid_speed, search.dt, parts));
        let mut neighbours = Some(Vec::new());
        reach::for_each_within(
            (deformable, body),
            &reach,
            search,
            gate,
            |handle, collider, pushes| {
                let pose = true_pose(collider, parts);
                let rigid = collider.parent().and_then(|b| parts.bodies.get(b));
                let way = rigid.map_or(0.0, |b| way(b, collider, search.dt));
                let swept = true_bounds(collider, parts).loosened(way as f32);
                if !swept.intersects(bounds) {
                    return;
                }
                if rigid.is_some_and(|b| moves(b, search.dt)) {
                    neighbours = None;
                }
                if let Some(neighbours) = &mut neighbours {
                    neighbours.push(Neighbour {
                        collider: handle,
                        shape: Some(HeldShape(collider.shared_shape().clone())),
                        pose,
                        skin: collider.contact_skin(),
                        friction: (collider.friction(), collider.friction_combine_rule()),
                        dominance: rigid.map(RigidBody::effective_dominance_group),
                        pushes,
                    });
                }
            },
        );
        neighbours
    }

    /// Wakes the groups that something will disturb in a step of the world of `dt` s, and what they in turn disturb.
    pub(in crate::world) fn wake_islands(&mut self, parts: &RapierParts, dt: f64) {
        if !self.islands.is_empty() {
            let search = Search::ahead(&mut self.known, &self.attachments, parts, dt);
            self.wake_disturbed(&search);
        }
    }

    /// As [`Self::wake_islands`], between the Rapier steps of one step of the world.
    pub(in crate::world) fn wake_more_islands(&mut self, parts: &RapierParts, dt: f64) {
        if !self.islands.is_empty() {
            let search = Search::new(&mut self.known, &self.attachments, parts, dt);
            self.wake_disturbed(&search);
        }
    }

    fn wake_disturbed(&mut self, search: &Search) {
        let mut gate = self.open_gate();
        let active = self.iter().filter(|(_, b)| b.is_active());
        let mut awake: Vec<(DeformableHandle, Aabb)> = active
            .map(|(h, b)| (h, self.swept_box(h, b, search)))
            .collect();
        loop {
            let calm = |island: &Island| self.is_calm(island, &awake, search, &mut gate);
            let calm: Vec<bool> = self.islands.iter().map(calm).collect();
            if calm.iter().all(|calm| *calm) {
                break;
            }
            let mut calm = calm.into_iter();
            let woken = self.islands.extract_if(.., |_| calm.next() == Some(false));
            let woken: Vec<Island> = woken.collect();
            for handle in woken.iter().flat_map(Island::members) {
                if let Some(body) = self.get_mut(handle) {
                    body.wake_up();
                }
                self.clear_touches_of(handle);
                if let Some(body) = self.get(handle).filter(|b| b.is_active()) {
                    awake.push((handle, self.swept_box(handle, body, search)));
                }
            }
        }
        self.keep_answers(gate);
    }

    fn is_calm(
        &self,
        island: &Island,
        awake: &[(DeformableHandle, Aabb)],
        search: &Search,
        gate: &mut Gate,
    ) -> bool {
        let parts = search.parts;
        let asleep = |s: &Sleeper| self.is_asleep(s.deformable);
        let disturbed = |s: &Sleeper| {
            let meets = |(other, bounds): &(DeformableHandle, Aabb)| {
                bounds.intersects(&s.bounds) && self.may_meet(*other, s.deformable)
            };
            awake.iter().any(meets)
                || self
                    .neighbours(s.deformable, &s.bounds, search, gate)
                    .as_ref()
                    != Some(&s.neighbours)
        };
        island.sleepers.iter().all(asleep)
            && island.rigid.iter().all(|(body, pose)| {
                let rigid = parts.bodies.get(*body);
                rigid
                    .is_some_and(|b| b.is_enabled() && !moves(b, search.dt) && b.position() == pose)
            })
            && !island.sleepers.iter().any(disturbed)
    }
}

/// Whether a rigid body moves in the coming `dt` s, or may.
fn moves(body: &RigidBody, dt: f64) -> bool {
    let dynamic = body.is_dynamic() && !body.is_sleeping();
    let (v, w) = velocity(body, dt);
    body.is_enabled() && (dynamic || v != DVec3::ZERO || w != DVec3::ZERO)
}

/// How far any point of a collider may go in `dt` s \[m\].
fn way(body: &RigidBody, collider: &Collider, dt: f64) -> f64 {
    let (v, w) = velocity(body, dt);
    let arm = f64::from(collider.shape().compute_local_bounding_sphere().radius)
        + f64::from(
            collider
                .position_wrt_parent()
                .map_or(0.0, |p| p.translation.length()),
        );
    1.5 * dt * (v.length() + w.length() * arm)
}
