//! Attachments: points of a deformable held at points of a rigid body, of the world or of another deformable, both ways,
//! with a force one can read and a strength.
//!
//! A held point is a sum of weighted nodes. A weld holds every node at a point of its own, which three nodes or more turn
//! into a fixed rotation; a pin holds one point of all its nodes and leaves rotation free; a link is a weld through springs
//! and dampers. Ties ask for the velocity that leads to where the anchor *will* be: a point of a turning body moves along a
//! chord, and the rate at the start of a substep, ω × arm, would leave the node ½h²ω² arm behind in each.

use super::ties::Average;
use crate::body::state::State;
use crate::contact::site::slot;
use crate::law::row::{lean, link};
use crate::math::{DMat3, DQuat, DVec3, Real};
use crate::solve::rows::{Rows, Term, Tie};
use crate::solve::shadow::Shadow;
use rapier3d::dynamics::RigidBodyHandle;
use std::sync::Arc;

/// What nodes are attached to; `D` is a handle of a deformable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub enum To<D> {
    /// A rigid body, with or without colliders.
    Body(RigidBodyHandle),
    /// Another deformable.
    Deformable(D),
    /// Points of the world, which never move.
    World,
}

impl<D> From<RigidBodyHandle> for To<D> {
    fn from(body: RigidBodyHandle) -> Self {
        Self::Body(body)
    }
}

/// How held points are held.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub enum Hold {
    /// Every node at its own point.
    Weld,
    /// One point of all the nodes; rotation is free.
    Pin,
    /// Every node at its own point, by a spring of zero rest length and a damper.
    Link {
        /// Of each node \[N/m\].
        stiffness: f64,
        /// Of each node \[N·s/m\].
        damping: f64,
    },
}

/// A node's part in a held point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Part {
    /// Whether the node is one of the deformable that is attached to.
    pub other: bool,
    /// Its index.
    pub node: u32,
    /// Its weight; negative on the other side.
    pub weight: f64,
}

/// A held point.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Point {
    /// Its nodes.
    pub parts: Vec<Part>,
    /// Where it is held, in the frame of the body \[m\]; 0 between deformables.
    pub anchor: DVec3,
}

impl Point {
    /// The node that it is, if it is one.
    pub fn node(&self) -> Option<u32> {
        match &self.parts[..] {
            [part] => Some(part.node),
            _ => None,
        }
    }
}

/// When, and under what, an attachment broke.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Break {
    /// Force on the target \[N\].
    pub force: DVec3,
    /// Moment on the target \[N·m\].
    pub moment: DVec3,
    /// Simulated time \[s\].
    pub time: f64,
}

/// What an attachment does to its target: in a step a force, or added up an impulse, which is why there are no units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Load {
    /// The resultant.
    pub force: DVec3,
    /// About the pivot.
    pub moment: DVec3,
    /// About the rigid body's centre of mass.
    pub torque: DVec3,
}

impl std::ops::Mul<f64> for Load {
    type Output = Self;

    fn mul(self, by: f64) -> Self {
        Self {
            force: self.force * by,
            moment: self.moment * by,
            torque: self.torque * by,
        }
    }
}

impl std::ops::AddAssign for Load {
    fn add_assign(&mut self, other: Self) {
        self.force += other.force;
        self.moment += other.moment;
        self.torque += other.torque;
    }
}

/// An attachment as the world keeps it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Bond<D> {
    /// The deformable whose nodes are attached.
    pub deformable: D,
    /// What they are attached to.
    pub target: To<D>,
    /// How.
    pub hold: Hold,
    /// The nodes, in ascending order.
    pub nodes: Arc<[u32]>,
    /// The held points.
    pub points: Arc<[Point]>,
    /// About which the moment is taken, as an anchor is given; between deformables it is the mean of the held points.
    pub pivot: DVec3,
    /// The body's centre of mass in its frame, as of this rigid step \[m\]: it moves when colliders come and go.
    pub(crate) com: DVec3,
    /// Force at which it breaks \[N\].
    pub strength: f64,
    /// Moment at which it breaks \[N·m\].
    pub moment_strength: f64,
    /// Mean force on the target in the last rigid step \[N\].
    pub force: DVec3,
    /// Its mean moment about the pivot \[N·m\].
    pub moment: DVec3,
    /// Its mean torque about the rigid body's centre of mass \[N·m\].
    pub torque: DVec3,
    /// What of these is borne by points that pinned nodes alone hold, as of the last step in which the rigid body was awake.
    /// While it sleeps nothing tells: neither side gives way.
    pub(crate) by_pins: Load,
    /// Elastic energy in the springs of a link \[J\].
    pub energy: f64,
    /// By how much each point of a link moved relative to its anchor in the last substep, as seen from the body and as rows left it
    /// \[m\]; none before the first. A length, for substeps differ in theirs.
    pub(crate) moved: Vec<DVec3>,
    /// How long that one was \[s\].
    pub(crate) moved_in: f64,
    /// What is held against the strength.
    pub average: Average,
    /// Set once it has broken.
    pub broken: Option<Break>,
    /// Whether something was moved from outside: the nodes are led back at a limited speed.
    pub loose: bool,
    /// How far the farthest held point was from where it is held at the start of the last step \[m\], if its rigid body slept.
    pub(crate) apart_asleep: Option<f64>,
}

/// One side of an attachment within a substep.
pub struct Side<'a> {
    /// Index of the deformable within its group.
    pub member: u32,
    /// Its nodes.
    pub state: &'a State<Real>,
    /// Maps its nodes to row nodes.
    pub slots: &'a mut [u32],
}

impl<D> Bond<D> {
    /// Whether its strength was exceeded.
    pub fn is_broken(&self) -> bool {
        self.broken.is_some()
    }

    /// Whether it gives way elastically.
    pub fn is_link(&self) -> bool {
        matches!(self.hold, Hold::Link { .. })
    }

    /// The rigid body that it holds to, if it does.
    pub fn body(&self) -> Option<RigidBodyHandle> {
        match self.target {
            To::Body(body) => Some(body),
            _ => None,
        }
    }

    /// The nodes of points that pinned nodes alone hold.
    pub(crate) fn pinned_nodes<'a>(&'a self, own: &'a State<Real>) -> impl Iterator<Item = u32> {
        let pinned = |p: &Part| own.particles[p.node as usize].inv_mass == 0.0;
        let points = self.points.iter();
        let held = points.filter(move |point| point.parts.iter().all(pinned));
        held.flat_map(|point| point.parts.iter().map(|p| p.node))
    }

    /// From each anchor to its held point \[m\]. `origin` and `rot` are the frame of the rigid body.
    pub fn errors(
        &self,
        origin: DVec3,
        rot: DQuat,
        own: &State<Real>,
        other: Option<&State<Real>>,
    ) -> impl Iterator<Item = DVec3> {
        let between = matches!(self.target, To::Deformable(_));
        self.points.iter().map(move |point| {
            let held = position(point, own, other);
            if between {
                held
            } else {
                held - (origin + rot * point.anchor)
            }
        })
    }

    /// Adds a tie for every held point, and returns where the pivot is relative to the arms of the ties.
    pub fn add_ties<'a>(
        &self,
        index: u32,
        h: f64,
        shadow: (u32, &Shadow),
        mut own: Side<'a>,
        mut other: Option<Side<'a>>,
        rows: &mut Rows,
    ) -> DVec3 {
        let between = other.is_some();
        let (number, shadow) = shadow;
        let chord = if between {
            DMat3::ZERO
        } else {
            chords(shadow.w, h)
        };
        for (i, point) in self.points.iter().enumerate() {
            let first = rows.terms.len();
            let (mut at, mut held) = (DVec3::ZERO, DVec3::ZERO);
            for part in &point.parts {
                let side = match &mut other {
                    Some(other) if part.other => other,
                    _ => &mut own,
                };
                let x = side.state.position(part.node as usize);
                let node = slot(side.member, part.node, side.state, side.slots, rows);
                at += x * part.weight;
                if !part.other {
                    held += x * part.weight;
                }
                rows.terms.push(Term {
                    node,
                    weight: part.weight,
                    share: part.weight,
                });
            }
            let arm = if between {
                held
            } else {
                shadow.rot * (point.anchor - self.com)
            };
            let error = if between { at } else { at - (shadow.com + arm) };
            let arm = match self.hold {
                // Where its node is: there a damper sees no motion of what turns as a whole, and gives no moment from nowhere.
                Hold::Link { .. } if !between => arm + error,
                _ => arm,
            };
            let ahead = chord * arm;
            let mut tie = Tie {
                terms: rows.terms_since(first),
                between,
                shadow: if between { 0 } else { number },
                attachment: index,
                arm,
                error,
                before: self.moved.get(i).copied().unwrap_or_default() / h,
                chord: ahead,
                bias: ahead,
                lean: lean(self.moved_in, h),
                softness: 0.0,
                impulse: DVec3::ZERO,
                mass: Default::default(),
                give: Default::default(),
            };
            if let Hold::Link { stiffness, damping } = self.hold {
                let (softness, pull, carry) = link(stiffness, damping, h, tie.lean);
                tie.softness = softness;
                tie.bias += tie.before * carry - error * pull;
            }
            rows.ties.push(tie);
        }
        if between {
            let own = &rows.ties[rows.ties.len() - self.points.len()..];
            own.iter().map(|t| t.arm).sum::<DVec3>() / own.len().max(1) as f64
        } else {
            shadow.rot * (self.pivot - self.com)
        }
    }
}

/// Where a held point is, less where it is held on another deformable \[m\].
fn position(point: &Point, own: &State<Real>, other: Option<&State<Real>>) -> DVec3 {
    let at = |part: &Part| {
        let state = if part.other { other } else { Some(own) };
        state.map_or(DVec3::ZERO, |s| {
            s.position(part.node as usize) * part.weight
        })
    };
    point.parts.iter().map(at).sum()
}

/// What the mean velocity over h s of a point turning at `w` differs from its velocity at the start, by its arm \[1/s\].
fn chords(w: DVec3, h: f64) -> DMat3 {
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(w * h));
    let rate = DMat3::from_cols(w.cross(DVec3::X), w.cross(DVec3::Y), w.cross(DVec3::Z));
    (turn - DMat3::IDENTITY) * (1.0 / h) - rate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chord_ends_where_the_point_is() {
        let (w, arm, h) = (
            DVec3::new(3.0, -20.0, 5.0),
            DVec3::new(0.4, 0.1, -0.7),
            1e-3,
        );
        let end = arm + (w.cross(arm) + chords(w, h) * arm) * h;
        assert!((end.length() - arm.length()).abs() < 1e-12);
        let centripetal = w.cross(w.cross(arm)) * (0.5 * h);
        assert!((chords(w, h) * arm - centripetal).length() < 0.02 * centripetal.length());
    }
}
