//! What is kept of a group asleep. What its contacts and attachments bore last goes on being told, and rigid bodies asleep on
//! it feel the same load as before.

#[cfg(feature = "serde-serialize")]
use super::wake::Neighbour;
use super::wake::Sleeper;
use crate::math::Pose;
use crate::world::observer::{AttachmentImpulse, Observer, PairImpulse, Substep};
use crate::world::params::DeformableParameters;
use crate::world::substep::Group;
use crate::world::ties::mirrored;
use crate::world::{Deformable, DeformableHandle, DeformableWorld, RapierParts};
use rapier3d::dynamics::RigidBodyHandle;

/// A group that sleeps if nothing near it is awake.
#[derive(Clone, Debug)]
pub(in crate::world) struct Drowsy {
    pub members: Vec<DeformableHandle>,
    /// The rigid bodies it can touch.
    rigid: Vec<RigidBodyHandle>,
    /// What contacts and attachments bore last, per second.
    pub pairs: Vec<PairImpulse>,
    pub tied: Vec<AttachmentImpulse>,
}

/// A group asleep.
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
#[derive(Clone, Debug)]
pub(in crate::world) struct Island {
    pub sleepers: Vec<Sleeper>,
    /// The rigid bodies it can touch, and where they rest.
    pub rigid: Vec<(RigidBodyHandle, Pose)>,
    /// What contacts and attachments bore last, per second.
    pub pairs: Vec<PairImpulse>,
    pub tied: Vec<AttachmentImpulse>,
}

impl Group {
    /// The group as it would sleep after a rigid step of `dt` s: `None` if one of its members must not.
    pub fn as_drowsy(&self, dt: f64, params: &DeformableParameters) -> Option<Drowsy> {
        let sleeps = |(handle, body): &(DeformableHandle, Box<Deformable>)| {
            body.sleep.slow_for >= params.sleep_after
                && body.comes_to_rest()
                && self.holds(*handle, body)
        };
        if !self.members.iter().all(sleeps) {
            return None;
        }
        let bonds = self.attachments.iter().zip(&self.tied);
        let mut tied: Vec<AttachmentImpulse> = bonds
            .map(|(bond, tied)| AttachmentImpulse {
                impulse: -bond.load.force / dt,
                moment: -bond.load.moment / dt,
                ..*tied
            })
            .collect();
        let others: Vec<_> = mirrored(&self.attachments, &tied, &self.members).collect();
        tied.extend(others);
        Some(Drowsy {
            members: self.members.iter().map(|(handle, _)| *handle).collect(),
            rigid: self.touched.iter().map(|t| t.body).collect(),
            pairs: self.pair_sums().map(|(p, sum)| sum.mean(p, dt)).collect(),
            tied,
        })
    }

    /// Whether something keeps a member where it is: pins, contacts or attachments.
    fn holds(&self, handle: DeformableHandle, body: &Deformable) -> bool {
        let touches = |pair: &PairImpulse| pair.deformable == handle;
        body.state.particles.iter().any(|p| p.inv_mass == 0.0)
            || (self.pair_sums()).any(|(pair, sum)| touches(pair) && sum.is_touching())
            || self.tied.iter().any(|tied| tied.deformable == handle)
    }
}

impl Drowsy {
    /// Where its rigid bodies rest; `None` if one of them does not.
    pub fn resting(&self, parts: &RapierParts) -> Option<Vec<(RigidBodyHandle, Pose)>> {
        let pose = |&handle: &RigidBodyHandle| {
            let body = parts.bodies.get(handle)?;
            (!body.is_dynamic() || body.is_sleeping()).then_some((handle, *body.position()))
        };
        self.rigid.iter().map(pose).collect()
    }
}

impl Island {
    pub fn members(&self) -> impl Iterator<Item = DeformableHandle> {
        self.sleepers.iter().map(|s| s.deformable)
    }

    /// The colliders at rest beside its members.
    #[cfg(feature = "serde-serialize")]
    pub fn neighbours_mut(&mut self) -> impl Iterator<Item = &mut Neighbour> {
        self.sleepers.iter_mut().flat_map(|s| &mut s.neighbours)
    }

    /// The same, to be read.
    #[cfg(feature = "serde-serialize")]
    pub fn neighbours(&self) -> impl Iterator<Item = &Neighbour> {
        self.sleepers.iter().flat_map(|s| &s.neighbours)
    }

    /// What its contacts and attachments bear in `dt` s.
    fn borne(&self, dt: f64) -> (Vec<PairImpulse>, Vec<AttachmentImpulse>) {
        let contacts = self.pairs.iter().map(|pair| PairImpulse {
            impulse: pair.impulse * dt,
            ..*pair
        });
        let attachments = self.tied.iter().map(|tied| AttachmentImpulse {
            impulse: tied.impulse * dt,
            moment: tied.moment * dt,
            ..*tied
        });
        (contacts.collect(), attachments.collect())
    }
}

impl DeformableWorld {
    /// Rigid bodies asleep on sleeping deformables feel what they felt.
    pub(super) fn feel_sleeping_islands(&mut self) {
        for (body, _) in self.islands.iter().flat_map(|island| &island.rigid) {
            if let Some(memory) = self.memory.get_mut(&body.into_raw_parts()) {
                memory.seen = self.steps;
            }
        }
    }

    /// Tells the observer of what groups asleep bear, as of one substep of `dt` s.
    pub(in crate::world) fn observe_islands(&mut self, dt: f64, observer: &mut dyn Observer) {
        let islands = std::mem::take(&mut self.islands);
        for island in &islands {
            let members = island.members();
            let deformables: Vec<_> = members.filter_map(|h| Some((h, self.take(h)?))).collect();
            let (contacts, attachments) = island.borne(dt);
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
