//! How a body moves within a step: what it is prepared with, its free motion, the impulses of rows, and the way back when a
//! step goes wrong.

use super::Deformable;
use super::steady::Steadiness;
use crate::body::state::Particle;
use crate::math::{DVec3, Real, Vector};
use crate::solve::Integrator;
use crate::solve::work::Work;

/// What a second prediction starts from.
#[derive(Clone, Debug, Default)]
pub(super) struct Start {
    particles: Vec<Particle<Real>>,
    low: Vec<[Real; 4]>,
    work: Work,
    /// Whether the body has been put back to it in this substep.
    restored: bool,
}

/// What a body has booked, and what the books are kept by, at the start of a rigid step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Books {
    work: Work,
    /// Elastic energy in the links of its attachments \[J\].
    links: f64,
    gravity: [Real; 3],
    h: f64,
    steady: Steadiness,
}

impl Deformable {
    /// Fills the solver's forces from outside for the coming rigid step, and leads its kinematic nodes: by how long it is till the end
    /// of the frame \[s\], and how long this step is.
    pub(super) fn prepare(&mut self, gravity: Vector, (remaining, dt): (f64, f64)) {
        self.cache.forget();
        self.solver.kernel = self.defaults.kernel;
        let gravity = (gravity * self.gravity_scale).to_array();
        if gravity != self.solver.external.gravity {
            self.edit_by(Self::node_energies, |body| {
                body.solver.external.gravity = gravity;
            });
        }
        let forces = &mut self.solver.external.node_forces;
        forces.clear();
        forces.extend(
            self.node_forces
                .iter()
                .map(|(kept, once)| (*kept + *once).to_array()),
        );
        let led: Vec<(usize, DVec3)> = self.led_velocities(remaining, dt).collect();
        self.lead_nodes(&led);
        self.courses.begin(&led, dt);
        self.solver.speed_squared = self.max_speed_squared();
    }

    /// Gives led nodes velocities. The kinetic energy of symplectic Euler is told half a substep on, so that the power of springs
    /// at them is in it: whoever leads them has put in what it changes by.
    fn lead_nodes(&mut self, led: &[(usize, DVec3)]) {
        let changes = |(node, v): &&(usize, DVec3)| self.state.velocity(*node) != *v;
        let changed = led.iter().filter(changes).map(|(node, _)| *node as u32);
        let subset = self.subset(changed);
        if subset.nodes.is_empty() {
            return;
        }
        let before = self.energies_in(&subset).balance();
        for &(node, v) in led {
            self.state.set_velocity(node, v);
        }
        let after = self.energies_in(&subset).balance();
        self.solver.work.external += after - before;
    }

    /// The velocities of led nodes in the next `dt` s of the `remaining` s in which they get to their targets \[m/s\].
    fn led_velocities(&self, remaining: f64, dt: f64) -> impl Iterator<Item = (usize, DVec3)> + '_ {
        self.led.iter().map(move |&(node, target)| {
            let mean = (target - self.state.position(node as usize)) / remaining;
            (
                node as usize,
                self.courses.mean(node, mean, (remaining, dt)),
            )
        })
    }

    /// Finds how the velocities of led nodes change within a frame of `dt` s.
    pub(super) fn bend_courses(&mut self, dt: f64) {
        let led = self.led.iter();
        let led = led.map(|(node, target)| (*node, [self.state.position(*node as usize), *target]));
        self.courses.go_on(led, dt);
    }

    /// Velocities of all nodes in a step to come, over which led ones are led in `lead` s \[m/s\].
    pub(super) fn coming_velocities(&self, lead: Option<f64>) -> Vec<DVec3> {
        let velocity = |i| self.state.velocity(i);
        let mut velocities: Vec<DVec3> = (0..self.node_count()).map(velocity).collect();
        let led = lead
            .into_iter()
            .flat_map(|lead| self.led_velocities(lead, lead));
        led.for_each(|(node, v)| velocities[node] = v);
        velocities
    }

    /// Largest speed of any node in such a step \[m/s\].
    pub(super) fn coming_speed(&self, lead: Option<f64>) -> f64 {
        let led = lead
            .into_iter()
            .flat_map(|lead| self.led_velocities(lead, lead));
        led.map(|(_, v)| v.length())
            .fold(self.max_speed(), f64::max)
    }

    /// Begins a substep of h s, before anything looks at velocities.
    pub(super) fn begin(&mut self, h: f64) {
        if self.integrator() == Integrator::SymplecticEuler {
            self.set_back(h);
        }
        for (node, v) in self.courses.substep(h) {
            self.state.set_velocity(node, v);
        }
        self.told.clear();
    }

    /// Moves freely over h s.
    pub(super) fn predict(&mut self, h: f64) {
        if self.h == 0.0 {
            // What velocity Verlet's kinetic energy is is known only now.
            self.edit(|body| body.h = h);
        }
        self.h = h;
        if !self.integrator().takes_late_impulses() {
            self.start.particles.clone_from(&self.state.particles);
            self.start.low.clone_from(&self.state.low);
            self.start.work = self.solver.work;
        }
        self.free_motion(h);
        if self.integrator() == Integrator::SymplecticEuler {
            // As in `lead_nodes`, by the forces at the instant of the change.
            for (node, change) in self.courses.changes() {
                let power = self.solver.elastic_force(node).dot(change);
                self.solver.work.external += 0.5 * h * power;
            }
        }
    }

    /// Velocities of symplectic Euler stand half a substep before the positions. Those that were set are meant for the
    /// positions as they are, as at first all are: this takes half a kick of the elastic forces from them. Without it a mode
    /// comes out larger by the cosine of half the angle by which it turns in a substep, which for the fastest is more than
    /// twice, whenever it is told to stand still.
    ///
    /// Forces from outside are left out, so that a body gets its momentum by force times time from the start, but for what of
    /// the elastic ones they hold in balance, which moves nothing; and so is damping, which would be taken for what drives.
    fn set_back(&mut self, h: f64) {
        let all = self.h == 0.0;
        if !all && self.told.is_empty() {
            return;
        }
        let mut told = std::mem::take(&mut self.told);
        if all {
            told = (0..self.node_count() as u32).collect();
        }
        self.edit(|body| {
            body.h = h;
            let gravity = body.gravity();
            let Self {
                solver,
                state,
                field,
                ..
            } = body;
            solver.evaluate(state, field.as_deref(), None, 0.0);
            for &node in &told {
                let node = node as usize;
                let inv_mass = f64::from(state.particles[node].inv_mass);
                if inv_mass > 0.0 {
                    let elastic = solver.elastic_force(node) * inv_mass;
                    let net = elastic + solver.applied_force(node) * inv_mass + gravity;
                    let is_balanced = net.length_squared() < elastic.length_squared();
                    let kick = if is_balanced { net } else { elastic };
                    let v = state.velocity(node) - kick * (0.5 * h);
                    state.set_velocity(node, v);
                }
            }
        });
        self.told = told;
    }

    fn free_motion(&mut self, h: f64) {
        let integrator = self.integrator();
        let Self {
            solver,
            state,
            field,
            ..
        } = self;
        solver.predict(state, integrator, h, field.as_deref());
        solver.last_substep = Some(h);
    }

    /// The velocity by which a node has moved in the free motion \[m/s\].
    pub(super) fn free_velocity(&self, node: usize, h: f64) -> DVec3 {
        if self.integrator().takes_late_impulses() {
            return self.state.velocity(node);
        }
        let (x, low) = (self.start.particles[node].x, self.start.low[node]);
        let start = DVec3::new(x[0].into(), x[1].into(), x[2].into())
            + DVec3::new(low[0].into(), low[1].into(), low[2].into());
        (self.state.local(node) - start) / h
    }

    /// The square of the speed by which its fastest node has moved in the last substep \[m²/s²\]. Where impulses are taken at
    /// the start of a substep, what is pressed has at its end the velocity ½·h·F/m that the next impulse takes away: a body
    /// at rest moves by nothing and has that.
    pub(super) fn last_motion_squared(&self) -> f64 {
        let known = self.start.particles.len() == self.state.particles.len();
        if self.integrator().takes_late_impulses() || !known || self.h <= 0.0 {
            return self.max_speed_squared().into();
        }
        let nodes = 0..self.state.particles.len();
        nodes
            .map(|node| self.free_velocity(node, self.h).length_squared())
            .fold(0.0, f64::max)
    }

    /// Gives a node the velocity change of its rows. Schemes that must move anew start over at the first.
    pub(super) fn take_impulse(&mut self, node: usize, change: DVec3, h: f64) {
        if self.integrator().takes_late_impulses() {
            self.solver.kick(&mut self.state, node, change, h);
            return;
        }
        if !self.start.restored {
            self.start.restored = true;
            self.state.particles.clone_from(&self.start.particles);
            self.state.low.clone_from(&self.start.low);
            // Flow and fracture were committed at the start and stay; the other sums belong to the motion that is taken
            // back.
            self.solver.work = Work {
                plastic: self.solver.work.plastic,
                fracture: self.solver.work.fracture,
                ..self.start.work
            };
        }
        let v = self.state.velocity(node) + change;
        self.state.set_velocity(node, v);
    }

    /// Moves anew where impulses were taken at the start of the substep.
    pub(super) fn move_anew(&mut self, h: f64) {
        if std::mem::take(&mut self.start.restored) {
            self.free_motion(h);
        }
    }

    /// Completes the substep.
    pub(super) fn finish(&mut self, h: f64) {
        self.cache.forget();
        let integrator = self.integrator();
        let Self {
            solver,
            state,
            field,
            ..
        } = self;
        solver.finish(state, integrator, h, field.as_deref());
    }

    /// Ends a step of the world: led nodes stand at their targets, one-step forces are gone.
    pub(super) fn end_frame(&mut self) {
        self.cache.forget();
        let led = std::mem::take(&mut self.led);
        if self.is_enabled() {
            let still: Vec<_> = led
                .iter()
                .map(|(n, _)| (*n as usize, DVec3::ZERO))
                .collect();
            self.lead_nodes(&still);
            for (node, target) in led {
                let way = self.state.position(node as usize).distance(target);
                self.moved += way;
                self.way = None;
                if self.solver.last_substep.is_none() {
                    // The step went wrong and was taken back: it has not been led there.
                    self.edit_at([node], |body| {
                        body.state.set_position(node as usize, target)
                    });
                } else {
                    self.state.set_position(node as usize, target);
                }
            }
        }
        for (_, once) in &mut self.node_forces {
            *once = Vector::ZERO;
        }
    }

    /// Remembers what [`Self::go_back`] goes back to.
    pub(super) fn back_up(&mut self) {
        self.backup.take_over_nodes(&self.state);
        if !self.solver.table.limits.is_empty() {
            self.backup.take_over_springs(&self.state);
        }
        self.told_before.clone_from(&self.told);
        self.books = Books {
            work: self.solver.work,
            links: self.links,
            gravity: self.solver.external.gravity,
            h: self.h,
            steady: self.steady,
        };
    }

    /// Back to the start of the rigid step: positions, velocities, what flowed and broke, the work done, and what gravity and
    /// substep it was booked by.
    pub(super) fn go_back(&mut self) {
        self.cache.forget();
        self.moved_out.clear();
        self.state.take_over_nodes(&self.backup);
        self.state.take_over_springs(&self.backup);
        self.told.clone_from(&self.told_before);
        self.solver.work = self.books.work;
        self.solver.external.gravity = self.books.gravity;
        (self.links, self.h) = (self.books.links, self.books.h);
        self.steady = self.books.steady;
        self.solver.events.clear();
        self.solver.last_substep = None;
        self.start.restored = false;
        (self.moved, self.way) = (0.0, None);
        self.edits += 1;
        self.rebuild_table();
        self.solver.forget_forces();
        if self.topology.torn.any() {
            self.tear_anew();
        }
    }

    /// Back to the start of the rigid step, at rest, out of the simulation.
    pub(super) fn freeze(&mut self) {
        self.go_back();
        self.edit(|body| {
            for particle in &mut body.state.particles {
                particle.v = [0.0; 3];
            }
        });
        self.frozen = true;
    }

    /// A bound on how fast any node goes into the coming substep \[m/s\]: the integration pass has seen velocities before
    /// rows, and how far nodes moved tells what rows did to them.
    pub(super) fn fastest(&self) -> f64 {
        let speed = self.gain() * self.solver.top_speed();
        if self.h > 0.0 {
            speed.max(self.moved / self.h)
        } else {
            speed
        }
    }

    /// Largest speed of any node \[m/s\].
    pub(super) fn max_speed(&self) -> f64 {
        f64::from(self.max_speed_squared()).sqrt()
    }

    /// Largest squared speed of any node \[m²/s²\].
    pub(super) fn max_speed_squared(&self) -> f32 {
        self.state
            .particles
            .iter()
            .map(|p| p.v.iter().map(|c| c * c).sum::<f32>())
            .fold(0.0, f32::max)
    }
}
