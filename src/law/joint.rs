//! The law of a joint's axis that is neither free nor locked: it has limits, a motor, or both.
//!
//! A motor is a spring and a damper towards a place and a velocity. Rapier takes its force at the end of each of its solver
//! iterations, h_r s long, which gives it in the mean the place of ½·h_r later; so does this, in whatever substep. In one of
//! h_r it is Rapier's own row. A limit lets the axis come as far as it reaches within the substep, and no farther.
//!
//! Locked axes of a soft joint are springs and dampers as well, though other ones than their frequency says, see [`Softness`].

/// What a joint does along three axes, and about them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Axes {
    /// Which displacements and turns are locked.
    pub locked: [bool; 6],
    /// How these give way, if they do.
    pub softness: Option<Softness>,
    /// Displacements that count as one, the distance; its limits and motor are those of the first of them.
    pub coupled: [bool; 3],
    /// Limits of those that are not locked \[m, rad\].
    pub limits: [Option<[f64; 2]>; 6],
    /// Their motors.
    pub motors: [Option<Motor>; 6],
    /// Length of Rapier's solver iterations \[s\].
    pub solver_step: f64,
    /// How often Rapier goes over its rows in each of them.
    pub sweeps: i32,
    /// Damping of those that are not locked, apart from what motors do \[N·s/m\], \[N·m·s\].
    pub drag: [f64; 6],
}

/// How locked axes give way, by what they feel of the mass of the rigid bodies.
///
/// Rapier solves them twice in each of its iterations, h s long: with what takes back how far they are open, which moves the
/// bodies, and again without, which leaves them their velocities. With γ = ω·(ω·h + 2ζ) and r = ω²·h/(1 + γ·h) the velocity v
/// falls by 1/(1 + γ·h) in each, and the opening e drifts back by r·h·e besides: v̇ = a − γ·v and ė = v − r·e. So the opening is
/// on a spring with a damper, ë = a − (γ + r)·ė − γ·r·e, which never swings and gives way by 1 + 1/(γ·h) times a/ω². The
/// damping here is such that e falls by the factor 1 − r·h in a step of h s, as it does there. Without that second time the spring is
/// the one that its frequency says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness {
    /// \[1/s²\].
    pub stiffness: f64,
    /// \[1/s\].
    pub damping: f64,
    /// What share of the opening is taken back besides what Rapier's velocity tells \[1/s\].
    pub drift: f64,
}

impl Softness {
    /// That of a natural frequency ω in rad/s and a damping ratio ζ in iterations of h s, which take the axes up twice if Rapier
    /// `relaxes` them.
    pub fn new(omega: f64, ratio: f64, h: f64, relaxes: bool) -> Self {
        let ratio = ratio.max(0.0);
        if !relaxes {
            return Self {
                stiffness: omega * omega,
                damping: 2.0 * ratio * omega,
                drift: 0.0,
            };
        }
        let taken = omega * (omega * h + 2.0 * ratio);
        let drift = omega * omega * h / (1.0 + taken * h);
        Self {
            stiffness: taken * drift,
            damping: taken * (1.0 - drift * h) + drift / (1.0 - drift * h),
            drift,
        }
    }
}

/// What drives an axis; metres and newtons along it, or radians and newton metres about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Place that is aimed at \[m, rad\].
    pub place: f64,
    /// Velocity that is aimed at \[m/s, rad/s\].
    pub velocity: f64,
    /// \[N/m, N·m/rad\].
    pub stiffness: f64,
    /// \[N·s/m, N·m·s/rad\]. Without either the motor is as stiff as its force lets it be, as Rapier's is.
    pub damping: f64,
    /// Most that it exerts \[N, N·m\].
    pub max_force: f64,
}

/// What an axis is to do in a substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Velocity that the motor aims at with its softness: v + softness·impulse = aim.
    aim: f64,
    softness: f64,
    /// Most impulse of the motor.
    most: f64,
    /// Velocities that reach the limits at the end of the substep, or 0 where they are reached already.
    range: [f64; 2],
}

impl Drive {
    /// That of `motor`, of which the axis is `off` its place \[m, rad\], in a substep of `h` s where Rapier's are of `step`.
    pub fn new(motor: Option<&Motor>, off: f64, h: f64, step: f64) -> Self {
        let mut drive = Self {
            aim: 0.0,
            softness: 0.0,
            most: 0.0,
            range: [f64::NEG_INFINITY, f64::INFINITY],
        };
        if let Some(motor) = motor {
            let pull = motor.stiffness * (0.5 * (h + step)) + motor.damping;
            drive.aim = motor.velocity;
            if pull > 0.0 {
                drive.aim -= motor.stiffness * off / pull;
                drive.softness = 1.0 / (h * pull);
            }
            drive.most = motor.max_force * h;
        }
        drive
    }

    /// Adds a damper of `drag` N·s/m or N·m·s, in a substep of `h` s: −drag·v besides what the motor does, which counts for its most as well.
    pub fn damp(&mut self, drag: f64, h: f64) {
        if drag <= 0.0 {
            return;
        }
        let damper = h * drag;
        if self.most == 0.0 {
            (self.aim, self.softness, self.most) = (0.0, 1.0 / damper, f64::INFINITY);
        } else if self.softness > 0.0 {
            let motor = 1.0 / self.softness;
            self.softness = 1.0 / (motor + damper);
            self.aim *= motor * self.softness;
        }
    }

    /// Lets the motor give way as Rapier's does, which solves motors apart from locked axes: by Gauss–Seidel, in so many
    /// `sweeps` of an iteration. A unit of impulse adds the velocity `alone` to the axis, and `held` with what the locked ones
    /// answer: of what is missing, each sweep leaves (alone − held)/(alone + softness), and that to the power of the sweeps
    /// is as good as more softness.
    pub fn give_way(
        &mut self,
        motor: &Motor,
        [alone, held]: [f64; 2],
        sweeps: i32,
        h: f64,
        step: f64,
    ) {
        let pull = motor.stiffness * step + motor.damping;
        let softness = if pull > 0.0 { 1.0 / (step * pull) } else { 0.0 };
        let left = ((alone - held) / (alone + softness)).powi(sweeps);
        if held > 0.0 && left > 0.0 && left < 1.0 {
            self.softness += (held + softness) * left / (1.0 - left) * step / h;
        }
    }

    /// Keeps the axis from going farther than `to` the one limit and the other \[m, rad\]: down to `to[0]` ≤ 0, up to
    /// `to[1]` ≥ 0. What is beyond a limit already is not brought back; what is no number limits nothing.
    pub fn limit(&mut self, [down, up]: [f64; 2], h: f64) {
        if down <= f64::INFINITY {
            self.range[0] = down.min(0.0) / h;
        }
        if up >= f64::NEG_INFINITY {
            self.range[1] = up.max(0.0) / h;
        }
    }

    /// The impulse in all, of motor and limits, if it was `before`, which has left the axis at `velocity`, and a unit of it
    /// adds `response`; and whether a limit has a part in it.
    pub fn impulse(&self, before: f64, velocity: f64, response: f64) -> (f64, bool) {
        if response <= 0.0 {
            return (before, false);
        }
        let alone = velocity - response * before;
        let motor = (self.aim - alone) / (response + self.softness);
        let driven = alone + response * motor.min(self.most).max(-self.most);
        let within = driven.max(self.range[0]).min(self.range[1]);
        ((within - alone) / response, within != driven)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPRING: Motor = Motor {
        place: 0.0,
        velocity: 0.0,
        stiffness: 50.0,
        damping: 1.5,
        max_force: f64::MAX,
    };

    /// Of 2 kg in steps of h, started at 0.1 m: places after `time`.
    fn swing(motor: &Motor, h: f64, step: f64, time: f64) -> f64 {
        let (mut x, mut v, m) = (0.1, 0.0, 2.0);
        for _ in 0..(time / h).round() as usize {
            let drive = Drive::new(Some(motor), x - motor.place, h, step);
            v += drive.impulse(0.0, v, 1.0 / m).0 / m;
            x += v * h;
        }
        x
    }

    /// x(t) of a spring and damper in closed form, with the damping that comes of forces half a solver iteration late. The
    /// velocity stands half a substep before.
    #[test]
    fn a_motor_is_a_spring_and_a_damper() {
        for (stiffness, damping, step) in [(50.0, 1.5, 0.0), (50.0, 0.0, 4e-3), (800.0, 6.0, 1e-3)]
        {
            let motor = Motor {
                stiffness,
                damping,
                ..SPRING
            };
            let (m, h) = (2.0, 1e-5);
            let c = damping + 0.5 * stiffness * step;
            let (decay, time) = (c / (2.0 * m), 0.7_f64);
            let w = (stiffness / m - decay * decay).sqrt();
            let exact =
                0.1 * (-decay * time).exp() * ((w * time).cos() + decay / w * (w * time).sin());
            let x = swing(&motor, h, step, time);
            assert!((x - exact).abs() < 1e-5, "{x} {exact}");
        }
    }

    /// In a substep as long as Rapier's it is the row of Rapier: implicit Euler.
    #[test]
    fn in_rapiers_step_it_is_rapiers_row() {
        let (h, k, c) = (0.01, SPRING.stiffness, SPRING.damping);
        let (x, v, m) = (0.1, 0.3, 2.0);
        let (j, _) = Drive::new(Some(&SPRING), x, h, h).impulse(0.0, v, 1.0 / m);
        let after = v + j / m;
        assert!((j + h * (k * (x + h * after) + c * after)).abs() < 1e-12);
    }

    /// On an axis of 1 kg with a load that sets in: as Rapier's two passes leave it, in substeps of any length.
    #[test]
    fn a_soft_axis_gives_way_as_in_rapier() {
        let (h, load) = (1e-3, 5.0);
        for (frequency, ratio, relaxes, tolerance) in [
            (20.0, 1.0, true, 0.01),
            (60.0, 1.0, true, 0.01),
            (60.0, 0.2, true, 0.03),
            (300.0, 1.0, true, 0.05),
            (60.0, 0.2, false, 0.1),
        ] {
            let omega = frequency * std::f64::consts::TAU;
            let soft = Softness::new(omega, ratio, h, relaxes);
            let sag = load / soft.stiffness;
            let (bias, cfm) = (
                omega / (h * omega + 2.0 * ratio),
                1.0 / (h * omega * (h * omega + 2.0 * ratio)),
            );
            let (mut v, mut opened) = (0.0, 0.0);
            let mut own = [(0.0, 0.0); 3];
            for n in 0..2000 {
                v += h * load;
                let held = v - (v + bias * opened) / (1.0 + cfm);
                opened += h * held;
                v = if relaxes { v * cfm / (1.0 + cfm) } else { held };
                for ((x, v), parts) in own.iter_mut().zip([1, 4, 20]) {
                    let h_s = h / f64::from(parts);
                    let pull = soft.stiffness * 0.5 * (h_s + h) + soft.damping;
                    for _ in 0..parts {
                        *v = (*v + h_s * (load - soft.stiffness * *x)) / (1.0 + h_s * pull);
                        *x += h_s * *v;
                    }
                    let off = (*x - opened).abs() / sag;
                    assert!(
                        n < 3 || off < tolerance,
                        "{frequency} {ratio}, {parts}: {off} in {n}"
                    );
                }
            }
            assert!((opened / sag - 1.0).abs() < 1e-6, "{opened} {sag}");
            // What hangs still has a velocity in Rapier.
            assert!((v - soft.drift * opened).abs() < 1e-6, "{v}");
        }
    }

    #[test]
    fn it_exerts_no_more_than_its_force() {
        let motor = Motor {
            velocity: 5.0,
            max_force: 3.0,
            ..SPRING
        };
        for (velocity, force) in [(-100.0, 3.0), (100.0, -3.0)] {
            let drive = Drive::new(Some(&motor), 0.0, 0.01, 0.01);
            let (j, at_limit) = drive.impulse(0.0, velocity, 0.5);
            assert!((j / 0.01 - force).abs() < 1e-12 && !at_limit);
        }
    }

    /// Whatever it starts from, the impulse leaves the axis within its limits, and is none where it is within them anyway.
    #[test]
    fn a_limit_stops_and_never_pulls() {
        let h = 0.01;
        let mut drive = Drive::new(None, 0.0, h, h);
        drive.limit([-0.02, f64::INFINITY], h);
        for (velocity, left) in [(-5.0, -2.0), (-2.0, -2.0), (-1.0, -1.0), (7.0, 7.0)] {
            for before in [0.0, 1.5] {
                let now = velocity + 0.5 * before;
                let (j, at_limit) = drive.impulse(before, now, 0.5);
                assert_eq!(at_limit, velocity < left);
                assert!((velocity + 0.5 * j - left).abs() < 1e-12, "{velocity}: {j}");
                assert!(j >= 0.0);
            }
        }
        // Beyond a limit it goes no farther, and back freely.
        drive.limit([0.1, f64::INFINITY], h);
        assert_eq!(drive.impulse(0.0, -1.0, 0.5), (2.0, true));
        assert_eq!(drive.impulse(0.0, 1.0, 0.5), (0.0, false));
        // Rapier passes over what is no number.
        let mut drive = Drive::new(None, 0.0, h, h);
        drive.limit([f64::NAN, f64::NAN], h);
        assert_eq!(drive.impulse(0.0, -1.0, 0.5), (0.0, false));
    }

    /// The limit takes what the motor gives against it, which gives no more than its force.
    #[test]
    fn a_motor_presses_on_its_limit() {
        let motor = Motor {
            velocity: -1.0,
            stiffness: 0.0,
            damping: 1e9,
            max_force: 30.0,
            place: 0.0,
        };
        let h = 0.01;
        let mut drive = Drive::new(Some(&motor), 0.0, h, h);
        drive.limit([0.0, 1.0], h);
        assert_eq!(drive.impulse(0.0, 0.0, 0.5), (0.0, true));
        // It helps to stop what comes up against it.
        assert!((drive.impulse(0.0, 0.1, 0.5).0 + 0.2).abs() < 1e-12);
        assert!((drive.impulse(0.0, 1.0, 0.5).0 + 0.3).abs() < 1e-12);
    }

    /// Two unknowns by Gauss–Seidel: the axis, and a locked one that answers to it.
    #[test]
    fn it_gives_way_as_sweeps_do_that_have_not_converged() {
        let (h, across, locked, alone) = (0.01, 0.6, 0.9, 0.7);
        let held = alone - across * across / locked;
        for (stiffness, damping) in [(0.0, 1e9), (3e4, 0.0), (800.0, 6.0), (0.0, 0.0)] {
            let motor = Motor {
                velocity: 1.0,
                stiffness,
                damping,
                ..SPRING
            };
            let mut drive = Drive::new(Some(&motor), 0.0, h, h);
            let softness = drive.softness;
            for sweeps in 1..5 {
                let (mut j, mut other) = (0.0, 0.0);
                for _ in 0..sweeps {
                    j = (1.0 - across * other) / (alone + softness);
                    other = -across * j / locked;
                }
                drive.softness = softness;
                drive.give_way(&motor, [alone, held], sweeps, h, h);
                let (found, _) = drive.impulse(0.0, 0.0, held);
                assert!((found - j).abs() < 1e-9 * j, "{sweeps}: {found} {j}");
            }
        }
    }

    /// A damper alone takes what an implicit step leaves of the velocity, and with a motor both pull.
    #[test]
    fn a_damped_axis_is_slowed() {
        let (h, drag, response) = (1e-2, 3.0, 0.5);
        let mut damped = Drive::new(None, 0.0, h, h);
        damped.damp(drag, h);
        let (impulse, _) = damped.impulse(0.0, 2.0, response);
        let left = 2.0 + response * impulse;
        assert!((left - 2.0 / (1.0 + drag * h * response)).abs() < 1e-12);
        let mut both = Drive::new(Some(&SPRING), 0.1, h, h);
        let (alone, _) = both.impulse(0.0, left, response);
        both.damp(drag, h);
        let (impulse, _) = both.impulse(0.0, left, response);
        let after = left + response * impulse;
        let spring = -SPRING.stiffness * (0.1 + h * after) - SPRING.damping * after;
        assert!((impulse - h * (spring - drag * after)).abs() < 1e-12);
        assert!((impulse - alone).abs() > 1e-3);
        let mut none = Drive::new(None, 0.0, h, h);
        none.damp(0.0, h);
        assert_eq!(none.impulse(0.0, 2.0, response).0, 0.0);
    }
}
