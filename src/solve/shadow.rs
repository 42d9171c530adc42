//! A shadow: the rigid body as a deformable sees it during the substeps of one rigid step.
//!
//! A rigid body that stood still while a deformable makes thirty substeps against it, and then got one impulse, would act
//! as if infinitely heavy and then as if hit by a hammer. Shadows move with the same equations as the rigid pipeline,
//! take every contact impulse at once, and sum them up for the hand-over.

#[cfg(test)]
mod tests;

use crate::math::{DMat3, DQuat, DVec3, sum_of_squares};

/// State and mass of a rigid body during substeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// Centre of mass in the world \[m\].
    pub com: DVec3,
    /// Orientation.
    pub rot: DQuat,
    /// Velocity of the centre of mass \[m/s\].
    pub v: DVec3,
    /// Angular velocity \[rad/s\].
    pub w: DVec3,
    /// Velocities at the end of the last substep, for the trapezoid rule of work.
    pub before: (DVec3, DVec3),
    /// Velocity by impulse \[1/kg\]: 1/m, while rows are solved that of what is tied to it too, less where joints hold, 0 where locked,
    /// fixed, kinematic or asleep; scaled by the response ratio.
    pub inv_mass: DMat3,
    /// Velocity by angular impulse, and transposed, spin by impulse \[1/(kg·m)\]: none without joints, scaled likewise.
    pub cross: Option<DMat3>,
    /// Spin by angular impulse \[1/(kg·m²)\]: I⁻¹ in world axes, less where joints hold, scaled likewise.
    pub inv_inertia: DMat3,
    /// I in world axes, where the body's rotation conserves angular momentum by itself; zero otherwise.
    pub inertia: DMat3,
    /// Its principal axes in its own frame, and its moments about them \[kg·m²\], where there is an `inertia`.
    pub principal: (DQuat, DVec3),
    /// Acceleration by gravity and user forces \[m/s²\], scaled likewise.
    pub acceleration: DVec3,
    /// Angular acceleration by user torques \[rad/s²\], scaled likewise.
    pub spin_up: DVec3,
    /// By how much its velocity stands before its position \[s\], see [`Self::synchronise`]: half of Rapier's solver iterations, 0 for
    /// what is led on a course; `None` for what is not free, is driven by a motor, or gets forces alone.
    pub lead: Option<f64>,
    /// By how much its velocity and spin are ahead of Rapier's, because of that or of soft joints \[m/s\], \[rad/s\].
    pub ahead: (DVec3, DVec3),
    /// Linear and angular damping \[1/s\].
    pub damping: (f64, f64),
    /// What it has taken of velocity and spin since the rigid step began \[m/s\], \[rad/s\].
    pub damped: (DVec3, DVec3),
    /// Angular impulse that it takes in the next substep, together with what is tied to it \[N·m·s\].
    pub late_torque: DVec3,
    /// Sum of impulses received \[N·s\].
    pub impulse: DVec3,
    /// Sum of angular impulses about the centre of mass \[N·m·s\].
    pub torque: DVec3,
    /// What of the impulses of its rigid contacts Rapier is to get as well, and of the angular ones, see
    /// [`RigidRow::bears`](super::rows::RigidRow::bears).
    pub borne: (DVec3, DVec3),
    /// All these sums integrated over the time of the substeps \[N·s²\], \[N·m·s²\]: a free body's displacement by them, and
    /// about its turn, times its mass.
    pub shift: (DVec3, DVec3),
}

/// What a body tumbles by where its axis of rotation counts as fixed during a substep, see [`Shadow::tumbles`].
const TUMBLES: f64 = 1e-6;

/// Frobenius norms of the responses of a shadow.
#[derive(Clone, Copy, Debug, Default)]
pub struct Norms {
    mass: f64,
    cross: f64,
    inertia: f64,
}

impl Norms {
    /// A bound of the norm of the response matrix at `arm` \[1/kg\].
    #[inline(always)]
    pub fn response(&self, arm: DVec3) -> f64 {
        let lever = arm.length();
        self.mass + lever * (2.0 * self.cross + lever * self.inertia)
    }
}

impl Shadow {
    /// What never moves: the world itself.
    pub const FIXED: Self = Self {
        com: DVec3::ZERO,
        rot: DQuat::IDENTITY,
        v: DVec3::ZERO,
        w: DVec3::ZERO,
        before: (DVec3::ZERO, DVec3::ZERO),
        inv_mass: DMat3::ZERO,
        cross: None,
        inv_inertia: DMat3::ZERO,
        inertia: DMat3::ZERO,
        principal: (DQuat::IDENTITY, DVec3::ZERO),
        acceleration: DVec3::ZERO,
        spin_up: DVec3::ZERO,
        lead: None,
        ahead: (DVec3::ZERO, DVec3::ZERO),
        damping: (0.0, 0.0),
        damped: (DVec3::ZERO, DVec3::ZERO),
        late_torque: DVec3::ZERO,
        impulse: DVec3::ZERO,
        torque: DVec3::ZERO,
        borne: (DVec3::ZERO, DVec3::ZERO),
        shift: (DVec3::ZERO, DVec3::ZERO),
    };

    /// What Rapier's body is to get: impulse \[N·s\] and angular impulse about the centre of mass \[N·m·s\].
    pub fn given(&self) -> (DVec3, DVec3) {
        (self.impulse + self.borne.0, self.torque + self.borne.1)
    }

    /// Whether any impulse moves it.
    pub fn gives_way(&self) -> bool {
        self.inv_mass != DMat3::ZERO || self.inv_inertia != DMat3::ZERO
    }

    /// What an impulse and an angular impulse about the centre of mass \[N·s\], \[N·m·s\] do to velocity and spin \[m/s\],
    /// \[rad/s\].
    #[inline(always)]
    pub fn answer(&self, impulse: DVec3, torque: DVec3) -> (DVec3, DVec3) {
        let (mut v, mut w) = (self.inv_mass * impulse, self.inv_inertia * torque);
        if let Some(cross) = &self.cross {
            v += *cross * torque;
            w += cross.transpose() * impulse;
        }
        (v, w)
    }

    /// Takes an impulse and an angular impulse about the centre of mass \[N·s\], \[N·m·s\].
    #[inline(always)]
    pub fn take(&mut self, impulse: DVec3, torque: DVec3) {
        let (v, w) = self.answer(impulse, torque);
        self.v += v;
        self.w += w;
    }

    /// Takes what was left for later.
    pub fn take_late(&mut self) {
        let torque = std::mem::take(&mut self.late_torque);
        if torque != DVec3::ZERO {
            self.take(DVec3::ZERO, torque);
            self.torque += torque;
        }
    }

    /// Velocity of the point at `arm` from the centre of mass \[m/s\].
    #[inline(always)]
    pub fn velocity_at(&self, arm: DVec3) -> DVec3 {
        self.v + self.w.cross(arm)
    }

    /// Velocity of that point at the end of the last substep \[m/s\].
    #[inline(always)]
    pub fn velocity_before(&self, arm: DVec3) -> DVec3 {
        self.before.0 + self.before.1.cross(arm)
    }

    /// Inverse of the mass felt along `direction` at `arm` \[1/kg\].
    #[inline(always)]
    pub fn response(&self, arm: DVec3, direction: DVec3) -> f64 {
        let turn = arm.cross(direction);
        let mixed = self.cross.map_or(DVec3::ZERO, |c| c * (2.0 * turn));
        (self.inv_mass * direction + mixed).dot(direction) + (self.inv_inertia * turn).dot(turn)
    }

    /// The inverse mass matrix felt at `arm` \[1/kg\].
    pub fn response_matrix(&self, arm: DVec3) -> DMat3 {
        let turn = DMat3::from_cols(
            DVec3::new(0.0, arm.z, -arm.y),
            DVec3::new(-arm.z, 0.0, arm.x),
            DVec3::new(arm.y, -arm.x, 0.0),
        );
        let alone = self.inv_mass - turn * self.inv_inertia * turn;
        self.cross.map_or(alone, |cross| {
            let mixed = cross * turn;
            alone + mixed + mixed.transpose()
        })
    }

    /// How large its responses are.
    pub fn norms(&self) -> Norms {
        let of = |m: &DMat3| sum_of_squares(m).sqrt();
        Norms {
            mass: of(&self.inv_mass),
            cross: self.cross.as_ref().map_or(0.0, of),
            inertia: of(&self.inv_inertia),
        }
    }

    /// Takes an impulse at `arm` \[N·s\].
    #[inline(always)]
    pub fn push(&mut self, arm: DVec3, impulse: DVec3) {
        self.take(impulse, arm.cross(impulse));
    }

    /// Rapier's velocity stands half a solver iteration before its position, because gravity is integrated symplectically in
    /// such steps; the shadow's stands half a substep before. This takes the one for the other, after which free flight ends
    /// where Rapier ends it, and a supported body does not creep. The hand-over takes it back by itself: it gives momentum,
    /// not velocity.
    pub fn synchronise(&mut self, h: f64) {
        if let Some(lead) = self.lead {
            self.ahead.0 = self.acceleration * (lead - 0.5 * h);
            self.v += self.ahead.0;
            if !self.gives_way() {
                self.w -= self.spin_up * (0.5 * h);
            }
            self.before = (self.v, self.w);
        }
    }

    /// Leads it through a step of `dt` s at the mean velocities that it has, on a course on which they change at these rates
    /// \[m/s², rad/s²\]. It turns about an axis that is fixed but for what the rates make of it.
    pub fn lead_on(&mut self, (acceleration, spin_up): (DVec3, DVec3), dt: f64) {
        (self.acceleration, self.spin_up) = (acceleration, spin_up);
        self.v -= acceleration * (0.5 * dt);
        self.w -= spin_up * (0.5 * dt);
        self.before = (self.v, self.w);
        self.lead = Some(0.0);
    }

    /// Goes on in substeps of h s after some of `last` s: what is led has the velocity of their middle.
    pub fn change_substep(&mut self, last: f64, h: f64) {
        if !self.gives_way() {
            self.v += self.acceleration * (0.5 * (last - h));
            self.w += self.spin_up * (0.5 * (last - h));
        }
    }

    /// As it is, but what is led through a step of `dt` s goes at its mean velocities, as it does in Rapier's step.
    pub fn led_straight(mut self, dt: f64) -> Self {
        if !self.gives_way() {
            self.v += self.acceleration * (0.5 * dt);
            self.w += self.spin_up * (0.5 * dt);
            (self.acceleration, self.spin_up) = Default::default();
        }
        self
    }

    /// First half of a substep: forces.
    pub fn accelerate(&mut self, h: f64) {
        self.before = (self.v, self.w);
        self.v += self.acceleration * h;
        self.w += self.spin_up * h;
    }

    /// Second half of a substep: position and orientation, with the velocities that rows were solved for, and then damping.
    pub fn advance(&mut self, h: f64) {
        self.shift.0 += self.impulse * h;
        self.shift.1 += self.torque * h;
        self.com += self.v * h;
        let turns_freely = self.inertia != DMat3::ZERO;
        let momentum = self.inertia * self.w;
        let turn = if turns_freely && self.tumbles(h) {
            self.tumble(momentum, h)
        } else {
            DQuat::from_scaled_axis(self.w * h)
        };
        self.rot = (turn * self.rot).normalize();
        if turns_freely {
            let r = DMat3::from_quat(turn);
            self.inertia = r * self.inertia * r.transpose();
            self.inv_inertia = r * self.inv_inertia * r.transpose();
            // The response ratio scales I⁻¹ and not I, so the new w is found from the change of axes alone.
            let w = self.inertia.inverse() * momentum;
            if w.is_finite() {
                self.w = w;
            }
        }
        self.damp(h);
    }

    /// What bears a body has stopped it by now, and damping takes nothing of that.
    fn damp(&mut self, h: f64) {
        let (v, w) = (self.v, self.w);
        self.v /= 1.0 + h * self.damping.0;
        self.w /= 1.0 + h * self.damping.1;
        self.damped.0 += v - self.v;
        self.damped.1 += w - self.w;
    }

    /// Whether its axis of rotation moves so much in a substep of h s that a turn about that at the start is not good enough: for
    /// slender bodies it multiplies the angle that their momentum makes with their axis by ½·I₁/I₃·(ωh)² in each.
    fn tumbles(&self, h: f64) -> bool {
        let (_, moments) = self.principal;
        let (least, most) = (moments.min_element(), moments.max_element());
        (most - least) * self.w.length_squared() * h * h > TUMBLES * least
    }

    /// How it turns in a substep of h s with a given angular momentum \[N·m·s\]. The energy L²/2I of a free body is split into
    /// one of a ball with its middle moment and what the other two add, Lᵢ²·(1/Iᵢ − 1/I)/2; each alone turns it about a fixed
    /// axis. For bodies with two equal moments that is exact, for others of second order and reversible, however fast they spin
    /// (Dullweber, Leimkuhler and McLachlan 1997).
    fn tumble(&self, momentum: DVec3, h: f64) -> DQuat {
        let (frame, moments) = self.principal;
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &k| moments[i].total_cmp(&moments[k]));
        let [small, middle, large] = order;
        let of_ball = moments[middle].recip();
        let mut turn = DQuat::IDENTITY;
        let mut spin = |i: usize, h: f64| {
            let axis = turn * self.rot * frame * DVec3::AXES[i];
            let more = moments[i].recip() - of_ball;
            turn = DQuat::from_scaled_axis(axis * (momentum.dot(axis) * more * h)) * turn;
        };
        spin(large, 0.5 * h);
        spin(small, h);
        spin(large, 0.5 * h);
        DQuat::from_scaled_axis(momentum * (of_ball * h)) * turn
    }
}
