//! Nodes in the hollows of a solid, a compound or voxels, where they lie against several faces, or come to one along another.

use super::Making;
use crate::contact::beside::SAME;
use crate::contact::site::Reach;
use crate::math::DVec3;

/// A node is held by at most so many faces of a solid.
const MOST: usize = 4;

/// Cosine of an angle within which two normals say the same.
const ALIKE: f64 = 0.99;

impl Making<'_, '_> {
    /// The rows for what else of a hollow solid the node lies against or comes to in the coming substep, along what it lies on: who slides
    /// over a floor is nearest to that until it is in the wall. `first` is the row of the nearest face.
    pub(super) fn others(
        &mut self,
        i: u32,
        place: DVec3,
        nearest: (f64, DVec3),
        first: Option<(f64, DVec3)>,
    ) {
        let (solid, skin) = (self.solid, self.target.skin);
        let Reach { touching, h, .. } = self.site.reach;
        let (slip, gain) = self.motion(i, place);
        let reach = self.site.reach.at(slip.length() + gain.length());
        let deep = first.map_or(0.0, |(depth, _)| depth.max(0.0));
        if !solid.has_hollow_at(place, skin + reach + deep) {
            return;
        }
        let motion = self.frame.axes.transpose() * (slip + gain) * h;
        // As far as its skin and what counts as touching, as slowly as it may come.
        let least = 20.0 * touching + 4.0 * skin;
        let mut way = motion + motion.normalize_or_zero() * (least - motion.length()).max(0.0);
        let mut known = [first.map_or(nearest.1, |(_, normal)| normal); MOST];
        let mut lifted = place;
        let mut last = first;
        for k in 1..MOST {
            if let Some((depth, normal)) = last {
                known[k - 1] = normal;
                let gap = normal.dot(lifted - place) - depth;
                lifted += normal * (2.0 * touching - gap).max(0.0);
                way -= normal * (way.dot(normal) + gap.max(0.0)).min(0.0);
            }
            let is_new = |normal: DVec3| known.iter().all(|n| n.dot(normal) < ALIKE);
            let key = [0, i, k as u32];
            let touched = self.touches.last(key).copied();
            let notch = touched.and_then(|touch| self.notch(i, place, nearest, touch));
            let notch = notch.filter(|(_, normal)| is_new(*normal));
            let notch = notch.map(|(height, normal)| (skin - height, normal));
            let ahead = || {
                let (point, normal) = self.plane_ahead(lifted, way, is_new)?;
                Some((skin - (place - point).dot(normal), normal))
            };
            let found = notch.or_else(ahead);
            let back = touched.filter(|touch| is_new(touch.normal));
            let back = back.and_then(|touch| self.back(place, slip, &touch));
            let found = match (found, back) {
                (Some(found), Some(back)) if found.1.dot(back.1) >= 0.0 => Some(found),
                (found, back) => back.or(found),
            };
            let Some((depth, normal)) = found.filter(|(depth, _)| *depth >= -reach) else {
                return;
            };
            let touched = touched.filter(|touch| touch.normal.dot(normal) > SAME);
            self.add((key, touched), place, (depth, normal));
            last = Some((depth, normal));
        }
    }

    /// The plane that a node lies against or comes to on its way, if it is a new one: a point of it and its normal.
    fn plane_ahead(
        &self,
        place: DVec3,
        way: DVec3,
        is_new: impl Fn(DVec3) -> bool,
    ) -> Option<(DVec3, DVec3)> {
        let (distance, normal) = self.solid.signed_distance(place);
        if distance - self.target.skin < self.site.reach.touching && is_new(normal) {
            return Some((place - normal * distance, normal));
        }
        let (t, normal) = self.solid.cast(place, place + way)?;
        is_new(normal).then_some((place + way * t, normal))
    }
}
