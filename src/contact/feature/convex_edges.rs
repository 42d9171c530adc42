//! An edge of one body against the edges, round corners and round sides of a convex part of a solid.

use super::making::{BORDER, Making};
use super::meet::{ALIKE, share_node};
use super::part::Convex;
use super::recall::Recall;
use super::sharp::FLAT;
use crate::contact::cone::Pushed;
use crate::contact::distance::{Crossing, Solid, StraightEdge};
use crate::contact::touches::Key;
use crate::math::DVec3;

/// An edge of a part that crosses one of the body.
pub(super) type SeenEdge = (u32, StraightEdge);

/// How many of them are kept.
const MOST: usize = 4;

/// The edges of a part that an edge was found to cross.
#[derive(Default)]
struct Found {
    edges: [u32; MOST],
    count: usize,
    /// Whether there is more that is to be looked at anew in every substep: what is round, is passed at an end, or lies
    /// beside for now.
    more: bool,
}

impl Found {
    fn note(&mut self, edge: u32) {
        match self.edges.get_mut(self.count) {
            Some(place) => (*place, self.count) = (edge, self.count + 1),
            None => self.more = true,
        }
    }

    /// All of them, with their ends.
    fn all_of(&self, solid: &Solid) -> Option<impl Iterator<Item = SeenEdge>> {
        let straight = |&edge: &u32| Some((edge, solid.straight_edge(edge)?));
        let edges = self.edges[..self.count].iter();
        let all = !self.more && edges.clone().all(|edge| straight(edge).is_some());
        all.then(|| edges.filter_map(straight))
    }
}

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

    /// How deep an edge can be in one of the part and still belong to it \[m\].
    fn deepest_crossing(&self, part: &Convex) -> f64 {
        self.skin + 0.5 * part.solid.width()
    }

    /// The share of an edge, at either end and beyond it, that counts as its end.
    fn end_of(&self, [a, b]: &[DVec3; 2]) -> f64 {
        BORDER * self.site.reach.touching / a.distance(*b)
    }

    /// An edge against the part: where it crosses the part's edges and round corners, and where it comes nearest to a round side.
    /// Returns how far it is from any of them, or less \[m\].
    pub(super) fn edge(
        &mut self,
        part: &Convex,
        (key, bound): ([u32; 2], f64),
        seen: &mut Recall<SeenEdge>,
    ) -> f64 {
        if self.site.side.topology.torn.edge(key[1]) {
            return f64::INFINITY;
        }
        let nodes = self.site.side.topology.edges[key[1] as usize];
        let corners = self.ends(&nodes);
        if let Some(apart) = self.edge_again(part, key, (&nodes, &corners), seen) {
            return apart;
        }
        let mut found = Found::default();
        let apart = self.edge_anew(part, (key, bound), (&nodes, corners), &mut found);
        if let Some(edges) = found.all_of(&part.solid) {
            seen.note(key, &corners, (apart, self.near), edges);
        }
        apart
    }

    /// Adds the rows of an edge that has not moved, with the edges of the part that it has crossed before; `None` where it
    /// must be looked at anew.
    fn edge_again(
        &mut self,
        part: &Convex,
        [p, e]: [u32; 2],
        (nodes, corners): (&[u32; 2], &[DVec3; 2]),
        seen: &mut Recall<SeenEdge>,
    ) -> Option<f64> {
        let (apart, edges) = seen.of([p, e], corners)?;
        let (margin, deepest) = (self.end_of(corners), self.deepest_crossing(part));
        let mut points = [const { None }; MOST];
        for (place, edge) in points.iter_mut().zip(edges) {
            let c = part.solid.crossing(prolonged(corners, margin), *edge)?;
            let c = shortened(c, margin);
            if c.t.min(1.0 - c.t) < margin {
                return None;
            }
            let key = [p, e, c.edge];
            let (known, at) = (self.touches.touched(key), (c.t, c.normal, c.distance));
            *place = Some((key, self.across(known, (nodes, corners), at, deepest)?));
        }
        for (key, point) in points.into_iter().flatten() {
            self.add(key, point);
        }
        seen.go_on();
        Some(apart)
    }

    fn edge_anew(
        &mut self,
        part: &Convex,
        ([p, e], bound): ([u32; 2], f64),
        (nodes, corners): (&[u32; 2], [DVec3; 2]),
        found: &mut Found,
    ) -> f64 {
        let [a, b] = corners;
        let apart = part.solid.edges_apart(a.min(b), a.max(b));
        let apart = apart.max(bound);
        let known = self.touches.knows([p, e]);
        let Some(reach) = self.reach_of(known, apart, (nodes, &corners)) else {
            return apart;
        };
        let away = part.away(0.5 * (a + b), &corners);
        let apart = apart.max(away);
        if away > reach {
            return apart;
        }
        let deepest = self.deepest_crossing(part);
        let most = if known {
            self.near.max(deepest)
        } else {
            self.near
        };
        let before = self.site.rows.contacts.len();
        let end = self.end_of(&corners);
        let mut cross = |making: &mut Self, c: Crossing| {
            // So near an end, or past it, it is the node's business, unless the edge goes in from there: then the node, which may
            // have slid over the part's edge to the next face, or be on it, does not hold it.
            let from = if c.t < 0.5 { [a, b] } else { [b, a] };
            let at_end = c.t.min(1.0 - c.t) < end;
            found.more |= at_end;
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
            let Some(point) = making.across(known, (nodes, &corners), at, deepest) else {
                // What is deep may become known by what touches beside it.
                found.more |= depth > -making.site.reach.touching;
                return;
            };
            if making.edge_lies_beside(part, (e, corners), &c, known) {
                found.more = true;
            } else if !making.is_internal_edge(part, corners, &c) {
                making.add(key, point);
                found.note(c.edge);
            }
        };
        let [from, to] = prolonged(&corners, end);
        part.solid.for_each_crossing(from, to, most, &mut |c| {
            cross(self, shortened(c, end));
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

/// An edge that is longer by a share `end` of it at either end.
fn prolonged([a, b]: &[DVec3; 2], end: f64) -> [DVec3; 2] {
    [a.lerp(*b, -end), b.lerp(*a, -end)]
}

/// A crossing of that, by the share of the edge itself.
fn shortened(crossing: Crossing, end: f64) -> Crossing {
    Crossing {
        t: crossing.t * (1.0 + 2.0 * end) - end,
        ..crossing
    }
}

/// Whether an edge goes into the part from its first end: it does not where that is on a face which the edge lies on or leaves.
fn enters(part: &Convex, [end, other]: [DVec3; 2]) -> bool {
    let (_, normal) = part.solid.signed_distance(end);
    normal.dot(other - end) < -FLAT * end.distance(other)
}
