//! Groups of deformables asleep: when they fall asleep, what is kept of them, and what wakes them.
//!
//! A group sleeps as a whole, once all its nodes have been slow for a while and everything rigid that it can touch rests
//! as well. What its contacts and attachments bore last goes on being told, and rigid bodies asleep on it feel the same load
//! as before. It wakes when anything awake comes near, when anything near changes, and when one of its bodies is changed.

use super::observer::{AttachmentImpulse, Observer, PairImpulse, Substep};
use super::params::DeformableParameters;
use super::reach::{self, Search, travel, true_pose};
use super::substep::Group;
use super::ties::mirrored;
use super::{Deformable, DeformableHandle, DeformableWorld, RapierParts, hooks};
use crate::coupling::observe::velocity;
use crate::math::{DVec3, Pose, Real, narrow};
use rapier3d::dynamics::{RigidBody, RigidBodyHandle};
use rapier3d::geometry::{Aabb, Collider, ColliderHandle};
use rapier3d::parry::bounding_volume::BoundingVolume;

/// How close something awake may be, in length units.
const NEAR: f64 = 0.01;

/// A deformable's part in sleeping.
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sleep {
    /// Whether it may sleep.
    pub allowed: bool,
    pub asleep: bool,
    /// For how long its nodes have been slow \[s\].
    slow_for: f64,
    /// The momentum that it had when it fell asleep, summed up over all times it did \[N·s\].
    pub lost: DVec3,
    /// Whether a rigid body was in reach in the last step.
    pub beside_rigid: bool,
}

impl Sleep {
    pub fn new(allowed: bool) -> Self {
        Self {
            allowed,
            ..Self::default()
        }
    }

    /// What the next steps depend on.
    pub fn bits(&self) -> u64 {
        self.slow_for.to_bits() ^ u64::from(self.asleep)
    }
}

/// A collider that a sleeping deformable may lie on.
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
#[derive(Clone, Debug, PartialEq)]
struct Neighbour {
    collider: ColliderHandle,
    pose: Pose,
    bounds: Aabb,
    friction: Real,
    pushes: bool,
}

/// A sleeping deformable.
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
#[derive(Clone, Debug)]
struct Sleeper {
    deformable: DeformableHandle,
    bounds: Aabb,
    neighbours: Vec<Neighbour>,
}

/// A group asleep.
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
#[derive(Clone, Debug)]
pub(super) struct Island {
    members: Vec<DeformableHandle>,
    sleepers: Vec<Sleeper>,
    /// The rigid bodies it can touch, and where they rest.
    rigid: Vec<(RigidBodyHandle, Pose)>,
    /// What contacts and attachments bore last, per second.
    pairs: Vec<PairImpulse>,
    tied: Vec<AttachmentImpulse>,
}

impl Group {
    /// The island that this group makes if it falls asleep after a rigid step of `dt` s: `None` if some of it must not.
    pub fn as_island(&self, dt: f64, params: &DeformableParameters) -> Option<Island> {
        let mut sums = self.pair_sums();
        let held = |m: &DeformableHandle, body: &Deformable| {
            let pinned = body.state.particles.iter().any(|p| p.inv_mass == 0.0);
            pinned
                || sums.any(|(pair, sum)| pair.deformable == *m && sum.is_touching())
                || self.tied.iter().any(|tied| tied.deformable == *m)
        };
        let mut held = held;
        let sleeps = |(m, body): &(DeformableHandle, Box<Deformable>)| {
            body.sleep.slow_for >= params.sleep_after && body.comes_to_rest() && held(m, body)
        };
        if !self.members.iter().all(sleeps) {
            return None;
        }
        let bonds = self.attachments.iter().zip(&self.tied);
        let mut tied: Vec<AttachmentImpulse> = bonds
            .map(|(bond, tied)| AttachmentImpulse {
                impulse: -bond.impulse / dt,
                moment: -bond.moment / dt,
                ..*tied
            })
            .collect();
        let others: Vec<_> = mirrored(&self.attachments, &tied, &self.members).collect();
        tied.extend(others);
        Some(Island {
            members: self.members.iter().map(|(handle, _)| *handle).collect(),
            sleepers: Vec::new(),
            rigid: (self.touched.iter())
                .map(|t| (t.body, Pose::IDENTITY))
                .collect(),
            pairs: self.pair_sums().map(|(p, sum)| sum.mean(p, dt)).collect(),
            tied,
        })
    }
}

impl Deformable {
    /// Whether it sleeps: it costs next to nothing, and stands still until something wakes it.
    pub fn is_sleeping(&self) -> bool {
        self.sleep.asleep
    }

    /// Wakes it, and in the next step the group it sleeps with. Every change of a body does that by itself.
    pub fn wake_up(&mut self) {
        self.sleep.asleep = false;
        self.sleep.slow_for = 0.0;
    }

    /// Its momentum, with what falling asleep has taken from it so far \[N·s\].
    pub(crate) fn momentum_before_sleep(&self) -> DVec3 {
        self.momentum() + self.sleep.lost
    }

    /// Whether it may sleep.
    pub fn can_sleep(&self) -> bool {
        self.sleep.allowed
    }

    /// Lets it sleep from now on, or not.
    pub fn set_can_sleep(&mut self, can_sleep: bool) {
        self.wake_up();
        self.sleep.allowed = can_sleep;
    }

    /// Whether rest is what it comes to: nothing drives it, and something damps it.
    fn comes_to_rest(&self) -> bool {
        let solid = self.blueprint.solid.as_ref().map(|s| s.solid);
        let damped = self.solver.external.drag > 0.0
            || self.blueprint.springs.iter().any(|s| s.damping > 0.0)
            || solid.is_some_and(|s| s.mass_damping > 0.0 || s.stiffness_damping > 0.0);
        self.sleep.allowed && damped && self.field.is_none() && self.led.is_empty()
    }

    pub(super) fn box_within(&self, margin: f64) -> Aabb {
        let (lo, hi) = self.bounds();
        // f32 corners far from the origin are coarse.
        let margin = margin + (lo.abs().max(hi.abs()) * 2e-7).max_element();
        Aabb::new(narrow(lo - margin), narrow(hi + margin))
    }
}

impl DeformableWorld {
    /// Lets groups fall asleep at the end of a step of `dt` s. Their last motion is taken from them as external work.
    pub(super) fn fall_asleep(&mut self, parts: &RapierParts, dt: f64) {
        let limit = self.params.sleep_speed * parts.length_unit();
        for (_, body) in self.bodies.iter_mut().filter(|(_, b)| b.is_active()) {
            let slow = f64::from(body.max_speed_squared()) < limit * limit;
            body.sleep.slow_for = if slow { body.sleep.slow_for + dt } else { 0.0 };
        }
        if self.drowsy.is_empty() {
            return;
        }
        let search = Search::new(&self.known, parts, dt);
        for mut island in std::mem::take(&mut self.drowsy) {
            let slow = |h: &DeformableHandle| {
                let body = self.get(*h);
                body.is_some_and(|b| b.sleep.slow_for >= self.params.sleep_after)
            };
            if !island.members.iter().all(slow) || !island.settle(parts) {
                continue;
            }
            let mut gate = self.open_gate();
            let members = island.members.iter();
            let sleepers = members.map(|&h| self.sleeper(h, &search, &mut gate));
            let sleepers: Option<Vec<Sleeper>> = sleepers.collect();
            self.forget_answers(gate);
            let Some(sleepers) = sleepers else { continue };
            for sleeper in &sleepers {
                let Some(body) = self.get_mut(sleeper.deformable) else {
                    continue;
                };
                body.sleep.lost += body.momentum();
                body.edit(|body| {
                    body.state.particles.iter_mut().for_each(|p| p.v = [0.0; 3]);
                });
                body.solver.speed_squared = 0.0;
                body.sleep.asleep = true;
            }
            island.sleepers = sleepers;
            self.islands.push(island);
        }
    }

    /// A body as it would sleep; `None` if something awake is too close.
    fn sleeper(
        &self,
        deformable: DeformableHandle,
        search: &Search,
        gate: &mut hooks::Gate,
    ) -> Option<Sleeper> {
        let body = self.get(deformable)?;
        let thickness = f64::from(body.surface().thickness);
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
        gate: &mut hooks::Gate,
    ) -> Option<Vec<Neighbour>> {
        let body = self.get(deformable)?;
        let parts = search.parts;
        let reach = bounds.loosened(travel(search.rigid_speed, search.dt, parts) as f32);
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
                let swept = collider.shape().compute_aabb(&pose).loosened(way as f32);
                if !swept.intersects(bounds) {
                    return;
                }
                if rigid.is_some_and(|b| moves(b, search.dt)) {
                    neighbours = None;
                }
                if let Some(neighbours) = &mut neighbours {
                    neighbours.push(Neighbour {
                        collider: handle,
                        pose,
                        bounds: collider.shape().compute_local_aabb(),
                        friction: collider.friction(),
                        pushes,
                    });
                }
            },
        );
        neighbours
    }

    /// Wakes the groups that something will disturb within `dt` s, and what they in turn disturb.
    pub(super) fn wake_islands(&mut self, parts: &RapierParts, dt: f64) {
        if self.islands.is_empty() {
            return;
        }
        let search = Search::new(&self.known, parts, dt);
        let mut gate = self.open_gate();
        let active = self.iter().filter(|(_, b)| b.is_active());
        let mut awake: Vec<(DeformableHandle, Aabb)> = active
            .map(|(h, b)| (h, self.swept_box(h, b, &search)))
            .collect();
        loop {
            let calm = |island: &Island| self.is_calm(island, &awake, &search, &mut gate);
            let calm: Vec<bool> = self.islands.iter().map(calm).collect();
            if calm.iter().all(|calm| *calm) {
                break;
            }
            let mut calm = calm.into_iter();
            let woken = self.islands.extract_if(.., |_| calm.next() == Some(false));
            let woken: Vec<Island> = woken.collect();
            for &handle in woken.iter().flat_map(|island| &island.members) {
                if let Some(body) = self.get_mut(handle) {
                    body.wake_up();
                }
                self.clear_touches_of(handle);
                if let Some(body) = self.get(handle).filter(|b| b.is_active()) {
                    awake.push((handle, self.swept_box(handle, body, &search)));
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
        gate: &mut hooks::Gate,
    ) -> bool {
        let parts = search.parts;
        let asleep = |s: &Sleeper| self.get(s.deformable).is_some_and(|b| b.sleep.asleep);
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
                rigid.is_some_and(|b| !moves(b, search.dt) && b.position() == pose)
            })
            && !island.sleepers.iter().any(disturbed)
    }

    /// Whether a body sleeps, by what its handle is sorted by.
    pub(super) fn sleeps(&self, (index, generation): (u32, u32)) -> bool {
        let handle = DeformableHandle(rapier3d::data::arena::Index::from_raw_parts(
            index, generation,
        ));
        self.get(handle).is_some_and(|b| b.sleep.asleep)
    }

    /// Rigid bodies asleep on sleeping deformables feel what they felt.
    pub(super) fn feel_sleeping_islands(&mut self) {
        for (body, _) in self.islands.iter().flat_map(|island| &island.rigid) {
            if let Some(memory) = self.memory.get_mut(&body.into_raw_parts()) {
                memory.seen = self.steps;
            }
        }
    }

    /// Tells the observer of what groups asleep bear, as of one substep of `dt` s.
    pub(super) fn observe_islands(&mut self, dt: f64, observer: &mut dyn Observer) {
        let islands = std::mem::take(&mut self.islands);
        for island in &islands {
            let members = island.members.iter();
            let deformables: Vec<_> = members.filter_map(|&h| Some((h, self.take(h)?))).collect();
            let pairs = island.pairs.iter();
            let contacts: Vec<_> = pairs
                .map(|pair| PairImpulse {
                    impulse: pair.impulse * dt,
                    ..*pair
                })
                .collect();
            let tied = island.tied.iter();
            let attachments: Vec<_> = tied
                .map(|tied| AttachmentImpulse {
                    impulse: tied.impulse * dt,
                    moment: tied.moment * dt,
                    ..*tied
                })
                .collect();
            observer.substep(&Substep {
                time: self.time,
                h: dt,
                deformables: &deformables,
                contacts: &contacts,
                attachments: &attachments,
                node_impulses: &[],
            });
            for (handle, body) in deformables {
                self.put_back(handle, body);
            }
        }
        self.islands = islands;
    }
}

impl Island {
    /// Notes where its rigid bodies rest; `false` if one of them does not.
    fn settle(&mut self, parts: &RapierParts) -> bool {
        self.rigid.iter_mut().all(|(body, pose)| {
            let rigid = parts.bodies.get(*body);
            let rigid = rigid.filter(|b| !b.is_dynamic() || b.is_sleeping());
            rigid.map(|b| *pose = *b.position()).is_some()
        })
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
