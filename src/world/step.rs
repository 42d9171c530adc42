//! One step of the world, top to bottom: before Rapier's step the deformables and the shadows of what they touch are
//! advanced, then Rapier steps, then rigid bodies get the rest of their impulses.

use super::advance::{Advance, Moving};
use super::group::Ends;
use super::kinematic::KinematicTargets;
use super::observer::Observer;
use super::reach::Search;
use super::substep::{NEAR, Settings};
use super::{DeformableWorld, RapierParts, landing, reach};
use crate::contact::form::Form;
use crate::coupling::handover;
use crate::coupling::memory::BodyMemory;
use crate::math::{Real, Vector};
use rapier3d::dynamics::{IntegrationParameters, RigidBodyHandle};
use rapier3d::pipeline::{EventHandler, PhysicsHooks, PhysicsWorld};

/// For how long Rapier goes on with short steps after a deformable was last in reach of an awake body \[s\].
const FINE_FOR: f64 = 0.5;

/// The shortest step there is \[s\]. What rounding leaves of a position, over a step 10⁵ times as short, is a speed that shows in
/// the energies; the time itself would no longer grow by it.
const SHORTEST: Real = 1e-9;

/// The longest \[s\]. A program that was suspended, and asks for the hours that it has missed at once, would stand still for as
/// long.
const LONGEST: Real = 10.0;

impl DeformableWorld {
    /// Advances deformables and Rapier's world by `world.integration_parameters.dt`.
    pub fn step(&mut self, world: &mut PhysicsWorld) {
        self.step_with(world, &(), &(), &mut ());
    }

    /// As [`Self::step`], with Rapier's hooks and events, and an observer that sees every substep.
    ///
    /// dt = 0 applies changes made to Rapier's sets and moves nothing; a dt that is NaN, negative, longer than 10 s or else
    /// shorter than a nanosecond does nothing at all and is reported, as are a gravity that is not finite and
    /// [`params`](Self::params) out of range.
    pub fn step_with(
        &mut self,
        world: &mut PhysicsWorld,
        hooks: &dyn PhysicsHooks,
        events: &dyn EventHandler,
        observer: &mut dyn Observer,
    ) {
        let dt = f64::from(world.integration_parameters.dt);
        if !self.takes(dt, world.gravity) {
            return;
        }
        self.complete_half_step(&mut RapierParts::from(&mut *world), observer);
        self.report.rigid_steps = 1;
        self.wake_on_new_gravity(&mut RapierParts::from(&mut *world));
        if dt > 0.0 {
            self.wake_unmoored(&mut RapierParts::from(&mut *world), dt);
            self.wake_struck(&mut RapierParts::from(&mut *world), dt);
        }
        self.wake_islands(&RapierParts::from(&mut *world), dt);
        if dt == 0.0 {
            world.step_with_events(hooks, events);
            return;
        }
        self.begin_touches();
        self.wake_sleepers_in_the_way(&mut RapierParts::from(&mut *world), dt);
        let targets = KinematicTargets::read(&world.bodies, &mut self.courses, dt);
        for (_, body) in self.bodies.iter_mut() {
            body.bend_courses(dt);
        }
        let steps = self.rigid_steps(&RapierParts::from(&mut *world), dt);
        self.report.rigid_steps = steps;
        let mut parameters = world.integration_parameters;
        parameters.dt = (dt / steps as f64) as f32;
        parameters.normalized_contact_recycle_distance = parameters
            .normalized_contact_recycle_distance
            .min(RECYCLE_DISTANCE);
        for m in 0..steps {
            targets.set(&mut world.bodies, m + 1, steps);
            let left = dt * (steps - m) as f64 / steps as f64;
            let mut parts = RapierParts::from(&mut *world);
            parts.integration_parameters = &parameters;
            if m > 0 {
                self.wake_more_islands(&parts, dt / steps as f64);
            }
            self.advance(&mut parts, dt / steps as f64, dt, left, observer);
            if steps == 1 {
                world.step_with_events(hooks, events);
            } else {
                rapier_step(world, &parameters, hooks, events);
            }
            self.hand_over(&mut RapierParts::from(&mut *world), dt / steps as f64);
        }
        targets.restore(&mut world.bodies);
        self.end_frame(&RapierParts::from(&mut *world), dt, observer);
    }

    /// For those who own the loop: advances the deformables through `parts.integration_parameters.dt` and gives rigid
    /// bodies the first part of their impulses. Make one Rapier step, then call [`Self::after_step`]. Heavy bodies on
    /// light deformables want Rapier steps of [`max_rigid_dt`](super::DeformableParameters::max_rigid_dt) or less here, light
    /// ones that carry heavy nodes and lie on something or hang on joints still less, which [`Self::step`] sees to by itself.
    pub fn before_step(&mut self, parts: &mut RapierParts, observer: &mut dyn Observer) {
        let dt = f64::from(parts.integration_parameters.dt);
        if self.takes(dt, parts.gravity) && dt > 0.0 {
            self.complete_half_step(parts, observer);
            self.wake_on_new_gravity(parts);
            self.wake_unmoored(parts, dt);
            self.wake_struck(parts, dt);
            self.wake_islands(parts, dt);
            self.begin_touches();
            // A single step to the targets leads straight to them.
            self.courses.clear();
            for (_, body) in self.bodies.iter_mut() {
                body.courses.clear();
            }
            self.report.rigid_steps = 1;
            self.wake_sleepers_in_the_way(parts, dt);
            self.advance(parts, dt, dt, dt, observer);
            self.half_done = Some(dt);
        }
    }

    /// The other half of [`Self::before_step`]; without one before it, nothing.
    pub fn after_step(&mut self, parts: &mut RapierParts) {
        self.after_step_with(parts, &mut ());
    }

    /// As [`Self::after_step`], with an observer that is told of contacts that began or ended in the step.
    pub fn after_step_with(&mut self, parts: &mut RapierParts, observer: &mut dyn Observer) {
        self.complete_half_step(parts, observer);
    }

    /// Begins the report of a step, which says what is wrong with its numbers where they are none to step with.
    fn takes(&mut self, dt: f64, gravity: Vector) -> bool {
        self.report.clear();
        let report = &mut self.report;
        let is_step = dt == 0.0 || (f64::from(SHORTEST)..=f64::from(LONGEST)).contains(&dt);
        report.invalid_dt = (!is_step).then_some(dt);
        report.invalid_gravity = (!gravity.is_finite()).then_some(gravity);
        report.invalid_params = self.params.check().err();
        report.invalid_dt.is_none()
            && report.invalid_gravity.is_none()
            && report.invalid_params.is_none()
    }

    /// Completes a [`Self::before_step`] that has not been completed: bodies get the rest of their impulses, and the user's
    /// forces back.
    fn complete_half_step(&mut self, parts: &mut RapierParts, observer: &mut dyn Observer) {
        if let Some(dt) = self.half_done.take() {
            self.hand_over(parts, dt);
            self.end_frame(parts, dt, observer);
        }
    }

    /// M: how many Rapier steps this frame is cut into.
    fn rigid_steps(&mut self, parts: &RapierParts, dt: f64) -> usize {
        if self.can_touch_awake_body(parts, dt) {
            self.fine_until = self.time + FINE_FOR;
        } else if self.time >= self.fine_until {
            return 1;
        }
        let longest = self.params.max_rigid_dt;
        let finer = self.finer_steps(parts, longest.min(dt));
        // A hair less, so that 1/60 is four steps of 1/240 and not five.
        let usual = ((dt / longest - 1e-6).ceil() as usize).max(1);
        if longest > 1e-3 && finer == 1 {
            return usual;
        }
        // Never more often than the deformables themselves.
        let bodies = self.iter().filter(|(_, b)| b.is_active());
        let substeps = bodies.map(|(_, b)| b.last_substeps(dt)).max();
        let wanted = usual.saturating_mul(finer).min(substeps.unwrap_or(1));
        if longest > 1e-3 {
            wanted.max(usual)
        } else {
            wanted.max(1)
        }
    }

    fn can_touch_awake_body(&mut self, parts: &RapierParts, dt: f64) -> bool {
        let awake = |h: RigidBodyHandle| {
            parts
                .bodies
                .get(h)
                .is_some_and(|b| b.is_dynamic() && !b.is_sleeping() && b.is_enabled())
        };
        if !self.iter().any(|(_, b)| b.is_active()) {
            return false;
        }
        let search = Search::ahead(&mut self.known, &self.attachments, parts, dt);
        let mut found = false;
        let mut gate = self.open_gate();
        for (own, body) in self.iter().filter(|(_, b)| b.is_active()) {
            let own = (own, body, body.coming_speed(search.lead));
            reach::for_each_in_reach(own, &search, &mut gate, |_, collider, pushes| {
                let moves = collider.parent().is_some_and(awake);
                found |= pushes && moves && Form::takes(collider.shape());
            });
        }
        self.keep_answers(gate);
        let mut bonds = self.attachments.iter().filter(|(_, a)| !a.is_broken());
        found || bonds.any(|(_, a)| a.body().is_some_and(awake))
    }

    /// Advances all deformables through a rigid step of `dt` s, the `left` s of a `frame` that is not over yet.
    fn advance(
        &mut self,
        parts: &mut RapierParts,
        dt: f64,
        frame: f64,
        left: f64,
        observer: &mut dyn Observer,
    ) {
        self.drop_stale_attachments(Some(&*parts.bodies));
        self.find_loose_attachments(parts);
        let usual = self.params.max_rigid_dt.min(frame).max(dt);
        self.stiffly = self.find_stiffly_held(parts, dt, usual);
        for (_, attachment) in self.attachments.iter_mut() {
            let owner = self.bodies.get(attachment.deformable.0);
            if !owner.is_some_and(|b| b.is_sleeping()) {
                (attachment.force, attachment.torque, attachment.moment) = Default::default();
            }
        }
        let defaults = self.params;
        for (_, body) in self.bodies.iter_mut().filter(|(_, b)| b.is_active()) {
            body.defaults = defaults;
            body.state.recentre(parts.length_unit());
            body.solver.time = self.time;
            body.back_up();
            body.prepare(parts.gravity, (left, dt));
        }
        let advance = Advance {
            time: self.time,
            parity: self.parity,
            dt,
            frame,
            review_interval: self.params.review_interval.max(1e-6),
            settings: self.settings(parts.length_unit()),
        };
        let mut parity = self.parity;
        self.drowsy.clear();
        let groups = self.form_groups(parts, dt);
        let mut moving: Vec<Moving> = groups.into_iter().map(Moving::from).collect();
        advance.all(&mut moving, observer);
        for moved in moving {
            parity ^= moved.odd;
            self.report.include(&moved.report);
            self.dissolve(moved.group, parts, dt);
        }
        self.parity = parity;
        self.time += dt;
        self.observe_islands(dt, observer);
    }

    /// Settings of substeps, in a world of this length unit.
    fn settings(&self, unit: f64) -> Settings {
        Settings {
            passes: self.params.passes.max(1),
            push_out: self.params.push_out_speed * unit,
            near: NEAR * unit,
            touching: 1e-5 * unit,
            length_unit: unit,
        }
    }

    /// Gives rigid bodies the rest of their impulses, learns their response, and wakes sleepers whose load has changed.
    fn hand_over(&mut self, parts: &mut RapierParts, dt: f64) {
        self.steps += 1;
        let mut ends = Ends::new();
        let held = self.held();
        let mut waiting = std::mem::take(&mut self.waiting);
        for w in &waiting {
            let (body, end) = (w.touched.body, &w.end);
            ends.insert(body.into_raw_parts(), (end.com, end.rot));
            let sleeping = parts.bodies.get(body).is_some_and(|b| b.is_sleeping());
            let memory = self
                .memory
                .entry(body.into_raw_parts())
                .or_insert_with(|| BodyMemory::first_seen(sleeping));
            memory.seen = self.steps;
            (memory.near, memory.was_put) = (w.near, false);
            memory.feel(end.impulse, dt);
            // Asleep it would not be lifted, and the node that it holds stay where it is; or a deformable on its way be held up.
            if w.holds || w.led {
                parts.islands.wake_up(parts.bodies, body, true);
            }
            if w.pending.is_something()
                && let Some(body) = parts.bodies.get_mut(body)
            {
                handover::after_step(body, &w.pending, end, memory);
            }
        }
        landing::land(parts.bodies, &mut waiting);
        self.lead_back(parts, &mut waiting, dt);
        for w in &waiting {
            if let Some(body) = parts.bodies.get(w.touched.body) {
                self.report.coupling_defect += handover::defect(body, &w.pending, &w.end);
            }
            self.leave_shadow(parts, w, &held, dt);
        }
        self.follow_rigid_bodies(parts, &ends);
        self.watch_sleepers(parts, dt);
        self.sense(parts);
    }

    fn end_frame(&mut self, parts: &RapierParts, dt: f64, observer: &mut dyn Observer) {
        self.end_touches(parts, dt, observer);
        for (_, body) in self.bodies.iter_mut() {
            body.end_frame();
        }
        self.fall_asleep(parts, dt);
        self.note_moorings(parts, dt);
    }
}

/// Rapier takes the contacts of its last look at a pair for those of now until the pair has moved by so much, in length
/// units: 5 cm by default, and 2 cm where it found nothing near then, by which time a fast body is inside. What it is
/// about to answer could not be foreseen.
const RECYCLE_DISTANCE: f32 = 2e-3;

/// Rapier's step with other parameters than the world's own, which stay as they are.
fn rapier_step(
    world: &mut PhysicsWorld,
    parameters: &IntegrationParameters,
    hooks: &dyn PhysicsHooks,
    events: &dyn EventHandler,
) {
    world.physics_pipeline.step(
        world.gravity,
        parameters,
        &mut world.islands,
        &mut world.broad_phase,
        &mut world.narrow_phase,
        &mut world.bodies,
        &mut world.colliders,
        &mut world.impulse_joints,
        &mut world.multibody_joints,
        &mut world.soft_bodies,
        &mut world.ccd_solver,
        hooks,
        events,
    );
}
