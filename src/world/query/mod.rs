//! Questions about where deformables are: rays, nearest points, overlaps.
//!
//! They are asked of the nodes as they stand, between steps as well as after a change by hand. Faces are those of the
//! simulation ([`Blueprint::faces`](crate::body::Blueprint::faces)): a body that carries a finer skin is met where its faces are, not where its skin is
//! drawn. Torn faces ([`Deformable::is_torn`]) are none. Faces count from both sides. A body whose faces close has an
//! inside, torn or not.
//!
//! Bodies without faces (ropes, nets, lone nodes) are met at their unbroken springs and at the nodes that no spring holds.
//! These are lines and points, which a ray can't hit, unless the filter gives them a
//! [`line_radius`](DeformableFilter::line_radius).
//!
//! **Cost.** The first question about a body after it moved looks at every node once; the first one that reaches into its
//! bounds fits a bounding volume tree to it. Every later one is logarithmic in the number of faces, plus one look at the
//! bounds of every body. For a body of 97,200 faces on one core: 0.2 s to build the tree once, 30 ms to fit it after a
//! step, 6 µs for a ray or a point.

mod hit;
mod overlap;
mod point;
mod ray;

pub use hit::RayHit;
pub use overlap::DeformableOverlap;
pub use point::DeformableProjection;
pub use ray::DeformableRayHit;

use super::{Deformable, DeformableHandle, DeformableWorld};
use crate::body::SurfacePoint;
use crate::body::search::Search;
use crate::math::{DVec3, Real, Vector};
use rapier3d::geometry::InteractionGroups;

/// Which deformables a query looks at, and how thick lines are.
///
/// ```
/// use crumple::prelude::*;
/// let only_marked = |_: DeformableHandle, body: &Deformable| body.user_data == 7;
/// let filter = DeformableFilter::new().line_radius(0.01).predicate(&only_marked);
/// # assert!(filter.predicate.is_some());
/// ```
#[derive(Clone, Copy, Default)]
pub struct DeformableFilter<'a> {
    /// Only bodies whose collision groups agree with these.
    pub groups: Option<InteractionGroups>,
    /// Not this one.
    pub exclude: Option<DeformableHandle>,
    /// Only bodies of which this is true.
    #[allow(clippy::type_complexity)]
    pub predicate: Option<&'a dyn Fn(DeformableHandle, &Deformable) -> bool>,
    /// Half the thickness of the springs and lone nodes of bodies without faces \[m\]. With 0, rays pass them, and points
    /// and shapes are measured against bare lines; so does a value that is negative or not finite.
    pub line_radius: Real,
}

impl<'a> DeformableFilter<'a> {
    /// All enabled bodies, lines without thickness.
    pub fn new() -> Self {
        Self::default()
    }

    /// Only bodies whose collision groups agree with these.
    pub fn groups(self, groups: InteractionGroups) -> Self {
        Self {
            groups: Some(groups),
            ..self
        }
    }

    /// Not this one.
    pub fn exclude(self, deformable: DeformableHandle) -> Self {
        Self {
            exclude: Some(deformable),
            ..self
        }
    }

    /// Only bodies of which this is true.
    pub fn predicate(self, predicate: &'a impl Fn(DeformableHandle, &Deformable) -> bool) -> Self {
        Self {
            predicate: Some(predicate),
            ..self
        }
    }

    /// Half the thickness of springs and lone nodes of bodies without faces \[m\].
    pub fn line_radius(self, radius: Real) -> Self {
        Self {
            line_radius: radius,
            ..self
        }
    }

    /// Whether a query looks at this body. What takes no part in the simulation is not found, as in Rapier.
    pub fn test(&self, handle: DeformableHandle, body: &Deformable) -> bool {
        let groups = body.surface().collision_groups;
        body.is_enabled()
            && self.exclude != Some(handle)
            && self.groups.is_none_or(|g| groups.test(g))
            && self.predicate.is_none_or(|p| p(handle, body))
    }

    fn radius(&self) -> f64 {
        if self.line_radius.is_finite() {
            f64::from(self.line_radius).max(0.0)
        } else {
            0.0
        }
    }
}

impl DeformableWorld {
    fn filtered(
        &self,
        filter: &DeformableFilter,
    ) -> impl Iterator<Item = (DeformableHandle, &Deformable)> {
        self.iter()
            .filter(|(handle, body)| filter.test(*handle, body))
    }
}

impl Deformable {
    /// Bounds of what queries meet, about the body's origin; `None` for a body of nothing or with a node that is not
    /// finite.
    fn extent(&self, radius: f64) -> Option<(DVec3, DVec3)> {
        let (lo, hi) = self.cache.bounds(&self.state);
        let radius = if self.blueprint.faces.is_empty() {
            radius
        } else {
            0.0
        };
        (lo.is_finite() && hi.is_finite()).then_some((lo - radius, hi + radius))
    }

    /// A search through it, its lines as thick as this radius \[m\].
    pub(super) fn search(&self, radius: f64) -> Search<'_> {
        Search {
            blueprint: &self.blueprint,
            topology: &self.topology,
            state: &self.state,
            tree: self.cache.tree(&self.blueprint, &self.state),
            bounds: self.cache.bounds(&self.state),
            radius,
        }
    }

    /// Where a point of the surface is now \[m\]; `None` if it names a node that the body does not have.
    pub fn world_point(&self, at: &SurfacePoint) -> Option<DVec3> {
        // About the body's origin: the weights are f32, and their sum is 1 only to its precision.
        self.blended(at, |i| self.state.local(i))
            .map(|local| self.state.origin + local)
    }

    /// How fast a point of the surface moves \[m/s\]; `None` if it names a node that the body does not have.
    pub fn velocity_at(&self, at: &SurfacePoint) -> Option<DVec3> {
        self.blended(at, |i| self.state.velocity(i))
    }

    fn blended(&self, at: &SurfacePoint, value: impl Fn(usize) -> DVec3) -> Option<DVec3> {
        let known = at.nodes.iter().all(|n| n.index() < self.node_count());
        let terms = || at.nodes.iter().zip(at.weights);
        known.then(|| terms().map(|(n, w)| value(n.index()) * f64::from(w)).sum())
    }

    /// Adds to the force that acts on a point of the surface during the coming step only \[N\], shared among its nodes.
    /// Nodes that the body does not have and values that are not finite change nothing: `false`.
    pub fn add_step_force_at(&mut self, at: &SurfacePoint, force: Vector) -> bool {
        let shares = at.weights.map(|w| force * w);
        let known = at.nodes.iter().all(|n| n.index() < self.node_count());
        let ok = known && shares.iter().all(|f| f.is_finite());
        if ok {
            for (node, share) in at.nodes.iter().zip(shares) {
                self.add_step_force(*node, share);
            }
        }
        ok
    }
}
