//! Edges that can cut into a face: ridges and borders, for contact of edges and corners.

use super::facet::{Facet, Patch};
use super::{Soup, meets};
use crate::math::DVec3;
use std::cmp::Ordering;

/// Sine of the angle below which two facets are one plane.
const FLAT: f64 = 1.0e-3;

/// What an edge is to a face that comes near.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub enum EdgeKind {
    /// Sticks out on the front of its two facets.
    Ridge,
    /// Sticks out on their back.
    Valley,
    /// Sticks out all round: a border, a segment, a fold, or an edge whose facets do not agree on a front.
    Free,
}

/// An edge of a soup.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Edge {
    /// What tells it from others of its soup, in whatever box it was found: the number of the first of the sides that meet
    /// in it.
    pub id: u32,
    /// Its ends \[m\], the lower one in order of x, y, z first.
    pub ends: [DVec3; 2],
    /// What it is.
    pub kind: EdgeKind,
    /// Normals of its two facets, seen along an agreed front, first of the one to the left of the way from the lower end to
    /// the higher; 0 for what is not there, and both 0 between more than two.
    pub normals: [DVec3; 2],
    /// How far the narrower one of its facets reaches from it \[m\].
    pub width: f32,
}

/// Buffers of a search for edges.
#[derive(Clone, Debug, Default)]
pub struct EdgeSearch {
    facets: Vec<u32>,
    ids: Vec<u32>,
    halves: Vec<Half>,
    edges: Vec<Edge>,
}

/// The edges of a whole mesh.
pub struct Edges {
    list: Vec<Edge>,
    /// The edges of each triangle; `u32::MAX` for one that is not in the list.
    of_facet: Vec<[u32; 3]>,
    /// Whether every edge is run along as often in one direction as in the other.
    pub closed: bool,
}

impl Edge {
    /// From its lower end to its higher \[m\].
    pub fn along(&self) -> DVec3 {
        self.ends[1] - self.ends[0]
    }

    /// The box around it \[m\].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let [a, b] = self.ends;
        (a.min(b), a.max(b))
    }

    fn meets(&self, lo: DVec3, hi: DVec3) -> bool {
        let (own_lo, own_hi) = self.bounds();
        meets(lo, hi, own_lo, own_hi)
    }

    /// Whether it is the side of one facet and no other: the surface ends there.
    pub fn is_border(&self) -> bool {
        let [a, b] = self.normals.map(|n| n != DVec3::ZERO);
        self.kind == EdgeKind::Free && a != b
    }

    /// The unit directions into its facets, square to it; 0 for none.
    pub fn flanks(&self) -> [DVec3; 2] {
        let along = self.along().normalize_or_zero();
        [self.normals[0].cross(along), along.cross(self.normals[1])]
    }

    /// Whether it stands out along a direction, as the border of one facet does along any: in a valley it is the facets that are
    /// touched. On which side of a slight bend a taut edge is that lies on it, rounding tells.
    pub fn stands_out(&self, direction: DVec3) -> bool {
        let [a, b] = self.flanks();
        a == DVec3::ZERO || b == DVec3::ZERO || (a + b).dot(direction) <= 0.0
    }

    /// The sum of its facets' normals where these agree on a front, else 0.
    pub fn front(&self) -> DVec3 {
        if self.kind == EdgeKind::Free {
            DVec3::ZERO
        } else {
            self.normals[0] + self.normals[1]
        }
    }

    /// Sine of the angle by which its facets bend, 1 from a right angle on and where it is free.
    pub fn bend(&self) -> f64 {
        let [a, b] = self.normals;
        if self.kind == EdgeKind::Free || a.dot(b) <= 0.0 {
            1.0
        } else {
            a.cross(b).length()
        }
    }
}

impl EdgeSearch {
    /// Puts into `out` the edges of some facets, all that meet a box, whose own boxes meet it from `lo` to `hi` \[m\].
    pub fn find(
        &mut self,
        facets: impl Iterator<Item = (u32, Facet)>,
        (lo, hi): (DVec3, DVec3),
        wanted: impl Fn(&Edge) -> bool,
        out: &mut Vec<Edge>,
    ) {
        // Both facets of an edge in the box are in the box.
        self.halves.clear();
        for (id, facet) in facets {
            Half::of(id, &facet, &mut self.halves);
        }
        self.edges.clear();
        classify(&mut self.halves, &mut self.edges, |_, _| {});
        let found = self.edges.iter();
        out.extend(found.filter(|edge| edge.meets(lo, hi) && wanted(edge)));
    }
}

impl Soup {
    /// Puts into `out` the edges whose boxes meet the one from `lo` to `hi` \[m\], each once: borders and ridges; of a soup
    /// with two sides valleys too, which are ridges seen from behind. Edges between facets in one plane are left out.
    pub fn convex_edges_in(
        &self,
        lo: DVec3,
        hi: DVec3,
        search: &mut EdgeSearch,
        out: &mut Vec<Edge>,
    ) {
        out.clear();
        let mut facets = std::mem::take(&mut search.facets);
        self.facets_in(lo, hi, &mut facets);
        let wanted = |edge: &Edge| edge.kind != EdgeKind::Valley || !self.oriented;
        if let Some(edges) = &self.edges {
            search.ids.clear();
            for &facet in &facets {
                let own = edges.of_facet.get(facet as usize);
                search.ids.extend(own.into_iter().flatten());
            }
            search.ids.sort_unstable();
            search.ids.dedup();
            let ids = search.ids.iter();
            let found = ids.filter_map(|&i| edges.list.get(i as usize));
            out.extend(found.filter(|edge| edge.meets(lo, hi) && wanted(edge)));
        } else {
            let found = facets.iter();
            let found = found.filter_map(|&id| Some((id, self.facet(id)?)));
            search.find(found, (lo, hi), wanted, out);
        }
        search.facets = facets;
    }
}

impl Edges {
    /// The edges of the first `count` facets of a soup.
    pub fn of(soup: &Soup, count: u32) -> Self {
        let mut halves = Vec::with_capacity(3 * count as usize);
        for id in 0..count {
            if let Some(facet) = soup.facet(id) {
                Half::of(id, &facet, &mut halves);
            }
        }
        let mut list = Vec::new();
        let mut of_facet = vec![[u32::MAX; 3]; count as usize];
        let closed = classify(&mut halves, &mut list, |half, edge| {
            of_facet[half.facet as usize][half.side as usize] = edge;
        });
        Self {
            closed: closed && !halves.is_empty(),
            list,
            of_facet,
        }
    }
}

/// An edge as one facet has it.
#[derive(Clone, Copy, Debug)]
struct Half {
    ends: [DVec3; 2],
    /// Whether the facet runs from the lower end to the higher.
    forward: bool,
    /// The facet's other corner.
    opposite: DVec3,
    normal: DVec3,
    facet: u32,
    side: u8,
}

impl Half {
    fn of(id: u32, facet: &Facet, out: &mut Vec<Self>) {
        let normal = Patch::new(id, facet).normal;
        // −0 and 0 are one place.
        let points = facet.points();
        let point = |i: usize| points[i % points.len()] + DVec3::ZERO;
        let sides = if points.len() == 3 { 3 } else { 1 };
        for side in 0..sides {
            let (a, b) = (point(side), point(side + 1));
            let forward = match order(a, b) {
                Ordering::Less => true,
                Ordering::Greater => false,
                // A triangle with a corner twice has its two other sides to close it.
                Ordering::Equal => continue,
            };
            out.push(Self {
                ends: if forward { [a, b] } else { [b, a] },
                forward,
                opposite: point(side + 2),
                normal,
                facet: id,
                side: side as u8,
            });
        }
    }

    fn key_order(&self, other: &Self) -> Ordering {
        order(self.ends[0], other.ends[0])
            .then_with(|| order(self.ends[1], other.ends[1]))
            .then_with(|| (self.facet, self.side).cmp(&(other.facet, other.side)))
    }

    /// How far the facet reaches from the edge \[m\].
    fn width(&self) -> f64 {
        let [a, b] = self.ends;
        let along = (b - a).normalize_or_zero();
        along.cross(self.opposite - a).length()
    }
}

/// The number of a side of a facet: 0 from its first corner to the second, and on.
pub fn side_id(facet: u32, side: u32) -> u32 {
    facet.wrapping_mul(3).wrapping_add(side)
}

/// By x, then y, then z.
fn order(a: DVec3, b: DVec3) -> Ordering {
    a.x.total_cmp(&b.x)
        .then_with(|| a.y.total_cmp(&b.y))
        .then_with(|| a.z.total_cmp(&b.z))
}

/// Puts each edge that is not flat into `list` and tells `found` whose it is; returns whether all are closed.
fn classify(halves: &mut [Half], list: &mut Vec<Edge>, mut found: impl FnMut(&Half, u32)) -> bool {
    halves.sort_unstable_by(Half::key_order);
    let mut closed = true;
    for group in halves.chunk_by(|a, b| a.ends == b.ends) {
        let forward = group.iter().filter(|half| half.forward).count();
        closed &= 2 * forward == group.len();
        if let Some(edge) = edge(group) {
            let index = list.len() as u32;
            list.push(edge);
            for half in group {
                found(half, index);
            }
        }
    }
    closed
}

/// The edge of some facets; `None` if they are two in one plane, or have no planes at all and stand between others.
fn edge(group: &[Half]) -> Option<Edge> {
    let mut planes = group.iter().filter(|half| half.normal != DVec3::ZERO);
    let first = &group[0];
    let edge = |kind, normals, width: f64| {
        Some(Edge {
            // Halves are sorted by their numbers.
            id: side_id(first.facet, first.side.into()),
            ends: first.ends,
            kind,
            normals,
            width: width as f32,
        })
    };
    let (Some(a), b, None) = (planes.next(), planes.next(), planes.next()) else {
        return edge(EdgeKind::Free, [DVec3::ZERO; 2], 0.0);
    };
    let Some(b) = b else {
        let normals = if a.forward {
            [a.normal, DVec3::ZERO]
        } else {
            [DVec3::ZERO, a.normal]
        };
        return edge(EdgeKind::Free, normals, a.width());
    };
    // Seen along an agreed front.
    let agree = a.forward != b.forward;
    let other = if agree { b.normal } else { -b.normal };
    let normals = if a.forward {
        [a.normal, other]
    } else {
        [other, a.normal]
    };
    let width = a.width().min(b.width());
    if a.normal.cross(other).length() < FLAT {
        return if a.normal.dot(other) > 0.0 {
            None
        } else {
            edge(EdgeKind::Free, normals, width)
        };
    }
    let kind = if !agree {
        EdgeKind::Free
    } else if a.normal.dot(b.opposite - first.ends[0]) < 0.0 {
        EdgeKind::Ridge
    } else {
        EdgeKind::Valley
    };
    edge(kind, normals, width)
}
