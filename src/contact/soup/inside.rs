//! The way out of an oriented mesh, for a node that starts deep inside.

use super::Soup;
use super::facet::Patch;
use super::near::{Near, SAME};
use crate::math::{DVec3, wide};
use rapier3d::geometry::{TriMesh, TypedShape};
use rapier3d::parry::partitioning::TraversalAction;

/// The nearest way out.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Exit {
    /// The nearest facet, the lowest id among equals.
    pub facet: u32,
    /// How deep the point is \[m\].
    pub depth: f64,
    /// Unit normal, outwards.
    pub normal: DVec3,
    /// The nearest point of the surface \[m\].
    pub point: DVec3,
}

impl Soup {
    /// The nearest way out for a point inside an oriented mesh; `None` outside, on the surface, and for other soups.
    /// Searches the whole mesh.
    pub fn inside(&self, p: DVec3) -> Option<Exit> {
        let TypedShape::TriMesh(mesh) = self.shape.as_typed_shape() else {
            return None;
        };
        if !self.oriented || !p.is_finite() {
            return None;
        }
        let distance = self.distance(mesh, p)?;
        // All facets at the nearest point, for the sign.
        let mut ids = Vec::new();
        let corner = DVec3::splat(distance + 10.0 * SAME);
        self.facets_in(p - corner, p + corner, &mut ids);
        let patches: Vec<Patch> = ids
            .iter()
            .filter_map(|&id| Some(Patch::new(id, &self.facet(id)?)))
            .collect();
        let slots: Vec<u32> = (0..patches.len() as u32).collect();
        let near = Near {
            patches: &patches,
            slots: &slots,
            oriented: true,
            radius: 0.0,
        };
        let nearest = near.nearest(p)?;
        if !near.behind(p, &nearest) {
            return None;
        }
        Some(Exit {
            facet: patches[nearest.slot as usize].id,
            depth: nearest.distance,
            normal: -near.direction(p, &nearest)?,
            point: nearest.point,
        })
    }

    /// Distance to the nearest facet \[m\].
    fn distance(&self, mesh: &TriMesh, p: DVec3) -> Option<f64> {
        let mut best2 = f64::INFINITY;
        mesh.bvh().traverse(|node| {
            let (lo, hi) = (wide(node.mins()), wide(node.maxs()));
            let outside = (lo - p).max(p - hi).max(DVec3::ZERO).length_squared();
            if outside > best2 {
                return TraversalAction::Prune;
            }
            if let Some(facet) = node.leaf_data().and_then(|id| self.facet(id)) {
                best2 = best2.min(Patch::new(0, &facet).foot(p).distance2);
            }
            TraversalAction::Continue
        });
        best2.is_finite().then(|| best2.sqrt())
    }
}
