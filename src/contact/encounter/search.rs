//! The lists of an encounter: what is near what.

use super::Encounter;
use super::near::Near;
use super::outline::{NONE, Outline};
use super::posed::Posed;
use crate::body::State;
use crate::contact::closest::{between_segments, bounds};
use crate::math::{DVec3, Real};

/// The least margin of a list, per shortest edge: a body at rest makes one in thousands of substeps.
const LEAST: f64 = 0.05;

/// A body whose tree may be brought up to date.
pub struct Searched<'a> {
    /// Its state.
    pub state: &'a State<Real>,
    /// Its outline.
    pub outline: &'a mut Outline,
}

impl Encounter {
    /// Makes the lists anew if, after `moved` m since the last look, they might lack something that can get a row in the
    /// coming substep, which is anything within `farthest` m of touching. In a substep the two may close by `closing` m.
    pub fn refresh(&mut self, bodies: [Searched; 2], moved: f64, (closing, farthest): (f64, f64)) {
        self.budget -= moved;
        self.way += moved;
        if self.budget >= farthest {
            return;
        }
        let spacing = bodies[0].outline.spacing.min(bodies[1].outline.spacing);
        let least = if spacing.is_finite() {
            LEAST * spacing
        } else {
            0.0
        };
        // Fast things would list whole bodies.
        let more = (3.0 * farthest + 100.0 * closing).max(least).min(spacing);
        let margin = farthest + more.max(closing);
        (self.budget, self.way) = (margin, 0.0);
        let origin = bodies[0].state.origin;
        let [a, b] = bodies.map(|Searched { state, outline }| {
            outline.refit(state);
            Posed::new(outline, state, origin)
        });
        let (distance, apart) = (self.manners.distance(), a.apart(&b));
        let radius = margin + distance;
        if apart > radius {
            self.nodes.iter_mut().for_each(Vec::clear);
            self.edges.clear();
            self.budget = apart - distance;
            return;
        }
        list_nodes(&mut self.nodes[0], &a, &b, radius);
        list_nodes(&mut self.nodes[1], &b, &a, radius);
        list_edges(&mut self.edges, &a, &b, radius);
    }
}

/// Nodes of `own` within `radius` m of elements of `other`.
fn list_nodes(list: &mut Vec<Near>, own: &Posed, other: &Posed, radius: f64) {
    list.clear();
    for &node in &own.outline.nodes {
        let x = own.at(node);
        if !other.may_hold(x, radius) {
            continue;
        }
        let first = list.len();
        collect(list, node, x, other, radius);
        if list.len() == first && other.outline.closed {
            collect_inside(list, node, x, other, radius);
        }
        list[first..].sort_unstable_by_key(|near| near.other);
    }
}

fn collect(list: &mut Vec<Near>, node: u32, x: DVec3, other: &Posed, radius: f64) {
    let local = x - other.shift;
    other.outline.near(local, local, radius, |element| {
        if other.outline.is_gone(element, other.state) {
            return;
        }
        let square = other.nearest(element, x).squared;
        if square <= radius * radius {
            list.push(Near::new(node, element, square.sqrt()));
        }
    });
}

/// A node that is nowhere near the surface of a solid may be deep inside: then it is listed with what is nearest, which
/// is found by doubling the radius.
fn collect_inside(list: &mut Vec<Near>, node: u32, x: DVec3, other: &Posed, radius: f64) {
    let first = list.len();
    let most = 4.0 * other.outline.extent();
    let mut wider = 2.0 * radius;
    while list.len() == first && wider < most {
        collect(list, node, x, other, wider);
        wider *= 2.0;
    }
    let ways = list[first..]
        .iter()
        .map(|near| other.nearest(near.other, x));
    let nearest = ways.min_by(|a, b| a.squared.total_cmp(&b.squared));
    let inside =
        nearest.is_some_and(|w| w.way.dot(other.normal_at(w.element, w.nearest.feature)) < 0.0);
    if !inside {
        list.truncate(first);
    }
}

/// Edges of `a` within `radius` m of edges of `b`.
fn list_edges(list: &mut Vec<Near>, a: &Posed, b: &Posed, radius: f64) {
    list.clear();
    for edge in 0..a.outline.edges.len() as u32 {
        let ends = a.ends(edge);
        let (lo, hi) = bounds(ends.into_iter());
        // Boxes first: of most pairs even these are too far apart.
        let may_reach = |other: [DVec3; 2]| {
            let (from, to) = bounds(other.into_iter());
            let apart = (from - hi).max(lo - to).max(DVec3::ZERO);
            apart.length_squared() <= radius * radius
        };
        let overlap = b.may_hold(lo, radius + hi.distance(lo));
        if !overlap || a.outline.is_broken(edge, a.state) {
            continue;
        }
        let first = list.len();
        b.outline
            .near(lo - b.shift, hi - b.shift, radius, |element| {
                for other in b.outline.edges_of[element as usize] {
                    let owned = other != NONE && b.outline.owner[other as usize] == element;
                    if !owned {
                        continue;
                    }
                    let others = b.ends(other);
                    if !may_reach(others) {
                        continue;
                    }
                    let (distance, _) = between_segments(ends, others);
                    if distance <= radius {
                        list.push(Near::new(edge, other, distance));
                    }
                }
            });
        list[first..].sort_unstable_by_key(|near| near.other);
    }
}
