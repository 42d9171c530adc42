//! Who touches whom, how strongly, since when: the readable contact forces and the events of a step.
//!
//! A pair touches in a step if any of its substeps had an impulse, so a node that rattles at the rate of the substeps makes
//! no events. Everything is added up over the substeps and over Rapier's steps within a step.

use super::observer::{Observer, PairImpulse, Partner};
use super::{DeformableHandle, DeformableWorld, RapierParts};
use crate::math::DVec3;

/// What one partner did to one deformable in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct PairContact {
    /// The deformable.
    pub deformable: DeformableHandle,
    /// What it touches.
    pub partner: Partner,
    /// Impulse on the deformable \[N·s\].
    pub impulse: DVec3,
    /// Mean force on the deformable over the step \[N\].
    pub force: DVec3,
    /// Largest force of a substep \[N\].
    pub peak_force: f64,
    /// Deepest penetration in any substep \[m\].
    pub depth: f64,
    /// Where they touched, in the mean by impulse \[m\]. The moment of a contact that goes round something is not that of its
    /// force here: sum up those of the impulses of nodes, which an [`Observer`] gets.
    pub point: DVec3,
    /// Mean normal by impulse, out of the partner; zero if the parts of it cancel.
    pub normal: DVec3,
    /// The most points that received an impulse in one substep; 0 for partners that notice and do not push.
    pub touching: u32,
}

/// What happened to a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TouchEventKind {
    /// It began to exchange impulses, or to overlap.
    Started,
    /// It ceased to.
    Stopped {
        /// Because one of the two is no more.
        removed: bool,
    },
    /// The mean force over the step was above the deformable's
    /// [`contact_force_event_threshold`](crate::contact::target::SurfaceProperties::contact_force_event_threshold). Bodies asleep
    /// make no such events, as with Rapier.
    Force,
}

/// A contact or an overlap began, was strong, or ended within a step.
///
/// Contacts are told by impulses, added up over the step. Sensors, and colliders whose solver groups do not agree with the
/// deformable's, only notice it: by a face, a spring or a node of it that is in them after a Rapier step, or by a node that
/// went right through in between, however fast, which both starts and stops in the one step. What is narrower than the
/// distance between nodes may pass unnoticed between them. A collider that becomes a sensor, or ceases to be one, while it
/// touches ends the one and starts the other. Rapier's `ActiveCollisionTypes` and `ActiveEvents` of the
/// collider do not matter: a deformable counts as a dynamic body that asks for its events.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TouchEvent {
    /// What happened.
    pub kind: TouchEventKind,
    /// Whether the partner is a sensor.
    pub sensor: bool,
    /// Simulated time at the end of the step \[s\].
    pub time: f64,
    /// Who, and how strongly in this step; all zero for what only notices, and where nothing touched any more.
    pub contact: PairContact,
}

/// A key of a pair to sort by.
pub(super) type TouchKey = ((u32, u32), (bool, (u32, u32)));

/// A pair that touches, or did a moment ago.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub(super) struct Touch {
    contact: PairContact,
    /// Σ of normal impulses \[N·s\].
    weight: f64,
    pub sensor: bool,
    /// Whether the partner was one in the last step.
    was_sensor: bool,
    /// Whether it touched at the end of the last step.
    before: bool,
    /// Whether it got an impulse in this step.
    pushed: bool,
    /// Whether it was noticed in this step.
    pub seen: bool,
    /// The last Rapier step after which it overlapped.
    pub inside: u64,
}

impl Touch {
    pub fn new(deformable: DeformableHandle, partner: Partner) -> Self {
        let contact = PairContact {
            deformable,
            partner,
            impulse: DVec3::ZERO,
            force: DVec3::ZERO,
            peak_force: 0.0,
            depth: 0.0,
            point: DVec3::ZERO,
            normal: DVec3::ZERO,
            touching: 0,
        };
        Self {
            contact,
            weight: 0.0,
            sensor: false,
            was_sensor: false,
            before: false,
            pushed: false,
            seen: false,
            inside: u64::MAX,
        }
    }

    pub fn key(deformable: DeformableHandle, partner: Partner) -> TouchKey {
        (deformable.key(), partner.key())
    }

    /// Begins a step.
    fn clear(&mut self) {
        let c = &self.contact;
        *self = Self {
            before: self.before,
            sensor: self.sensor,
            was_sensor: self.was_sensor,
            inside: self.inside,
            ..Self::new(c.deformable, c.partner)
        };
    }

    /// Ends a step of `dt` s: sums become means.
    fn finish(&mut self, dt: f64) {
        let c = &mut self.contact;
        c.force = c.impulse / dt;
        if self.weight > 0.0 {
            c.point /= self.weight;
            c.normal = c.normal.normalize_or_zero();
        }
    }

    /// Two deformables are two pairs; the second one makes no events.
    fn is_mirrored(&self) -> bool {
        match self.contact.partner {
            Partner::Collider(_) => false,
            Partner::Deformable(other) => other.key() < self.contact.deformable.key(),
        }
    }
}

/// What a pair of a group adds up over the substeps of a Rapier step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PairSum {
    impulse: DVec3,
    peak: f64,
    depth: f64,
    touching: u32,
    /// Σ impulse · point, Σ impulse · normal, Σ impulse, of normal impulses.
    point: DVec3,
    normal: DVec3,
    weight: f64,
}

impl PairSum {
    /// Takes in a row.
    #[inline]
    pub fn add_row(&mut self, point: DVec3, normal: DVec3, impulse: f64) {
        self.point += point * impulse;
        self.normal += normal * impulse;
        self.weight += impulse;
    }

    /// Whether anything touched.
    pub fn is_touching(&self) -> bool {
        self.touching > 0
    }

    /// The mean over a rigid step of `dt` s, per second.
    pub fn mean(&self, pair: &PairImpulse, dt: f64) -> PairImpulse {
        PairImpulse {
            impulse: self.impulse / dt,
            depth: self.depth,
            touching: self.touching,
            ..*pair
        }
    }

    /// Takes in a substep of h s.
    #[inline]
    pub fn add(&mut self, pair: &PairImpulse, h: f64) {
        if pair.touching > 0 {
            self.impulse += pair.impulse;
            self.peak = self.peak.max(pair.impulse.length() / h);
            self.touching = self.touching.max(pair.touching);
        }
        self.depth = self.depth.max(pair.depth);
    }
}

impl DeformableWorld {
    /// Mean force of a collider, or of another deformable, on a deformable over the last step \[N\]; `None` where they did
    /// not touch.
    ///
    /// ```
    /// use crumple::prelude::*;
    /// use crumple::rapier3d::prelude::*;
    /// let mut world = PhysicsWorld::default();
    /// let (_, floor) = world.insert(RigidBodyBuilder::fixed(), ColliderBuilder::cuboid(5.0, 0.1, 5.0));
    /// let mut deformables = DeformableWorld::default();
    /// let block = deformables.insert(
    ///     DeformableBuilder::new(lattice(Vector::splat(0.4), 0.2))
    ///         .material(Material::rubber())
    ///         .translation(Vector::Y * 0.3),
    /// )?;
    /// deformables.step(&mut world);
    /// assert_eq!(deformables.report().events[0].kind, TouchEventKind::Started);
    /// for _ in 0..120 {
    ///     deformables.step(&mut world);
    /// }
    /// let (force, weight) = (deformables.contact_force(block, floor), deformables[block].mass() * 9.81);
    /// assert!((force.unwrap().y / weight - 1.0).abs() < 0.01);
    /// # Ok::<(), crumple::body::BuildError>(())
    /// ```
    pub fn contact_force(
        &self,
        deformable: DeformableHandle,
        partner: impl Into<Partner>,
    ) -> Option<DVec3> {
        let touch = self.touches.get(&Touch::key(deformable, partner.into()))?;
        touch.pushed.then_some(touch.contact.force)
    }

    /// What touched a deformable in the last step: colliders first, in the order of their handles.
    pub fn contacts_of(&self, deformable: DeformableHandle) -> impl Iterator<Item = &PairContact> {
        let key = deformable.key();
        let last = (true, (u32::MAX, u32::MAX));
        self.touches
            .range((key, (false, (0, 0)))..=(key, last))
            .filter(|(_, t)| t.pushed)
            .map(|(_, t)| &t.contact)
    }

    /// Which deformables a collider, or another deformable, touched in the last step, in the order of their handles.
    pub fn contacts_with(&self, partner: impl Into<Partner>) -> impl Iterator<Item = &PairContact> {
        let partner = partner.into();
        self.touches
            .values()
            .filter(move |t| t.pushed && t.contact.partner == partner)
            .map(|t| &t.contact)
    }

    /// Begins a step: what touched in the last one is not read any more.
    pub(super) fn begin_touches(&mut self) {
        for touch in self.touches.values_mut() {
            let body = self.bodies.get(touch.contact.deformable.0);
            if !body.is_some_and(|b| b.is_sleeping()) {
                touch.clear();
            }
        }
    }

    /// Begins a step of a body that has just been woken.
    pub(super) fn clear_touches_of(&mut self, deformable: DeformableHandle) {
        let steps = self.steps;
        for touch in self.touches.values_mut() {
            if touch.contact.deformable == deformable {
                if touch.inside != u64::MAX {
                    touch.inside = steps;
                }
                touch.clear();
            }
        }
    }

    /// Adds up a Rapier step of a pair.
    pub(super) fn add_touch(&mut self, pair: &PairImpulse, sum: &PairSum) {
        if sum.touching == 0 {
            return;
        }
        let partner = pair.partner;
        let touch = self.touches.entry(Touch::key(pair.deformable, partner));
        let touch = touch.or_insert_with(|| Touch::new(pair.deformable, partner));
        (touch.pushed, touch.seen, touch.sensor) = (true, true, false);
        touch.weight += sum.weight;
        let c = &mut touch.contact;
        c.impulse += sum.impulse;
        c.peak_force = c.peak_force.max(sum.peak);
        c.depth = c.depth.max(sum.depth);
        c.touching = c.touching.max(sum.touching);
        c.point += sum.point;
        c.normal += sum.normal;
    }

    /// Ends a step of `dt` s: means, and events in the order of deformables and partners.
    pub(super) fn end_touches(
        &mut self,
        parts: &RapierParts,
        dt: f64,
        observer: &mut dyn Observer,
    ) {
        let Self {
            touches,
            bodies,
            report,
            steps,
            time,
            ..
        } = self;
        touches.retain(|_, touch| {
            // What was told of a body asleep holds as long as it sleeps.
            let asleep = bodies.get(touch.contact.deformable.0);
            if asleep.is_some_and(|b| b.is_sleeping()) {
                return true;
            }
            touch.finish(dt);
            let now = touch.pushed || touch.inside == *steps;
            let turned = touch.seen && touch.before && touch.sensor != touch.was_sensor;
            let (began, was) = (touch.seen && !touch.before, touch.seen || touch.before);
            let was_sensor = std::mem::replace(&mut touch.was_sensor, touch.sensor);
            touch.before = now;
            if touch.is_mirrored() {
                return now;
            }
            let mut tell = |kind, sensor, contact| {
                let event = TouchEvent {
                    kind,
                    sensor,
                    time: *time,
                    contact,
                };
                observer.touch_event(&event);
                report.events.push(event);
            };
            let (sensor, contact) = (touch.sensor, touch.contact);
            if turned {
                let ended = Touch::new(contact.deformable, contact.partner).contact;
                let kind = TouchEventKind::Stopped { removed: false };
                tell(kind, was_sensor, ended);
            }
            if began || turned {
                tell(TouchEventKind::Started, sensor, contact);
            }
            let deformable = bodies.get(touch.contact.deformable.0);
            let threshold = deformable.and_then(|b| b.surface.contact_force_event_threshold);
            if touch.pushed
                && threshold.is_some_and(|t| touch.contact.force.length() > f64::from(t))
            {
                tell(TouchEventKind::Force, sensor, contact);
            }
            if was && !now {
                let there = match touch.contact.partner {
                    Partner::Collider(c) => parts.colliders.contains(c),
                    Partner::Deformable(d) => bodies.contains(d.0),
                };
                let removed = deformable.is_none() || !there;
                tell(TouchEventKind::Stopped { removed }, sensor, contact);
            }
            now
        });
    }
}

#[cfg(test)]
mod tests;
