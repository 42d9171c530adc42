//! What a node feels of the facets near it.

use super::near::{Near, Nearest, SAME};
use super::slide::{LIFT, Plane, Planes, inner_rim, slide};
use crate::math::DVec3;

/// A node is held by at most this many facets.
const MOST: usize = 3;
/// Cosine of an angle below which two normals say the same.
const ALIKE: f64 = 0.9998;

/// One contact of a node, in the frame of the shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch {
    /// Positive inside or pushed through, minus the gap outside \[m\].
    pub depth: f64,
    /// Unit normal, to the side where the node belongs.
    pub normal: DVec3,
}

/// The contacts of one node, and what it must remember.
#[derive(Clone, Copy, Debug, Default)]
pub struct Touches {
    list: [Touch; MOST],
    len: usize,
    /// Where the node is known to be on the right side: to be handed in as `remembered` next time; in the frame of the
    /// shape \[m\].
    pub anchor: Option<DVec3>,
}

impl Touches {
    /// The contacts: what was met first, first.
    pub fn as_slice(&self) -> &[Touch] {
        &self.list[..self.len]
    }

    /// Adds one; of two with the same normal the deeper stays.
    fn push(&mut self, depth: f64, normal: DVec3) {
        for old in &mut self.list[..self.len] {
            if old.normal.dot(normal) > 1.0 - 1.0e-9 {
                old.depth = old.depth.max(depth);
                return;
            }
        }
        if self.len < MOST && depth.is_finite() && normal.is_finite() {
            self.list[self.len] = Touch { depth, normal };
            self.len += 1;
        }
    }
}

/// The contacts of a node at `p` that will move by `motion` relative to the shape in the coming substep, if nothing stops
/// it. All in the frame of the shape \[m\].
///
/// `remembered` is the last [`Touches::anchor`] of this node and shape; without it a node belongs to the side it is on,
/// exactly on a surface to the front, and inside an oriented mesh to the outside. `offset` is half the thickness of what
/// meets: skin and the node's own. Contacts are given up to a gap of `reach`, farther only if the motion meets them. A gap
/// that the motion would close is given only where it truly meets a facet, not its plane beyond the border.
///
/// The list must hold the facets within `offset`, `reach` and the longest motion. A `p` that is not finite has no contacts;
/// without facets it is on its side wherever it is.
pub fn touches(
    near: Near,
    p: DVec3,
    motion: DVec3,
    remembered: Option<DVec3>,
    offset: f64,
    reach: f64,
    out: &mut Touches,
) {
    out.len = 0;
    out.anchor = if p.is_finite() && near.slots.is_empty() {
        Some(p)
    } else {
        remembered
    };
    let Some(nearest) = near.nearest(p) else {
        return;
    };
    let offset = near.radius
        + if offset.is_finite() {
            offset.max(0.0)
        } else {
            0.0
        };
    let motion = if motion.is_finite() {
        motion
    } else {
        DVec3::ZERO
    };
    let anchor = remembered.filter(|a| a.is_finite());
    let mut planes = Planes::default();
    let stand = Stand::of(&near, p, anchor, &nearest, &mut planes);
    out.anchor = Some(stand.legit);
    let way = motion.length();
    if stand.nearest.is_some() && nearest.distance > offset + reach.max(way) {
        return;
    }
    for plane in planes.as_slice() {
        out.push(offset - plane.height(p), plane.normal);
    }
    let mut waiting = None;
    if let Some(plane) = stand.nearest {
        let depth = offset - plane.height(p);
        if depth > -LIFT {
            out.push(depth, plane.normal);
            // Depth is mended by others: for the motion the surface is where the node is.
            let point = plane.point + plane.normal * (offset - depth.max(0.0));
            planes.push(Plane { point, ..plane });
        } else if depth >= -reach && depth <= plane.normal.dot(motion) {
            waiting = Some((depth, plane.normal));
        }
    }
    if !planes.as_slice().is_empty() || nearest.distance <= offset + way {
        let known = planes.as_slice().len();
        slide(&near, stand.legit, p + motion, offset, &mut planes);
        for plane in &planes.as_slice()[known..] {
            out.push(-plane.height(p), plane.normal);
        }
    }
    if let Some((depth, normal)) = waiting {
        out.push(depth, normal);
    }
    if stand.nearest.is_some() {
        others(&near, p, motion, &stand, offset, reach, out);
    }
}

/// Where a node stands.
struct Stand {
    /// A point on the right side, the node itself if it is clear of all surfaces.
    legit: DVec3,
    /// The plane that touches the nearest point, if it has been pushed through none.
    nearest: Option<Plane>,
}

impl Stand {
    /// Finds it, and adds to `through` the planes the node has been pushed through.
    fn of(
        near: &Near,
        p: DVec3,
        anchor: Option<DVec3>,
        nearest: &Nearest,
        through: &mut Planes,
    ) -> Self {
        if let Some(anchor) = anchor
            && p.distance_squared(anchor) >= nearest.distance * nearest.distance
        {
            let legit = slide(near, anchor, p, 0.0, through);
            if !through.as_slice().is_empty() {
                return Self {
                    legit,
                    nearest: None,
                };
            }
        }
        let point = nearest.point;
        // So near a rim it is rounding, of the node's place as well, that says in which direction it is.
        let doubtful = nearest.distance <= if nearest.face { SAME } else { LIFT };
        if near.oriented && !doubtful && near.behind(p, nearest) {
            let out = near.direction(p, nearest).unwrap_or(DVec3::ZERO);
            let normal = -out;
            through.push(Plane { point, normal });
            return Self {
                legit: point + normal * LIFT,
                nearest: None,
            };
        }
        let normal = match (doubtful, anchor) {
            (false, _) => near.direction(p, nearest),
            (true, Some(anchor)) => towards(near, p, anchor, nearest),
            (true, None) => None,
        }
        .unwrap_or_else(|| fallback(near, nearest));
        let mut legit = p;
        if nearest.distance < LIFT {
            legit = point + normal * LIFT;
            if let Some(anchor) = anchor {
                // In a crease the lift may go through the other side.
                let mut planes = Planes::default();
                slide(near, anchor, legit, 0.0, &mut planes);
                if !planes.as_slice().is_empty() {
                    legit = anchor;
                }
            }
        }
        Self {
            legit,
            nearest: Some(Plane { point, normal }),
        }
    }
}

/// The normal on the side of `anchor` for a node on the surface itself.
fn towards(near: &Near, p: DVec3, anchor: DVec3, nearest: &Nearest) -> Option<DVec3> {
    if nearest.face
        && let Some(normal) = near.direction(p, nearest)
    {
        return Some(normal);
    }
    let back = anchor - p;
    let x = p + back * (10.0 * LIFT / back.length()).min(1.0);
    let nearest = near.nearest(x)?;
    near.direction(x, &nearest)
}

/// Some normal where nothing says which: the front's; across a line.
fn fallback(near: &Near, nearest: &Nearest) -> DVec3 {
    let front = near.front(nearest.point);
    let patch = &near.patches[nearest.slot as usize];
    if front != DVec3::ZERO {
        front
    } else if !patch.is_line() {
        patch.normal
    } else {
        patch
            .ab
            .try_normalize()
            .map_or(DVec3::Y, |along| along.any_orthonormal_vector())
    }
}

/// Adds facets besides the nearest that a node is over, or whose layer it is in, the deepest first.
fn others(
    near: &Near,
    p: DVec3,
    motion: DVec3,
    stand: &Stand,
    offset: f64,
    reach: f64,
    out: &mut Touches,
) {
    let known = |normal: DVec3, list: &[Touch]| list.iter().any(|t| t.normal.dot(normal) > ALIKE);
    let own = stand.nearest.map_or(DVec3::ZERO, |plane| plane.normal);
    while out.len < MOST {
        let mut best: Option<Touch> = None;
        for (_, patch) in near.iter() {
            let side = patch.height(stand.legit).signum();
            let height = patch.height(p) * side;
            let face = patch.normal * side;
            // Neighbours in a plane, most of all facets, end here.
            if height - offset > reach || own.dot(face) > ALIKE {
                continue;
            }
            let foot = patch.foot(p);
            let touch = if foot.face {
                Touch {
                    depth: offset - height,
                    normal: face,
                }
            } else {
                let distance = foot.distance2.sqrt();
                if distance >= offset
                    || distance <= SAME
                    || inner_rim(near, p, foot.point, distance)
                {
                    continue;
                }
                Touch {
                    depth: offset - distance,
                    normal: (p - foot.point) / distance,
                }
            };
            let met = touch.depth >= 0.0 || touch.depth <= touch.normal.dot(motion);
            if met
                && best.is_none_or(|b| touch.depth > b.depth)
                && own.dot(touch.normal) <= ALIKE
                && !known(touch.normal, out.as_slice())
            {
                best = Some(touch);
            }
        }
        let Some(touch) = best else {
            return;
        };
        out.push(touch.depth, touch.normal);
    }
}
