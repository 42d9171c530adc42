//! An edge of one body against the edges, round corners and round sides of a convex part of a solid.

use super::making::{BORDER, Making};
use super::meet::{ALIKE, share_node};
use super::part::Convex;
use super::sharp::FLAT;
use crate::contact::cone::Pushed;
use crate::contact::distance::Crossing;
use crate::contact::touches::Key;
use crate::math::DVec3;

/// Stands for an edge of the part where an edge of the body comes nearest to a round side.
const ROUND_SIDE: u32 = u32::MAX;

impl Making<'_, '_> {
    /// Whether an edge that is so deep in another one of the part \[m\] may have slid on from one beside it: this edge or a
    /// neighbour was about as deep when it last touched from the same side.
    fn has_slid_on(&self, [p, e, _]: Key, normal: DVec3, depth: f64) -> bool {
        let edges = &self.site.side.topology.edges;
        let nodes = edges[e as usize];
        let is = |[part, own, _]: Key| {
            let own = edges.get(own as usize);
            part == p && own.is_some_and(|own| share_node(own, &nodes))
        };
        let before = self.touches.deepest_along(normal, ALIKE, is);
        before.is_some_and(|before| depth <= before + self.site.reach.touching)
    }

    /// Whether the point at which an edge crosses one of the part lies beside it, see [`Pushed::lies_beside`].
    fn edge_lies_beside(
        &self,
        part: &Convex,
        (e, [a, b]): (u32, [DVec3; 2]),
        c: &Crossing,
        known: bool,
    ) -> bool {
        let site = &*self.site;
        let nodes = site.side.topology.edges[e as usize];
        let [v, w] = nodes.map(|i| site.side.state.velocity(i as usize));
        let way = |point| site.way(v.lerp(w, c.t), &self.frame, point);
        let around = || {
            let along = (b - a).normalize_or_zero();
            let [left, right] = self.flanks(e, [a, b], c.t);
            [left, right, along, -along].into_iter()
        };
        let pushed = Pushed {
            place: a.lerp(b, c.t),
            normal: c.normal,
            depth: self.skin - c.distance,
            skin: self.skin,
            touched: known,
        };
        let turn = self.frame.axes.transpose() * self.roll.turn(site.reach.h);
        pushed.lies_beside(&part.solid, &site.reach, around, (way, turn))
    }

    /// An edge against the part: where it crosses the part's edges and round corners, and where it comes nearest to a round side.
    /// Returns how far it is from any of them, or less \[m\].
    pub(super) fn edge(&mut self, part: &Convex, [p, e]: [u32; 2], bound: f64) -> f64 {
        let nodes = self.site.side.topology.edges[e as usize];
        let corners = self.ends(&nodes);
        let [a, b] = corners;
        let apart = part.solid.edges_apart(a.min(b), a.max(b));
        let apart = apart.max(bound);
        let known = self.touches.knows([p, e]);
        let beyond = apart > self.near || apart > self.reach(&nodes, &corners);
        if beyond && !known {
            return apart;
        }
        let away = part.solid.signed_distance(0.5 * (a + b)).0 - 0.5 * a.distance(b);
        let apart = apart.max(away);
        if away > self.skin + self.site.reach.farthest {
            return apart;
        }
        let deepest = self.skin + 0.5 * part.solid.width();
        let most = if known {
            self.near.max(deepest)
        } else {
            self.near
        };
        let before = self.site.rows.contacts.len();
        let end = BORDER * self.site.reach.touching / a.distance(b);
        let cross = |making: &mut Self, c: Crossing| {
            // So near an end, or past it, it is the node's business, unless the edge goes in from there: then the node, which may
            // have slid over the part's edge to the next face, or be on it, does not hold it.
            let from = if c.t < 0.5 { [a, b] } else { [b, a] };
            let at_end = c.t.min(1.0 - c.t) < end;
            if at_end && (c.edge == ROUND_SIDE || !enters(part, from)) {
                return;
            }
            let c = Crossing {
                t: c.t.clamp(0.0, 1.0),
                ..c
            };
            let key = [p, e, c.edge];
            let depth = making.skin - c.distance;
            let is_deep = depth > making.site.reach.touching && depth <= deepest;
            let known =
                making.touches.touched(key) || is_deep && making.has_slid_on(key, c.normal, depth);
            let at = (c.t, c.normal, c.distance);
            let point = making.across(known, (&nodes, &corners), at, deepest);
            if let Some(point) = point
                && !making.edge_lies_beside(part, (e, corners), &c, known)
                && !making.is_internal_edge(part, corners, &c)
            {
                making.add(key, point);
            }
        };
        let [from, to] = [a.lerp(b, -end), b.lerp(a, -end)];
        part.solid.for_each_crossing(from, to, most, &mut |c| {
            let t = c.t * (1.0 + 2.0 * end) - end;
            cross(self, Crossing { t, ..c });
        });
        // Closed surfaces have faces on both sides of every edge, and these hold round corners.
        let open = !self.site.side.topology.closed;
        if open && self.skin + part.solid.edge_radius() > self.site.reach.touching {
            part.solid.for_each_corner(a, b, most, &mut |c| {
                // What is over a face beside the edge is that face's.
                let flanks = self.flanks(e, corners, c.t);
                if flanks.iter().all(|flank| flank.dot(c.normal) >= 0.0) {
                    cross(self, c);
                }
            });
        }
        let mut side = f64::INFINITY;
        if part.solid.has_round_side() {
            let (t, distance, normal) = part.solid.nearest_on_segment(a, b);
            side = distance;
            if t > 0.0 && t < 1.0 {
                let nearest = Crossing {
                    edge: ROUND_SIDE,
                    t,
                    normal,
                    distance,
                };
                cross(self, nearest);
            }
        }
        if self.site.rows.contacts.len() > before {
            // What touches may be deeper next time.
            return 0.0;
        }
        if part.solid.has_round_side() {
            // A rim is a part of the surface, and that is no nearer.
            return apart.max(side);
        }
        let within = most.max(a.distance(b));
        apart.max(part.solid.edges_from(a, b, within))
    }
}

/// Whether an edge goes into the part from its first end: it does not where that is on a face which the edge lies on or leaves.
fn enters(part: &Convex, [end, other]: [DVec3; 2]) -> bool {
    let (_, normal) = part.solid.signed_distance(end);
    normal.dot(other - end) < -FLAT * end.distance(other)
}
