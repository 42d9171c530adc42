//! Contacts of shadows with each other.
//!
//! What presses on a rigid body in a heap feels what that body presses on. Rapier finds these contacts and answers them
//! once per step; between its answers the shadows keep them, so that a body on a floor gives way to nothing above it, and
//! to everything beside it. Their impulses stay among the shadows, and Rapier gets what deformables gave; but where it would give way to
//! that, as its contacts are the softer the lighter a body is, it gets what contacts of shadows answered beyond what its own can bear.

use super::climb::Climb;
use super::pass::inverse;
use super::settled::{Give, Settled};
use crate::law::row::{allowed_velocity, normal_impulse};
use crate::math::{DMat3, DVec3, sum_of_squares};
use crate::solve::shadow::Shadow;

/// A contact point of two shadows.
#[derive(Clone, Copy, Debug, Default)]
pub struct RigidRow {
    /// Indices into the shadows; 0 for the fixed world.
    pub shadows: [u32; 2],
    /// From the centres of mass to the point. They don't turn with the bodies: what a wheel stands on is below its hub,
    /// wherever the point is by now that was there at the start \[m\].
    pub arms: [DVec3; 2],
    /// Distance of the surfaces, negative inside \[m\].
    pub gap: f64,
    /// The same at the start of the rigid step \[m\].
    pub gap_at_start: f64,
    /// The penetration that shadows leave, where they part what is deeper \[m\]: Rapier does that, but for bodies that go where their
    /// shadows are.
    pub slop: Option<f64>,
    /// From the first to the second.
    pub normal: DVec3,
    /// What each takes of the impulse: 1, or 0 for a body that dominates the other.
    pub shares: [f64; 2],
    /// Coulomb's μ.
    pub friction: f64,
    /// Velocity of the first one's surface over its body \[m/s\]: a conveyor belt.
    pub belt: DVec3,
    /// Accumulated normal impulse of this substep, at its start that of the last one \[N·s\].
    pub normal_impulse: f64,
    /// Accumulated friction impulse on the second along two sides that are square to the normal, likewise \[N·s\].
    pub friction_impulse: [f64; 2],
    /// The mean force in a step that Rapier's own contact bears without giving way too much \[N\]; what it is pressed by beyond that it
    /// is spared.
    pub bears: f64,
    /// The sum of the normal impulses since the step began \[N·s\].
    pub pressed: f64,
    /// The fastest that the bodies have come in a substep, beyond what is allowed, before anything presses or pulls on them \[m/s\].
    pub came: f64,
    /// What it has borne since the step began.
    pub load: Load,
    /// What the pass makes of it.
    pub made: Made,
}

/// The sum of a contact's impulses in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Load {
    /// Along the normal \[N·s\].
    normal: f64,
    /// On the second body \[N·s\], and integrated over the time of the substeps \[N·s²\].
    impulse: DVec3,
    shift: DVec3,
}

/// How two shadows answer at a point, set for as long as they answer in the same way. All is along the normal and two sides: a
/// visit is three numbers in and three out, however the bodies' masses lie.
#[derive(Clone, Copy, Debug, Default)]
pub struct Made {
    is_ready: bool,
    axes: [Axis; 3],
    /// Relative velocity along each by an impulse along each \[1/kg\].
    response: [[f64; 3]; 3],
    /// Effective mass along the normal \[kg\].
    mass: f64,
    /// Smallest relative normal velocity that is allowed in the substep \[m/s\].
    allowed: f64,
    /// How fast the bodies come, beyond what is allowed, before anything presses or pulls on them \[m/s\].
    closing: f64,
    /// Velocity of the belt along the sides \[m/s\].
    belt: [f64; 2],
    /// What the shadows make of an impulse.
    give: Give,
    /// Which of them give way.
    moves: [bool; 2],
}

/// A direction, and what the shadows have to do with it.
#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    along: DVec3,
    /// Arm × direction: what the turning of each does to the point along it \[m\].
    turns: [DVec3; 2],
    /// What an impulse along it does to the velocities of each \[1/kg\] and to their spins \[1/(kg·m)\].
    velocity: [DVec3; 2],
    spin: [DVec3; 2],
}

impl Axis {
    fn of(along: DVec3, row: &RigidRow, sides: [&Shadow; 2]) -> Self {
        let mut axis = Self {
            along,
            turns: row.arms.map(|arm| arm.cross(along)),
            ..Self::default()
        };
        for (k, side) in sides.into_iter().enumerate() {
            let impulse = along * ([-1.0, 1.0][k] * row.shares[k]);
            let torque = row.arms[k].cross(impulse);
            (axis.velocity[k], axis.spin[k]) = side.answer(impulse, torque);
        }
        axis
    }

    /// Velocity of the second's point relative to the first's along it, by what both do \[m/s\].
    #[inline(always)]
    fn speed(&self, relative: DVec3, spins: [DVec3; 2]) -> f64 {
        self.along.dot(relative) + self.turns[1].dot(spins[1]) - self.turns[0].dot(spins[0])
    }
}

/// How fast shadows part what is inside, where that is theirs to do \[1/s\].
const PARTING: f64 = 30.0;

/// By which share of their norms answers of shadows may differ and count as the same: a body turns a little in every substep.
const SAME: f64 = 1e-3;

/// How shadows answered when rows were prepared: while they answer in the same way, these need no new preparation.
#[derive(Clone, Debug, Default)]
pub(super) struct Answers {
    known: Vec<[DMat3; 3]>,
    same: Vec<bool>,
}

impl Answers {
    fn note(&mut self, shadows: &[Shadow]) {
        self.known
            .resize(shadows.len(), [DMat3::from_diagonal(DVec3::NAN); 3]);
        self.same.clear();
        for (known, shadow) in self.known.iter_mut().zip(shadows) {
            let now = [
                shadow.inv_mass,
                shadow.cross.unwrap_or(DMat3::ZERO),
                shadow.inv_inertia,
            ];
            let is_same = |(known, now): (&DMat3, &DMat3)| {
                sum_of_squares(&(*now - *known)) <= SAME * SAME * sum_of_squares(known)
            };
            let same = known.iter().zip(&now).all(is_same);
            if !same {
                *known = now;
            }
            self.same.push(same);
        }
    }

    fn are_same(&self, shadows: [u32; 2]) -> bool {
        shadows.iter().all(|i| self.same[*i as usize])
    }
}

/// Starts a substep: shadows get what the rows gave them in the last one, or that share of it which leads farthest down.
pub(super) fn start_rigid(rows: &mut [RigidRow], shadows: &mut [Shadow], answers: &mut Answers) {
    let mut climb = Climb::default();
    answers.note(shadows);
    for row in &mut *rows {
        if !(row.made.is_ready && answers.are_same(row.shadows)) {
            row.prepare(shadows);
        }
        climb.slope += row.slope(shadows);
    }
    for row in &*rows {
        row.push(shadows, row.impulse());
    }
    climb.end = rows.iter().map(|row| row.slope(shadows)).sum();
    let share = climb.lowest();
    if share < 1.0 {
        for row in rows {
            row.push(shadows, row.impulse().map(|j| j * (share - 1.0)));
            row.scale(share);
        }
    }
}

impl RigidRow {
    /// Sees what the bodies do by themselves in a substep of h s.
    pub(super) fn approach(&mut self, shadows: &[Shadow], h: f64) {
        let comes = allowed_velocity(-self.gap, h) - self.speed(shadows);
        self.came = self.came.max(comes);
        let deep = self.slop.map_or(0.0, |slop| (-self.gap - slop).max(0.0));
        self.made.allowed = allowed_velocity(-self.gap, h) + PARTING * deep;
        self.made.closing = (comes + PARTING * deep).max(0.0);
    }

    /// Along the normal and the sides \[N·s\].
    pub(super) fn impulse(&self) -> [f64; 3] {
        let [first, second] = self.friction_impulse;
        [self.normal_impulse, first, second]
    }

    /// Makes its impulses larger or smaller.
    pub(super) fn scale(&mut self, by: f64) {
        self.normal_impulse *= by;
        self.friction_impulse = self.friction_impulse.map(|j| j * by);
    }

    /// The slope of what rows minimise along the impulse of this one, times the impulse \[J\].
    fn slope(&self, shadows: &[Shadow]) -> f64 {
        let slopes = self.impulse().into_iter().zip(self.errors(shadows));
        slopes.map(|(j, e)| j * e).sum()
    }

    /// By how much velocities along the normal and the sides exceed what they are to be \[m/s\].
    pub(super) fn errors(&self, shadows: &[Shadow]) -> [f64; 3] {
        let [normal, first, second] = self.velocities(shadows);
        let Made { allowed, belt, .. } = self.made;
        [normal - allowed, first - belt[0], second - belt[1]]
    }

    /// Gives more along the normal and the sides \[N·s\].
    pub(super) fn give(&mut self, shadows: &mut [Shadow], more: [f64; 3]) {
        self.normal_impulse += more[0];
        self.friction_impulse[0] += more[1];
        self.friction_impulse[1] += more[2];
        self.push(shadows, more);
    }

    /// The speed that it has to stop in a substep of h s \[m/s\].
    pub(super) fn closing(&self, shadows: &[Shadow], h: f64) -> f64 {
        allowed_velocity(-self.gap, h) - self.speed(shadows)
    }

    fn prepare(&mut self, shadows: &[Shadow]) {
        let sides = self.shadows.map(|i| &shadows[i as usize]);
        let side = self.normal.any_orthonormal_vector();
        let across = [side, self.normal.cross(side)];
        let along = [self.normal, across[0], across[1]];
        for (i, along) in along.into_iter().enumerate() {
            self.made.axes[i] = Axis::of(along, self, sides);
        }
        let made = &mut self.made;
        let mut square = 0.0;
        for (out, responses) in made.axes.iter().zip(&mut made.response) {
            for (by, response) in made.axes.iter().zip(responses) {
                *response = out.speed(by.velocity[1] - by.velocity[0], by.spin);
                square += *response * *response;
            }
        }
        made.mass = inverse(made.response[0][0]);
        made.belt = across.map(|side| self.belt.dot(side));
        made.give.shadows = square.sqrt();
        made.moves = sides.map(Shadow::gives_way);
        made.is_ready = true;
    }

    /// One visit of a pass; whether it was not settled yet.
    pub(super) fn solve(&mut self, shadows: &mut [Shadow], settled: Settled) -> bool {
        let [speed, first, second] = self.velocities(shadows);
        let Made {
            response,
            mass,
            allowed,
            belt,
            give,
            ..
        } = &self.made;
        let jn = normal_impulse(self.normal_impulse, *allowed, speed, *mass);
        let pressed = jn - self.normal_impulse;
        let mut given = [pressed, 0.0, 0.0];
        self.normal_impulse = jn;
        let limit = self.friction * jn;
        if limit > 0.0 || self.friction_impulse != [0.0; 2] {
            let slip = [
                first + response[1][0] * pressed - belt[0],
                second + response[2][0] * pressed - belt[1],
            ];
            let rubbed = rub(response, slip, self.friction_impulse, limit);
            given[1] = rubbed[0] - self.friction_impulse[0];
            given[2] = rubbed[1] - self.friction_impulse[1];
            self.friction_impulse = rubbed;
        }
        let (settles, change) = (*give, given.iter().map(|j| j * j).sum());
        self.push(shadows, given);
        settled.felt(change, jn * jn, settles).any()
    }

    /// Sums up what it bears of loads, less what stops bodies that come by themselves, without what is tied to them.
    fn book(&mut self, shadows: &[Shadow]) {
        if self.normal_impulse <= 0.0 {
            return;
        }
        let response = |k: usize| {
            let shadow = &shadows[self.shadows[k] as usize];
            self.shares[k] * shadow.response(self.arms[k], self.normal)
        };
        let own = self.made.closing * inverse(response(0) + response(1));
        let share = 1.0 - own / self.normal_impulse;
        if share > 0.0 {
            let [n, s, t] = &self.made.axes;
            let [along_n, along_s, along_t] = self.impulse().map(|j| j * share);
            self.load.normal += along_n;
            self.load.impulse += n.along * along_n + s.along * along_s + t.along * along_t;
        }
    }

    /// Ends a step of `dt` s: what Rapier's contact can't bear of the load, the bodies get as well.
    pub(super) fn spare(&self, shadows: &mut [Shadow], dt: f64) {
        let share = 1.0 - self.bears * dt / self.load.normal;
        if share <= 0.0 || share.is_nan() {
            return;
        }
        for k in 0..2 {
            let shadow = &mut shadows[self.shadows[k] as usize];
            if !shadow.gives_way() {
                continue;
            }
            let sign = [-1.0, 1.0][k] * self.shares[k] * share;
            let (impulse, shift) = (self.load.impulse * sign, self.load.shift * sign);
            let arm = self.arms[k];
            shadow.borne.0 += impulse;
            shadow.borne.1 += arm.cross(impulse);
            shadow.shift.0 += shift;
            shadow.shift.1 += arm.cross(shift);
        }
    }

    /// Ends a substep of h s.
    pub(super) fn end(&mut self, shadows: &[Shadow], h: f64) {
        self.pressed += self.normal_impulse;
        self.book(shadows);
        self.load.shift += self.load.impulse * h;
        self.gap += h * self.speed(shadows);
    }

    /// Whether the bodies have come together in a step of `dt` s, or so near that of their gap less is left than they have closed: faster
    /// than by `far` m in it, and than gravity and the like make them in a step.
    pub fn arrives(&self, shadows: &[Shadow], far: f64, dt: f64) -> bool {
        let driven = |i: u32| shadows[i as usize].acceleration.length();
        let [first, second] = self.shadows.map(driven);
        let slow = far + (first + second) * dt * dt;
        self.came * dt > slow || self.gap_at_start - self.gap > self.gap.max(slow)
    }

    /// Velocity of the second's point relative to the first's along the normal \[m/s\].
    fn speed(&self, shadows: &[Shadow]) -> f64 {
        let at = |k: usize| shadows[self.shadows[k] as usize].velocity_at(self.arms[k]);
        (at(1) - at(0)).dot(self.normal)
    }

    /// The same along the normal and the sides.
    #[inline(always)]
    fn velocities(&self, shadows: &[Shadow]) -> [f64; 3] {
        let [a, b] = self.shadows;
        let (a, b) = (&shadows[a as usize], &shadows[b as usize]);
        let (relative, spins) = (b.v - a.v, [a.w, b.w]);
        // Written out: a `map` the compiler leaves a call here.
        let [n, s, t] = &self.made.axes;
        [
            n.speed(relative, spins),
            s.speed(relative, spins),
            t.speed(relative, spins),
        ]
    }

    /// Gives the shadows an impulse along the normal and the sides \[N·s\].
    #[inline(always)]
    fn push(&self, shadows: &mut [Shadow], impulse: [f64; 3]) {
        let [n, s, t] = &self.made.axes;
        let [along_n, along_s, along_t] = impulse;
        for k in (0..2).filter(|k| self.made.moves[*k]) {
            let shadow = &mut shadows[self.shadows[k] as usize];
            shadow.v += n.velocity[k] * along_n + s.velocity[k] * along_s + t.velocity[k] * along_t;
            shadow.w += n.spin[k] * along_n + s.spin[k] * along_s + t.spin[k] * along_t;
        }
    }
}

/// The friction impulse that stops a slip \[m/s\], or the largest that there is against it \[N·s\].
#[inline(always)]
fn rub(response: &[[f64; 3]; 3], slip: [f64; 2], before: [f64; 2], limit: f64) -> [f64; 2] {
    let [x, y] = slip;
    let square = x * x + y * y;
    let given = response[1][1] * x * x + 2.0 * response[1][2] * x * y + response[2][2] * y * y;
    if given <= 0.0 || given.is_nan() {
        return before;
    }
    let mass = square / given;
    let wanted = [before[0] - x * mass, before[1] - y * mass];
    let square = wanted[0] * wanted[0] + wanted[1] * wanted[1];
    if square > limit * limit {
        let share = limit / square.sqrt();
        wanted.map(|j| j * share)
    } else {
        wanted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// That is what Rapier leaves, 1 mm; and to be parted is not to have come.
    #[test]
    fn what_is_deeper_than_the_slop_is_parted() {
        let shadows = [Shadow::FIXED; 2];
        for (slop, asked) in [(None, 0.0), (Some(1e-3), PARTING * 1e-2)] {
            let mut row = RigidRow {
                shadows: [0, 1],
                normal: DVec3::Y,
                gap: -1.1e-2,
                slop,
                ..RigidRow::default()
            };
            row.approach(&shadows, 1e-3);
            let made = &row.made;
            assert!((made.allowed - asked).abs() < 1e-12 && made.closing == made.allowed);
            assert_eq!(row.came, 0.0);
        }
    }
}
