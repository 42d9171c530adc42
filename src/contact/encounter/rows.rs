//! The rows of an encounter.

use super::Encounter;
use super::edge::{self, Kind};
use super::levers;
use super::near::{Near, of_the_same};
use super::node::{Found, Query};
use super::posed::Posed;
use super::touch::{Touch, Touches};
use crate::contact::closest::between_segments;
use crate::contact::site::{Carrier, Reach};
use crate::law::row::{Lift, Turn, softness};
use crate::math::DVec3;
use crate::solve::rows::{Row, Rows};

/// The two bodies of an encounter in a substep.
pub struct Bodies<'a> {
    /// Where they are.
    pub posed: [Posed<'a>; 2],
    /// What carries their points.
    pub carriers: [Carrier<'a>; 2],
    /// Maps of their nodes to row nodes (`u32::MAX`: none yet).
    pub slots: [&'a mut [u32]; 2],
}

/// A row to be: a node of which body, its weight and its lever, the touch and where it stands.
struct Draft {
    terms: [(usize, u32, f64, DVec3); 6],
    touch: Touch,
    depth: f64,
    drift: DVec3,
}

/// How far beside the normal a node counts as beside the point that it touches, per distance that counts as touching.
const BESIDE: f64 = 1e-3;

/// A term that is none.
const NOTHING: (usize, u32, f64, DVec3) = (0, 0, 0.0, DVec3::ZERO);

/// The levers of an edge.
struct Levers {
    /// Of its ends.
    ends: [DVec3; 2],
    /// The third corner of a face of it that takes the couple, and its lever.
    third: Option<(u32, DVec3)>,
}

impl Levers {
    /// Those of the ends alone, given that of the second.
    fn of_ends(lever: DVec3) -> Self {
        Self {
            ends: [-lever, lever],
            third: None,
        }
    }
}

impl Draft {
    /// Relative velocity of the points \[m/s\].
    fn velocity(&self, bodies: &Bodies) -> DVec3 {
        let velocity = |&(body, node, weight, _): &(usize, u32, f64, DVec3)| {
            bodies.posed[body].state.velocity(node as usize) * weight
        };
        let terms = self.terms.iter().filter(|(_, _, weight, _)| *weight != 0.0);
        terms.map(velocity).sum()
    }
}

impl Encounter {
    /// Adds a row for everything that can touch within the substep.
    pub fn add_rows(&mut self, bodies: &mut Bodies, rows: &mut Rows, reach: Reach) {
        for own in 0..2 {
            let mut touches = std::mem::take(&mut self.node_touches[own]);
            let mut list = std::mem::take(&mut self.nodes[own]);
            touches.begin(rows);
            self.add_node_rows(own, (&mut touches, &mut list), bodies, rows, reach);
            (self.node_touches[own], self.nodes[own]) = (touches, list);
        }
        let mut touches = std::mem::take(&mut self.edge_touches);
        let mut list = std::mem::take(&mut self.edges);
        let mut kinds = std::mem::take(&mut self.kinds);
        touches.begin(rows);
        kinds.clear();
        kinds.resize(bodies.posed[1].outline.edges.len(), None);
        self.add_edge_rows((&mut touches, &mut list), &mut kinds, bodies, rows, reach);
        (self.edge_touches, self.edges, self.kinds) = (touches, list, kinds);
    }

    /// Rows of the nodes of body `own` on the elements of the other.
    fn add_node_rows(
        &self,
        own: usize,
        (touches, mut rest): (&mut Touches, &mut [Near]),
        bodies: &mut Bodies,
        rows: &mut Rows,
        reach: Reach,
    ) {
        let mut from = 0;
        while let Some((near, others)) = of_the_same(rest) {
            rest = others;
            let node = near[0].own;
            if self.attached[own].contains(&node) {
                continue;
            }
            let (mine, other) = (bodies.posed[own], bodies.posed[1 - own]);
            let mut query = Query {
                other,
                x: mine.at(node),
                v: mine.state.velocity(node as usize),
                near,
                way: self.way,
                known: touches.of(node, &mut from),
                sign: if own == 0 { 1.0 } else { -1.0 },
                mine,
                node,
                unseen: self.unseen,
                distance: self.manners.distance(),
                reach,
            };
            let found = query.find();
            let drafts = found.map(|f| f.map(|f| self.draft_node(own, node, &f, &query, &reach)));
            for draft in drafts.iter().flatten() {
                self.push(draft, touches, bodies, rows, reach);
            }
        }
    }

    fn draft_node(
        &self,
        own: usize,
        node: u32,
        found: &Found,
        query: &Query,
        reach: &Reach,
    ) -> Draft {
        let other = 1 - own;
        let normal = found.normal * query.sign;
        let depth = self.manners.distance() - found.gap;
        let last = query.known.iter().find(|t| t.normal.dot(normal) > 0.7);
        let held = last.and_then(|t| t.anchor);
        let drift = held.map_or(DVec3::ZERO, |(e, w)| query.x - query.other.point(e, w));
        let way = query.x - query.other.point(found.element, found.weights);
        let here = (depth >= -reach.touching).then(|| {
            // Under a rim the nearest point is not the one that the node lies on.
            let beside = way - found.normal * way.dot(found.normal);
            let is_beside = beside.length_squared() > (BESIDE * reach.touching).powi(2);
            let foot = is_beside.then(|| query.other.foot(found.element, query.x));
            (found.element, foot.flatten().unwrap_or(found.weights))
        });
        let corners = query.other.outline.elements[found.element as usize];
        let places = query.other.corners(found.element);
        let levers = levers::of_face(places, found.normal, way.dot(found.normal));
        let corner = |k: usize| (other, corners[k], -query.sign * found.weights[k], levers[k]);
        let node = (own, node, query.sign, DVec3::ZERO);
        Draft {
            terms: [node, corner(0), corner(1), corner(2), NOTHING, NOTHING],
            touch: Touch {
                own: node.1,
                other: found.element,
                normal,
                depth,
                anchor: held.or(here),
                carried: last.map_or(0.0, |t| t.carried),
                impulse: last.map_or(Default::default(), |t| t.impulse),
            },
            depth,
            drift: drift * query.sign,
        }
    }

    fn add_edge_rows(
        &self,
        (touches, mut rest): (&mut Touches, &mut [Near]),
        kinds: &mut [Option<Kind>],
        bodies: &mut Bodies,
        rows: &mut Rows,
        reach: Reach,
    ) {
        let farthest = self.manners.distance() + reach.farthest;
        let mut from = 0;
        while let Some((near, others)) = of_the_same(rest) {
            rest = others;
            let edge = near[0].own;
            let known = touches.of(edge, &mut from);
            let is_beyond = |near: &Near| near.at_least(self.way) > farthest;
            if known.is_empty() && near.iter().all(is_beyond) {
                continue;
            }
            let is_pressed = known.iter().any(Touch::is_pressed);
            let [a, b] = bodies.posed;
            if a.outline.is_broken(edge, a.state) {
                continue;
            }
            let own = Kind::of(&a, edge);
            if own == Kind::Hollow && !is_pressed {
                continue;
            }
            let ends = a.ends(edge);
            for near in near {
                let other = near.other;
                let known = touches.of(edge, &mut from).iter();
                let last = known.copied().find(|t| t.other == other);
                if last.is_none() && is_beyond(near) {
                    continue;
                }
                // Asked before how far they are apart: most edges of a solid are flat.
                let kind = &mut kinds[other as usize];
                let kind = *kind.get_or_insert_with(|| Kind::of(&b, other));
                // What an edge bears on it flattens: let go for that, it would bend again.
                let meets = own.meets(kind) || last.as_ref().is_some_and(Touch::is_pressed);
                if !meets || b.outline.is_broken(other, b.state) {
                    continue;
                }
                let (distance, along) = between_segments(ends, b.ends(other));
                near.note(self.way, distance);
                let Some(along) = along.filter(|_| distance <= farthest) else {
                    continue;
                };
                let (pair, normal) = ([edge, other], last.map(|t| t.normal));
                let found = edge::crossing([&a, &b], pair, [own, kind], along, normal);
                if let Some(found) = found {
                    let draft = self.draft_edges(pair, &found, last, bodies, &reach);
                    let into = -draft.velocity(bodies).dot(found.normal);
                    // Edges cannot have passed each other by more since the last substep than they come within one.
                    let distance = self.manners.distance();
                    let was = last.map_or(0.0, |t| (t.depth - distance).max(0.0));
                    if -found.gap <= was + reach.come(into) {
                        self.push(&draft, touches, bodies, rows, reach);
                    }
                }
            }
        }
    }

    fn draft_edges(
        &self,
        pair: [u32; 2],
        found: &edge::Crossing,
        last: Option<Touch>,
        bodies: &Bodies,
        reach: &Reach,
    ) -> Draft {
        let [a, b] = bodies.posed;
        let [s, t] = found.along;
        let depth = self.manners.distance() - found.gap;
        let held = last.and_then(|t| t.anchor);
        let drift = held.map_or(DVec3::ZERO, |(_, [s, t, _])| {
            let (a, b) = (a.ends(pair[0]), b.ends(pair[1]));
            a[0].lerp(a[1], s) - b[0].lerp(b[1], t)
        });
        let here = (depth >= -reach.touching).then_some((pair[1], [s, t, 0.0]));
        let [first, second] = self.edge_levers(pair, found, bodies);
        let end = |body: usize, k: usize, weight: f64, levers: &Levers| {
            let node = bodies.posed[body].outline.edges[pair[body] as usize].nodes[k];
            (body, node, weight, levers.ends[k])
        };
        let third = |body: usize, levers: &Levers| {
            let third = levers.third.map(|(node, lever)| (body, node, 0.0, lever));
            third.unwrap_or(NOTHING)
        };
        Draft {
            terms: [
                end(0, 0, 1.0 - s, &first),
                end(0, 1, s, &first),
                end(1, 0, t - 1.0, &second),
                end(1, 1, -t, &second),
                third(0, &first),
                third(1, &second),
            ],
            touch: Touch {
                own: pair[0],
                other: pair[1],
                normal: found.normal,
                depth,
                anchor: held.or(here),
                carried: last.map_or(0.0, |t| t.carried),
                impulse: last.map_or(Default::default(), |t| t.impulse),
            },
            depth,
            drift,
        }
    }

    /// The levers of two edges that cross. A spring can't be turned about its own axis: if one of them is such, a face of the other takes the
    /// couple, as it does under a node, and where it is seen along its face, and can't, each takes that of its own part of the gap.
    fn edge_levers(&self, pair: [u32; 2], found: &edge::Crossing, bodies: &Bodies) -> [Levers; 2] {
        let is_spring = |k: usize| bodies.posed[k].outline.edges[pair[k] as usize].is_spring();
        let ends = [0, 1].map(|k| bodies.posed[k].ends(pair[k]));
        if !is_spring(0) && !is_spring(1) {
            return levers::of_edges(ends[0], ends[1], found).map(Levers::of_ends);
        }
        let face = |k: usize| {
            let (third, corners) = edge::face_across(&bodies.posed[k], pair[k], found.normal)?;
            let [a, b, c] = levers::of_face(corners, found.normal, found.gap);
            Some(Levers {
                ends: [a, b],
                third: Some((third, c)),
            })
        };
        let none = || Levers::of_ends(DVec3::ZERO);
        match [face(0), face(1)] {
            [Some(first), None] => [first, none()],
            [None, Some(second)] => [none(), second],
            _ => {
                let parts = self.manners.parts().map(|part| part * found.gap);
                let of_spring = |k: usize| levers::of_spring(ends[k], found.normal, parts[k]);
                [0, 1].map(|k| Levers::of_ends(of_spring(k)))
            }
        }
    }

    /// Adds a row if it can matter in this substep. What has not arrived yet has no friction; the impulse of the arrival is
    /// carried over to the next substep, so that none is lost.
    fn push(
        &self,
        draft: &Draft,
        touches: &mut Touches,
        bodies: &mut Bodies,
        rows: &mut Rows,
        reach: Reach,
    ) {
        let Draft { touch, depth, .. } = *draft;
        let closing = draft.velocity(bodies).length();
        if depth.is_nan() || depth < -reach.at(closing) {
            return;
        }
        let first = rows.terms.len();
        // What dominates takes nothing, and so no part of a couple.
        let levers = self.manners.shares == [1.0; 2];
        let levers = levers && draft.terms.iter().any(|t| t.3 != DVec3::ZERO);
        let levers = levers.then_some(rows.levers.len() as u32);
        for (body, point, weight, lever) in draft.terms {
            let lever = levers.map(|_| lever);
            if weight == 0.0 && lever.is_none_or(|l| l == DVec3::ZERO) {
                continue;
            }
            let part = (weight, self.manners.shares[body], lever);
            bodies.carriers[body].add_terms(point, part, bodies.slots[body], rows);
        }
        let terms = rows.merge_terms_since(first, levers);
        let (here, normal) = (depth >= -reach.touching, touch.normal);
        let stiffness = self.manners.stiffness;
        rows.contacts.push(Row {
            terms,
            shadow: 0,
            pair: self.pair,
            between: true,
            levers,
            normal,
            depth,
            arm: DVec3::ZERO,
            turn: Turn::default(),
            rigid_share: 0.0,
            friction: if here { self.manners.friction } else { 0.0 },
            softness: stiffness.map_or(0.0, |k| softness(k, reach.h)),
            drift: draft.drift - normal * draft.drift.dot(normal),
            carried: if here { touch.carried } else { 0.0 },
            normal_impulse: touch.impulse.0,
            friction_impulse: touch.impulse.1,
            response: Default::default(),
            lift: Lift::default(),
            pinched: 0.0,
        });
        touches.push(touch);
    }
}
