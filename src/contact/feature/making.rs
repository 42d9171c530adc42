//! The rows of faces and edges of one body against one convex part.

use super::part::Convex;
use super::patch::Patch;
use crate::contact::distance::Crossing;
use crate::contact::site::Site;
use crate::contact::target::{Frame, Target};
use crate::contact::touches::{Hold, Key, Touches, along};
use crate::math::DVec3;
use crate::solve::rows::Row;

/// A point of a part over or under a face of the deformable, in the part's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub point: u32,
    pub face: u32,
    weights: [f64; 4],
    patch: Patch,
    normal: DVec3,
    depth: f64,
    /// Whether it is so near that it may have come from outside within the substep.
    shallow: bool,
}

/// How near the border of a face counts as on it, in distances that count as touching.
const BORDER: f64 = 10.0;

impl Met {
    /// Whether the point is on the border of this face, within `width` m, and well within another one that looks elsewhere: what
    /// slides over a corner does not meet it with its side.
    fn yields_to(&self, other: &Self, width: f64) -> bool {
        other.shallow
            && self.normal.dot(other.normal) < 0.7
            && self.inset() < width
            && self.inset() < other.inset()
    }

    /// A length that goes to zero at the border \[m\].
    fn inset(&self) -> f64 {
        let corners = self.patch.corners();
        let side = corners[0].distance(corners[1]);
        let n = corners.len();
        // The weights of two neighbours are left at a side.
        let sides = (0..n).map(|i| 1.0 - self.weights[i] - self.weights[(i + 1) % n]);
        side * sides.fold(f64::INFINITY, f64::min)
    }
}

/// The rows of faces or edges against a part, in the making.
pub(super) struct Making<'a, 's> {
    pub target: &'a Target,
    pub pair: u32,
    pub part: &'a Convex,
    pub frame: Frame,
    pub site: &'a mut Site<'s>,
    pub touches: &'a mut Touches,
    /// How far anything can be from an edge of the part and still matter \[m\].
    pub near: f64,
}

/// A point of a face or an edge that meets the part, in the part's frame.
struct Point<'a> {
    nodes: &'a [u32],
    corners: &'a [DVec3],
    weights: [f64; 4],
    normal: DVec3,
    depth: f64,
}

impl Making<'_, '_> {
    /// Collects the points of the part that meet a face. Of a closed surface the outside is that of its winding; of an open
    /// one the side on which the middle of the part is. Returns how far the face is from any, or less \[m\].
    pub(super) fn meet(
        &mut self,
        p: u32,
        f: u32,
        points: &mut Vec<DVec3>,
        met: &mut Vec<Met>,
    ) -> f64 {
        let side = self.site.side;
        let nodes = side.topology.faces[f as usize].nodes();
        let local = nodes.iter().map(|&i| self.frame.to_local(side.state, i));
        let patch = Patch::new(local);
        let (lo, hi) = bounds(patch.corners());
        let apart = self.part.solid.points_apart(lo, hi);
        if apart > self.near && !self.touches.knows_last(p, f) {
            return apart;
        }
        let (middle, radius) = patch.ball();
        let away = self.part.solid.signed_distance(middle).0 - radius;
        if away > self.target.skin + self.site.reach.farthest {
            return apart.max(away);
        }
        let Some(mut n) = patch.normal() else {
            return apart;
        };
        if (self.part.centre - patch.corners()[0]).dot(n) < 0.0 {
            if side.topology.closed {
                return apart;
            }
            n = -n;
        }
        let deepest = self.deepest_point();
        let most = radius + self.near.max(deepest);
        let before = met.len();
        points.clear();
        self.part.solid.feature_points(n, points);
        for (i, &point) in (0..).zip(points.iter()) {
            // Bounds first: most points are far from most faces.
            if point.distance_squared(middle) > most * most {
                continue;
            }
            let height = (point - patch.corners()[0]).dot(n);
            if height > self.target.skin + self.site.reach.farthest + side.topology.spacing {
                continue;
            }
            let Some(foot) = patch.foot(point) else {
                continue;
            };
            let outward = foot.normal * 1.0_f64.copysign(foot.normal.dot(n));
            let depth = self.target.skin - (point - foot.point).dot(outward);
            let reach = self
                .site
                .reach
                .at(self.closing(nodes, patch.corners(), &foot.weights));
            if depth >= -reach && depth <= deepest {
                met.push(Met {
                    point: i,
                    face: f,
                    weights: foot.weights,
                    patch,
                    normal: -outward,
                    depth,
                    shallow: depth <= reach,
                });
            }
        }
        // What touches may be deeper next time.
        if met.len() > before { 0.0 } else { apart }
    }

    /// How deep a point of the part can be behind a face and still belong to it \[m\].
    pub(super) fn deepest_point(&self) -> f64 {
        self.target.skin + 0.5 * self.site.side.topology.spacing
    }

    /// Whether a point that touched last has not been met where it may get a row.
    pub(super) fn misses_some(&self, p: u32, met: &[Met]) -> bool {
        let is_met = |point: u32| {
            let met = met.iter().filter(|m| m.point == point);
            let mut met = met.map(|m| m.shallow || self.touches.touched([p, point, m.face]));
            met.any(|is| is)
        };
        self.touches.known(p).any(|[_, point, _]| !is_met(point))
    }

    /// The rows of one point of the part. A point that is deep below a face has come in through another one, unless it was
    /// known to touch; then it leaves by the nearest.
    pub(super) fn point(&mut self, p: u32, met: &[Met]) {
        let mut any = false;
        for m in met {
            if met
                .iter()
                .any(|other| m.yields_to(other, BORDER * self.site.reach.touching))
            {
                continue;
            }
            if m.shallow || self.touches.touched([p, m.point, m.face]) {
                any = true;
                self.add_met(p, m);
            }
        }
        if !any
            && self.touches.knows([p, met[0].point])
            && let Some(nearest) = met.iter().min_by(|a, b| a.depth.total_cmp(&b.depth))
        {
            self.add_met(p, nearest);
        }
    }

    fn add_met(&mut self, p: u32, m: &Met) {
        let point = Point {
            nodes: self.site.side.topology.faces[m.face as usize].nodes(),
            corners: m.patch.corners(),
            weights: m.weights,
            normal: m.normal,
            depth: m.depth,
        };
        self.add([p, m.point, m.face], point);
    }

    /// An edge against the part: where it crosses the part's edges, and where it comes nearest to a round side.
    /// Returns how far it is from any of them, or less \[m\].
    pub(super) fn edge(&mut self, p: u32, e: u32) -> f64 {
        let nodes = self.site.side.topology.edges[e as usize];
        let corners = nodes.map(|node| self.frame.to_local(self.site.side.state, node));
        let [a, b] = corners;
        let apart = if self.part.solid.has_rim() {
            f64::NEG_INFINITY
        } else {
            self.part.solid.edges_apart(a.min(b), a.max(b))
        };
        let known = self.touches.knows([p, e]);
        if apart > self.near && !known {
            return apart;
        }
        let part = self.part;
        let away = part.solid.signed_distance(0.5 * (a + b)).0 - 0.5 * a.distance(b);
        let apart = apart.max(away);
        if away > self.target.skin + self.site.reach.farthest {
            return apart;
        }
        let deepest = self.target.skin + 0.5 * part.solid.width();
        let most = if known {
            self.near.max(deepest)
        } else {
            self.near
        };
        let before = self.site.rows.contacts.len();
        let mut cross = |c: Crossing| {
            let depth = self.target.skin - c.distance;
            if depth < -self.site.reach.farthest || depth > deepest {
                return;
            }
            // So near an end it is the node's business.
            let end = BORDER * self.site.reach.touching / a.distance(b);
            if c.t < end || c.t > 1.0 - end {
                return;
            }
            let key = [p, e, c.edge];
            let weights = [1.0 - c.t, c.t, 0.0, 0.0];
            let reach = self.site.reach.at(self.closing(&nodes, &corners, &weights));
            if depth >= -reach && (depth <= reach || self.touches.touched(key)) {
                let point = Point {
                    nodes: &nodes,
                    corners: &corners,
                    weights,
                    normal: c.normal,
                    depth,
                };
                self.add(key, point);
            }
        };
        part.solid.for_each_crossing(a, b, most, &mut cross);
        if part.solid.has_round_side() {
            let (t, distance, normal) = part.solid.nearest_on_segment(a, b);
            if t > 0.0 && t < 1.0 {
                cross(Crossing {
                    edge: u32::MAX,
                    t,
                    normal,
                    distance,
                });
            }
        }
        // What touches may be deeper next time.
        if self.site.rows.contacts.len() > before {
            0.0
        } else {
            apart
        }
    }

    /// Speed of a point of the deformable relative to the collider \[m/s\].
    fn closing(&self, nodes: &[u32], corners: &[DVec3], weights: &[f64; 4]) -> f64 {
        let arm = self.arm(weigh(weights, corners.iter().copied()));
        let state = self.site.side.state;
        let velocities = nodes.iter().map(|&i| state.velocity(i as usize));
        (weigh(weights, velocities) - self.site.shadow.velocity_at(arm)).length()
    }

    /// From the collider's centre of mass to a point of the part's frame \[m\].
    fn arm(&self, point: DVec3) -> DVec3 {
        self.frame.axes * point + (self.frame.position - self.site.shadow.com)
    }

    fn add(&mut self, key: Key, point: Point) {
        // Both sides take the impulse at one point, that of the deformable, or angular momentum would be lost.
        let touched = weigh(&point.weights, point.corners.iter().copied());
        let arm = self.arm(touched);
        let corners = || point.corners.iter().copied();
        let held = self.touches.last(key).and_then(|(_, hold)| hold);
        let drift = held.map_or(DVec3::ZERO, |h| {
            h.drift + weigh(&h.weights, corners()) - h.anchor
        });
        let hold = Hold {
            weights: point.weights,
            anchor: touched,
            drift,
        };
        let Site {
            side,
            slots,
            rows,
            reach,
            ..
        } = &mut *self.site;
        self.touches
            .found(key, rows.contacts.len(), point.normal, hold);
        let first = rows.terms.len();
        for (&i, weight) in point.nodes.iter().zip(point.weights) {
            let part = (weight, self.target.node_share);
            side.carrier.add_terms(i, part, slots, rows);
        }
        let terms = rows.merge_terms_since(first);
        // Rows that share nodes converge slowly from nothing; those of single nodes do not share any.
        let (normal_impulse, friction_impulse) = self.touches.impulse(key);
        rows.contacts.push(Row {
            normal: self.frame.axes * point.normal,
            depth: point.depth,
            normal_impulse,
            friction_impulse,
            arm,
            drift: self.frame.axes * along(drift, point.normal),
            ..self.target.row(terms, self.pair, reach.h)
        });
    }
}

/// The box around some points.
fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let points = points.iter();
    points.fold(start, |(lo, hi), p| (lo.min(*p), hi.max(*p)))
}

fn weigh(weights: &[f64; 4], values: impl Iterator<Item = DVec3>) -> DVec3 {
    values.zip(weights).map(|(v, w)| v * *w).sum()
}
