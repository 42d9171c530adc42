//! The facets near one node, and the nearest of them.

use super::facet::Patch;
use crate::math::DVec3;

/// Two points closer than this are one \[m\].
pub const SAME: f64 = 1.0e-9;

/// The facets near a node, in ascending order of id.
#[derive(Clone, Copy, Debug)]
pub struct Near<'a> {
    /// All facets of a list.
    pub patches: &'a [Patch],
    /// Which of them are near.
    pub slots: &'a [u32],
    /// Whether the winding says what is inside.
    pub oriented: bool,
    /// Half the thickness the facets have by themselves \[m\].
    pub radius: f64,
}

/// The nearest point of all.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Distance \[m\].
    pub distance: f64,
    /// Where it is \[m\].
    pub point: DVec3,
    /// Whether it lies within the facet rather than on its rim.
    pub face: bool,
    /// The facet's slot.
    pub slot: u32,
}

impl<'a> Near<'a> {
    /// The facets with their slots.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = (u32, &'a Patch)> + use<'a> {
        let patches = self.patches;
        self.slots
            .iter()
            .filter_map(move |&slot| Some((slot, patches.get(slot as usize)?)))
    }

    /// The nearest point to `p`, the lowest id among equals; `None` without facets or for a `p` that is not finite.
    #[inline]
    pub fn nearest(&self, p: DVec3) -> Option<Nearest> {
        let mut best = None;
        let mut best2 = f64::INFINITY;
        for (slot, patch) in self.iter() {
            let height = patch.height(p);
            if height * height >= best2 {
                continue;
            }
            let foot = patch.foot(p);
            if foot.distance2 < best2 {
                best2 = foot.distance2;
                best = Some((slot, foot));
            }
        }
        let (slot, foot) = best?;
        Some(Nearest {
            distance: best2.sqrt(),
            point: foot.point,
            face: foot.face,
            slot,
        })
    }

    /// Direction from the nearest point to `p`: the facet's own normal where it can be, so that no rounding tilts it;
    /// `None` when `p` is too near to say.
    #[inline]
    pub fn direction(&self, p: DVec3, nearest: &Nearest) -> Option<DVec3> {
        if nearest.face {
            let patch = &self.patches[nearest.slot as usize];
            let height = patch.height(p);
            // Much of what is left of a subtraction of coordinates is still there at this height.
            (height.abs() > 1.0e-14 * (1.0 + patch.size + p.abs().max_element()))
                .then(|| patch.normal * height.signum())
        } else {
            (nearest.distance > SAME).then(|| (p - nearest.point) / nearest.distance)
        }
    }

    /// Mean of the front normals of the facets that meet at `q`, weighted by their angles there (Bærentzen and Aanæs
    /// 2005: its sign is right at edges and corners too); 0 if they cancel or have no planes.
    pub fn front(&self, q: DVec3) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (_, patch) in self.iter().filter(|(_, patch)| !patch.is_line()) {
            if patch.foot(q).distance2 > SAME * SAME {
                continue;
            }
            let (sides, _) = patch.sides();
            // At a corner its angle; on a side half a turn; within, all of it, but then the facet is alone.
            let angle = (0..3)
                .find(|&i| sides[i].0.distance_squared(q) <= SAME * SAME)
                .map_or(std::f64::consts::PI, |i| {
                    sides[i].1.angle_between(-sides[(i + 2) % 3].1)
                });
            sum += patch.normal * angle;
        }
        let length = sum.length();
        if length > 1.0e-6 {
            sum / length
        } else {
            DVec3::ZERO
        }
    }

    /// Whether `p` is behind the surface by its winding; only for oriented soups.
    pub fn behind(&self, p: DVec3, nearest: &Nearest) -> bool {
        if nearest.face {
            self.patches[nearest.slot as usize].height(p) < 0.0
        } else {
            self.front(nearest.point).dot(p - nearest.point) < 0.0
        }
    }
}
