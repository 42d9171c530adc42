//! Reading what rigid bodies press on: Rapier's own contacts.

use super::observe::Surroundings;
use crate::math::{DVec3, wide};
use rapier3d::dynamics::{RigidBodyHandle, RigidBodySet};
use rapier3d::geometry::{ContactManifold, ContactPair, SolverFlags};

/// A point where two rigid bodies press on each other, as Rapier last saw it.
#[derive(Clone, Copy, Debug)]
pub struct RigidContact {
    /// The bodies; `None` for a collider without one.
    pub bodies: [Option<RigidBodyHandle>; 2],
    /// The point on the surface of each now \[m\].
    pub points: [DVec3; 2],
    /// From the first to the second.
    pub normal: DVec3,
    /// What each takes of the impulse: 1, or 0 for a body that dominates the other.
    pub shares: [f64; 2],
    /// Coulomb's μ.
    pub friction: f64,
    /// Velocity of the first one's surface over its body \[m/s\].
    pub belt: DVec3,
    /// Impulse along the normal in Rapier's last step \[N·s\].
    pub impulse: f64,
}

/// All pairs in which a body presses on another one.
pub fn pairs<'a>(
    body: RigidBodyHandle,
    around: &'a Surroundings,
) -> impl Iterator<Item = &'a ContactPair> {
    let colliders = around.bodies.get(body).map_or(&[][..], |b| b.colliders());
    colliders.iter().flat_map(|&c| {
        let pairs = around.narrow_phase.contact_pairs_with(c);
        pairs.filter(|pair| pair.has_any_active_contact())
    })
}

/// The points of a pair.
pub fn points<'a>(
    pair: &'a ContactPair,
    bodies: &'a RigidBodySet,
) -> impl Iterator<Item = RigidContact> + 'a {
    let answered = |m: &&ContactManifold| {
        let flags = m.data.solver_flags;
        flags.contains(SolverFlags::COMPUTE_RIGID_IMPULSES)
    };
    let manifolds = pair.solver_manifolds().iter().filter(answered);
    manifolds.flat_map(move |m| {
        m.data.solver_contacts.iter().map(move |c| {
            let (first, second) = m.data.solver_contact_world_points(c, bodies);
            let id = (c.contact_id[0] & !rapier3d::geometry::NEW_CONTACT_BIT) as usize;
            let impulse = m.points.get(id).map_or(0.0, |p| p.data.impulse);
            RigidContact {
                bodies: [m.data.rigid_body1, m.data.rigid_body2],
                points: [wide(first), wide(second)],
                normal: wide(m.data.normal),
                shares: [
                    f64::from(m.data.relative_dominance <= 0),
                    f64::from(m.data.relative_dominance >= 0),
                ],
                friction: m.data.friction.into(),
                belt: wide(c.tangent_velocity),
                impulse: f64::from(impulse).max(0.0),
            }
        })
    })
}
