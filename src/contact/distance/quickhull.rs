//! Convex hull of points in `f64`: faces as loops of vertices.
//!
//! Not parry's faces: those join triangles up to 1.5° apart, which on a metre is 2 cm, and hulls of thin plates lose
//! their sides. This is quickhull, always adding the point farthest above any face, which keeps every decision far from
//! rounding; points within 1e-7 of the extent, the rounding of the `f32` they came from, of a face are on it.

use crate::math::DVec3;

/// The hull of some points.
pub enum Outline {
    /// All on a line, or on one point.
    Segment(DVec3, DVec3),
    /// Loops of vertices, counter-clockwise from outside. Of points in a plane: the polygon, seen from either side.
    Faces(Vec<Vec<u32>>),
}

/// Thickness that counts as none, as a part of the extent.
const FLAT: f64 = 1e-7;

/// A triangle of the growing hull.
struct Facet {
    v: [u32; 3],
    /// Across the edge from corner i to the next.
    across: [u32; 3],
    normal: DVec3,
    offset: f64,
    alive: bool,
}

impl Facet {
    fn new(points: &[DVec3], v: [u32; 3], across: [u32; 3]) -> Self {
        let [a, b, c] = v.map(|i| points[i as usize]);
        let normal = (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::ZERO);
        Self {
            v,
            across,
            normal,
            offset: normal.dot(a),
            alive: true,
        }
    }

    fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    /// Which corner an edge starts at.
    fn edge_from(&self, vertex: u32) -> usize {
        self.v.iter().position(|&v| v == vertex).unwrap_or(0)
    }
}

/// The hull of points; `None` for no points, points that are not finite, and (never seen) where rounding tears the hull.
pub fn outline(points: &[DVec3]) -> Option<Outline> {
    if points.is_empty() || !points.iter().all(|p| p.is_finite()) {
        return None;
    }
    let farthest = |of: &dyn Fn(DVec3) -> f64| -> u32 {
        let mut best = 0;
        for (i, &p) in points.iter().enumerate() {
            if of(p) > of(points[best]) {
                best = i;
            }
        }
        best as u32
    };
    let at = |i: u32| points[i as usize];
    let start = points[0];
    let a = farthest(&|p| p.distance_squared(start));
    let b = farthest(&|p| p.distance_squared(at(a)));
    let extent = at(a).distance(at(b));
    let along = (at(b) - at(a)).try_normalize().unwrap_or(DVec3::X);
    let c = farthest(&|p| (p - at(a)).cross(along).length());
    if (at(c) - at(a)).cross(along).length() <= FLAT * extent {
        return Some(Outline::Segment(at(a), at(b)));
    }
    let normal = (at(b) - at(a))
        .cross(at(c) - at(a))
        .try_normalize()
        .unwrap_or(DVec3::Y);
    let d = farthest(&|p| (p - at(a)).dot(normal).abs());
    let height = (at(d) - at(a)).dot(normal);
    if height.abs() <= FLAT * extent {
        let polygon = polygon(points, along, normal);
        let back = polygon.iter().rev().copied().collect();
        return Some(Outline::Faces(vec![polygon, back]));
    }
    let first = if height < 0.0 {
        [a, b, c, d]
    } else {
        [a, c, b, d]
    };
    let facets = grow(points, first, FLAT * extent)?;
    Some(Outline::Faces(faces(points, &facets, 2.0 * FLAT * extent)))
}

/// Quickhull from a tetrahedron whose fourth corner lies below the first three.
fn grow(points: &[DVec3], [a, b, c, d]: [u32; 4], eps: f64) -> Option<Vec<Facet>> {
    let mut facets = vec![
        Facet::new(points, [a, b, c], [3, 1, 2]),
        Facet::new(points, [c, b, d], [0, 3, 2]),
        Facet::new(points, [a, c, d], [0, 1, 3]),
        Facet::new(points, [b, a, d], [0, 2, 1]),
    ];
    // Per point the facet it is highest above, if it is above any.
    let mut above: Vec<(f64, u32)> = points
        .iter()
        .map(|&p| highest(&facets, 0..4, p, eps))
        .collect();
    let mut visible = Vec::new();
    let mut rim: Vec<(u32, u32, u32)> = Vec::new();
    loop {
        let apex = (0..points.len()).max_by(|&i, &j| above[i].0.total_cmp(&above[j].0))?;
        let (height, seed) = above[apex];
        if height <= eps {
            facets.retain_alive();
            return Some(facets);
        }
        visible.clear();
        rim.clear();
        visible.push(seed);
        facets[seed as usize].alive = false;
        let mut next = 0;
        while next < visible.len() {
            let f = visible[next];
            next += 1;
            for k in 0..3 {
                let (v, other) = (facets[f as usize].v, facets[f as usize].across[k] as usize);
                if !facets[other].alive {
                    if !visible.contains(&(other as u32)) {
                        return None;
                    }
                } else if facets[other].height(points[apex]) > 1e-3 * eps {
                    facets[other].alive = false;
                    visible.push(other as u32);
                } else {
                    rim.push((v[k], v[(k + 1) % 3], other as u32));
                }
            }
        }
        let fresh = facets.len() as u32;
        for (i, &(from, to, other)) in rim.iter().enumerate() {
            let after = one(&rim, |e| e.0 == to)?;
            let before = one(&rim, |e| e.1 == from)?;
            let across = [other, fresh + after, fresh + before];
            facets.push(Facet::new(points, [from, to, apex as u32], across));
            let edge = facets[other as usize].edge_from(to);
            facets[other as usize].across[edge] = fresh + i as u32;
        }
        above[apex].0 = f64::NEG_INFINITY;
        let all = fresh as usize..facets.len();
        for (i, entry) in above.iter_mut().enumerate() {
            if entry.0 > eps && !facets[entry.1 as usize].alive {
                *entry = highest(&facets, all.clone(), points[i], eps);
            }
        }
    }
}

/// The only element that fits.
fn one<T>(list: &[T], fits: impl Fn(&T) -> bool) -> Option<u32> {
    let mut found = list.iter().enumerate().filter(|(_, e)| fits(e));
    let (i, _) = found.next()?;
    found.next().is_none().then_some(i as u32)
}

/// The facet a point is highest above.
fn highest(facets: &[Facet], among: std::ops::Range<usize>, p: DVec3, eps: f64) -> (f64, u32) {
    let mut best = (f64::NEG_INFINITY, 0);
    for i in among {
        let height = facets[i].height(p);
        if height > best.0 && height > eps {
            best = (height, i as u32);
        }
    }
    best
}

/// Drops dead facets and renumbers the rest.
trait RetainAlive {
    fn retain_alive(&mut self);
}

impl RetainAlive for Vec<Facet> {
    fn retain_alive(&mut self) {
        let mut number = 0;
        let new: Vec<u32> = self
            .iter()
            .map(|f| {
                number += u32::from(f.alive);
                number.wrapping_sub(1)
            })
            .collect();
        self.retain(|f| f.alive);
        for facet in self {
            facet.across = facet.across.map(|f| new[f as usize]);
        }
    }
}

/// Joins facets that lie in one plane to within `tolerance` m, the largest first, and follows their outlines.
fn faces(points: &[DVec3], facets: &[Facet], tolerance: f64) -> Vec<Vec<u32>> {
    let area = |f: &Facet| {
        let [a, b, c] = f.v.map(|i| points[i as usize]);
        (b - a).cross(c - a).length()
    };
    let mut order: Vec<usize> = (0..facets.len()).collect();
    order.sort_by(|&i, &j| area(&facets[j]).total_cmp(&area(&facets[i])));
    let mut group = vec![usize::MAX; facets.len()];
    let mut loops = Vec::new();
    for seed in order {
        if group[seed] != usize::MAX {
            continue;
        }
        let plane = &facets[seed];
        let mut members = vec![seed];
        group[seed] = seed;
        let mut next = 0;
        while next < members.len() {
            for &other in &facets[members[next]].across {
                let f = &facets[other as usize];
                let flat =
                    f.v.iter()
                        .all(|&v| plane.height(points[v as usize]).abs() <= tolerance);
                if group[other as usize] == usize::MAX && flat && f.normal.dot(plane.normal) >= 0.0
                {
                    group[other as usize] = seed;
                    members.push(other as usize);
                }
            }
            next += 1;
        }
        match follow(facets, &members, &group) {
            Some(outline) => loops.push(outline),
            // No simple polygon: leave its triangles as they are.
            None => loops.extend(members.iter().map(|&f| facets[f].v.to_vec())),
        }
    }
    loops
}

/// The outline of a group of facets, if it is one loop.
fn follow(facets: &[Facet], members: &[usize], group: &[usize]) -> Option<Vec<u32>> {
    let mut edges = Vec::new();
    for &f in members {
        for k in 0..3 {
            if group[facets[f].across[k] as usize] != group[f] {
                edges.push((facets[f].v[k], facets[f].v[(k + 1) % 3]));
            }
        }
    }
    let (start, mut at) = *edges.first()?;
    let mut outline = vec![start];
    while at != start {
        outline.push(at);
        if outline.len() > edges.len() {
            return None;
        }
        at = edges[one(&edges, |e| e.0 == at)? as usize].1;
    }
    (outline.len() == edges.len()).then_some(outline)
}

/// The convex polygon of points in a plane, counter-clockwise about `normal`: Andrew's chain.
fn polygon(points: &[DVec3], along: DVec3, normal: DVec3) -> Vec<u32> {
    let up = normal.cross(along);
    let at = |i: u32| {
        let p = points[i as usize];
        (p.dot(along), p.dot(up))
    };
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by(|&i, &j| {
        let (a, b) = (at(i), at(j));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut chain: Vec<u32> = Vec::new();
    let mut floor = 0;
    for pass in 0..2 {
        for &i in &order {
            while chain.len() >= floor + 2 {
                let (o, a, b) = (
                    at(chain[chain.len() - 2]),
                    at(chain[chain.len() - 1]),
                    at(i),
                );
                if (a.0 - o.0) * (b.1 - o.1) - (a.1 - o.1) * (b.0 - o.0) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(i);
        }
        chain.pop();
        if pass == 0 {
            floor = chain.len();
            order.reverse();
        }
    }
    chain
}
