//! Edges that can cut into a face: ridges and borders, for contact of edges and corners.

use super::facet::{Facet, Patch};
use super::{Soup, meets};
use crate::math::DVec3;
use std::cmp::Ordering;

/// Sine of the angle below which two facets are one plane.
const FLAT: f64 = 1.0e-3;

/// What an edge is to a face that comes near.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
pub struct Edge {
    /// Its ends \[m\], the lower one in order of x, y, z first.
    pub ends: [DVec3; 2],
    /// What it is.
    pub kind: EdgeKind,
    /// Front normals of its facets, twice the same where it has only one; 0 for a segment.
    pub normals: [DVec3; 2],
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
        self.facets_in(lo, hi, &mut search.facets);
        let wanted = |edge: &Edge| {
            let (edge_lo, edge_hi) = (
                edge.ends[0].min(edge.ends[1]),
                edge.ends[0].max(edge.ends[1]),
            );
            (edge.kind != EdgeKind::Valley || !self.oriented) && meets(lo, hi, edge_lo, edge_hi)
        };
        if let Some(edges) = &self.edges {
            search.ids.clear();
            for &facet in &search.facets {
                let own = edges.of_facet.get(facet as usize);
                search.ids.extend(own.into_iter().flatten());
            }
            search.ids.sort_unstable();
            search.ids.dedup();
            let found = search
                .ids
                .iter()
                .filter_map(|&i| edges.list.get(i as usize));
            out.extend(found.filter(|edge| wanted(edge)));
            return;
        }
        // Both facets of an edge in the box are in the box.
        search.halves.clear();
        for &id in &search.facets {
            if let Some(facet) = self.facet(id) {
                Half::of(id, &facet, &mut search.halves);
            }
        }
        search.edges.clear();
        classify(&mut search.halves, &mut search.edges, |_, _| {});
        out.extend(search.edges.iter().filter(|edge| wanted(edge)));
    }

    /// Puts into `out` the ends of those edges that lie in the box, each once, in order of x, y, z.
    pub fn convex_corners_in(
        &self,
        lo: DVec3,
        hi: DVec3,
        search: &mut EdgeSearch,
        edges: &mut Vec<Edge>,
        out: &mut Vec<DVec3>,
    ) {
        self.convex_edges_in(lo, hi, search, edges);
        out.clear();
        let ends = edges.iter().flat_map(|edge| edge.ends);
        out.extend(ends.filter(|&p| meets(lo, hi, p, p)));
        out.sort_unstable_by(|a, b| order(*a, *b));
        out.dedup();
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
            .then_with(|| self.facet.cmp(&other.facet))
    }
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
    let ends = group[0].ends;
    let free = |normals| {
        Some(Edge {
            ends,
            kind: EdgeKind::Free,
            normals,
        })
    };
    let (Some(a), b, None) = (planes.next(), planes.next(), planes.next()) else {
        return free([group[0].normal; 2]);
    };
    let Some(b) = b else {
        return free([a.normal; 2]);
    };
    let normals = [a.normal, b.normal];
    // Seen along an agreed front.
    let other = if a.forward == b.forward {
        -b.normal
    } else {
        b.normal
    };
    if a.normal.cross(other).length() < FLAT {
        return if a.normal.dot(other) > 0.0 {
            None
        } else {
            free(normals)
        };
    }
    if a.forward == b.forward {
        return free(normals);
    }
    let kind = if a.normal.dot(b.opposite - ends[0]) < 0.0 {
        EdgeKind::Ridge
    } else {
        EdgeKind::Valley
    };
    Some(Edge {
        ends,
        kind,
        normals,
    })
}
