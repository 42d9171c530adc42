//! What of a body's surface can be touched besides its nodes: faces, their edges, and whether they close.

use super::Blueprint;
use crate::math::{DVec3, wide};
use std::collections::BTreeMap;

/// No node.
pub const NONE: u32 = u32::MAX;

/// A triangle or a quad, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// Three nodes.
    Triangle([u32; 3]),
    /// Four nodes.
    Quad([u32; 4]),
}

impl Face {
    /// Its nodes.
    pub fn nodes(&self) -> &[u32] {
        match self {
            Self::Triangle(nodes) => nodes,
            Self::Quad(nodes) => nodes,
        }
    }
}

/// Faces and edges of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// Triangles over the nodes, and flat quads where two of them make one: a triangle of a quad would lean to its diagonal.
    pub faces: Vec<Face>,
    /// Each edge of a face once, but for the diagonals of flat quads: whatever lies across a diagonal lies across two sides.
    /// Of a body without faces, its springs.
    pub edges: Vec<[u32; 2]>,
    /// The third nodes of the triangles to the left and to the right of each edge, seen from outside; [`NONE`] on a border,
    /// and between more than two triangles or such as don't agree on an outside. None of a body without faces.
    pub wings: Vec<[u32; 2]>,
    /// Whether the faces enclose a volume: every edge belongs to two faces that agree on which side is outside. A surface
    /// that is open has no outside, and both sides count.
    pub closed: bool,
    /// Mean length of the edges at rest \[m\].
    pub spacing: f64,
}

impl Topology {
    /// The topology of a blueprint.
    pub fn of(blueprint: &Blueprint) -> Self {
        let at = |node: u32| wide(blueprint.nodes[node as usize].position);
        let mut sides = BTreeMap::<[u32; 2], Vec<Side>>::new();
        for (face, &[a, b, c]) in blueprint.faces.iter().enumerate() {
            let normal = (at(b) - at(a)).cross(at(c) - at(a)).normalize_or_zero();
            for (from, to, opposite) in [(a, b, c), (b, c, a), (c, a, b)] {
                let others = [
                    at(opposite).distance(at(from)),
                    at(opposite).distance(at(to)),
                ];
                let side = Side {
                    face,
                    from,
                    opposite,
                    normal,
                    longest_other: others[0].max(others[1]),
                };
                sides
                    .entry([from.min(to), from.max(to)])
                    .or_default()
                    .push(side);
            }
        }
        let closed = !sides.is_empty() && sides.values().all(|s| closes(s));
        let mut faces: Vec<Option<Face>> = blueprint
            .faces
            .iter()
            .map(|f| Some(Face::Triangle(*f)))
            .collect();
        let mut edges = Vec::with_capacity(sides.len());
        let mut wings = Vec::new();
        for (&[a, b], sides) in &sides {
            match quad(at(a).distance(at(b)), [a, b], sides) {
                None => {
                    edges.push([a, b]);
                    wings.push(wings_of(a, sides));
                }
                Some((first, second, nodes)) => {
                    faces[first] = Some(Face::Quad(nodes));
                    faces[second] = None;
                }
            }
        }
        if blueprint.faces.is_empty() {
            edges = blueprint.springs.iter().map(|s| s.nodes).collect();
        }
        let total: f64 = edges.iter().map(|&[a, b]| at(a).distance(at(b))).sum();
        Self {
            faces: faces.into_iter().flatten().collect(),
            spacing: total / edges.len().max(1) as f64,
            edges,
            wings,
            closed,
        }
    }
}

/// An edge as one of its triangles has it.
struct Side {
    face: usize,
    /// Where the edge begins, going round the triangle.
    from: u32,
    /// The triangle's third node.
    opposite: u32,
    normal: DVec3,
    /// The longer one of the triangle's other edges \[m\].
    longest_other: f64,
}

/// The third nodes to the left and to the right of an edge from node `a`.
fn wings_of(a: u32, sides: &[Side]) -> [u32; 2] {
    let wing = |s: &Side| {
        if s.from == a {
            [s.opposite, NONE]
        } else {
            [NONE, s.opposite]
        }
    };
    match sides {
        [only] => wing(only),
        [first, second] if first.from == a && second.from != a => [first.opposite, second.opposite],
        [first, second] if second.from == a && first.from != a => [second.opposite, first.opposite],
        _ => [NONE; 2],
    }
}

/// Whether two triangles that agree on which side is outside share an edge.
fn closes(sides: &[Side]) -> bool {
    matches!(sides, [a, b] if a.from != b.from)
}

/// The quad whose diagonal an edge is, and its two triangles: they lie in one plane, and the edge is by far the longest of
/// both, so that no triangle is part of two quads.
fn quad(length: f64, [a, b]: [u32; 2], sides: &[Side]) -> Option<(usize, usize, [u32; 4])> {
    let [first, second] = sides else {
        return None;
    };
    let flat = first.normal.dot(second.normal) > 1.0 - 1e-6;
    let longest = length > 1.1 * first.longest_other && length > 1.1 * second.longest_other;
    let to = if first.from == a { b } else { a };
    let nodes = [first.from, second.opposite, to, first.opposite];
    (flat && longest && closes(sides)).then_some((first.face, second.face, nodes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Material;
    use crate::math::Vector;
    use crate::shape;

    fn topology(net: crate::body::Net) -> Topology {
        let material = Some(Material::rubber());
        Topology::of(&Blueprint::resolve(net, |_| material, None).unwrap())
    }

    #[test]
    fn a_block_is_closed_and_a_sheet_is_open() {
        let block = topology(shape::lattice(Vector::ONE, 0.5).unwrap());
        assert!(block.closed);
        assert_eq!(block.edges.len(), block.wings.len());
        let net = shape::lattice(Vector::ONE, 0.5).unwrap();
        let at = |i: u32| wide(net.nodes[i as usize].position);
        for (&[a, b], &[left, right]) in block.edges.iter().zip(&block.wings) {
            let outward = (at(b) - at(a)).cross(at(left) - at(right));
            assert!(outward.dot(at(a) + at(b)) > 0.0);
        }
        // Euler: V − E + F = 2.
        assert_eq!(block.faces.len(), 24);
        assert_eq!(26 + 24, 2 + block.edges.len());
        assert!(block.faces.iter().all(|f| f.nodes().len() == 4));
        let rope = topology(shape::rope(Vector::ZERO, Vector::X, 4, 1e-4).unwrap());
        assert!(!rope.closed && rope.faces.is_empty());
        assert_eq!(rope.edges.len(), 4);
        assert!((rope.spacing - 0.25).abs() < 1e-6);
    }
}
