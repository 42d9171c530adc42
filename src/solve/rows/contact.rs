//! A row of contact: what it is given, what it has done, and how the two sides answer.

use super::Terms;
use super::settled::Give;
use crate::law::row::{Lift, Turn, friction_impulse, normal_impulse};
use crate::math::{DMat3, DVec3};

/// How much faster, or farther, than the point of a contact one of its nodes may be moved where nothing takes the impulse back.
/// A point close to a pinned node moves only if the others fly: what can't be stopped, or a depth, would throw them without
/// bounds. A body that can be stopped throws them no harder than its own energy does.
pub(super) const LEVER: f64 = 10.0;

/// What a friction impulse that was set to its limit may be beyond that, as a share of its square.
const ROUNDING: f64 = 1e-12;

/// How the two sides of a row answer its impulses, set by the pass for a substep.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Smallest relative normal velocity that is allowed \[m/s\].
    pub allowed: f64,
    /// What the mean velocity of a turning shadow's point differs from that at the start of the substep, along the surface
    /// \[m/s\].
    pub chord: DVec3,
    /// Velocity of the point by its impulse \[1/kg\].
    pub own: f64,
    /// Velocity of the shadow there, against the impulse, or what levers add to that of the point \[1/kg\].
    pub rigid: DMat3,
    /// Effective mass along the normal \[kg\].
    pub mass: f64,
    /// What an impulse may leave of the normal velocity: the row's softness, and what keeps nodes from being thrown, see
    /// [`LEVER`] \[1/kg\].
    pub softness: f64,
    /// What share of a way the point can be moved without moving one of its nodes [`LEVER`] times as far \[1\].
    pub share: f64,
    /// What the two sides make of an impulse.
    pub give: Give,
}

impl Default for Response {
    /// That of what nothing moves.
    fn default() -> Self {
        Self {
            allowed: 0.0,
            chord: DVec3::ZERO,
            own: 0.0,
            // A matrix's own default is the identity.
            rigid: DMat3::ZERO,
            mass: 0.0,
            softness: 0.0,
            share: 1.0,
            give: Give::default(),
        }
    }
}

impl Response {
    /// Relative velocity by an impulse \[m/s\].
    #[inline(always)]
    pub fn to(&self, impulse: DVec3) -> DVec3 {
        impulse * self.own + self.rigid * impulse
    }

    /// What the shadow alone gives way along `direction` \[1/kg\].
    #[inline(always)]
    pub fn rigid_along(&self, direction: DVec3) -> f64 {
        direction.dot(self.rigid * direction)
    }

    /// The mass that the shadow has along `direction` over that of the point, at most 1 \[1\].
    pub fn mass_ratio(&self, direction: DVec3) -> f64 {
        let rigid = self.rigid_along(direction);
        if rigid > self.own {
            self.own / rigid
        } else {
            1.0
        }
    }

    /// Effective mass along `direction`, which may be of any length \[kg\].
    #[inline(always)]
    pub fn mass_along(&self, direction: DVec3) -> f64 {
        let square = direction.length_squared();
        let given = self.own * square + self.rigid_along(direction);
        if given > 0.0 { square / given } else { 0.0 }
    }
}

/// A unilateral contact with friction, of a point with a shadow or of points of two deformables.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The nodes of the point.
    pub terms: Terms,
    /// Index into the shadows; 0 for a row between two deformables.
    pub shadow: u32,
    /// Which pair of deformable and partner the impulse is counted for.
    pub pair: u32,
    /// Whether it lies between two deformables.
    pub between: bool,
    /// Where the levers of its terms begin, if they have any. Two deformables that keep a distance meet at one point, that of a node of the one or
    /// half-way, not at the two points that are nearest: friction between those would be a couple, which turns both. An
    /// impulse j beside the nodes of a face is one on them and a couple: g·n·(∇w·j) on each, for a distance g along n and the
    /// weights w of the nodes as functions of place. These are the levers g·∇w; they sum to zero over the nodes of each side.
    /// The velocity there is that of the surface carried on by its rotation, Σ w·v + g·∇w·(n·v).
    pub levers: Option<u32>,
    /// From the collider, or the second deformable, to the outside.
    pub normal: DVec3,
    /// Signed depth, positive inside \[m\].
    pub depth: f64,
    /// From the shadow's centre of mass to the point \[m\].
    pub arm: DVec3,
    /// How the turning of the shadow moves its surface there.
    pub turn: Turn,
    /// What the shadow takes of the impulse: 1, or 0 for a body that dominates the deformable.
    pub rigid_share: f64,
    /// Coulomb's μ.
    pub friction: f64,
    /// 0 for a rigid contact, see [`softness`](crate::law::row::softness) for one that gives \[1/kg\].
    pub softness: f64,
    /// How far the point has slipped from where friction took hold of it \[m\].
    pub drift: DVec3,
    /// Normal impulse of earlier substeps that friction has not answered yet \[N·s\].
    pub carried: f64,
    /// Accumulated normal impulse \[N·s\].
    pub normal_impulse: f64,
    /// Accumulated friction impulse \[N·s\].
    pub friction_impulse: DVec3,
    /// What the pass makes of it.
    pub response: Response,
    /// How it moves the body that holds its nodes, or that presses on nodes which can't give way.
    pub lift: Lift,
    /// How deep its nodes are in something on their other side, if that is not lifted either \[m\]: half-way between the two they
    /// stay.
    pub pinched: f64,
}

impl Row {
    /// It before it has done anything.
    pub fn fresh(&self) -> Self {
        Self {
            normal_impulse: 0.0,
            friction_impulse: DVec3::ZERO,
            lift: Lift::default(),
            pinched: 0.0,
            ..*self
        }
    }

    /// Has it begin with nothing.
    pub fn cool(&mut self) {
        (self.normal_impulse, self.friction_impulse) = (0.0, DVec3::ZERO);
    }

    /// Impulse on the point so far \[N·s\].
    pub fn impulse(&self) -> DVec3 {
        self.normal * self.normal_impulse + self.friction_impulse
    }

    /// The most that friction can do \[N·s\].
    pub fn friction_limit(&self) -> f64 {
        self.friction * (self.normal_impulse + self.carried)
    }

    /// A friction impulse at its limit, if it is beyond that and not only by rounding \[N·s\].
    pub(super) fn bounded(&self, friction: DVec3) -> Option<DVec3> {
        let (square, limit) = (friction.length_squared(), self.friction_limit());
        let beyond = square > limit * limit * (1.0 + ROUNDING);
        beyond.then(|| friction * (limit / square.sqrt()))
    }

    /// Whether friction holds the point: it is pressed on, and not at the limit of its cone.
    pub fn sticks(&self) -> bool {
        self.normal_impulse > 0.0
            && self.friction_impulse.length() < self.friction_limit() * (1.0 - 1e-9)
    }

    /// By how much the normal part of a relative velocity exceeds what it must be at least \[m/s\].
    #[inline(always)]
    pub(super) fn excess(&self, relative: DVec3) -> f64 {
        relative.dot(self.normal) + self.response.softness * self.normal_impulse
            - self.response.allowed
    }

    /// The part of a relative velocity along the surface by which the point slips \[m/s\].
    #[inline(always)]
    pub(super) fn slip(&self, relative: DVec3) -> DVec3 {
        self.along(relative) - self.response.chord
    }

    /// The part of a vector along the surface.
    #[inline(always)]
    pub(super) fn along(&self, vector: DVec3) -> DVec3 {
        vector - self.normal * vector.dot(self.normal)
    }

    /// Whether friction has anything to say.
    #[inline(always)]
    pub(super) fn rubs(&self) -> bool {
        self.friction_limit() > 0.0 || self.friction_impulse != DVec3::ZERO
    }

    /// Changes the normal impulse with an effective mass of `mass` kg, and says by what \[N·s\].
    #[inline(always)]
    pub(super) fn press(&mut self, relative: DVec3, mass: f64) -> f64 {
        let excess = self.lift.excess(self.excess(relative), mass);
        let before = self.normal_impulse;
        self.normal_impulse = normal_impulse(before, 0.0, excess, mass);
        self.normal_impulse - before
    }

    /// Changes the friction impulse against `slip` m/s likewise.
    #[inline(always)]
    pub(super) fn rub(&mut self, slip: DVec3, mass: f64) -> DVec3 {
        let before = self.friction_impulse;
        self.friction_impulse = friction_impulse(before, slip, mass, self.friction_limit());
        self.friction_impulse - before
    }
}
