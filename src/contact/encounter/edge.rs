//! An edge against an edge: where they cross, how deep, and which way is out.
//!
//! Only pairs count of which one stands out, or that bear on each other already, and only where both are crossed inside and the
//! normal is one that both can have: of flat and hollow parts the nodes meet faces, and at the ends of edges nodes meet edges.

use super::outline::NONE;
use super::posed::Posed;
use crate::contact::cone::can_push;
use crate::math::DVec3;

/// Edges that bend by less than this (1.5°) are flat \[rad\].
const FLAT: f64 = 0.026;

/// The cosine of a face with the normal of a contact up to which it is too steep to take the couple of friction.
const STEEP: f64 = 0.5;

/// How deep, per edge, two edges of solids can be in each other.
const DEEPEST: f64 = 0.25;

/// Two edges that cross.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// How far along each.
    pub along: [f64; 2],
    /// From the second to the first.
    pub normal: DVec3,
    /// Distance along it, negative when they have passed each other \[m\].
    pub gap: f64,
}

/// How an edge lies in its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It looks into a solid, and meets nothing anew.
    Hollow,
    /// Its faces hardly bend: it meets what stands out.
    Flat,
    /// It stands out, and meets all but what is hollow.
    Sharp,
}

impl Kind {
    /// That of an edge. Without roots: it is asked of all edges near the other body, and most of them are flat.
    pub fn of(body: &Posed, edge: u32) -> Self {
        let [first, second] = body.outline.edges[edge as usize].faces;
        let [Some(u), Some(v)] = [first, second].map(|face| flank(body, edge, face)) else {
            return Self::Sharp;
        };
        // |û + v̂|² = 2 + 2·cos.
        const COSINE: f64 = 1.0 - 0.5 * FLAT * FLAT;
        let product = u.dot(v);
        let squares = u.length_squared() * v.length_squared();
        if product < 0.0 && product * product > COSINE * COSINE * squares {
            Self::Flat
        } else if body.outline.closed && u.dot(body.face_area(second)) > 0.0 {
            Self::Hollow
        } else {
            Self::Sharp
        }
    }

    /// Whether edges of these kinds meet.
    pub fn meets(self, other: Self) -> bool {
        use Kind::{Flat, Sharp};
        matches!(
            (self, other),
            (Sharp, Sharp) | (Sharp, Flat) | (Flat, Sharp)
        )
    }

    /// Whether an edge can push along a unit `way`; a flat one does across its faces alone.
    fn can_push(self, body: &Posed, edge: u32, way: DVec3, touched: bool) -> bool {
        let faces = body.outline.edges[edge as usize].faces;
        let flanks = faces.map(|face| flank(body, edge, face).unwrap_or_default());
        let flanks = flanks.map(DVec3::normalize_or_zero);
        if self == Self::Flat {
            flanks.iter().all(|f| f.dot(way) <= FLAT)
        } else {
            can_push(flanks, way, touched)
        }
    }
}

/// From an edge into a face of it, square to it; `None` where there is no face, or one without area.
fn flank(body: &Posed, edge: u32, face: u32) -> Option<DVec3> {
    if face == NONE {
        return None;
    }
    let [a, b] = body.ends(edge);
    let along = b - a;
    let into = body.at(third(body, edge, face)?) - a;
    let flank = into * along.length_squared() - along * into.dot(along);
    (flank != DVec3::ZERO).then_some(flank)
}

/// The corner of a face that is not on an edge of it.
fn third(body: &Posed, edge: u32, face: u32) -> Option<u32> {
    let ends = body.outline.edges[edge as usize].nodes;
    let mut corners = body.outline.elements[face as usize].into_iter();
    corners.find(|n| !ends.contains(n))
}

/// The face of an edge that looks most along a unit `normal`: its third corner, and its corners from those of the edge on; `None` where it
/// is seen too steeply to take a couple.
pub fn face_across(body: &Posed, edge: u32, normal: DVec3) -> Option<(u32, [DVec3; 3])> {
    let e = &body.outline.edges[edge as usize];
    let [a, b] = body.ends(edge);
    let faces = e.faces.iter().filter(|face| **face != NONE);
    let seen = faces.filter_map(|&face| {
        let third = third(body, edge, face)?;
        let corners = [a, b, body.at(third)];
        let out = (b - a).cross(corners[2] - a).normalize_or_zero();
        Some((out.dot(normal).abs(), third, corners))
    });
    let (cosine, third, corners) = seen.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (cosine > STEEP).then_some((third, corners))
}

/// Where edge `edges[0]` of the first body and `edges[1]` of the second, whose kinds meet, cross, if they do: they come nearest at
/// `along` of each. `last` is the normal they had last.
pub fn crossing(
    bodies: [&Posed; 2],
    edges: [u32; 2],
    kinds: [Kind; 2],
    along: [f64; 2],
    last: Option<DVec3>,
) -> Option<Crossing> {
    let (a, b) = (bodies[0].ends(edges[0]), bodies[1].ends(edges[1]));
    let way = a[0].lerp(a[1], along[0]) - b[0].lerp(b[1], along[1]);
    let across = (a[1] - a[0]).cross(b[1] - b[0]).normalize();
    let out_of = |k: usize| {
        if bodies[k].outline.closed {
            bodies[k].edge_normal(edges[k])
        } else {
            DVec3::ZERO
        }
    };
    let out = out_of(1) - out_of(0);
    let side = if out != DVec3::ZERO {
        across.dot(out)
    } else {
        across.dot(last.unwrap_or(way))
    };
    let normal = if side < 0.0 { -across } else { across };
    let gap = way.dot(normal);
    let shortest = a[0].distance(a[1]).min(b[0].distance(b[1]));
    let can_push = |k: usize, way| kinds[k].can_push(bodies[k], edges[k], way, last.is_some());
    let possible = gap > -DEEPEST * shortest && can_push(1, normal) && can_push(0, -normal);
    possible.then_some(Crossing { along, normal, gap })
}
