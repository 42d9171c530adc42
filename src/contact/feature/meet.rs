//! A corner of the target against a face of the body, and an edge against an edge: on which side, how deep, which way out.

use super::bulge::Ridge;
use super::making::{BORDER, Lie, Making, Met};
use super::patch::Patch;
use super::sharp::{Corner, LINES};
use crate::body::topology::NONE;
use crate::contact::closest::{between_lines, between_segments, bounds};
use crate::contact::cone::can_push;
use crate::contact::soup::Edge;
use crate::contact::touches::Key;
use crate::math::DVec3;

/// Cosine from which on the side where a neighbour was found tells that of a point.
pub(super) const ALIKE: f64 = 0.3;

/// How far off the plane of a node, per distance from it, what is sharp may be and be of the same surface.
const STEEP: f64 = 0.5;

/// How far along each of two segments they come nearest, unless that is more than `overlap` m beyond an end or they are
/// parallel.
fn crossing(a: [DVec3; 2], b: [DVec3; 2], overlap: f64) -> Option<[f64; 2]> {
    let [s, t] = between_lines(a, b)?;
    let inside = |x: f64, [from, to]: [DVec3; 2]| {
        let beyond = (x - 0.5).abs() - 0.5;
        beyond * from.distance(to) <= overlap
    };
    (inside(s, a) && inside(t, b)).then_some([s.clamp(0.0, 1.0), t.clamp(0.0, 1.0)])
}

impl Making<'_, '_> {
    /// How far a corner is from a face, or less \[m\], and how it meets it. Of a closed surface the outside is that of its
    /// winding; of an open one where the corner was when it touched, or where all is that it is the corner of, or where it is.
    pub(super) fn meet_corner(
        &self,
        corner: &Corner,
        cone: &[DVec3],
        f: u32,
    ) -> (f64, Option<Met>) {
        let topology = self.site.side.topology;
        if topology.torn.face(f) {
            return (f64::INFINITY, None);
        }
        let patch = Patch::new(self.corners(topology.faces[f as usize].nodes()));
        let (lo, hi) = bounds(patch.corners().iter().copied());
        let p = corner.place;
        let apart = (lo - p).max(p - hi).max_element();
        let key = [0, corner.id, f];
        let touched = self.touches.touched(key);
        if apart > self.near && !touched {
            return (apart, None);
        }
        let Some((lie, foot)) = self.foot(&patch, p) else {
            return (apart, None);
        };
        let last = self.last_normal(key, foot.normal);
        let told = topology.closed || last.is_some();
        if lie == Lie::Past && !told {
            return (apart, None);
        }
        let outward = if topology.closed {
            foot.normal
        } else {
            let side = match last {
                Some(last) => -last,
                None => lies_over(cone.iter().copied(), foot.normal).unwrap_or(p - foot.point),
            };
            foot.normal * 1.0_f64.copysign(foot.normal.dot(side))
        };
        let nodes = topology.faces[f as usize].nodes();
        if !can_push(cone.iter().copied(), -outward, last.is_some())
            || !topology.closed && self.belongs_behind(nodes, p, (-outward, corner.front))
        {
            return (apart, None);
        }
        let met = self.over(
            (corner.id, p),
            (f, &patch),
            (lie, &foot, outward),
            self.deepest_point(),
        );
        (apart, met)
    }

    /// How far an edge of the target is from a face that is twisted, or less \[m\], and how it meets it between its ends and the
    /// edges of the face. The outside of an open surface is where the edge was when it touched, or where its own flanks are.
    pub(super) fn meet_line(&self, edge: &Edge, f: u32) -> (f64, Option<Met>) {
        let topology = self.site.side.topology;
        if topology.torn.face(f) {
            return (f64::INFINITY, None);
        }
        let patch = Patch::new(self.corners(topology.faces[f as usize].nodes()));
        let (lo, hi) = bounds(patch.corners().iter().copied());
        let [a, b] = edge.ends;
        let apart = (lo - a.max(b)).max(a.min(b) - hi).max_element();
        let key = [LINES, edge.id, f];
        let touched = self.touches.touched(key);
        if apart > self.near && !touched {
            return (apart, None);
        }
        let met = || {
            let normal = patch.normal()?;
            let last = self.last_normal(key, normal);
            let side = match last {
                _ if topology.closed => normal,
                Some(last) => -last,
                None => lies_over(edge.flanks(), normal).unwrap_or_else(|| {
                    let (middle, _) = patch.ball();
                    let t = (middle - a).dot(b - a) / a.distance_squared(b);
                    a.lerp(b, t.clamp(0.0, 1.0)) - middle
                }),
            };
            let normal = normal * 1.0_f64.copysign(normal.dot(side));
            let ridge = Ridge::of(&patch, normal, topology.spacing)?;
            let (place, outward) = ridge.lowest_on(edge.ends, self.near)?;
            let nodes = topology.faces[f as usize].nodes();
            if !can_push(edge.flanks(), -outward, last.is_some())
                || !topology.closed && self.belongs_behind(nodes, place, (-outward, edge.front()))
            {
                return None;
            }
            let foot = patch.foot(place)?;
            let at = (Lie::Over, &foot, outward);
            self.over((edge.id, place), (f, &patch), at, self.deepest_point())
        };
        (apart, met())
    }

    /// The side from which an edge, or one `beside` it, has slid on to where edges now cross at least `distance` m apart along
    /// `normal`, if any has. It may be on the wrong side by then, if it was as deep as that before: round a sharp edge, what comes
    /// after one that touches it looks the other way, and has not been through.
    fn slid_on_from(
        &self,
        beside: impl Fn(Key) -> bool,
        normal: DVec3,
        distance: f64,
    ) -> Option<DVec3> {
        let before = |normal: DVec3| self.touches.deepest_along(normal, ALIKE, &beside);
        if before(-normal).is_some_and(|before| before >= self.skin + distance) {
            return Some(-normal);
        }
        before(normal).map(|_| normal)
    }

    /// Whether what has these nodes belongs on the other side of a surface than the one to which a row at `place` would push it, where the
    /// facets look to the `front` in the mean. A pit is a peak to what is below it, as all seems to be that hangs on a node that was
    /// pushed through, and would be held there.
    fn belongs_behind(&self, nodes: &[u32], place: DVec3, (normal, front): (DVec3, DVec3)) -> bool {
        let front = front.normalize_or_zero();
        let mut places = nodes.iter().zip(self.corners(nodes));
        places.any(|(&node, at)| {
            let standing = self.nodes.and_then(|nodes| nodes.standing(node, at));
            standing.is_some_and(|[foot, up]| {
                let from = place - foot;
                let is_one_surface = from.dot(up).abs() <= STEEP * from.length();
                normal.dot(front * up.dot(front).signum()) < -ALIKE && is_one_surface
            })
        })
    }

    /// The normal that a point had when it last touched this face, or this face's on the side from which it touched one beside it.
    pub(super) fn last_normal(&self, key: Key, normal: DVec3) -> Option<DVec3> {
        let [part, point, f] = key;
        let nodes = self.site.side.topology.faces[f as usize].nodes();
        let last = self.touches.normal(key);
        let last = last.filter(|last| last.dot(normal).abs() > ALIKE);
        last.or_else(|| {
            let side = self.last_side(nodes, normal, |[p, id, _]| p == part && id == point)?;
            Some(normal * -side)
        })
    }

    /// On which side of a face certain points were that last touched it or one beside it: 1 for that of its normal, -1 for the other.
    /// Across a fold of a sheet it is the winding that tells which side is which, if all faces agree on that.
    pub(super) fn last_side(
        &self,
        nodes: &[u32],
        normal: DVec3,
        is: impl Fn(Key) -> bool,
    ) -> Option<f64> {
        let topology = self.site.side.topology;
        let by_winding = topology.oriented && !topology.closed;
        let sides = self.touches.normals().filter_map(|(key, last)| {
            if !is(key) {
                return None;
            }
            let beside = topology.faces.get(key[2] as usize)?.nodes();
            if !share_node(beside, nodes) {
                return None;
            }
            let normal = if by_winding {
                Patch::new(self.corners(beside)).normal()?
            } else {
                normal
            };
            Some(-last.dot(normal))
        });
        let side = sides.max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        (side.abs() > ALIKE).then_some(side.signum())
    }

    /// Adds the row of an edge and one of the `edges` of the target that cross, and returns how far they are from each other, or less \[m\].
    pub(super) fn meet_edge(&mut self, e: u32, edge: &Edge, edges: &[Edge]) -> f64 {
        if self.site.side.topology.torn.edge(e) {
            return f64::INFINITY;
        }
        let nodes = self.site.side.topology.edges[e as usize];
        let corners = self.ends(&nodes);
        let across = (corners[1] - corners[0]).cross(edge.along());
        let across = across.normalize_or_zero();
        // A line has no inside that would tell a node beside it to take over: edges overlap at their ends.
        let overlap = BORDER * self.site.reach.touching;
        let (apart, _) = between_segments(corners, edge.ends);
        let between_planes = (corners[0] - edge.ends[0]).dot(across).abs();
        let apart = (apart - 2.0 * overlap).max(between_planes);
        let key = [e, edge.id, u32::from(edge.is_border())];
        let touched = self.touches.touched(key);
        if apart > self.near && !touched {
            return apart;
        }
        let Some([t, s]) = crossing(corners, edge.ends, overlap) else {
            return apart;
        };
        let way = corners[0].lerp(corners[1], t) - edge.ends[0].lerp(edge.ends[1], s);
        let flanks = self.flanks(e, corners, t);
        let beside = |[own, id, _]: Key| {
            if own == e {
                let i = edges.binary_search_by_key(&id, |other| other.id);
                i.is_ok_and(|i| edges[i].ends.iter().any(|end| edge.ends.contains(end)))
            } else {
                let own = self.site.side.topology.edges.get(own as usize);
                id == edge.id && own.is_some_and(|own| share_node(own, &nodes))
            }
        };
        let (side, last) = if self.site.side.topology.closed {
            (
                flanks[0].cross(along(corners)) - flanks[1].cross(along(corners)),
                None,
            )
        } else {
            // What has an inside tells its outside, but where it is folded flat.
            let outward = edge.normals[0] + edge.normals[1];
            let has_inside = self.target.form.has_inside() && outward != DVec3::ZERO;
            let side = if has_inside { outward } else { way };
            let last = self.touches.normal(key);
            let last = last.filter(|n| n.dot(across).abs() > ALIKE);
            let last = last.or_else(|| {
                let normal = across * 1.0_f64.copysign(across.dot(side));
                let sunk = self.reach(&nodes, &corners) - self.skin;
                self.slid_on_from(beside, normal, way.dot(normal) - sunk)
            });
            (last.unwrap_or(side), last)
        };
        let normal = across * 1.0_f64.copysign(across.dot(side));
        let slid_on = last.is_some();
        let can_push = |flanks: [DVec3; 2], way| can_push(flanks, way, touched || slid_on);
        let closed = self.site.side.topology.closed;
        let belongs_here = || {
            let place = corners[0].lerp(corners[1], t);
            closed || !self.belongs_behind(&nodes, place, (normal, edge.front()))
        };
        if can_push(flanks, -normal)
            && can_push(edge.flanks(), normal)
            && edge.stands_out(normal)
            && belongs_here()
        {
            let distance = way.dot(normal);
            // About as deep as what it has slid on from: else that is beyond a thin part.
            let slid = || {
                let before = self.touches.deepest_along(normal, ALIKE, beside);
                let depth = self.skin - distance - self.site.reach.touching;
                before.is_some_and(|before| depth <= before)
            };
            let known = touched || last.is_some() && slid();
            let at = (t, normal, distance);
            if let Some(point) = self.across(known, (&nodes, &corners), at, self.deepest_point()) {
                self.add(key, point);
                // What touches may be deeper next time.
                return 0.0;
            }
        }
        apart
    }

    /// The unit directions from a place on an edge, at `t` of its length, into its faces, left and right, square to it; 0 for
    /// what is not there.
    pub(super) fn flanks(&self, e: u32, [a, b]: [DVec3; 2], t: f64) -> [DVec3; 2] {
        let wings = self.site.side.topology.wings.get(e as usize);
        let along = along([a, b]);
        wings.map_or([DVec3::ZERO; 2], |wings| {
            wings.map(|nodes| {
                if nodes.contains(&NONE) {
                    return DVec3::ZERO;
                }
                let [next_to_a, next_to_b] = self.ends(&nodes);
                let into = (next_to_a - a).lerp(next_to_b - b, t);
                (into - along * into.dot(along)).normalize_or_zero()
            })
        })
    }
}

/// The side of a face, as its normal or the opposite one, on which what goes away from a point of it in the directions of a `cone`
/// lies; `None` if that may be either.
fn lies_over(cone: impl IntoIterator<Item = DVec3> + Clone, normal: DVec3) -> Option<DVec3> {
    let is_over = |n: DVec3| can_push(cone.clone(), -n, false);
    match [is_over(normal), is_over(-normal)] {
        [true, false] => Some(normal),
        [false, true] => Some(-normal),
        _ => None,
    }
}

/// Whether two faces or edges have a node in common.
pub(super) fn share_node(a: &[u32], b: &[u32]) -> bool {
    a.iter().any(|node| b.contains(node))
}

/// The unit direction of an edge.
fn along([a, b]: [DVec3; 2]) -> DVec3 {
    (b - a).normalize_or_zero()
}
