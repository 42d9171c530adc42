//! Constraints of Rapier's contacts.

use super::bodies::Linkage;
use super::joints::{Motion, rate};
use crate::coupling::observe::Surroundings;
use crate::math::wide;
use rapier3d::geometry::ContactManifold;

impl Linkage {
    /// Takes in the rigid contacts that press on a body, from what does not move and from bodies before it.
    pub(super) fn press(&mut self, index: usize, around: &Surroundings, dt: f64) {
        let own = self.bodies[index];
        let Some(body) = around.bodies.get(own) else {
            return;
        };
        let pairs = body.colliders().iter();
        let pairs = pairs.flat_map(|&c| around.narrow_phase.contact_pairs_with(c));
        for pair in pairs.filter(|p| p.has_any_active_contact()) {
            for manifold in pair.solver_manifolds() {
                let data = &manifold.data;
                let handles = [data.rigid_body1, data.rigid_body2];
                let other = handles.into_iter().flatten().find(|h| *h != own);
                let partner = other.and_then(|h| self.index(h));
                let other = other.and_then(|h| around.bodies.get(h));
                if partner.is_some_and(|p| p > index) {
                    continue;
                }
                if partner.is_none() && other.is_some_and(|b| b.is_dynamic()) {
                    continue;
                }
                let motions = handles.map(|h| {
                    let body = h.and_then(|h| around.bodies.get(h));
                    body.map_or(Motion::STILL, |b| Motion::of(b, dt))
                });
                let sides = handles.map(|h| self.index(h?));
                self.take_in(manifold, sides, motions, dt);
            }
        }
    }

    /// The points of a contact that are pressed together, and held by friction if it does not slide.
    fn take_in(
        &mut self,
        manifold: &ContactManifold,
        sides: [Option<usize>; 2],
        [one, two]: [Motion; 2],
        dt: f64,
    ) {
        let normal = wide(manifold.data.normal);
        let points = || {
            let points = manifold.points.iter().map(|p| &p.data);
            points.filter(|p| p.warmstart_impulse > 0.0)
        };
        let pressed: f32 = points().map(|p| p.warmstart_impulse).sum();
        let dragged: f32 = points().map(|p| p.warmstart_tangent_world.length()).sum();
        let sticks = dragged < 0.95 * manifold.data.friction * pressed;
        let (t1, t2) = normal.any_orthonormal_pair();
        for point in points() {
            let arms = [wide(point.solver_dp1), wide(point.solver_dp2)];
            for axis in [normal, t1, t2] {
                let row = [-axis, -arms[0].cross(axis), axis, arms[1].cross(axis)];
                let now = rate(&row, &one, &two);
                if axis == normal && now > 1e-3 {
                    break;
                }
                self.hold(&row, sides, now / dt);
                if !sticks {
                    break;
                }
            }
        }
    }
}
