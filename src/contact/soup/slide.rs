//! A straight way among facets that is stopped by the first one and goes on along it, up to three times.
//!
//! Used twice: from a node's anchor to the node, to see what it has been pushed through; and from there along its motion,
//! to see what it is about to meet, also after it was deflected by the first thing in its way. Only facets that are truly
//! met count: the infinite plane of a facet stops nobody beyond its border.

use super::crossing::Crossing;
use super::near::{Near, Nearest};
use crate::math::DVec3;

/// How far from a surface points that must be on its right side are kept \[m\].
pub const LIFT: f64 = 1.0e-7;
/// How far before a hit on a seam one looks which facet is really in the way \[m\].
const BACK: f64 = 1.0e-6;
/// How far the middle of a facet lies behind the plane of its neighbour to fall away from it, per size.
const FALLS: f64 = 1.0e-4;

/// A plane that something must stay in front of.
#[derive(Clone, Copy, Debug, Default)]
pub struct Plane {
    /// A point of it \[m\].
    pub point: DVec3,
    /// Unit normal, to the free side.
    pub normal: DVec3,
}

impl Plane {
    /// Signed distance of `p`, positive on the free side \[m\].
    #[inline]
    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p - self.point)
    }
}

/// At most three planes: more directions than that do not fit in space.
#[derive(Clone, Copy, Debug, Default)]
pub struct Planes {
    list: [Plane; 3],
    len: usize,
}

impl Planes {
    /// The planes.
    #[inline]
    pub fn as_slice(&self) -> &[Plane] {
        &self.list[..self.len]
    }

    /// Adds one if there is room.
    pub fn push(&mut self, plane: Plane) -> bool {
        let room = self.len < self.list.len();
        if room {
            self.list[self.len] = plane;
            self.len += 1;
        }
        room
    }

    /// About the nearest point to `p` in front of all planes; exact for one, and for right angles.
    fn project(&self, mut p: DVec3) -> DVec3 {
        for _ in 0..if self.len > 1 { 16 } else { 1 } {
            for plane in self.as_slice() {
                p += plane.normal * (LIFT - plane.height(p)).max(0.0);
            }
        }
        p
    }
}

/// Goes from `from` towards `to`, adds to `planes` what is in the way, facets being `layer` m thick to each side, and
/// returns where one ends: as near to `to` as the planes allow, or `from` where there is no way on.
pub fn slide(near: &Near, from: DVec3, to: DVec3, layer: f64, planes: &mut Planes) -> DVec3 {
    let mut target = planes.project(to);
    for _ in 0..4 {
        let Some(plane) = first(near, from, target, layer) else {
            return target;
        };
        if !planes.push(plane) {
            break;
        }
        target = planes.project(to);
    }
    from
}

/// The first thing in the way from `from` to `to`.
fn first(near: &Near, from: DVec3, to: DVec3, layer: f64) -> Option<Plane> {
    let way = to - from;
    let mut through: Option<(u32, Crossing)> = None;
    let mut into: Option<(f64, Plane)> = None;
    for (slot, patch) in near.iter() {
        if let Some(crossing) = patch.crossing(from, to)
            && through.is_none_or(|(_, best)| crossing.t < best.t)
            && !is_over_ridge(near, [from, to], slot, crossing)
        {
            through = Some((slot, crossing));
        }
        if layer > 0.0
            && let Some(entry) = patch.entry(from, way, layer)
            && into.is_none_or(|(best, _)| entry.t < best)
        {
            let point = from + way * entry.t;
            if entry.face || !inner_rim(near, point, point - entry.normal * layer, layer) {
                let normal = entry.normal;
                into = Some((entry.t, Plane { point, normal }));
            }
        }
    }
    match (through, into) {
        (Some((_, crossing)), Some((t, plane))) if t <= crossing.t => Some(plane),
        (Some((slot, crossing)), _) => {
            let mut plane = at_crossing(near, from, to, slot, crossing);
            plane.point += plane.normal * layer;
            Some(plane)
        }
        (None, into) => into.map(|(_, plane)| plane),
    }
}

/// Whether `p`, a layer's thickness from the rim point `q` of one facet, is nearer than that to another one that has `q`
/// too: then it is over that one's face, and the seam between them is nothing to run into.
pub fn inner_rim(near: &Near, p: DVec3, q: DVec3, distance: f64) -> bool {
    let touching = (2.0 * super::near::SAME).powi(2);
    let nearer = (distance - super::near::SAME).max(0.0).powi(2);
    near.iter()
        .any(|(_, patch)| patch.foot(p).distance2 < nearer && patch.foot(q).distance2 < touching)
}

/// Whether a way meets a facet at a seam with another one, in front of which it stays, and from which that falls away: over a ridge it is
/// outside of both. What comes along the plane of the far one, as a taut rope does, is before it or behind it by rounding.
fn is_over_ridge(near: &Near, [from, to]: [DVec3; 2], slot: u32, crossing: Crossing) -> bool {
    if crossing.inner {
        return false;
    }
    let Some((nearest, plane)) = just_before(near, [from, to], crossing) else {
        return false;
    };
    let patch = &near.patches[slot as usize];
    let middle = patch.a + (patch.ab + patch.ac) / 3.0;
    let falls = plane.height(middle) < -FALLS * patch.size;
    nearest.face && nearest.slot != slot && plane.height(to) > 0.0 && falls
}

/// What is nearest just before a way crosses a facet, and the plane there, to the side of the way.
fn just_before(
    near: &Near,
    [from, to]: [DVec3; 2],
    crossing: Crossing,
) -> Option<(Nearest, Plane)> {
    let way = to - from;
    let back = (BACK / way.length()).min(crossing.t);
    let x = from + way * (crossing.t - back);
    let nearest = near.nearest(x)?;
    let normal = near.direction(x, &nearest)?;
    let point = nearest.point;
    Some((nearest, Plane { point, normal }))
}

/// The plane that stops a way through facet `slot`: its own, or on a seam the one that is right for all facets there.
fn at_crossing(near: &Near, from: DVec3, to: DVec3, slot: u32, crossing: Crossing) -> Plane {
    if !crossing.inner
        && let Some((_, plane)) = just_before(near, [from, to], crossing)
        && plane.height(to) <= 0.0
    {
        return plane;
    }
    Plane {
        point: from + (to - from) * crossing.t,
        normal: near.patches[slot as usize].normal * crossing.side,
    }
}
