//! Where a straight way meets a facet: through it, or into the layer around it.

use super::facet::{Patch, on_side, per};
use crate::math::DVec3;

/// Ways this close to a side count as through it, for both neighbours \[m\].
const SEAM: f64 = 1.0e-10;
/// Relative to the facet's size: farther from all sides than this, no neighbour is hit as well.
const INNER: f64 = 1.0e-6;

/// A way through a facet.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// Part of the way.
    pub t: f64,
    /// 1 from its front, −1 from its back.
    pub side: f64,
    /// Whether it is clear of the sides.
    pub inner: bool,
}

/// A way into the layer around a facet.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Part of the way.
    pub t: f64,
    /// From the facet to the point of entry.
    pub normal: DVec3,
    /// Whether it is over the face rather than round a side.
    pub face: bool,
}

impl Patch {
    /// Whether the way from `from` to `to` goes through the facet or ends on it. Neighbours agree on a common side: the
    /// volumes that decide are the same numbers with opposite signs, and both count what passes within a tolerance.
    #[inline]
    pub fn crossing(&self, from: DVec3, to: DVec3) -> Option<Crossing> {
        let (before, after) = (self.height(from), self.height(to));
        if !((before > 0.0 && after <= 0.0) || (before < 0.0 && after >= 0.0)) {
            return None;
        }
        let way = to - from;
        let a = self.a - from;
        let (b, c) = (a + self.ab, a + self.ac);
        let volumes = [a.cross(b), b.cross(c), c.cross(a)].map(|v| way.dot(v) * -before.signum());
        let least = volumes[0].min(volumes[1]).min(volumes[2]);
        let unit = way.length() * self.size;
        (least >= -SEAM * unit).then(|| Crossing {
            t: before / (before - after),
            side: before.signum(),
            inner: least > INNER * self.size * unit,
        })
    }

    /// Where a point that moves by `way` from `from` first comes within `radius` of the facet; `None` if it is so already.
    pub fn entry(&self, from: DVec3, way: DVec3, radius: f64) -> Option<Entry> {
        let height = self.height(from);
        let rate = self.normal.dot(way);
        let (gap, closing) = (height.abs() - radius, -rate * height.signum());
        if gap > closing.max(0.0) && !self.is_line() {
            return None;
        }
        let reach = radius + way.length();
        let distance2 = self.foot(from).distance2;
        if distance2 <= radius * radius || distance2 > reach * reach {
            return None;
        }
        let mut best: Option<Entry> = None;
        if gap >= 0.0 && closing > 0.0 {
            let t = gap / closing;
            if self.foot(from + way * t).face {
                best = Some(Entry {
                    t,
                    normal: self.normal * height.signum(),
                    face: true,
                });
            }
        }
        let (sides, count) = self.sides();
        for &(a, ab) in &sides[..count] {
            if let Some((t, normal)) = into_capsule(from, way, a, ab, radius)
                && best.is_none_or(|b| t < b.t)
            {
                best = Some(Entry {
                    t,
                    normal,
                    face: false,
                });
            }
        }
        best
    }
}

/// When a point outside a capsule enters it, and the normal there.
fn into_capsule(from: DVec3, way: DVec3, a: DVec3, ab: DVec3, radius: f64) -> Option<(f64, DVec3)> {
    let m = from - a;
    let length2 = ab.length_squared();
    let mut first = f64::INFINITY;
    if length2 > 0.0 {
        let across = |v: DVec3| v - ab * (v.dot(ab) / length2);
        if let Some(t) = into_ball(across(m), across(way), radius) {
            let along = (m + way * t).dot(ab);
            if (0.0..=length2).contains(&along) {
                first = t;
            }
        }
    }
    for end in [m, m - ab] {
        first = first.min(into_ball(end, way, radius).unwrap_or(f64::INFINITY));
    }
    if first > 1.0 {
        return None;
    }
    let x = from + way * first;
    let normal = (x - on_side(a, ab, per(length2), x).point).try_normalize()?;
    Some((first, normal))
}

/// When |m + way t| falls to `radius` from above, from 0 on.
fn into_ball(m: DVec3, way: DVec3, radius: f64) -> Option<f64> {
    let (a, b) = (way.length_squared(), m.dot(way));
    let c = m.length_squared() - radius * radius;
    let root = b * b - a * c;
    // Written so that neither a short way nor a grazing one cancels.
    (b < 0.0 && c >= 0.0 && root >= 0.0).then(|| c / (root.sqrt() - b))
}
